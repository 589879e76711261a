#include "savings_check.h"

namespace ellipsoid_vehicle_sim {
namespace {

SimConfig wholeOf(SimConfig config) {
  config.exact_savings = ExactSavings::kOff;
  return config;
}

}  // namespace

SavingsCheck::SavingsCheck(const VehicleModel& model, const SimConfig& config, const Terrain& terrain, const VehicleState& state)
    : whole_(model, wholeOf(config), terrain, state) {}

bool SavingsCheck::agrees(const VehicleState& state) { return whole_.advance() && hashOf(whole_.state()) == hashOf(state); }

}  // namespace ellipsoid_vehicle_sim
