#include "ellipsoid_vehicle_sim/vehicle/tick_stepper.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "contact_events.h"
#include "ellipsoid_vehicle_sim/vehicle/drive.h"
#include "error_control.h"
#include "linearly_implicit.h"
#include "one_vehicle.h"
#include "whole_step.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

// An error of a speed counts by what it moves in this time [s].
constexpr double kSpeedErrorTime = 0.1;
// Of Euler's methods a body whose axes differ gains energy from turning further than this within a step [rad]: ten-fold in
// a few hundred steps. Such a run is stopped, not shown.
constexpr double kFarthestTurn = 0.8;

// Distance from the origin of `body` to the farthest point that moves with it, about: as far as the links can reach.
double armOf(const VehicleModel& model, int body) {
  double arm = 0.0;
  for (const ModelEllipsoid& ellipsoid : model.ellipsoids) {
    double length = ellipsoid.X_BE.p.norm() + ellipsoid.radii.maxCoeff();
    int at = ellipsoid.body;
    for (; at > body; at = model.bodies[at].parent) length += model.bodies[at].X_PB.p.norm();
    if (at == body) arm = std::max(arm, length);
  }
  return arm;
}

bool turnsTooFar(const VehicleModel& model, const SimConfig& config, const Motion& x) {
  const bool euler = config.integrator == IntegratorKind::kExplicitEuler || config.integrator == IntegratorKind::kSemiImplicitEuler;
  if (!euler || x.w_WB.norm() * config.dt <= kFarthestTurn) return false;
  const Eigen::Vector3d moments = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(model.bodies[0].inertia.I_cm_A, Eigen::EigenvaluesOnly).eigenvalues();
  return moments.maxCoeff() - moments.minCoeff() > 1e-3 * moments.maxCoeff();
}

}  // namespace

TickStepper::TickStepper(const VehicleModel& model, const SimConfig& config, VehicleDynamics& dynamics)
    : model_(model),
      config_(config),
      dynamics_(dynamics),
      reach_(armOf(model, 0)),
      start_touch_(model.ellipsoids.size()),
      matrix_(6 + static_cast<int>(model.dynamic_joints.size())),
      flight_(model, config, dynamics.terrain()) {
  for (MotionRate& k : buffers_.k) k = dynamics.makeRate();
  for (MotionRate& k : buffers_.stages) k = dynamics.makeRate();
  buffers_.sum = buffers_.error = dynamics.makeRate();
  buffers_.trial = buffers_.scratch = dynamics.makeMotion();
  for (const DynamicJoint& joint : model.dynamic_joints)
    joint_arm_.push_back(model.bodies[joint.body].prismatic ? 1.0 : armOf(model, joint.body));
  if (config.integrator == IntegratorKind::kLinearlyImplicit)
    directions_.assign(static_cast<std::size_t>(matrix_.size()), dynamics.makeRate());
}

TickOutcome TickStepper::advance(VehicleState& state, std::vector<ContactMemory>& before, bool ends_tick) {
  TickOutcome outcome;
  if (takeFlight(state, before, ends_tick, outcome)) return outcome;
  OneVehicle vehicle(*this, dynamics_, config_, state, before, ends_tick, outcome);
  switch (config_.integrator) {
    case IntegratorKind::kExplicitEuler:
    case IntegratorKind::kSemiImplicitEuler:
    case IntegratorKind::kRk4:
      dynamics_.beginStep(state, config_.dt);
      wholeStep(dynamics_, config_.integrator, state.motion, config_.dt, buffers_.k, buffers_.scratch);
      accept(state, state.motion, config_.dt, ends_tick, before, outcome);
      break;
    case IntegratorKind::kRk4Events: ContactEvents<OneVehicle>(vehicle).take(); break;
    case IntegratorKind::kDormandPrince: takeByErrorControl(vehicle); break;
    case IntegratorKind::kLinearlyImplicit: LinearlyImplicit<OneVehicle>(vehicle).take(); break;
  }
  if (!outcome.sane) giveUp(state, before, outcome);
  return outcome;
}

void TickStepper::giveUp(VehicleState& state, std::vector<ContactMemory>& before, const TickOutcome& outcome) {
  if (outcome.steps > 0) {
    state.memory = before;
  } else {
    before = state.memory;
  }
}

void TickStepper::accept(VehicleState& state, const Motion& next, double h, bool ends_tick,
                         std::vector<ContactMemory>& before, TickOutcome& outcome) {
  if (&state.motion != &next) state.motion = next;
  if (!isSane(state.motion) || turnsTooFar(model_, config_, state.motion)) {
    outcome.sane = false;
    return;
  }
  for (std::size_t p = 0; p < state.profiles.size(); ++p) {
    state.profiles[p].effort = dynamics_.prescribedEffort(static_cast<int>(p));
    if (ends_tick && effortExceeded(model_.prescribed_joints[p], state.profiles[p])) ++outcome.effort_exceeded;
  }
  outcome.passed_through += outcome.steps == 0 ? dynamics_.accept(state, h, before, ends_tick)
                                               : dynamics_.accept(state, h, ends_tick);
  ++outcome.steps;
}

// Where nothing can touch: same bits, no search. False: has done nothing.
bool TickStepper::takeFlight(VehicleState& state, std::vector<ContactMemory>& before, bool ends_tick, TickOutcome& outcome) {
  if (!flight_.advance(state)) return false;
  if (!isSane(state.motion) || turnsTooFar(model_, config_, state.motion)) {
    outcome.sane = false;
    before = state.memory;
    return true;
  }
  // The paths of one rigid body move nothing that has mass.
  for (ProfileState& profile : state.profiles) profile.effort = 0.0;
  dynamics_.acceptFlight(state, config_.dt, before, ends_tick);
  ++outcome.steps;
  return true;
}

double TickStepper::errorOf(const MotionRate& error, double h) const {
  constexpr double T = kSpeedErrorTime;
  double e = std::max(error.v.norm() + reach_ * error.w.norm(), T * (error.a.norm() + reach_ * error.alpha.norm()));
  for (std::size_t i = 0; i < model_.dynamic_joints.size(); ++i) {
    const double arm = joint_arm_[i];
    e = std::max({e, arm * std::abs(error.q[i]), arm * T * std::abs(error.qd[i]), arm * std::abs(error.stretch[i])});
  }
  for (const Anchors& anchors : error.anchor)
    for (const Vector3d& z : anchors) e = std::max(e, z.norm());
  return h * e;
}

}  // namespace ellipsoid_vehicle_sim
