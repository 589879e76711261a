#include "wheel_torques.h"

#include <algorithm>
#include <cmath>

namespace ellipsoid_vehicle_sim {
namespace {

// Rate of a controller [1/s] times the step up to which every engine's method holds it.
constexpr double kHeldStep = 0.5;
constexpr double kHoldDampingRatio = 0.7;

}  // namespace

WheelTorques::WheelTorques(const DriveScene& scene, double dt) : scene_(scene), drive_(scene.model.drive) {
  open_ = drive_.layout == DriveLayout::kAckermann && drive_.differential != Differential::kPerWheel;
  for (const WheelUnit& unit : drive_.wheels) {
    Wheel wheel;
    const DynamicJoint& joint = scene.model.dynamic_joints[static_cast<std::size_t>(unit.joint)];
    const double inertia = joint.reflected_inertia, rate = kHeldStep / dt;
    wheel.speed_gain = std::min(drive_.speed_gain, inertia * rate);
    wheel.integral_gain = drive_.speed_gain > 0.0 ? drive_.integral_gain * wheel.speed_gain / drive_.speed_gain : 0.0;
    wheel.lock_gain = std::min(drive_.lock_gain, inertia * rate);
    wheel.hold_stiffness = std::min(joint.hold.stiffness, inertia * rate * rate);
    wheel.hold_damping = std::min(joint.hold.damping, 2.0 * kHoldDampingRatio * inertia * rate);
    wheel.damping = std::min(joint.damping, inertia * rate);
    wheel.friction = joint.friction;
    wheel.angle = wheel.slack = scene.start.q[static_cast<std::size_t>(unit.joint)];
    // What the brake already holds at the start.
    if (joint.hold.stiffness > 0.0)
      wheel.slack -= scene.start.stretch[static_cast<std::size_t>(unit.joint)] * joint.hold.stiffness / wheel.hold_stiffness;
    wheels_.push_back(wheel);
  }
  torque_.assign(wheels_.size(), 0.0);
  for (std::size_t i = 0; i < wheels_.size(); ++i)
    wheels_[i].grows = drive_.wheels[i].driven && scene.series.mode(0.0) == DriveState::Mode::kDrive;
}

template <typename Of>
double WheelTorques::shared(std::size_t i, Of&& of) const {
  if (!open_) return of(i);
  double mean = 0.0;
  int driven = 0;
  for (std::size_t j = 0; j < wheels_.size(); ++j) {
    if (!drive_.wheels[j].driven) continue;
    mean += drive_.wheels[j].forward_sign * of(j);
    ++driven;
  }
  return drive_.wheels[i].forward_sign * mean / std::max(driven, 1);
}

double WheelTorques::error(std::size_t i, double time, const std::vector<double>& speed) const {
  return shared(i, [&](std::size_t j) { return scene_.series.wheelSpeed(static_cast<int>(j), time) - speed[j]; });
}

// How far the wheel fell behind since the step began [rad].
double WheelTorques::behind(std::size_t i, double time, const std::vector<double>& angle) const {
  return shared(i, [&](std::size_t j) {
    const int wheel = static_cast<int>(j);
    return scene_.series.wheelAngle(wheel, time) - scene_.series.wheelAngle(wheel, begun_) -
           (angle[j] - wheels_[j].angle);
  });
}

double WheelTorques::holdLimit(std::size_t i, DriveState::Mode mode) const {
  const WheelUnit& unit = drive_.wheels[i];
  return wheels_[i].friction + (mode == DriveState::Mode::kBrake && unit.braked ? unit.brake_torque : 0.0);
}

void WheelTorques::drive(double time, const std::vector<double>& angle, const std::vector<double>& speed) {
  double power = 0.0;
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    const WheelUnit& unit = drive_.wheels[i];
    const Wheel& wheel = wheels_[i];
    if (!unit.driven) continue;
    const double grown = wheel.grows ? wheel.integral_gain * behind(i, time, angle) : 0.0;
    torque_[i] = std::clamp(wheel.speed_gain * error(i, time, speed) + wheel.integral + grown, -unit.max_torque,
                            unit.max_torque);
    power += std::abs(torque_[i] * speed[i]);
  }
  if (scene_.max_power && power > *scene_.max_power)
    for (double& torque : torque_) torque *= *scene_.max_power / power;
  if (!open_ || drive_.differential != Differential::kLocked) return;
  for (std::size_t i = 0; i < wheels_.size(); ++i)
    if (drive_.wheels[i].driven)
      torque_[i] += wheels_[i].lock_gain * (shared(i, [&](std::size_t j) { return speed[j]; }) - speed[i]);
}

const std::vector<double>& WheelTorques::at(double time, const std::vector<double>& angle,
                                            const std::vector<double>& speed) {
  std::fill(torque_.begin(), torque_.end(), 0.0);
  const DriveState::Mode mode = scene_.series.mode(time);
  if (mode == DriveState::Mode::kDrive) drive(time, angle, speed);
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    const Wheel& wheel = wheels_[i];
    torque_[i] -= wheel.damping * speed[i];
    const double limit = holdLimit(i, mode);
    if (limit <= 0.0) continue;
    const double spring = std::clamp(wheel.hold_stiffness * (angle[i] - wheel.slack), -limit, limit);
    torque_[i] -= std::clamp(spring + wheel.hold_damping * speed[i], -limit, limit);
  }
  return torque_;
}

void WheelTorques::endStep(double time, const std::vector<double>& angle, const std::vector<double>& speed) {
  const DriveState::Mode mode = scene_.series.mode(time);
  // All integrals before any angle moves on: a differential's wheels share theirs.
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    Wheel& wheel = wheels_[i];
    if (wheel.grows) wheel.integral += wheel.integral_gain * behind(i, time, angle);
  }
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    Wheel& wheel = wheels_[i];
    const bool driven = drive_.wheels[i].driven && mode == DriveState::Mode::kDrive;
    if (!driven) wheel.integral = 0.0;
    // None while the torque is at its limit.
    wheel.grows = driven && std::abs(wheel.speed_gain * error(i, time, speed) + wheel.integral) < drive_.wheels[i].max_torque;
    wheel.angle = angle[i];
    // The brake's spring slips where it is at its limit.
    const double stretch = wheel.hold_stiffness > 0.0 ? holdLimit(i, mode) / wheel.hold_stiffness : 0.0;
    wheel.slack = std::clamp(wheel.slack, angle[i] - stretch, angle[i] + stretch);
  }
  begun_ = time;
}

}  // namespace ellipsoid_vehicle_sim
