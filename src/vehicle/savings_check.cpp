#include "savings_check.h"

namespace ellipsoid_vehicle_sim {
namespace {

SimConfig wholeOf(SimConfig config) {
  config.exact_savings = ExactSavings::kOff;
  return config;
}

}  // namespace

SavingsCheck::SavingsCheck(const VehicleModel& model, const SimConfig& config, const Terrain& terrain, const VehicleState& state)
    : whole_(wholeOf(config)),
      dynamics_(model, whole_, terrain),
      stepper_(model, whole_, dynamics_),
      shadow_(state),
      before_(state.memory) {}

bool SavingsCheck::agrees(const VehicleState& state) {
  return stepper_.advance(shadow_, before_).sane && hashOf(shadow_) == hashOf(state);
}

}  // namespace ellipsoid_vehicle_sim
