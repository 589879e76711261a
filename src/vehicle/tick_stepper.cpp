#include "ellipsoid_vehicle_sim/vehicle/tick_stepper.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "ellipsoid_vehicle_sim/dynamics/integrator.h"
#include "ellipsoid_vehicle_sim/vehicle/drive.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

// Step control [Hairer1993, II.4]: safety, and by how much a step may shrink or grow.
constexpr double kSafety = 0.9, kShrink = 0.1, kGrow = 5.0;
// An error of a speed counts by what it moves in this time [s].
constexpr double kSpeedErrorTime = 0.1;
// Of Euler's methods a body whose axes differ gains energy from turning further than this within a step [rad]: ten-fold in
// a few hundred steps. Such a run is stopped, not shown.
constexpr double kFarthestTurn = 0.8;
// What is left of a tick after its last step, in parts of it, is rounding.
constexpr double kRounding = 1e-9;

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
      sum_(dynamics.makeRate()),
      error_(dynamics.makeRate()),
      trial_(dynamics.makeMotion()),
      scratch_(dynamics.makeMotion()),
      reach_(armOf(model, 0)),
      always_substep_(!model.dynamic_joints.empty()),
      start_touch_(model.ellipsoids.size()),
      implicit_(6 + static_cast<int>(model.dynamic_joints.size())),
      flight_(model, config, dynamics.terrain()) {
  for (MotionRate& k : k_) k = dynamics.makeRate();
  for (MotionRate& k : stages_) k = dynamics.makeRate();
  for (const DynamicJoint& joint : model.dynamic_joints)
    joint_arm_.push_back(model.bodies[joint.body].prismatic ? 1.0 : armOf(model, joint.body));
  if (config.integrator == IntegratorKind::kLinearlyImplicit)
    directions_.assign(static_cast<std::size_t>(implicit_.size()), dynamics.makeRate());
}

TickOutcome TickStepper::advance(VehicleState& state, std::vector<ContactMemory>& before, bool ends_tick) {
  TickOutcome outcome;
  before_ = &before;
  ends_tick_ = ends_tick;
  if (takeFlight(state, outcome)) return outcome;
  switch (config_.integrator) {
    case IntegratorKind::kExplicitEuler:
    case IntegratorKind::kSemiImplicitEuler:
    case IntegratorKind::kRk4: takeWhole(state, outcome); break;
    case IntegratorKind::kRk4Events: takeRk4Events(state, outcome); break;
    case IntegratorKind::kDormandPrince: takeDormandPrince(state, outcome); break;
    case IntegratorKind::kLinearlyImplicit: takeLinearlyImplicit(state, outcome); break;
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

void TickStepper::endStep(VehicleState& state, const Motion& next, double h, std::vector<ContactMemory>& before,
                          TickOutcome& outcome) {
  before_ = &before;
  ends_tick_ = true;
  accept(state, next, h, true, outcome);
  if (!outcome.sane) giveUp(state, before, outcome);
}

void TickStepper::accept(VehicleState& state, const Motion& next, double h, bool last, TickOutcome& outcome) {
  const bool ends_tick = last && ends_tick_;
  if (&state.motion != &next) state.motion = next;
  if (!isSane(state.motion) || turnsTooFar(model_, config_, state.motion)) {
    outcome.sane = false;
    return;
  }
  for (std::size_t p = 0; p < state.profiles.size(); ++p) {
    state.profiles[p].effort = dynamics_.prescribedEffort(static_cast<int>(p));
    if (ends_tick && effortExceeded(model_.prescribed_joints[p], state.profiles[p])) ++outcome.effort_exceeded;
  }
  outcome.passed_through += outcome.steps == 0 ? dynamics_.accept(state, h, *before_, ends_tick)
                                               : dynamics_.accept(state, h, ends_tick);
  ++outcome.steps;
}

// Where nothing can touch: same bits, no search. False: has done nothing.
bool TickStepper::takeFlight(VehicleState& state, TickOutcome& outcome) {
  if (!flight_.advance(state)) return false;
  if (!isSane(state.motion) || turnsTooFar(model_, config_, state.motion)) {
    outcome.sane = false;
    *before_ = state.memory;
    return true;
  }
  // The paths of one rigid body move nothing that has mass.
  for (ProfileState& profile : state.profiles) profile.effort = 0.0;
  dynamics_.acceptFlight(state, config_.dt, *before_, ends_tick_);
  ++outcome.steps;
  return true;
}

void TickStepper::takeWhole(VehicleState& state, TickOutcome& outcome) {
  dynamics_.beginStep(state, config_.dt);
  switch (config_.integrator) {
    case IntegratorKind::kExplicitEuler: explicitEulerStep(dynamics_, state.motion, config_.dt, k_, scratch_); break;
    case IntegratorKind::kSemiImplicitEuler: semiImplicitEulerStep(dynamics_, state.motion, config_.dt, k_, scratch_); break;
    default: rk4Step(dynamics_, state.motion, config_.dt, k_, scratch_); break;
  }
  accept(state, state.motion, config_.dt, true, outcome);
}

// What the step got wrong, as a length [m]: displacement of the base and of what turns with it, of the joints and of the
// friction, and what an error of the speeds moves in a while.
double TickStepper::errorOf(double h) const {
  constexpr double T = kSpeedErrorTime;
  double e = std::max(error_.v.norm() + reach_ * error_.w.norm(), T * (error_.a.norm() + reach_ * error_.alpha.norm()));
  for (std::size_t i = 0; i < model_.dynamic_joints.size(); ++i) {
    const double arm = joint_arm_[i];
    e = std::max({e, arm * std::abs(error_.q[i]), arm * T * std::abs(error_.qd[i]), arm * std::abs(error_.stretch[i])});
  }
  for (const Anchors& anchors : error_.anchor)
    for (const Vector3d& z : anchors) e = std::max(e, z.norm());
  return h * e;
}

void TickStepper::takeDormandPrince(VehicleState& state, TickOutcome& outcome) {
  const double T = config_.dt, floor = dormand_prince::kSmallestPart * T;
  double done = 0.0, h = T;
  while (outcome.sane && T - done > kRounding * T) {
    h = std::min(h, T - done);
    // A rest shorter than the floor would be a step of its own for nothing.
    if (T - done - h < floor) h = T - done;
    dynamics_.beginStep(state, h);
    dormandPrinceStep(dynamics_, state.motion, h, stages_, sum_, error_, trial_);
    const double error = errorOf(h);
    const bool finite = std::isfinite(error) && isSane(trial_);
    const bool held = finite && error <= config_.error_tolerance;
    const double factor = error > 0.0 ? kSafety * std::pow(config_.error_tolerance / error, 0.2) : kGrow;
    const double next = h * (finite ? std::clamp(factor, kShrink, kGrow) : kShrink);
    // A step with what would be left of the tick in it may be nearly two floors long: it cannot be cut, either.
    if (!held && h >= 2.0 * floor) {
      h = std::max(floor, std::min(next, 0.5 * h));
      continue;
    }
    if (!held) ++outcome.floor_steps;
    done += h;
    accept(state, trial_, h, T - done <= kRounding * T, outcome);
    h = std::max(floor, next);
  }
}

}  // namespace ellipsoid_vehicle_sim
