#include "ellipsoid_vehicle_sim/description/joint_roles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <set>

#include "ellipsoid_vehicle_sim/description/number_text.h"
#include "ellipsoid_vehicle_sim/description/vehicle_tree.h"
#include "role_text.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

constexpr double kDegree = M_PI / 180.0;
const double kLevel = std::sin(20.0 * kDegree);    // of |z| of a level axis, at most
const double kLateral = std::cos(20.0 * kDegree);  // of |y| of a lateral axis, at least
const double kUpright = std::cos(30.0 * kDegree);  // of |z| of an upright axis, at least
constexpr double kFullTurn = 340.0 * kDegree;      // a joint that turns this far has no limits to speak of
constexpr double kLowest = 0.3;                    // radii above the lowest wheel's bottom: still on the ground
constexpr double kHitch = 2.0;                     // radii from the steering axis to its wheels, at most
constexpr double kTrail = 0.1;                     // radii from a swivel's axis to its wheel: a caster trails

bool isRotary(JointType type) { return type == JointType::kContinuous || type == JointType::kRevolute; }

class RoleFinder {
 public:
  RoleFinder(VehicleDescription& vehicle, const std::vector<std::vector<CollisionShape>>& shapes,
             const RoleHints& hints, Problems& problems, std::vector<std::string>& notes)
      : vehicle_(vehicle),
        shapes_(shapes),
        hints_(hints),
        problems_(problems),
        notes_(notes),
        parents_(parentLinks(vehicle)),
        X_RL_(linkPosesAtZero(vehicle)),
        wheel_of_joint_(vehicle.joints.size(), -1) {
    for (std::size_t j = 0; j < vehicle.joints.size(); ++j) {
      axes_R_.push_back(X_RL_[j + 1].q * vehicle.joints[j].axis);
    }
  }

  std::vector<GroundWheel> find() {
    findWheels();
    for (std::size_t j = 0; j < vehicle_.joints.size(); ++j) {
      if (wheel_of_joint_[j] < 0) classify(static_cast<int>(j));
    }
    chooseDriven();
    chooseLayout();
    return wheels_;
  }

 private:
  JointDescription& joint(int j) { return vehicle_.joints[j]; }
  const JointRole* overruled(int j) const {
    const auto found = hints_.roles.find(vehicle_.joints[j].name);
    return found == hints_.roles.end() ? nullptr : &found->second;
  }
  bool forcedWheel(int j) const {
    const JointRole* role = overruled(j);
    return (role && (*role == JointRole::kDrive || *role == JointRole::kFreeWheel)) ||
           (!role && contains(hints_.drive_joints, vehicle_.joints[j].name));
  }
  static bool contains(const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  }
  /// The joint above joint j; -1 above the root's own.
  int above(int j) const { return parents_[j + 1] - 1; }
  bool turnsFully(int j) const { return vehicle_.joints[j].upper - vehicle_.joints[j].lower >= kFullTurn; }
  bool upright(int j) const { return std::abs(axes_R_[j].z()) >= kUpright; }

  std::vector<PlacedShape> shapesOf(int j) const {
    std::vector<PlacedShape> placed;
    for (const GroupedLink& g : rigidGroup(vehicle_, parents_, j + 1)) {
      for (const CollisionShape& s : shapes_[g.link]) placed.push_back({&s, g.X_GL * s.X_LS});
    }
    return placed;
  }

  /// The wheel joint j would be; nullopt if its axis or its shapes rule it out.
  std::optional<GroundWheel> candidate(int j) {
    const bool forced = forcedWheel(j);
    if (!isRotary(joint(j).type) || (overruled(j) && !forced)) return std::nullopt;
    bool below_upright = false;
    for (int a = above(j); a >= 0; a = above(a)) below_upright |= isRotary(joint(a).type) && upright(a);
    const Vector3d& axis = axes_R_[j];
    const bool fits =
        std::abs(axis.z()) <= kLevel && (below_upright || std::abs(axis.y()) >= kLateral) && turnsFully(j);
    if (!fits && !forced) return std::nullopt;
    const auto shapes = shapesOf(j);
    if (shapes.empty()) {
      if (forced) {
        problems_.push_back(
            {placeText(vehicle_.file, joint(j).line, "joint", joint(j).name),
             "it is named as a wheel, and nothing that collides turns with it; allowed is a joint with a"
             " <collision> below it"});
      }
      return std::nullopt;
    }
    GroundWheel wheel;
    wheel.joint = j;
    wheel.measure = measureWheel(shapes, joint(j).axis);
    if (!wheel.measure.round && !forced) return std::nullopt;
    wheel.p_RC = X_RL_[j + 1] * (wheel.measure.axial_centre * joint(j).axis);
    // A spheroid's reach along z: its radius across the axis, its half width along it.
    const double along = std::abs(axis.z());
    wheel.bottom = wheel.p_RC.z() - std::hypot(wheel.measure.radius * std::sqrt(1.0 - std::min(1.0, along * along)),
                                               wheel.measure.half_width * along);
    return wheel;
  }

  void findWheels() {
    std::vector<GroundWheel> candidates;
    double lowest = std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < vehicle_.joints.size(); ++j) {
      if (auto wheel = candidate(static_cast<int>(j))) {
        lowest = std::min(lowest, wheel->bottom);
        candidates.push_back(*wheel);
      }
    }
    for (const GroundWheel& wheel : candidates) {
      const double height = wheel.bottom - lowest;
      if (height > kLowest * wheel.measure.radius && !forcedWheel(wheel.joint)) {
        joint(wheel.joint).role_reason = ", round but " + numberText(height) + " m above the lowest wheel";
        continue;
      }
      wheel_of_joint_[wheel.joint] = static_cast<int>(wheels_.size());
      wheels_.push_back(wheel);
    }
  }

  std::vector<const GroundWheel*> wheelsBelow(int j) const {
    std::vector<const GroundWheel*> below;
    for (const GroundWheel& wheel : wheels_) {
      int a = wheel.joint;
      while (a >= 0 && a != j) a = above(a);
      if (a == j && wheel.joint != j) below.push_back(&wheel);
    }
    return below;
  }

  /// Level distance of the wheels' common middle from the joint's axis, in radii of the wheels.
  double standOff(int j, const std::vector<const GroundWheel*>& wheels) const {
    Vector3d middle = Vector3d::Zero();
    double radius = 0.0;
    for (const GroundWheel* wheel : wheels) middle += wheel->p_RC, radius += wheel->measure.radius;
    const Vector3d arm = middle / static_cast<double>(wheels.size()) - X_RL_[j + 1].p;
    const Vector3d& a = axes_R_[j];
    // Where the axis passes at the wheels' height: a raked kingpin meets the ground away from its joint.
    const Vector3d off = arm - a * (arm.z() / a.z());
    return off.head<2>().norm() * static_cast<double>(wheels.size()) / radius;
  }

  /// Mass or shape on anything that moves with joint j.
  bool carries(int j) const {
    std::vector<bool> below(vehicle_.links.size(), false);
    below[j + 1] = true;
    for (std::size_t k = j; k < vehicle_.joints.size(); ++k) {
      const std::size_t link = k + 1;
      if (link != static_cast<std::size_t>(j + 1)) below[link] = below[parents_[link]];
      if (below[link] && (vehicle_.links[link].mass > 0.0 || !shapes_[link].empty())) return true;
    }
    return false;
  }

  bool named(int j) const {
    for (const TransmissionText& t : hints_.transmissions) {
      if (t.joint == vehicle_.joints[j].name) return true;
    }
    return false;
  }

  void set(int j, JointRole role, const std::string& reason) {
    // What findWheels left there says why it is no wheel.
    const std::string no_wheel = joint(j).role_reason;
    joint(j).role = role;
    joint(j).role_reason = typeText(joint(j).type) + (joint(j).type == JointType::kPrismatic ? " along " : " about ") +
                           axisText(axes_R_[j]) + (reason.empty() ? "" : ", " + reason) + no_wheel;
    if (joint(j).mimic) {
      notes_.push_back(placeText(vehicle_.file, joint(j).line, "joint", joint(j).name) + ": mimics '" +
                       joint(j).mimic->joint + "'; its role is told from its geometry: " + toString(role));
    }
  }

  /// +-180 degrees on a wheel or swivel stand for "turns as it likes"; a stop there would end the first revolution.
  void liftLimits(int j) {
    JointDescription& d = joint(j);
    if (!std::isfinite(d.lower) && !std::isfinite(d.upper)) return;
    notes_.push_back(placeText(vehicle_.file, d.line, "joint", d.name) + ": its limits " + limitsText(d) +
                     " leave a full turn; taken as unlimited");
    d.lower = -std::numeric_limits<double>::infinity();
    d.upper = std::numeric_limits<double>::infinity();
  }

  void classify(int j) {
    const JointDescription& d = joint(j);
    if (d.type == JointType::kFixed) {
      joint(j).role = JointRole::kLocked;
      joint(j).role_reason = "fixed";
      return;
    }
    if (const JointRole* role = overruled(j)) return set(j, *role, "as asked for by parameter");
    if (d.lower == d.upper) {
      notes_.push_back(placeText(vehicle_.file, d.line, "joint", d.name) + ": lower and upper are both " +
                       numberText(d.lower) + ": it cannot move and is locked");
      return set(j, JointRole::kLocked, "its limits leave no room");
    }
    const auto wheels = wheelsBelow(j);
    if (wheels.empty()) return classifyWithoutWheels(j);
    if (d.type == JointType::kPrismatic) {
      if (upright(j)) return set(j, JointRole::kSuspension, wheelCount(wheels.size()) + " below it");
      return set(j, d.spring_stiffness ? JointRole::kSuspension : JointRole::kPrescribed,
                 wheelCount(wheels.size()) + " below it, not upright" + (d.spring_stiffness ? ", sprung" : ""));
    }
    if (upright(j)) return classifyUpright(j, wheels);
    if (d.spring_stiffness) return set(j, JointRole::kSuspension, wheelCount(wheels.size()) + " below it, sprung");
    const bool lateral = std::abs(axes_R_[j].y()) >= kLateral;
    set(j, JointRole::kPassive,
        wheelCount(wheels.size()) + " below it: " + (lateral ? "rocker or bogie" : "pivoting axle"));
  }

  void classifyUpright(int j, const std::vector<const GroundWheel*>& wheels) {
    const double off = standOff(j, wheels);
    const std::string count = wheelCount(wheels.size()) + " below it";
    if (!turnsFully(j)) {
      if (off <= kHitch) return set(j, JointRole::kSteer, "limits " + limitsText(joint(j)) + ", " + count);
      return set(j, JointRole::kPassive, count + ", " + numberText(off) + " radii off its axis: hitch");
    }
    if (named(j) && off < kTrail) return set(j, JointRole::kSteer, "no limits, named by a <transmission>, " + count);
    liftLimits(j);
    set(j, JointRole::kPassive, "no limits, " + count + ": caster swivel");
  }

  void classifyWithoutWheels(int j) {
    const JointDescription& d = joint(j);
    const bool limited = std::isfinite(d.lower) || std::isfinite(d.upper);
    const bool carrying = carries(j);
    if (!limited && !carrying) {
      notes_.push_back(placeText(vehicle_.file, d.line, "joint", d.name) +
                       ": nothing that weighs or collides hangs on it: locked");
      return set(j, JointRole::kLocked, "nothing hangs on it");
    }
    set(j, JointRole::kPrescribed,
        std::string("no ground wheel below it, holds its position") + (carrying ? "" : ", weightless"));
  }

  bool hasAbove(int j, JointRole role, bool only_upright) const {
    for (int a = above(j); a >= 0; a = above(a)) {
      if (vehicle_.joints[a].role == role && (!only_upright || (isRotary(vehicle_.joints[a].type) && upright(a))))
        return true;
    }
    return false;
  }

  /// Names of the driven wheels' joints by transmission; empty if none names a wheel.
  std::set<std::string> drivenByTransmission() const {
    std::set<std::string> all, velocity;
    for (const TransmissionText& t : hints_.transmissions) {
      for (const GroundWheel& wheel : wheels_) {
        if (vehicle_.joints[wheel.joint].name != t.joint || hasAbove(wheel.joint, JointRole::kPassive, true)) continue;
        all.insert(t.joint);
        if (t.velocity_interface) velocity.insert(t.joint);
      }
    }
    return velocity.empty() ? all : velocity;
  }

  /// With steering and without a hint: the unsteered wheels, unless steered ones stand both before and behind them.
  std::set<std::string> drivenByLayout(std::string& why) const {
    std::set<std::string> steered, unsteered;
    double front = -std::numeric_limits<double>::infinity(), rear = -front, foremost = front, rearmost = rear;
    for (const GroundWheel& wheel : wheels_) {
      if (hasAbove(wheel.joint, JointRole::kPassive, true)) continue;
      const std::string& name = vehicle_.joints[wheel.joint].name;
      const double x = wheel.p_RC.x();
      if (hasAbove(wheel.joint, JointRole::kSteer, false)) {
        steered.insert(name), front = std::max(front, x), rear = std::min(rear, x);
      } else {
        unsteered.insert(name), foremost = std::max(foremost, x), rearmost = std::min(rearmost, x);
      }
    }
    if (steered.empty()) {
      why = "without steering all do";
      return unsteered;
    }
    const bool between = !unsteered.empty() && foremost < front && rearmost > rear;
    why = unsteered.empty() || between ? "steered, and no unsteered axle at an end" : "unsteered";
    return unsteered.empty() || between ? steered : unsteered;
  }

  void chooseDriven() {
    std::set<std::string> driven(hints_.drive_joints.begin(), hints_.drive_joints.end());
    std::string why = "as asked for by parameter";
    if (driven.empty()) {
      driven = drivenByTransmission();
      why = "named by a <transmission>";
    }
    if (driven.empty()) {
      driven = drivenByLayout(why);
      const bool steers = std::any_of(vehicle_.joints.begin(), vehicle_.joints.end(),
                                      [](const JointDescription& d) { return d.role == JointRole::kSteer; });
      std::string names;
      for (const std::string& name : driven) names += (names.empty() ? "'" : ", '") + name + "'";
      if (steers && !driven.empty()) {
        notes_.push_back(vehicle_.file +
                         ": nothing says which wheels drive (no <transmission>, no drive_joints): taken are " + names +
                         ", " + why);
      }
    }
    for (const GroundWheel& wheel : wheels_) {
      const int j = wheel.joint;
      const JointRole* role = overruled(j);
      const bool drives = role ? *role == JointRole::kDrive : driven.count(joint(j).name) > 0;
      std::string reason = "wheel r " + numberText(wheel.measure.radius) + ", lowest";
      if (role)
        reason += ", as asked for by parameter";
      else if (drives)
        reason += ", drives: " + why;
      else if (hasAbove(j, JointRole::kPassive, true))
        reason += ", below a swivel or hitch";
      else
        reason += ", not driven";
      liftLimits(j);
      set(j, drives ? JointRole::kDrive : JointRole::kFreeWheel, reason);
    }
  }

  void chooseLayout() {
    vehicle_.layout = DriveLayout::kNone;
    double left = -std::numeric_limits<double>::infinity(), right = -left, radius = 0.0;
    for (const GroundWheel& wheel : wheels_) {
      if (hasAbove(wheel.joint, JointRole::kSteer, false)) vehicle_.layout = DriveLayout::kAckermann;
      if (joint(wheel.joint).role != JointRole::kDrive) continue;
      left = std::max(left, wheel.p_RC.y());
      right = std::min(right, wheel.p_RC.y());
      radius = std::max(radius, wheel.measure.radius);
    }
    if (vehicle_.layout == DriveLayout::kNone && left - right > 0.5 * radius && radius > 0.0) {
      vehicle_.layout = DriveLayout::kDifferential;
    }
  }

  VehicleDescription& vehicle_;
  const std::vector<std::vector<CollisionShape>>& shapes_;
  const RoleHints& hints_;
  Problems& problems_;
  std::vector<std::string>& notes_;
  std::vector<int> parents_;
  std::vector<Pose> X_RL_;
  std::vector<Vector3d> axes_R_;
  std::vector<GroundWheel> wheels_;
  std::vector<int> wheel_of_joint_;
};

}  // namespace

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

}  // namespace ellipsoid_vehicle_sim
