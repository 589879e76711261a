#pragma once

#include "ellipsoid_vehicle_sim/vehicle/tick_stepper.h"

namespace ellipsoid_vehicle_sim {

/// exact_savings: checked. Beside every tick the whole model takes it too, with everything worked out anew and buffers of its
/// own: what is left out must not change a bit of the state.
class SavingsCheck {
 public:
  /// The arguments must outlive it.
  SavingsCheck(const VehicleModel& model, const SimConfig& config, const Terrain& terrain, const VehicleState& state);

  void scaleFriction(double scale) { dynamics_.scaleFriction(scale); }

  /// The state at the start of a tick, its drive already that of the tick.
  void begin(const VehicleState& state) { shadow_ = state; }
  /// Whether the whole model ends the tick in `state` too, to the last bit.
  bool agrees(const VehicleState& state);

 private:
  SimConfig whole_;
  VehicleDynamics dynamics_;
  TickStepper stepper_;
  VehicleState shadow_;
  std::vector<ContactMemory> before_;
};

}  // namespace ellipsoid_vehicle_sim
