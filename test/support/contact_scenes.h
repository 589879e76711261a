#pragma once

#include <gtest/gtest.h>

#include <cctype>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "../../src/vehicle/set_down.h"
#include "ellipsoid_vehicle_sim/vehicle/tick_stepper.h"
#include "ellipsoid_vehicle_sim/vehicle/vehicle_dynamics.h"
#include "support/scenes.h"

/// Worlds and bodies for the tests of the contact layer.
namespace ellipsoid_vehicle_sim::test {

/// The corners of a profile z(x), pulled along y: one strip per piece, front to the left of the walking direction +x.
inline TriangleSoup profileSoup(const std::vector<Eigen::Vector2d>& xz, double half_width = 50.0) {
  TriangleSoup soup;
  for (std::size_t i = 0; i + 1 < xz.size(); ++i) {
    const auto at = [&](std::size_t j, double y) { return Eigen::Vector3d(xz[j].x(), y, xz[j].y()); };
    addQuad(soup, at(i, -half_width), at(i + 1, -half_width), at(i + 1, half_width), at(i, half_width));
  }
  return soup;
}

/// Ridges and valleys of the given slope [rad], `length` from ridge to valley.
inline TriangleSoup sawtoothSoup(double slope, double length, int teeth) {
  std::vector<Eigen::Vector2d> xz;
  for (int i = -teeth; i <= teeth; ++i) xz.emplace_back(i * length, i % 2 == 0 ? 0.0 : length * std::tan(slope));
  return profileSoup(xz);
}

/// Ground at z = 0 for x < 0, a kerb of the given height at x = 0, its top beyond.
inline TriangleSoup kerbSoup(double height) {
  return profileSoup({{-50.0, 0.0}, {0.0, 0.0}, {0.0, height}, {50.0, height}});
}

/// Flat ground that bends by `angle` [rad] at x = 0: up (a valley) when positive, down (a ridge) when negative.
inline TriangleSoup bendSoup(double angle) {
  return profileSoup({{-200.0, 0.0}, {0.0, 0.0}, {200.0 * std::cos(angle), 200.0 * std::sin(angle)}});
}

/// Ground z = 0 with a wall at x = 0 that faces -x; the ground goes on below it.
inline TriangleSoup groundAndWallSoup() {
  TriangleSoup soup;
  addQuad(soup, {-50, -50, 0}, {50, -50, 0}, {50, 50, 0}, {-50, 50, 0});
  addQuad(soup, {0, 50, -1}, {0, -50, -1}, {0, -50, 5}, {0, 50, 5});
  return soup;
}

/// Settings under which a solid body meets the world without friction: stiffness 1e7 N/m and the given damping.
inline SimConfig frictionless(IntegratorKind integrator, double dt, ContactsPerEllipsoid contacts, double damping) {
  SimConfig config;
  config.integrator = integrator;
  config.dt = dt;
  config.contacts_per_ellipsoid = contacts;
  config.stiffness = 1e7;
  config.damping = damping;
  config.mu_static = config.mu_kinetic = 0.0;
  config.allow_no_wheels = true;
  return config;
}

/// A vehicle stepped by its rate function alone: no certificate, no range of gravity, no clock, so that hundreds of
/// runs cost nothing but their steps. Does in a step what the simulator does.
class BareRun {
 public:
  BareRun(const VehicleDescription& vehicle, std::shared_ptr<const Terrain> terrain, const SimConfig& config)
      : config_(config), terrain_(std::move(terrain)) {
    // The model is checked at a common gravity; the run may have any.
    SimConfig common = config;
    common.gravity = std::min(config.gravity, 100.0);
    Loaded<VehicleModel> model = compileVehicle(vehicle, common);
    if (!model) throw std::runtime_error(problemText(model.problems));
    model_ = std::move(*model.value);
    dynamics_ = std::make_unique<VehicleDynamics>(model_, config_, *terrain_);
    observer_ = std::make_unique<VehicleDynamics>(model_, config_, *terrain_);
    stepper_ = std::make_unique<TickStepper>(model_, config_, *dynamics_);
  }
  BareRun(const BareRun&) = delete;
  BareRun& operator=(const BareRun&) = delete;

  void place(const Eigen::Vector3d& p, const Eigen::Quaterniond& q = Eigen::Quaterniond::Identity(),
             const Eigen::Vector3d& v = Eigen::Vector3d::Zero(), const Eigen::Vector3d& w = Eigen::Vector3d::Zero()) {
    state_ = restState(model_, *dynamics_);
    state_.motion.X_WB = Pose{p, q.normalized()};
    state_.motion.v_WB = v;
    state_.motion.w_WB = w;
    dynamics_->beginStep(state_, 0.0);
    dynamics_->accept(state_, 0.0);
    passed_ = 0;
  }
  /// What set-down does after it has found a rest: depth is sag then, and all of it is charged to the springs.
  void settled() {
    for (ContactMemory& memory : state_.memory) memory.slack = 0.0;
  }

  void step() {
    const TickOutcome outcome = stepper_->advance(state_, before_);
    if (!outcome.sane) throw std::runtime_error("the run diverged");
    passed_ += outcome.passed_through;
  }
  void run(double seconds) {
    const auto steps = static_cast<std::int64_t>(std::llround(seconds / config_.dt));
    for (std::int64_t i = 0; i < steps; ++i) step();
  }

  const SimConfig& config() const { return config_; }
  const VehicleModel& model() const { return model_; }
  VehicleState& state() { return state_; }
  const Motion& motion() const { return state_.motion; }
  const Eigen::Vector3d& position() const { return state_.motion.X_WB.p; }
  const Eigen::Vector3d& velocity() const { return state_.motion.v_WB; }
  const ContactMemory& memory() const { return state_.memory[0]; }
  int passedThrough() const { return passed_; }

  /// Contacts at the present state, with their forces.
  const std::vector<ActiveContact>& contacts() {
    MotionRate k = observer_->makeRate();
    observer_->evaluate(state_, k);
    return observer_->activeContacts();
  }
  /// Force of all contacts on the vehicle [N].
  Eigen::Vector3d contactForce() {
    Eigen::Vector3d f = Eigen::Vector3d::Zero();
    for (const ActiveContact& c : contacts()) f += c.force.normal * c.contact.nhat_W + c.force.friction_W;
    return f;
  }
  /// Kinetic, gravity and springs [J].
  double energy() {
    contacts();
    return observer_->kineticEnergy(state_.motion) + observer_->potentialEnergy(state_.motion);
  }
  double kineticEnergy() {
    contacts();
    return observer_->kineticEnergy(state_.motion);
  }

 private:
  SimConfig config_;
  std::shared_ptr<const Terrain> terrain_;
  VehicleModel model_;
  std::unique_ptr<VehicleDynamics> dynamics_, observer_;
  std::unique_ptr<TickStepper> stepper_;
  VehicleState state_;
  std::vector<ContactMemory> before_;
  int passed_ = 0;
};

/// The settings every claim about the memory is tried with.
struct ContactSetting {
  IntegratorKind integrator;
  double dt;
  ContactsPerEllipsoid contacts;
};

inline std::vector<ContactSetting> allContactSettings() {
  std::vector<ContactSetting> all;
  for (const IntegratorKind integrator : allIntegrators())
    for (const double dt : {1e-3, 0.25e-3}) {
      // The three that step within the tick are tried at the default's only: they take long.
      if (integrator > IntegratorKind::kRk4 && dt != 1e-3) continue;
      for (const ContactsPerEllipsoid contacts : {ContactsPerEllipsoid::kOne, ContactsPerEllipsoid::kValley})
        all.push_back({integrator, dt, contacts});
    }
  return all;
}

inline std::string settingName(const testing::TestParamInfo<ContactSetting>& info) {
  const ContactSetting& s = info.param;
  // "rk4_events" becomes "Rk4Events".
  std::string integrator;
  bool upper = true;
  for (const char* c = toString(s.integrator); *c != '\0'; ++c) {
    if (*c != '_') integrator += upper ? static_cast<char>(std::toupper(*c)) : *c;
    upper = *c == '_';
  }
  return integrator + (s.dt == 1e-3 ? "OneMillisecond" : "QuarterMillisecond") +
         (s.contacts == ContactsPerEllipsoid::kOne ? "One" : "Valley");
}

}  // namespace ellipsoid_vehicle_sim::test
