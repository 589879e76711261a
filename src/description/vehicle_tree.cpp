#include "ellipsoid_vehicle_sim/description/vehicle_tree.h"

#include <map>
#include <tuple>

namespace ellipsoid_vehicle_sim {
namespace {

/// First use of every name; later ones are problems.
template <typename Item, typename Name, typename Line>
std::map<std::string, int> indexNames(const std::vector<Item>& items, Name name, Line line, const std::string& what,
                                      const std::string& file, Problems& problems) {
  std::map<std::string, int> index;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (name(items[i]).empty()) continue;  // already a problem of its own
    const auto inserted = index.emplace(name(items[i]), static_cast<int>(i));
    if (inserted.second) continue;
    problems.push_back({placeText(file, line(items[i]), what, name(items[i])),
                        "the name is taken by the " + what + " in line " +
                            std::to_string(line(items[inserted.first->second])) + "; allowed is once"});
  }
  return index;
}

/// Joints that end in the same link: each after the first.
void checkParents(const UrdfText& urdf, const std::vector<int>& joint_of_link, const std::vector<int>& child_of_joint,
                  const std::string& file, Problems& problems) {
  for (std::size_t j = 0; j < urdf.joints.size(); ++j) {
    const int child = child_of_joint[j];
    if (child < 0 || joint_of_link[child] == static_cast<int>(j)) continue;
    const JointDescription& joint = urdf.joints[j].joint;
    problems.push_back({placeText(file, joint.line, "joint", joint.name),
                        "link '" + joint.child + "' already hangs on joint '" +
                            urdf.joints[joint_of_link[child]].joint.name + "'; allowed is one parent"});
  }
}

std::string listNames(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "'" : ", '") + name + "'";
  return text;
}

}  // namespace

std::optional<TreeOrder> orderTree(const UrdfText& urdf, const std::string& file, Problems& problems) {
  const std::size_t before = problems.size();
  if (urdf.links.empty()) {
    problems.push_back({file, "there is no <link>; a vehicle needs at least one"});
    return std::nullopt;
  }
  const auto links = indexNames(
      urdf.links, [](const LinkText& l) -> const std::string& { return l.name; },
      [](const LinkText& l) { return l.line; }, "link", file, problems);
  indexNames(
      urdf.joints, [](const JointText& j) -> const std::string& { return j.joint.name; },
      [](const JointText& j) { return j.joint.line; }, "joint", file, problems);

  std::vector<int> joint_of_link(urdf.links.size(), -1), child_of_joint(urdf.joints.size(), -1);
  std::vector<std::vector<int>> joints_below(urdf.links.size());
  for (std::size_t j = 0; j < urdf.joints.size(); ++j) {
    const JointDescription& joint = urdf.joints[j].joint;
    const auto parent = links.find(joint.parent), child = links.find(joint.child);
    for (const auto& [end, name, what] : {std::tuple{parent, joint.parent, "parent"}, {child, joint.child, "child"}}) {
      if (end != links.end() || name.empty()) continue;
      problems.push_back(
          {placeText(file, joint.line, "joint", joint.name),
           std::string("the ") + what + " link '" + name + "' does not exist; allowed is a <link> of this file"});
    }
    if (parent == links.end() || child == links.end()) continue;
    joints_below[parent->second].push_back(static_cast<int>(j));
    child_of_joint[j] = child->second;
    if (joint_of_link[child->second] < 0) joint_of_link[child->second] = static_cast<int>(j);
  }
  checkParents(urdf, joint_of_link, child_of_joint, file, problems);
  // Links cut off by the faults above, or without a name, would only be reported again as roots.
  bool named = true;
  for (const LinkText& link : urdf.links) named = named && !link.name.empty();
  for (const JointText& joint : urdf.joints) named = named && !joint.joint.parent.empty() && !joint.joint.child.empty();
  if (problems.size() > before || !named) return std::nullopt;

  std::vector<int> roots;
  for (std::size_t l = 0; l < urdf.links.size(); ++l) {
    if (joint_of_link[l] < 0) roots.push_back(static_cast<int>(l));
  }
  if (roots.size() > 1) {
    std::vector<std::string> names;
    for (int l : roots) names.push_back(urdf.links[l].name);
    problems.push_back(
        {placeText(file, urdf.links[roots[1]].line, "link", urdf.links[roots[1]].name),
         "the links " + listNames(names) + " hang on nothing; allowed is one root, joined to all others"});
  }

  TreeOrder order;
  std::vector<bool> reached(urdf.links.size(), false);
  std::vector<std::pair<int, int>> open;  // link, joint that leads there
  for (auto root = roots.rbegin(); root != roots.rend(); ++root) open.emplace_back(*root, -1);
  while (!open.empty()) {
    const auto [link, joint] = open.back();
    open.pop_back();
    reached[link] = true;
    order.links.push_back(link);
    if (joint >= 0) order.joints.push_back(joint);
    for (auto j = joints_below[link].rbegin(); j != joints_below[link].rend(); ++j)
      open.emplace_back(child_of_joint[*j], *j);
  }
  std::vector<std::string> looped;
  int line = 0;
  for (std::size_t l = 0; l < urdf.links.size(); ++l) {
    if (reached[l]) continue;
    if (looped.empty()) line = urdf.links[l].line;
    looped.push_back(urdf.links[l].name);
  }
  if (!looped.empty()) {
    problems.push_back({placeText(file, line, "link", looped.front()),
                        "the links " + listNames(looped) + " are joined in a loop, or hang on one; allowed is a tree"});
  }
  if (problems.size() > before) return std::nullopt;
  return order;
}

std::vector<int> parentLinks(const VehicleDescription& vehicle) {
  std::map<std::string, int> index;
  for (std::size_t l = 0; l < vehicle.links.size(); ++l) index.emplace(vehicle.links[l].name, static_cast<int>(l));
  std::vector<int> parents(vehicle.links.size(), -1);
  for (std::size_t j = 0; j < vehicle.joints.size(); ++j) parents[j + 1] = index.at(vehicle.joints[j].parent);
  return parents;
}

std::vector<Pose> linkPosesAtZero(const VehicleDescription& vehicle) {
  const std::vector<int> parents = parentLinks(vehicle);
  std::vector<Pose> X_RL(vehicle.links.size());
  for (std::size_t j = 0; j < vehicle.joints.size(); ++j) X_RL[j + 1] = X_RL[parents[j + 1]] * vehicle.joints[j].X_PJ;
  return X_RL;
}

std::vector<GroupedLink> rigidGroup(const VehicleDescription& vehicle, const std::vector<int>& parents, int link) {
  std::vector<GroupedLink> group = {{link, Pose{}}};
  std::vector<int> place(vehicle.links.size(), -1);
  place[link] = 0;
  for (std::size_t j = link; j < vehicle.joints.size(); ++j) {  // parents come first: one pass finds all
    const int parent = place[parents[j + 1]];
    if (parent < 0 || vehicle.joints[j].type != JointType::kFixed) continue;
    place[j + 1] = static_cast<int>(group.size());
    group.push_back({static_cast<int>(j + 1), group[parent].X_GL * vehicle.joints[j].X_PJ});
  }
  return group;
}

}  // namespace ellipsoid_vehicle_sim
