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

}  // namespace ellipsoid_vehicle_sim
