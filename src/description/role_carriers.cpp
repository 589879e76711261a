// What carries wheels: steering, swivels, hitches, suspensions, rockers; and what carries none.

#include <cmath>

#include "ellipsoid_vehicle_sim/description/number_text.h"
#include "role_finder.h"
#include "role_text.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr double kHitch = 2.0;         // radii from the steering axis to its wheels, at most
constexpr double kTrail = 0.1;         // radii from a swivel's axis to its wheel: a caster trails
constexpr double kTurntable = 0.3;     // radii: an axle about its middle
constexpr double kHitchedMass = 0.35;  // of the whole vehicle, on one joint: more than an axle

/// Words that name a lift, where its geometry could be a suspension's.
bool namesLift(const JointDescription& joint) {
  for (const std::string& name : {joint.name, joint.child}) {
    for (const char* word : {"lift", "fork", "mast", "elevat", "Lift", "Fork", "Mast", "Elevat"}) {
      if (name.find(word) != std::string::npos) return true;
    }
  }
  return false;
}

}  // namespace

std::vector<const GroundWheel*> RoleFinder::wheelsBelow(int j) const {
  std::vector<const GroundWheel*> below;
  for (const GroundWheel& wheel : wheels_) {
    int a = wheel.joint;
    while (a >= 0 && a != j) a = above(a);
    if (a == j && wheel.joint != j) below.push_back(&wheel);
  }
  return below;
}

/// Level distance of the wheels' common middle from the joint's axis, in radii of the wheels.
double RoleFinder::standOff(int j, const std::vector<const GroundWheel*>& wheels) const {
  Vector3d middle = Vector3d::Zero();
  double radius = 0.0;
  for (const GroundWheel* wheel : wheels) middle += wheel->p_FC, radius += wheel->measure.radius;
  const Vector3d arm = middle / static_cast<double>(wheels.size()) - X_FL_[j + 1].p;
  const Vector3d& a = axes_F_[j];
  // Where the axis passes at the wheels' height: a raked kingpin meets the ground away from its joint.
  const Vector3d off = arm - a * (arm.z() / a.z());
  return off.head<2>().norm() * static_cast<double>(wheels.size()) / radius;
}

/// Mass or shape on anything that moves with joint j.
bool RoleFinder::carries(int j) const {
  std::vector<bool> below(vehicle_.links.size(), false);
  below[j + 1] = true;
  for (std::size_t k = j; k < vehicle_.joints.size(); ++k) {
    const std::size_t link = k + 1;
    if (link != static_cast<std::size_t>(j + 1)) below[link] = below[parents_[link]];
    if (below[link] && (vehicle_.links[link].mass > 0.0 || !shapes_[link].empty())) return true;
  }
  return false;
}

/// Mass of everything that moves with joint j, as a fraction of the whole.
double RoleFinder::massBelow(int j) const {
  std::vector<bool> below(vehicle_.links.size(), false);
  below[j + 1] = true;
  double mass = 0.0, all = 0.0;
  for (std::size_t link = 0; link < vehicle_.links.size(); ++link) {
    if (link > static_cast<std::size_t>(j + 1)) below[link] = below[parents_[link]];
    all += vehicle_.links[link].mass;
    if (below[link]) mass += vehicle_.links[link].mass;
  }
  return all > 0.0 ? mass / all : 0.0;
}

void RoleFinder::set(int j, JointRole role, const std::string& reason) {
  // What findWheels left there says why it is no wheel.
  const std::string no_wheel = joint(j).role_reason;
  joint(j).role = role;
  joint(j).role_reason = typeText(joint(j).type) + (joint(j).type == JointType::kPrismatic ? " along " : " about ") +
                         axisText(axes_F_[j]) + (reason.empty() ? "" : ", " + reason) + no_wheel;
  if (joint(j).mimic) {
    notes_.push_back(placeText(vehicle_.file, joint(j).line, "joint", joint(j).name) + ": mimics '" +
                     joint(j).mimic->joint + "'; its role is told from its geometry: " + toString(role));
  }
}

/// +-180 degrees on a wheel or swivel stand for "turns as it likes"; a stop there would end the first revolution.
void RoleFinder::liftLimits(int j) {
  JointDescription& d = joint(j);
  if (!std::isfinite(d.lower) && !std::isfinite(d.upper)) return;
  notes_.push_back(placeText(vehicle_.file, d.line, "joint", d.name) + ": its limits " + limitsText(d) +
                   " leave a full turn; taken as unlimited");
  d.lower = -std::numeric_limits<double>::infinity();
  d.upper = std::numeric_limits<double>::infinity();
}

void RoleFinder::classify(int j) {
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
  const std::string count = wheelCount(wheels.size()) + " below it";
  if (d.type == JointType::kPrismatic) {
    // A slide from zero upwards that is called a lift lifts, even if rollers hang on it.
    if (upright(j) && !d.spring_stiffness && namesLift(d))
      return set(j, JointRole::kPrescribed, count + ", called a lift: holds its position");
    if (upright(j)) return set(j, JointRole::kSuspension, count);
    return set(j, d.spring_stiffness ? JointRole::kSuspension : JointRole::kPrescribed,
               count + ", not upright" + (d.spring_stiffness ? ", sprung" : ""));
  }
  if (upright(j)) return classifyUpright(j, wheels);
  if (d.spring_stiffness) return set(j, JointRole::kSuspension, count + ", sprung");
  const bool lateral = std::abs(axes_F_[j].y()) >= kLateral;
  set(j, JointRole::kPassive, count + ": " + (lateral ? "rocker or bogie" : "pivoting axle"));
}

void RoleFinder::classifyUpright(int j, const std::vector<const GroundWheel*>& wheels) {
  const double off = standOff(j, wheels);
  const std::string count = wheelCount(wheels.size()) + " below it";
  // An axle that turns as a whole stands on its axis; a trailer follows behind it.
  const bool heavy = massBelow(j) > kHitchedMass && wheels.size() > 1 && off > kTurntable;
  if (!turnsFully(j)) {
    if (off > kHitch) return set(j, JointRole::kPassive, count + ", " + numberText(off) + " radii off its axis: hitch");
    if (heavy) return set(j, JointRole::kPassive, count + ", and a third of the mass or more: hitch");
    return set(j, JointRole::kSteer, "limits " + limitsText(joint(j)) + ", " + count);
  }
  if (named(j) && off < kTrail) return set(j, JointRole::kSteer, "no limits, named by a <transmission>, " + count);
  // Where all wheels stand below such joints, they can only be meant to steer.
  bool only_swivels = true;
  for (const GroundWheel& wheel : wheels_) {
    bool swivels = false;
    for (int a = above(wheel.joint); a >= 0; a = above(a))
      swivels |= isRotary(joint(a).type) && upright(a) && turnsFully(a);
    only_swivels = only_swivels && swivels;
  }
  if (only_swivels) return set(j, JointRole::kSteer, "no limits, and every wheel stands below such a joint");
  liftLimits(j);
  set(j, JointRole::kPassive, "no limits, " + count + (heavy || off > kHitch * 3.0 ? ": hitch" : ": caster swivel"));
}

void RoleFinder::classifyWithoutWheels(int j) {
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

}  // namespace ellipsoid_vehicle_sim
