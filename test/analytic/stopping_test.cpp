// From a speed to rest. Source: notation.h [StoppingDistance].
#include <gtest/gtest.h>

#include "support/motions.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Vector3d;

constexpr double kMu = 0.9, kGravity = 9.81;

SimConfig stoppingConfig(IntegratorKind kind, FrictionMode mode) {
  SimConfig config;
  config.integrator = kind;
  config.gravity = kGravity;
  config.body_friction = mode;
  config.mu_static = config.mu_kinetic = kMu;
  return config;
}

/// Distance until it stands; gives up after `longest` seconds.
double distanceToStop(Simulator& simulator, double longest) {
  const Vector3d start = simulator.rootPose().p;
  const auto most = static_cast<std::int64_t>(longest / simulator.config().dt);
  int still = 0;
  for (std::int64_t i = 0; i < most && still < 100; ++i) {
    if (simulator.step() != StepStatus::kOk) throw std::runtime_error("the simulation diverged");
    still = simulator.rootVelocity_W().norm() < 1e-3 ? still + 1 : 0;
  }
  EXPECT_EQ(still, 100) << "it never stood still";
  return (simulator.rootPose().p - start).norm();
}

TEST(Stopping, ASlidingBlockStopsAfterSpeedSquaredOverTwoMuG) {
  // What the vertical settling does to the speed it undoes again; left is the anchors' spring-back, millimetres.
  for (const double speed : {30.0, 100.0})
    for (const FrictionMode mode : {FrictionMode::kAnchored, FrictionMode::kBrush})
      for (const IntegratorKind kind : allIntegrators()) {
        Simulator simulator = make(fourFeet(50.0, 0.5, 0.4, 0.1), flatFloor(2000.0), stoppingConfig(kind, mode));
        placeAt(simulator, {0.0, 0.0, 0.1 + 1e-9}, {speed, 0.0, 0.0});
        const double expected = speed * speed / (2.0 * kMu * kGravity);
        EXPECT_NEAR(distanceToStop(simulator, 20.0), expected, 3e-4 * expected)
            << toString(kind) << " " << speed << " m/s";
      }
}

TEST(Stopping, TheDirectionMakesNoDifference) {
  for (int i = 0; i < 12; ++i) {
    const double heading = 2.0 * M_PI * i / 12.0 + 0.1;
    Simulator simulator = make(fourFeet(50.0), flatFloor(2000.0),
                               stoppingConfig(IntegratorKind::kSemiImplicitEuler, FrictionMode::kAnchored));
    placeAt(simulator, {0.0, 0.0, 0.1 + 1e-9}, 30.0 * Vector3d(std::cos(heading), std::sin(heading), 0.0));
    const double expected = 900.0 / (2.0 * kMu * kGravity);
    EXPECT_NEAR(distanceToStop(simulator, 10.0), expected, 3e-4 * expected) << i;
  }
}

TEST(Stopping, ACarWithAllWheelsLockedStopsTheSame) {
  // Load moves to the front wheels, but they all slide with the same mu. The car starts at its springs' rest, dives,
  // and comes back: its centre of mass then stands where it should but for the pitch that is left.
  for (const IntegratorKind kind : {IntegratorKind::kSemiImplicitEuler, IntegratorKind::kRk4}) {
    SimConfig config = stoppingConfig(kind, FrictionMode::kAnchored);
    config.max_deceleration = 60.0;  // brakes far beyond what the ground can hold
    Simulator simulator = make(car(), flatFloor(2000.0), config);
    standAt(simulator, 0.0, 0.0, 0.0);
    const Pose rest = simulator.rootPose();
    // A wheel starts in the ground by its sag, which place() does not charge to its spring: lift it out.
    placeAt(simulator, rest.p + Vector3d(0.0, 0.0, simulator.largestPenetration() + 1e-6), {30.0, 0.0, 0.0});
    const double expected = 900.0 / (2.0 * kMu * kGravity);
    const double distance = distanceToStop(simulator, 10.0);
    EXPECT_NEAR(distance, expected, 1e-3 * expected) << toString(kind);
    EXPECT_LT(std::abs(simulator.rootPose().p.y()), 0.01);
  }
}

TEST(Stopping, CappedViscousFrictionStopsAsComputed) {
  // m = 1300 kg, f = 5e4 N s/m in all, 30 m/s: 50.971384 m, most of it on the cone, the tail exponential.
  const double mass = 1300.0, f = 5e4;
  for (const IntegratorKind kind : {IntegratorKind::kSemiImplicitEuler, IntegratorKind::kRk4}) {
    SimConfig config = stoppingConfig(kind, FrictionMode::kViscous);
    config.viscous_friction = 0.25 * f;
    Simulator simulator = make(fourFeet(mass), flatFloor(2000.0), config);
    placeAt(simulator, {0.0, 0.0, 0.1 + 1e-9}, {30.0, 0.0, 0.0});
    const double v1 = kMu * mass * kGravity / f;
    const double expected = (900.0 - v1 * v1) / (2.0 * kMu * kGravity) + mass * v1 / f;
    EXPECT_NEAR(expected, 50.971384, 1e-6);
    EXPECT_NEAR(distanceToStop(simulator, 10.0), expected, 3e-4 * expected) << toString(kind);
  }
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
