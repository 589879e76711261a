#pragma once

#include "stepped_vehicle.h"

namespace ellipsoid_vehicle_sim {

/// A run beside the run: takes a tick from the same state under another configuration, with dynamics, contact caches and
/// buffers of its own, so that the run itself knows nothing of it.
class ShadowRun {
 public:
  /// The arguments must outlive it, but for the configuration and the state.
  ShadowRun(const VehicleModel& model, const SimConfig& config, const Terrain& terrain, const VehicleState& state)
      : model_(model),
        config_(config),
        dynamics_(model, config_, terrain),
        stepper_(model, config_, dynamics_),
        state_(state),
        before_(state.memory) {}
  ShadowRun(const ShadowRun&) = delete;
  ShadowRun& operator=(const ShadowRun&) = delete;

  void scaleFriction(double scale) { dynamics_.scaleFriction(scale); }

  /// The state at the start of a tick, its drive already that of the tick.
  void begin(const VehicleState& state) { state_ = state; }
  /// On by config().dt; false: the state is not to be used.
  bool advance(bool ends_tick = true) { return stepper_.advance(state_, before_, ends_tick).sane; }
  /// For a tick with others instead of advance().
  SteppedVehicle vehicle() { return {&model_, &config_, &dynamics_, &stepper_, &state_, &before_}; }

  const SimConfig& config() const { return config_; }
  const VehicleState& state() const { return state_; }

 private:
  const VehicleModel& model_;
  SimConfig config_;
  VehicleDynamics dynamics_;
  TickStepper stepper_;
  VehicleState state_;
  std::vector<ContactMemory> before_;
};

}  // namespace ellipsoid_vehicle_sim
