#include "local_error.h"

#include <cmath>

namespace ellipsoid_vehicle_sim {
namespace {

SimConfig halfOf(SimConfig config) {
  config.dt *= 0.5;
  return config;
}

int orderOf(IntegratorKind kind) {
  switch (kind) {
    case IntegratorKind::kRk4:
    case IntegratorKind::kRk4Events: return 4;
    case IntegratorKind::kDormandPrince: return 5;
    default: return 1;
  }
}

}  // namespace

LocalErrorEstimator::LocalErrorEstimator(const VehicleModel& model, const SimConfig& config, const Terrain& terrain,
                                         const VehicleState& state)
    : model_(model), halves_(model, halfOf(config), terrain, state) {}

bool LocalErrorEstimator::end(const VehicleState& state, ErrorEstimate& estimate) {
  if (!halves_.advance(false) || !halves_.advance()) return false;
  compare(state, estimate);
  return true;
}

void LocalErrorEstimator::compare(const VehicleState& state, ErrorEstimate& estimate) const {
  const double power = std::pow(2.0, orderOf(halves_.config().integrator));
  const double factor = power / (power - 1.0);
  const Motion &a = state.motion, &b = halves_.state().motion;
  const Eigen::Vector3d p_BR = a.X_WB.q * model_.X_BR.p, other_BR = b.X_WB.q * model_.X_BR.p;
  // The vector part of a small turn's quaternion is half the turn.
  const Eigen::Quaterniond turned = a.X_WB.q * b.X_WB.q.conjugate();
  estimate.position_W = factor * (a.X_WB.p + p_BR - b.X_WB.p - other_BR);
  estimate.rotation_W = factor * (turned.w() < 0.0 ? -2.0 : 2.0) * turned.vec();
  estimate.velocity_W = factor * (a.v_WB + a.w_WB.cross(p_BR) - b.v_WB - b.w_WB.cross(other_BR));
  estimate.angular_velocity_W = factor * (a.w_WB - b.w_WB);
}

}  // namespace ellipsoid_vehicle_sim
