#pragma once

#include "ellipsoid_vehicle_sim/vehicle/simulator.h"
#include "shadow_run.h"

namespace ellipsoid_vehicle_sim {

/// What one tick gets wrong, by step doubling: beside the tick, a shadow takes the same way in two halves
/// [Hairer1993, II.4]. The difference times
/// 2^p / (2^p - 1) is the error of the whole step, p its order; through touch-downs p = 1 would make twice as much of it.
class LocalErrorEstimator {
 public:
  /// The arguments must outlive it.
  LocalErrorEstimator(const VehicleModel& model, const SimConfig& config, const Terrain& terrain, const VehicleState& state);

  void scaleFriction(double scale) { halves_.scaleFriction(scale); }

  /// The state at the start of a tick, its drive already that of the tick.
  void begin(const VehicleState& state) { halves_.begin(state); }
  /// The state at its end. False: the shadow's state is not to be used, nothing is told.
  bool end(const VehicleState& state, ErrorEstimate& estimate);

  /// For a tick with others, instead of end(): the run that takes its halves with theirs, and the difference to it then.
  ShadowRun& run() { return halves_; }
  void compare(const VehicleState& state, ErrorEstimate& estimate) const;

 private:
  const VehicleModel& model_;
  ShadowRun halves_;
};

}  // namespace ellipsoid_vehicle_sim
