#pragma once

#include <memory>

#include "ellipsoid_vehicle_sim/scene/scene.h"

namespace ellipsoid_vehicle_sim {

/// A motion known in closed form, made from the scene's own start; see notation.h for the sources.
///   bounce       a body falls flat on a level ground with an undamped spring, again and again: parabolas and, in
///   contact,
///                y'' = g - (k/m) y. Error: height [m].
///   torque_free  a body without contact: parabola of the centre of mass, and the rotation that keeps the angular
///   momentum
///                (its kinematics integrated in steps of 50 us, which leaves rounding). Error: position plus angle
///                times the longest half axis [m].
///   roll_down    a body round about its axle rolls down a slope, a = g sin(alpha) / (1 + I / (m R^2)). Error: of the
///   way
///                in the second half, from the speed at its beginning [m].
///   slide        a body slides on level ground: v = v0 - mu g t until it stops; mu = 0: it goes on. Error: way [m].
///   circle       an Ackermann car at a low speed: radius L / tan(delta) about the point amidships its rear axle.
///   Error:
///                of the radius of the root link's path, second half [m].
///   stop         braking from the speed at the last command: v^2 / (2 a), a = min(max_deceleration, mu g). Error: of
///   the
///                way [m].
///   rest         it stays where it is. Error: distance from the start [m].
class ClosedFormCheck {
 public:
  virtual ~ClosedFormCheck() = default;
  /// After every tick, `time` since the start.
  virtual void watch(const Simulator& simulator, double time) = 0;
  /// At the end; nullopt where the scene does not have what the form needs.
  virtual std::optional<double> error() const = 0;
};

/// Nullptr for ClosedForm::kNone. The simulator is at the scene's start.
std::unique_ptr<ClosedFormCheck> makeClosedFormCheck(const LoadedScene& scene, const Simulator& simulator);

}  // namespace ellipsoid_vehicle_sim
