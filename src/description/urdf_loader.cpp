#include "ellipsoid_vehicle_sim/description/urdf_loader.h"

#include <console_bridge/console.h>
#include <urdf_parser/urdf_parser.h>

#include <cmath>
#include <exception>
#include <filesystem>
#include <mutex>
#include <utility>

#include "ellipsoid_vehicle_sim/description/joint_roles.h"
#include "ellipsoid_vehicle_sim/description/number_text.h"
#include "ellipsoid_vehicle_sim/description/shapes_to_ellipsoids.h"
#include "ellipsoid_vehicle_sim/description/urdf_text.h"
#include "ellipsoid_vehicle_sim/description/vehicle_tree.h"
#include "ellipsoid_vehicle_sim/description/xacro.h"
#include "text_to_description.h"

namespace ellipsoid_vehicle_sim {
namespace {

/// More is no help to anybody.
constexpr std::size_t kMostProblems = 200;

/// Collects what urdfdom would print, while it lives. console_bridge has one output for the whole process, hence the
/// lock.
class UrdfdomChatter : public console_bridge::OutputHandler {
 public:
  UrdfdomChatter() : lock_(mutex()), previous_(console_bridge::getOutputHandler()) {
    console_bridge::useOutputHandler(this);
  }
  ~UrdfdomChatter() override { console_bridge::useOutputHandler(previous_); }
  UrdfdomChatter(const UrdfdomChatter&) = delete;
  UrdfdomChatter& operator=(const UrdfdomChatter&) = delete;

  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level < console_bridge::CONSOLE_BRIDGE_LOG_ERROR) return;
    if (said_.find(text) == std::string::npos) said_ += (said_.empty() ? "" : "; ") + text;
  }
  std::string said() const { return said_.empty() ? "it gives no reason" : "it says: " + said_; }

 private:
  static std::mutex& mutex() {
    static std::mutex only;
    return only;
  }
  std::lock_guard<std::mutex> lock_;
  console_bridge::OutputHandler* previous_;
  std::string said_;
};

/// Every link urdfdom kept less of than the text holds. It parses a link up to the first element it cannot read and
/// keeps it as far as it got (model.cpp ignores the result of parseLink), so RViz and robot_state_publisher would show,
/// and other simulators run, another vehicle than the file describes.
void compareWithUrdfdom(const std::string& text, const UrdfText& urdf, const std::string& file, bool already_refused,
                        Problems& problems) {
  UrdfdomChatter chatter;
  urdf::ModelInterfaceSharedPtr model;
  std::string thrown;
  try {
    model = urdf::parseURDF(text);
  } catch (const std::exception& error) {
    thrown = error.what();
  }
  if (!model) {
    // One reason is enough: what we refused with line and value, urdfdom mostly refuses too.
    if (already_refused) return;
    problems.push_back({file, "urdfdom, and with it every ROS tool, refuses this file; " +
                                  (thrown.empty() ? chatter.said() : "it says: " + thrown)});
    return;
  }
  for (const LinkText& link : urdf.links) {
    if (!link.complete) continue;
    const auto found = model->links_.find(link.name);
    const bool there = found != model->links_.end() && found->second;
    const auto compare = [&](const char* element, int in_text, std::size_t read) {
      if (static_cast<std::size_t>(in_text) == read) return;
      problems.push_back({placeText(file, link.line, "link", link.name),
                          "urdfdom, and with it every ROS tool, keeps " + std::to_string(read) + " of " +
                              std::to_string(in_text) + " <" + element + ">; allowed is a link it reads whole; " +
                              chatter.said()});
    };
    compare("inertial", link.inertial_count, there && found->second->inertial ? 1 : 0);
    compare("visual", link.visual_count, there ? found->second->visual_array.size() : 0);
    compare("collision", link.collision_count, there ? found->second->collision_array.size() : 0);
  }
}

/// One note for all pictures that are not there: nothing but RViz misses them.
void noteMissingVisuals(const UrdfText& urdf, const ShapeBuilder& builder, const std::string& file,
                        std::vector<std::string>& notes) {
  int missing = 0;
  std::string first;
  for (const LinkText& link : urdf.links) {
    for (const ShapeText& visual : link.visuals) {
      if (builder.visualExists(visual)) continue;
      if (missing++ == 0)
        first = placeText(file, visual.line, "link", link.name) + ": visual mesh \"" + visual.filename + "\"";
    }
  }
  if (missing == 1) notes.push_back(first + " was not found; nothing that collides is missing");
  if (missing > 1) {
    notes.push_back(first + " and " + std::to_string(missing - 1) +
                    " more visual meshes were not found; nothing that collides is missing");
  }
}

/// A vehicle has to touch the ground with something, and what has joints is meant to drive.
void checkGroundContact(const VehicleDescription& vehicle, const std::vector<GroundWheel>& wheels, Problems& problems,
                        std::vector<std::string>& notes) {
  bool collides = false;
  for (const LinkDescription& link : vehicle.links) collides = collides || !link.ellipsoids.empty();
  if (!collides) problems.push_back({vehicle.file, "no link has a <collision>; a vehicle needs one to stand on"});
  if (!wheels.empty() || !collides) return;
  std::string reasons;
  for (const JointDescription& joint : vehicle.joints) {
    if (joint.type != JointType::kFixed) reasons += "; joint '" + joint.name + "': " + joint.role_reason;
  }
  if (reasons.empty()) {
    notes.push_back(vehicle.file + ": no joints and no wheels: it moves as one body and cannot be driven");
  } else {
    problems.push_back({vehicle.file,
                        "no ground wheel; needed is a joint that turns without limits about a level, lateral axis"
                        " with a round <collision> centred on it (x of the root link is forward)" +
                            reasons});
  }
}

int lineOf(const VehicleDescription& vehicle, const std::string& link) {
  for (const LinkDescription& l : vehicle.links)
    if (l.name == link) return l.line;
  return 0;
}

/// Lints masses and inertias: repairs them, or refuses what cannot be and warns of what is odd.
void lint(VehicleDescription& vehicle, const std::vector<std::vector<CollisionShape>>& shapes,
          const std::vector<GroundWheel>& wheels, const UrdfOptions& options, Loaded<VehicleDescription>& result) {
  const bool refused = !result.problems.empty();
  const std::vector<InertiaFinding> findings = lintInertias(vehicle, shapes, wheels);
  if (options.findings) *options.findings = findings;
  if (options.repair_inertia && !refused) return repairInertias(findings, vehicle, result.notes);
  for (const InertiaFinding& f : findings) {
    const std::string place = placeText(vehicle.file, f.line, "link", f.link);
    const std::string suggested = f.suggestion.empty() ? "" : "; suggested: " + f.suggestion;
    // A mass of 0 is told by checkMasses, with the joint it moves on.
    if (f.kind == InertiaFinding::Kind::kMass && f.message.find("weighs 0 kg") != std::string::npos) {
      for (Problem& problem : result.problems)
        if (problem.where == placeText(vehicle.file, lineOf(vehicle, f.link), "link", f.link)) problem.message += suggested;
      continue;
    }
    if (f.fault && (!f.tolerated || refused)) {
      result.problems.push_back({place, f.message + suggested + ", or repair_inertia: true"});
    } else if (f.fault) {
      result.notes.push_back("WARNING " + place + ": " + f.message +
                             "; with what is fixed to it or held against it the whole can be, so that it is taken as it is" +
                             suggested);
    } else if (!refused) {
      result.notes.push_back("WARNING " + place + ": " + f.message + suggested);
    }
  }
}

Loaded<VehicleDescription> load(const std::string& text, const std::string& file, const UriResolver& resolver,
                                const UrdfOptions& options) {
  Loaded<VehicleDescription> result;
  Problems& problems = result.problems;
  const auto urdf = readUrdfText(text, file, problems, result.notes, options.repair_inertia);
  if (!urdf) return result;

  // Everything that can be said about the file by itself, before the first refusal stops the work.
  RoleHints hints{urdf->transmissions, options.roles, options.drive_joints, options.forward_yaw, {}};
  for (const JointText& joint : urdf->joints)
    if (!joint.axis) hints.without_axis.insert(joint.joint.name);
  checkHints(hints, urdf->joints, file, problems);
  const auto order = orderTree(*urdf, file, problems);
  VehicleDescription vehicle = order ? describe(*urdf, *order, file, problems, result.notes) : VehicleDescription{};
  if (!order) checkJointsAndInertias(*urdf, file, problems, result.notes);

  ShapeBuilder builder(file, resolver, options.read_mesh ? options.read_mesh : readMeshVertices);
  std::vector<std::vector<CollisionShape>> shapes;
  for (std::size_t l = 0; l < urdf->links.size(); ++l) {
    const LinkText& link = urdf->links[order ? order->links[l] : l];
    shapes.push_back(builder.build(link, problems, result.notes));
  }
  noteMissingVisuals(*urdf, builder, file, result.notes);
  if (order) checkMasses(vehicle, *urdf, options.roles, options.repair_inertia, problems);
  // Links joined in a ring hold each other in urdfdom's memory for ever; where there is no tree all has been said.
  if (order) compareWithUrdfdom(text, *urdf, file, !problems.empty(), problems);
  if (!problems.empty()) {
    // What the lint would say of single links is worth hearing all the same.
    if (order) lint(vehicle, shapes, {}, options, result);
    return result;
  }

  const auto wheels = assignRoles(vehicle, shapes, hints, problems, result.notes);
  lint(vehicle, shapes, wheels, options, result);
  addEllipsoids(vehicle, shapes, wheels, ShapeRules{options.body_ellipsoids}, result.notes);
  addSurfaces(vehicle, *urdf, wheels, result.notes);
  checkGroundContact(vehicle, wheels, problems, result.notes);
  noteEffortLimits(vehicle, *urdf, result.notes);
  if (problems.empty()) result.value = std::move(vehicle);
  return result;
}

Loaded<VehicleDescription> loadGuarded(const std::string& text, const std::string& file, const UriResolver& resolver,
                                       const UrdfOptions& options) {
  // The passed-in functions are the caller's, and a file may be larger than the memory: neither may end the program.
  try {
    Loaded<VehicleDescription> loaded = load(text, file, resolver, options);
    if (const std::size_t count = loaded.problems.size(); count > kMostProblems) {
      loaded.problems.resize(kMostProblems);
      loaded.problems.push_back({file, "and " + std::to_string(count - kMostProblems) + " more problems"});
    }
    return loaded;
  } catch (const std::exception& error) {
    return {std::nullopt, {{file, std::string("loading stopped: ") + error.what()}}, {}};
  }
}

}  // namespace

Loaded<VehicleDescription> loadUrdfText(const std::string& text, const std::string& name, const UriResolver& resolver,
                                        const UrdfOptions& options) {
  if (resolver) return loadGuarded(text, name, resolver, options);
  const auto dirs = options.package_dirs.empty() ? std::vector<std::string>{"."} : options.package_dirs;
  return loadGuarded(text, name, fileResolver(dirs, "."), options);
}

Loaded<VehicleDescription> loadUrdfFile(const std::string& path, const UriResolver& resolver,
                                        const UrdfOptions& options) {
  Loaded<std::string> text = readVehicleText(path);
  if (!text) return {std::nullopt, text.problems, {}};
  std::string folder = std::filesystem::path(path).parent_path().string();
  if (folder.empty()) folder = ".";
  const auto dirs = options.package_dirs.empty() ? packageDirsOf(path) : options.package_dirs;
  Loaded<VehicleDescription> loaded =
      loadGuarded(*text.value, path, resolver ? resolver : fileResolver(dirs, folder), options);
  loaded.notes.insert(loaded.notes.begin(), text.notes.begin(), text.notes.end());
  return loaded;
}

}  // namespace ellipsoid_vehicle_sim
