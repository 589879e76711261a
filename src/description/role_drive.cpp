// Which wheels drive, and the layout they make.

#include <algorithm>
#include <limits>

#include "ellipsoid_vehicle_sim/description/number_text.h"
#include "role_finder.h"
#include "role_text.h"

namespace ellipsoid_vehicle_sim {

/// Names of the driven wheels' joints by transmission; empty if none names a wheel.
std::set<std::string> RoleFinder::drivenByTransmission(std::string& why) const {
  std::set<std::string> all, velocity;
  for (const TransmissionText& t : hints_.transmissions) {
    for (const GroundWheel& wheel : wheels_) {
      if (vehicle_.joints[wheel.joint].name != t.joint || hasAbove(wheel.joint, JointRole::kPassive, true)) continue;
      all.insert(t.joint);
      if (t.velocity_interface) velocity.insert(t.joint);
      why = "named by a " + t.element;
    }
  }
  return velocity.empty() ? all : velocity;
}

/// With steering and without a hint: the unsteered wheels, unless steered ones stand both before and behind them.
std::set<std::string> RoleFinder::drivenByLayout(std::string& why) const {
  std::set<std::string> steered, unsteered;
  double front = -std::numeric_limits<double>::infinity(), rear = -front, foremost = front, rearmost = rear;
  for (const GroundWheel& wheel : wheels_) {
    if (hasAbove(wheel.joint, JointRole::kPassive, true)) continue;
    const std::string& name = vehicle_.joints[wheel.joint].name;
    const double x = wheel.p_FC.x();
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

void RoleFinder::chooseDriven() {
  std::set<std::string> driven(hints_.drive_joints.begin(), hints_.drive_joints.end());
  std::string why = "as asked for by parameter";
  if (driven.empty()) driven = drivenByTransmission(why);
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

void RoleFinder::chooseLayout() {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  double left = -kFar, right = kFar, radius = 0.0;            // of the driven wheels
  double front = -kFar, rear = kFar;                          // of those that neither steer nor swivel
  std::set<int> steers;
  int steered_front = 0, steered_rear = 0, casters = 0, hitched = 0, plain = 0, rockers = 0;
  double middle = 0.0;
  for (const GroundWheel& wheel : wheels_) middle += wheel.p_FC.x() / static_cast<double>(wheels_.size());
  vehicle_.layout = DriveLayout::kNone;
  for (const GroundWheel& wheel : wheels_) {
    const bool steered = hasAbove(wheel.joint, JointRole::kSteer, false);
    if (steered) {
      vehicle_.layout = DriveLayout::kAckermann;
      ++(wheel.p_FC.x() >= middle ? steered_front : steered_rear);
    } else if (hasAbove(wheel.joint, JointRole::kPassive, true)) {
      // The words that classifyUpright leaves tell a trailer from a caster.
      bool trailer = false;
      for (int a = above(wheel.joint); a >= 0; a = above(a))
        trailer |= vehicle_.joints[a].role_reason.find("hitch") != std::string::npos;
      ++(trailer ? hitched : casters);
    } else {
      ++plain;
      front = std::max(front, wheel.p_FC.x());
      rear = std::min(rear, wheel.p_FC.x());
    }
    for (int a = above(wheel.joint); a >= 0; a = above(a))
      if (vehicle_.joints[a].role == JointRole::kPassive && isRotary(vehicle_.joints[a].type) && !upright(a)) ++rockers;
    if (joint(wheel.joint).role != JointRole::kDrive) continue;
    left = std::max(left, wheel.p_FC.y());
    right = std::min(right, wheel.p_FC.y());
    radius = std::max(radius, wheel.measure.radius);
  }
  if (vehicle_.layout == DriveLayout::kNone && left - right > 0.5 * radius && radius > 0.0) {
    vehicle_.layout = DriveLayout::kDifferential;
  }

  std::string& text = vehicle_.layout_text;
  if (vehicle_.layout == DriveLayout::kAckermann) {
    const int steered = steered_front + steered_rear;
    text = steered_front > 0 && steered_rear > 0 ? "steered at both ends"
           : steered == 1                        ? (steered_front ? "tricycle steered in front" : "tricycle steered behind")
           : steered_front > 0                   ? "steered in front"
                                                 : "steered behind";
  } else if (vehicle_.layout == DriveLayout::kDifferential) {
    text = front - rear > 0.1 * radius ? "skid-steer on " + wheelCount(static_cast<std::size_t>(plain)) : "differential";
  } else {
    text = wheels_.empty() ? "no wheels" : "nothing to steer by";
  }
  if (rockers > 0) text += ", on rockers";
  if (casters > 0) text += ", " + std::to_string(casters) + (casters == 1 ? " caster" : " casters");
  if (hitched > 0) text += ", with a trailer";
}

}  // namespace ellipsoid_vehicle_sim
