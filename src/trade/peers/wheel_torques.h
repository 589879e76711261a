#pragma once

#include <vector>

#include "drive_scene.h"

namespace ellipsoid_vehicle_sim {

/// Motors and brakes of a DriveScene's wheels, for every engine the same and as ours: a servo with an integral, limited in
/// torque and power, through the vehicle's differential; a brake that holds by a spring and damper up to its torque. What
/// an engine's step cannot hold is capped to what it can: beyond a millisecond or so they are softer than ours.
class WheelTorques {
 public:
  /// `dt`: the engine's step [s]. The scene must outlive it.
  WheelTorques(const DriveScene& scene, double dt);

  /// Of every wheel unit, in the sign of its joint [N m], within the step that endStep() began. Angles and speeds of
  /// their joints [rad], [rad/s].
  const std::vector<double>& at(double time, const std::vector<double>& angle, const std::vector<double>& speed);
  /// The step has ended at `time`; the next begins.
  void endStep(double time, const std::vector<double>& angle, const std::vector<double>& speed);

 private:
  struct Wheel {
    double speed_gain = 0.0, integral_gain = 0.0, lock_gain = 0.0;
    double hold_stiffness = 0.0, hold_damping = 0.0, damping = 0.0, friction = 0.0;
    double angle = 0.0;     // at the step's start [rad]
    double integral = 0.0;  // of the servo there [N m]
    bool grows = false;     // it does in this step
    double slack = 0.0;     // angle at which the brake's spring is slack [rad]
  };
  double error(std::size_t i, double time, const std::vector<double>& speed) const;
  double behind(std::size_t i, double time, const std::vector<double>& angle) const;
  void drive(double time, const std::vector<double>& angle, const std::vector<double>& speed);
  double holdLimit(std::size_t i, DriveState::Mode mode) const;
  // The mean over the driven wheels where a differential makes them turn as one, else the wheel's own.
  template <typename Of>
  double shared(std::size_t i, Of&& of) const;

  const DriveScene& scene_;
  const DriveModel& drive_;
  bool open_ = false;
  double begun_ = 0.0;  // the step [s]
  std::vector<Wheel> wheels_;
  std::vector<double> torque_;
};

}  // namespace ellipsoid_vehicle_sim
