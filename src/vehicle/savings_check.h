#pragma once

#include "shadow_run.h"

namespace ellipsoid_vehicle_sim {

/// exact_savings: checked. Beside every tick the whole model takes it too, with everything worked out anew: what is left out
/// must not change a bit of the state.
class SavingsCheck {
 public:
  /// The arguments must outlive it.
  SavingsCheck(const VehicleModel& model, const SimConfig& config, const Terrain& terrain, const VehicleState& state);

  void scaleFriction(double scale) { whole_.scaleFriction(scale); }

  /// The state at the start of a tick, its drive already that of the tick.
  void begin(const VehicleState& state) { whole_.begin(state); }
  /// Whether the whole model ends the tick in `state` too, to the last bit.
  bool agrees(const VehicleState& state) { return whole_.advance() && isAt(state); }

  /// For a tick with others, instead of agrees(): the run that takes it with theirs, and whether it ended in `state`.
  ShadowRun& run() { return whole_; }
  bool isAt(const VehicleState& state) const { return hashOf(whole_.state()) == hashOf(state); }

 private:
  ShadowRun whole_;
};

}  // namespace ellipsoid_vehicle_sim
