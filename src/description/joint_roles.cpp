#include "ellipsoid_vehicle_sim/description/joint_roles.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "role_finder.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr double kDegree = M_PI / 180.0;
constexpr double kFullTurn = 340.0 * kDegree;  // a joint that turns this far has no limits to speak of

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

const double kLevel = std::sin(20.0 * kDegree);    // of |z| of a level axis, at most
const double kLateral = std::cos(20.0 * kDegree);  // of |y| of a lateral axis, at least
const double kUpright = std::cos(30.0 * kDegree);  // of |z| of an upright axis, at least

RoleFinder::RoleFinder(VehicleDescription& vehicle, const std::vector<std::vector<CollisionShape>>& shapes,
                       const RoleHints& hints, Problems& problems, std::vector<std::string>& notes)
    : vehicle_(vehicle),
      shapes_(shapes),
      hints_(hints),
      problems_(problems),
      notes_(notes),
      parents_(parentLinks(vehicle)),
      X_RL_(linkPosesAtZero(vehicle)),
      wheel_of_joint_(vehicle.joints.size(), -1) {}

std::vector<GroundWheel> RoleFinder::find() {
  guessAxes();
  findForward();
  findWheels();
  for (std::size_t j = 0; j < vehicle_.joints.size(); ++j) {
    if (wheel_of_joint_[j] < 0) classify(static_cast<int>(j));
  }
  chooseDriven();
  chooseLayout();
  return wheels_;
}

const JointRole* RoleFinder::overruled(int j) const {
  const auto found = hints_.roles.find(vehicle_.joints[j].name);
  return found == hints_.roles.end() ? nullptr : &found->second;
}

bool RoleFinder::forcedWheel(int j) const {
  const JointRole* role = overruled(j);
  return (role && (*role == JointRole::kDrive || *role == JointRole::kFreeWheel)) ||
         (!role && contains(hints_.drive_joints, vehicle_.joints[j].name));
}

bool RoleFinder::turnsFully(int j) const { return vehicle_.joints[j].upper - vehicle_.joints[j].lower >= kFullTurn; }

bool RoleFinder::upright(int j) const { return std::abs(axes_F_[j].z()) >= kUpright; }

bool RoleFinder::named(int j) const {
  return std::any_of(hints_.transmissions.begin(), hints_.transmissions.end(),
                     [&](const TransmissionText& t) { return t.joint == vehicle_.joints[j].name; });
}

bool RoleFinder::hasAbove(int j, JointRole role, bool only_upright) const {
  for (int a = above(j); a >= 0; a = above(a)) {
    if (vehicle_.joints[a].role == role && (!only_upright || (isRotary(vehicle_.joints[a].type) && upright(a))))
      return true;
  }
  return false;
}

std::vector<PlacedShape> RoleFinder::shapesOf(int j) const {
  std::vector<PlacedShape> placed;
  for (const GroupedLink& g : rigidGroup(vehicle_, parents_, j + 1)) {
    for (const CollisionShape& s : shapes_[g.link]) placed.push_back({&s, g.X_GL * s.X_LS});
  }
  return placed;
}

std::vector<GroundWheel> assignRoles(VehicleDescription& vehicle,
                                     const std::vector<std::vector<CollisionShape>>& shapes, const RoleHints& hints,
                                     Problems& problems, std::vector<std::string>& notes) {
  return RoleFinder(vehicle, shapes, hints, problems, notes).find();
}

std::map<std::string, JointRole> rolesFromWords(const std::vector<std::string>& words, const std::string& where,
                                                Problems& problems) {
  constexpr std::array<JointRole, 7> kRoles = {JointRole::kLocked,    JointRole::kDrive,      JointRole::kFreeWheel,
                                               JointRole::kSteer,     JointRole::kSuspension, JointRole::kPassive,
                                               JointRole::kPrescribed};
  std::map<std::string, JointRole> roles;
  for (const std::string& word : words) {
    const std::size_t equals = word.find('=');
    const std::string role_name = equals == std::string::npos ? "" : word.substr(equals + 1);
    const auto role = std::find_if(kRoles.begin(), kRoles.end(),
                                   [&role_name](JointRole candidate) { return role_name == toString(candidate); });
    if (role == kRoles.end()) {
      std::string known;
      for (const JointRole candidate : kRoles) known += (known.empty() ? "" : ", ") + std::string(toString(candidate));
      problems.push_back({where, "'" + word + "' is not JOINT=ROLE with one of the roles " + known});
    } else {
      roles[word.substr(0, equals)] = *role;
    }
  }
  return roles;
}

std::optional<double> forwardFromWord(const std::string& word, const std::string& where, Problems& problems) {
  const std::array<std::pair<const char*, double>, 4> directions = {
      {{"x", 0.0}, {"-x", M_PI}, {"y", 0.5 * M_PI}, {"-y", -0.5 * M_PI}}};
  if (word.empty() || word == "auto") return std::nullopt;
  for (const auto& [name, yaw] : directions) {
    if (word == name) return yaw;
  }
  problems.push_back({where, "'" + word + "' is no direction; allowed are auto, x, -x, y, -y of the root link"});
  return std::nullopt;
}

}  // namespace ellipsoid_vehicle_sim
