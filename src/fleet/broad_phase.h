#pragma once

#include "fleet_island.h"

namespace ellipsoid_vehicle_sim {

/// Which ellipsoids of which vehicles could touch within the coming tick: their boxes, widened by what they can move and
/// turn, overlap. Depends on the vehicles' states alone; the pairs come sorted.
class BroadPhase {
 public:
  void reserve(std::size_t members);
  /// The members' dynamics are left posed at their states.
  void find(std::vector<FleetMember>& members, double dt);
  std::vector<PairCandidate>& pairs() { return pairs_; }

 private:
  void sweep(FleetMember& member, double dt) const;
  void addPairs(const std::vector<FleetMember>& members, int a, int b);

  std::vector<int> order_;
  std::vector<PairCandidate> pairs_;
};

}  // namespace ellipsoid_vehicle_sim
