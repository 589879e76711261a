#include "island_shadow.h"

namespace ellipsoid_vehicle_sim {

void IslandShadow::clear() {
  stepper_.clear();
  pairs_.clear();
}

void IslandShadow::addVehicle(ShadowRun& run, const VehicleState& state, int place) {
  run.begin(state);
  stepper_.addVehicle(run.vehicle(), place);
}

void IslandShadow::addPairs(const std::vector<PairCandidate*>& pairs) {
  for (const PairCandidate* pair : pairs) pairs_.push_back(*pair);
  for (PairCandidate& pair : pairs_) stepper_.addPair(pair);
}

bool IslandShadow::agrees(const std::vector<PairCandidate*>& pairs) const {
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const PairMemory &here = pairs_[p].memory, &there = pairs[p]->memory;
    if (pairs_[p].known != pairs[p]->known) return false;
    if (!pairs_[p].known) continue;
    if (here.nhat_W != there.nhat_W || here.depth != there.depth || here.slack != there.slack || here.anchor_W != there.anchor_W)
      return false;
  }
  return true;
}

}  // namespace ellipsoid_vehicle_sim
