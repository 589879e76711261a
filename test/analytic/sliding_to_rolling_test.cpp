// A ball thrown along the floor without spin. Source: notation.h [SlidingToRolling].
#include <gtest/gtest.h>

#include "support/motions.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Vector3d;

constexpr double kMass = 10.0, kRadius = 0.35, kFriction = 100.0, kSpeed = 5.0, kGravity = 9.81;
constexpr double kInertia = 0.4 * kMass * kRadius * kRadius;
constexpr double kLambda = kFriction * (1.0 / kMass + kRadius * kRadius / kInertia);

/// Contact with damping ratio one; the ball comes down at the speed at which the damper alone carries it, so that the
/// floor pushes with m g or a little more from the first touch on, and the cone is never narrower than at rest. The
/// contact's frequency times the step is 0.1 where steps are short, and 0.3 at 1 ms.
Simulator thrown(IntegratorKind kind, double dt, double mu, FrictionMode mode = FrictionMode::kViscous) {
  const double stiffness = dt < 5e-4 ? 1e7 : 1e6;
  const double damping = 2.0 * std::sqrt(stiffness * kMass);
  SimConfig config = springConfig(kind, dt, stiffness, damping);
  config.allow_unstable = false;
  config.gravity = kGravity;
  config.body_friction = mode;
  config.viscous_friction = kFriction;
  config.mu_static = config.mu_kinetic = mu;
  Simulator simulator = make(solidBody(Vector3d::Constant(kRadius), kMass), flatFloor(), config);
  placeAt(simulator, {0.0, 0.0, kRadius + 1e-12}, {kSpeed, 0.0, -kMass * kGravity / damping});
  return simulator;
}

double speedOf(const Simulator& s) { return s.rootVelocity_W().x(); }
double spinOf(const Simulator& s) { return s.rootAngularVelocity_W().y(); }
double slipOf(const Simulator& s) { return speedOf(s) - spinOf(s) * kRadius; }

TEST(SlidingToRolling, ViscousFrictionGivesTheClosedForm) {
  // Until a step has found the floor there is no friction: at most one step's f u / m = 5e-5 m/s is missing.
  constexpr double kDt = 1e-6, kTolerance = kFriction * kSpeed / kMass * kDt;
  Simulator simulator = thrown(IntegratorKind::kSemiImplicitEuler, kDt, 10.0);
  run(simulator, 0.01);
  EXPECT_NEAR(speedOf(simulator), 4.578125842, kTolerance);
  EXPECT_NEAR(spinOf(simulator), 3.013386840, 2.5 * kTolerance / kRadius);
  run(simulator, 0.09);
  EXPECT_NEAR(speedOf(simulator), 3.614567691, kTolerance);
  EXPECT_NEAR(spinOf(simulator), 9.895945067, 2.5 * kTolerance / kRadius);
}

TEST(SlidingToRolling, SlipDecaysExponentiallyAtTheDefaultTick) {
  // lambda dt = 0.035: RK4 is off by (lambda dt)^5 / 120 = 4e-10 of the slip a step.
  Simulator simulator = thrown(IntegratorKind::kRk4, 1e-3, 10.0);
  run(simulator, 0.01);
  const double u0 = slipOf(simulator), v0 = speedOf(simulator);
  for (int i = 1; i <= 20; ++i) {
    run(simulator, 0.005);
    const double left = std::exp(-kLambda * 0.005 * i);
    EXPECT_NEAR(slipOf(simulator), u0 * left, 1e-7);
    const double gone = u0 * kInertia / (kInertia + kMass * kRadius * kRadius) * (1.0 - left);
    EXPECT_NEAR(speedOf(simulator), v0 - gone, 1e-7);
  }
}

TEST(SlidingToRolling, EndsAtFiveSeventhsOfTheSpeedAndThenRollsForEver) {
  for (const IntegratorKind kind : allIntegrators()) {
    Simulator simulator = thrown(kind, 1e-3, 10.0);
    run(simulator, 2.0);
    const double rolling = speedOf(simulator);
    // Angular momentum about the track is kept whatever the friction does.
    EXPECT_NEAR(rolling, 5.0 / 7.0 * kSpeed, 1e-9) << toString(kind);
    EXPECT_NEAR(slipOf(simulator), 0.0, 1e-12) << toString(kind);
    run(simulator, 3.0);
    EXPECT_NEAR(speedOf(simulator), rolling, 1e-12) << toString(kind);
  }
}

TEST(SlidingToRolling, EveryFrictionEndsInTheSameRolling) {
  for (const FrictionMode mode : {FrictionMode::kViscous, FrictionMode::kAnchored, FrictionMode::kBrush}) {
    Simulator simulator = thrown(IntegratorKind::kRk4, 1e-3, 0.5, mode);
    run(simulator, 5.0);
    EXPECT_NEAR(speedOf(simulator), 5.0 / 7.0 * kSpeed, 1e-8) << static_cast<int>(mode);
    EXPECT_NEAR(spinOf(simulator) * kRadius, 5.0 / 7.0 * kSpeed, 1e-8) << static_cast<int>(mode);
  }
}

TEST(SlidingToRolling, LosesTheEnergyOfTheSlip) {
  // 1/2 u0^2 m I / (I + m R^2); the fall onto the floor is not counted.
  Simulator simulator = thrown(IntegratorKind::kRk4, 1e-3, 10.0);
  const auto kinetic = [&] {
    return 0.5 * kMass * speedOf(simulator) * speedOf(simulator) +
           0.5 * kInertia * spinOf(simulator) * spinOf(simulator);
  };
  const double before = kinetic();
  run(simulator, 2.0);
  const double lost = 0.5 * kSpeed * kSpeed * kMass * kInertia / (kInertia + kMass * kRadius * kRadius);
  EXPECT_NEAR(before - kinetic(), lost, 1e-7);
}

TEST(SlidingToRolling, TheCapBoundsTheForceUntilTheSlipIsSmall) {
  // mu m g = 49 N is reached at a slip of 0.49 m/s.
  constexpr double kMu = 0.5, kDt = 1e-4;
  const double knee = kMu * kMass * kGravity / kFriction;
  Simulator simulator = thrown(IntegratorKind::kRk4, kDt, kMu);
  const double vz0 = simulator.rootVelocity_W().z();
  run(simulator, 0.01);
  // What the floor pushed is gravity's share plus the change of the vertical speed, exactly: the friction is mu times
  // that, but for the step of first touch, 2 mu g dt at most.
  double pushed = kGravity * 0.01 + simulator.rootVelocity_W().z() - vz0;
  EXPECT_NEAR(speedOf(simulator), kSpeed - kMu * pushed, 2.0 * kMu * kGravity * kDt);
  const double v1 = speedOf(simulator), u1 = slipOf(simulator), vz1 = simulator.rootVelocity_W().z();
  run(simulator, 0.15);
  pushed = kGravity * 0.15 + simulator.rootVelocity_W().z() - vz1;
  EXPECT_NEAR(speedOf(simulator), v1 - kMu * pushed, 1e-10);
  const double until_knee = (u1 - knee) / (kMu * kMass * kGravity * kLambda / kFriction);
  // From the knee on the exponential: u1 and the time of the knee are known, so is everything after it.
  run(simulator, 0.3);
  const double after = 0.45 - until_knee;
  // The step in which the knee falls is off by its own (lambda dt)^2 / 8 of the knee's slip.
  EXPECT_NEAR(slipOf(simulator), knee * std::exp(-kLambda * after), 1e-5);
}

TEST(SlidingToRolling, ALockedBodyStopsAfterMassTimesSpeedOverFriction) {
  // Four feet cannot roll. Together they have the friction f of the formula, stop after m v / f and never turn.
  SimConfig config = springConfig(IntegratorKind::kRk4, 1e-3, 1e5, 500.0);
  config.allow_unstable = false;
  config.gravity = kGravity;
  config.viscous_friction = 25.0;
  config.mu_static = config.mu_kinetic = 10.0;
  Simulator simulator = make(fourFeet(kMass), flatFloor(), config);
  standAt(simulator, 0.0, 0.0, 0.0);
  const Pose rest = simulator.rootPose();
  placeAt(simulator, rest.p + Vector3d(0.0, 0.0, 1e-4), {0.1, 0.0, 0.0});
  run(simulator, 0.2);
  const double v1 = speedOf(simulator), x1 = simulator.rootPose().p.x();
  run(simulator, 3.0);
  // The feet pitch the block a little as they brake it, and it comes up again: its height times that angle, below 1e-5
  // m.
  EXPECT_NEAR(simulator.rootPose().p.x() - x1, kMass * v1 / 100.0, 1e-5);
  EXPECT_LT(std::abs(speedOf(simulator)), 1e-6);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
