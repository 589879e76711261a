#pragma once

#include <vector>

#include "../vehicle/shadow_run.h"
#include "island_stepper.h"

namespace ellipsoid_vehicle_sim {

/// An island beside the island: its vehicles' shadow runs take the tick together from the same state.
class IslandShadow {
 public:
  void clear();
  /// At the state of the tick's start, its drive already that of the tick. In the order of FleetIsland.
  void addVehicle(ShadowRun& run, const VehicleState& state, int place);
  /// After the last vehicle; the pairs are left as they are.
  void addPairs(const std::vector<PairCandidate*>& pairs);

  /// On by the configurations' dt; false: the runs' states are not to be used.
  bool advance(bool ends_tick = true) { return stepper_.advance(ends_tick); }
  /// Whether those pairs end the tick here too as they have ended it there, to the last bit.
  bool agrees(const std::vector<PairCandidate*>& pairs) const;

 private:
  IslandStepper stepper_;
  std::vector<PairCandidate> pairs_;
};

}  // namespace ellipsoid_vehicle_sim
