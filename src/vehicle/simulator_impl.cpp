#include "simulator_impl.h"

#include <cstdio>

#include "ellipsoid_vehicle_sim/vehicle/drive.h"
#include "ellipsoid_vehicle_sim/vehicle/touch_down.h"
#include "rest.h"
#include "set_down.h"

namespace ellipsoid_vehicle_sim {
namespace {

// Energy that a touch-down may add before it is a warning [-].
constexpr double kTouchDownWarned = 0.2;

// A flat ground of the vehicle's own, to stand on while it is certified.
Terrain flatGround(const SimConfig& config) {
  TriangleSoup soup;
  constexpr double kHalfSize = 500.0;
  soup.vertices = {{-kHalfSize, -kHalfSize, 0}, {kHalfSize, -kHalfSize, 0}, {kHalfSize, kHalfSize, 0}, {-kHalfSize, kHalfSize, 0}};
  soup.triangles = {{0, 1, 2}, {0, 2, 3}};
  soup.surface = {0, 0};
  soup.surfaces = {Surface{"flat", config.mu_static, config.mu_kinetic}};
  return std::move(*Terrain::build(std::move(soup)).value);
}

}  // namespace

void Simulator::Impl::allocate() {
  dynamics = std::make_unique<VehicleDynamics>(model, config, *terrain);
  observer = std::make_unique<VehicleDynamics>(model, config, *terrain);
  stepper = std::make_unique<TickStepper>(model, config, *dynamics);
  observed = dynamics->makeRate();
  state = previous = home = restState(model, *dynamics);
  driven = !model.drive.wheels.empty() || !model.prescribed_joints.empty();
  if (config.error_estimate_every > 0.0) needEstimator();
  if (checksSavings()) needSavingsCheck();
  for (const JointDescription& joint : model.description.joints)
    if (joint.type != JointType::kFixed) joint_names.push_back(joint.name);
  for (std::size_t i = 0; i < model.ellipsoids.size(); ++i) {
    const ModelEllipsoid& e = model.ellipsoids[i];
    EllipsoidPlacement placement{e.name, e.link, Pose{}, e.radii, false, ""};
    for (const LinkDescription& link : model.description.links)
      for (const EllipsoidDescription& shape : link.ellipsoids)
        if (link.name == e.link && shape.name == e.name) {
          placement.X_LE = shape.X_LE;
          placement.source = shape.source;
        }
    for (const WheelUnit& wheel : model.drive.wheels)
      placement.ground_wheel = placement.ground_wheel || wheel.ellipsoid == static_cast<int>(i);
    placements.push_back(placement);
  }
}

LocalErrorEstimator& Simulator::Impl::needEstimator() {
  if (!estimator) {
    estimator = std::make_unique<LocalErrorEstimator>(model, config, *terrain, state);
    estimator->scaleFriction(friction_scale);
  }
  return *estimator;
}

SavingsCheck& Simulator::Impl::needSavingsCheck() {
  if (!savings_check) {
    savings_check = std::make_unique<SavingsCheck>(model, config, *terrain, state);
    savings_check->scaleFriction(friction_scale);
  }
  return *savings_check;
}

// The bounds of the step, on a flat ground of the vehicle's own, so that they belong to the vehicle and not to a place.
void Simulator::Impl::certifyVehicle() {
  const Terrain flat = flatGround(config);
  VehicleDynamics on_flat(model, config, flat);
  VehicleState rest;
  const Problems problems = settle(model, config, flat, on_flat, 0.0, 0.0, 0.0, rest);
  if (problems.empty() && config.gravity > 0.0) {
    certificate = certify(model, on_flat, rest, config.contact_substeps);
  } else {
    certificate = certifyContactsAlone(model, config.contact_substeps);
    load_report.push_back("stability: no rest pose on flat ground (" +
                          (problems.empty() ? std::string("no gravity") : problems.front().message) +
                          "); the bounds are those of each contact alone");
  }
  constexpr std::size_t kModesTold = 8;
  for (const std::string& line : describeModes(certificate, config.dt, config.integrator, kModesTold))
    load_report.push_back(line);
  for (int i = 0; i < kIntegratorCount; ++i) {
    char line[320];
    std::snprintf(line, sizeof line, "stability: %s holds steps up to %.4g s (%s)%s", toString(static_cast<IntegratorKind>(i)),
                  certificate.largest_step[i], certificate.worst[i].c_str(),
                  static_cast<IntegratorKind>(i) == config.integrator ? ", in use" : "");
    load_report.emplace_back(line);
  }
}

// What the certificate does not see, for it is of what presses already; told, and no reason to refuse.
void Simulator::Impl::tellTouchDown() {
  const TouchDown worst = worstTouchDown(model, config.integrator, config.dt, config.contact_substeps);
  if (worst.ellipsoid.empty()) return;
  char line[320];
  std::snprintf(line, sizeof line,
                "%stouch-down: within a step of %.4g s %s may add up to %.2g %% to the energy that it comes with (contact of '%s')",
                worst.gain > kTouchDownWarned ? "WARNING " : "", config.dt, toString(config.integrator), 100.0 * worst.gain,
                worst.ellipsoid.c_str());
  load_report.emplace_back(line);
}

Problems Simulator::Impl::checkStep() const {
  const double largest = certificate.largestStep(config.integrator);
  if (config.dt <= largest || config.allow_unstable) return {};
  char text[400];
  std::snprintf(text, sizeof text,
                "is %.6g s, more than %s can hold for this vehicle: %s; allowed are steps up to %.6g s "
                "(or softer contacts, another integrator, or allow_unstable: true to see it fail)",
                config.dt, toString(config.integrator), certificate.worst[static_cast<int>(config.integrator)].c_str(), largest);
  return {{"parameter 'dt'", text}};
}

bool Simulator::Impl::beginTick() {
  bool timed_out = false;
  if (resting) {
    // Motion and contacts are what they were; the drive alone goes on.
    updateDrive(model, config, state, timed_out);
    resting = isLeftAlone(state);
    previous.drive = state.drive;
    return timed_out;
  }
  // The memories of contacts change in accept() only, which hands over the old ones.
  previous.motion = state.motion;
  if (driven || state.drive.has_command) {
    previous.profiles = state.profiles;
    previous.treads = state.treads;
    previous.drive = state.drive;
    // One command for the whole tick: every evaluation sees the same input.
    updateDrive(model, config, state, timed_out);
  }
  resting = config.rest_detection && isStill(state) && isLeftAlone(state) && balanced();
  return timed_out;
}

void Simulator::Impl::restTick(bool timed_out) {
  const bool estimates = estimatesNow();
  events.command_timeouts += timed_out ? 1 : 0;
  ++step_count;
  if (estimates) estimate = ErrorEstimate{step_count};
}

StepStatus Simulator::Impl::endTick(const TickOutcome& outcome, bool timed_out) {
  if (!outcome.sane) {
    state = previous;
    status = StepStatus::kDiverged;
    return status;
  }
  events.effort_exceeded += outcome.effort_exceeded;
  events.command_timeouts += timed_out ? 1 : 0;
  events.passed_through += outcome.passed_through;
  events.floor_steps += outcome.floor_steps;
  ++step_count;
  observed_fresh = false;
  return status;
}

StepStatus Simulator::Impl::step() {
  if (status != StepStatus::kOk) return status;  // never build on a broken state
  const bool timed_out = beginTick();
  if (resting) {
    restTick(timed_out);
    return status;
  }
  const bool estimates = estimatesNow();
  if (estimates) estimator->begin(state);
  if (checksSavings()) savings_check->begin(state);
  const TickOutcome outcome = stepper->advance(state, previous.memory);
  if (outcome.sane && estimates && estimator->end(state, estimate)) estimate.step = step_count + 1;
  if (outcome.sane && checksSavings() && !savings_check->agrees(state)) ++events.savings_differences;
  return endTick(outcome, timed_out);
}

bool Simulator::Impl::balanced() {
  observed_fresh = false;  // whoever looked before saw another drive
  observe();
  return isBalanced(observed);
}

void Simulator::Impl::observe() {
  if (observed_fresh) return;
  observer->evaluate(state, observed, outside);
  observed_fresh = true;
}

void Simulator::Impl::becomeHome(const VehicleState& placed) {
  home = placed;
  restart();
}

void Simulator::Impl::restart() {
  state = previous = home;
  status = StepStatus::kOk;
  events = StepEvents{};
  estimate = ErrorEstimate{};
  resting = false;
  forgetOthers();
  beginAccount();
}

void Simulator::Impl::beginAccount() {
  if (!config.energy_balance) return;
  state.motion.work = Work{};
  energy_at_start = energy();
}

double Simulator::Impl::energy() {
  observe();
  return observer->kineticEnergy(state.motion) + observer->potentialEnergy(state.motion);
}

void Simulator::Impl::forgetOthers() {
  touched.clear();
  outside.clear();
  observed_fresh = false;
  ++times_placed;
}

}  // namespace ellipsoid_vehicle_sim
