// One wheel rolling with slip: the brush is a linear tyre of stiffness C = k_t l up to its cone.
#include <gtest/gtest.h>

#include "support/motions.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Vector3d;

constexpr double kRadius = 0.35, kStiffnessOfBrush = 1e5, kLength = 0.1, kC = kStiffnessOfBrush * kLength, kMu = 0.9;

/// So heavy that the tyre's force changes its motion by a thousandth a second, in a gravity so small that the load is a
/// car wheel's: 3 kN.
constexpr double kMass = 1e6, kGravity = 3e-3;

struct Rolling {
  double friction_along, friction_across, normal, slip_along, slip_across;  // slip over rolling speed
  bool sliding;
};

/// Rolls at `speed` for some relaxation lengths with the given slip, then looks.
Rolling rolled(IntegratorKind kind, double speed, double slip_along, double slip_across, double heading = 0.0) {
  SimConfig config;
  config.integrator = kind;
  config.gravity = kGravity;
  config.stiffness = 1e7;
  config.damping = 2.0 * std::sqrt(1e7 * kMass);
  config.body_friction = FrictionMode::kBrush;
  config.mu_static = config.mu_kinetic = kMu;
  config.tangential_stiffness = kStiffnessOfBrush;
  config.tangential_damping = 100.0;
  config.brush_length = kLength;
  VehicleDescription wheel = solidBody(Vector3d::Constant(kRadius), kMass);
  Simulator simulator = make(wheel, flatFloor(2000.0), config);
  const Vector3d along(std::cos(heading), std::sin(heading), 0.0), across(-std::sin(heading), std::cos(heading), 0.0);
  const Vector3d v = speed * ((1.0 + slip_along) * along + slip_across * across);
  placeAt(simulator, {0.0, 0.0, kRadius + 1e-9}, v - Vector3d(0.0, 0.0, kMass * kGravity / *config.damping),
          speed / kRadius * across);
  run(simulator, std::max(0.3, 20.0 * kLength / speed));

  const GroundForce force = groundForce(simulator);
  // The slip as it is now: the tyre's force has changed it a little.
  const Vector3d arm(0.0, 0.0, -kRadius);
  const Vector3d turning = simulator.rootAngularVelocity_W().cross(arm);
  const Vector3d slip = simulator.rootVelocity_W() + turning;
  return {force.friction_W.dot(along),      force.friction_W.dot(across),      force.normal,
          slip.dot(along) / turning.norm(), slip.dot(across) / turning.norm(), force.sliding > 0};
}

// To three digits: what the force changes of the motion within a relaxation length, and its lag behind that.
constexpr double kThreeDigits = 1e-3;

TEST(Brush, CorneringForceIsStiffnessTimesTheTangentOfTheSlipAngle) {
  for (const IntegratorKind kind : allIntegrators())
    for (const double angle : {0.001, 0.01, 0.05, 0.1, 0.2}) {
      const Rolling r = rolled(kind, 20.0, 0.0, std::tan(angle));
      ASSERT_FALSE(r.sliding);
      EXPECT_NEAR(r.friction_across, -kC * r.slip_across, kThreeDigits * kC * std::tan(angle))
          << toString(kind) << " " << angle;
      EXPECT_NEAR(r.slip_across, std::tan(angle), 2e-3 * std::tan(angle) + 1e-6);
    }
}

TEST(Brush, StiffnessIsTheSameAtEverySpeed) {
  // Also beyond l / tau = 50 m/s, where the memory of the patch is bounded.
  for (const double speed : {1.0, 5.0, 20.0, 49.0, 51.0, 150.0}) {
    const Rolling r = rolled(IntegratorKind::kRk4, speed, 0.0, 0.1);
    // The force follows the slip after l / v, in which a slow wheel's own motion has changed by 7/2 F / m.
    const double lag = 3.5 * kC * kLength / (kMass * speed * speed);
    EXPECT_NEAR(r.friction_across, -kC * r.slip_across, (kThreeDigits + lag) * kC * 0.1) << speed << " m/s";
  }
}

TEST(Brush, SlipAlongAndAcrossHaveTheSameStiffness) {
  for (const double slip : {-0.1, -0.01, 0.01, 0.1}) {
    const Rolling r = rolled(IntegratorKind::kRk4, 20.0, slip, 0.05);
    EXPECT_NEAR(r.friction_along, -kC * r.slip_along, kThreeDigits * kC * 0.1) << slip;
    EXPECT_NEAR(r.friction_across, -kC * r.slip_across, kThreeDigits * kC * 0.1) << slip;
  }
}

TEST(Brush, HeadingMakesNoDifference) {
  for (int i = 0; i < 12; ++i) {
    const Rolling r = rolled(IntegratorKind::kSemiImplicitEuler, 20.0, 0.02, -0.08, 2.0 * M_PI * i / 12.0);
    EXPECT_NEAR(r.friction_across, -kC * r.slip_across, kThreeDigits * kC * 0.1) << i;
    EXPECT_NEAR(r.friction_along, -kC * r.slip_along, kThreeDigits * kC * 0.1) << i;
  }
}

TEST(Brush, BeyondTheConeTheForceIsExactlyMuTimesTheLoad) {
  for (const IntegratorKind kind : allIntegrators())
    for (const double angle : {0.5, 1.0, 1.4}) {
      const Rolling r = rolled(kind, 20.0, 0.0, std::tan(angle));
      ASSERT_GT(kC * std::tan(angle), 1.2 * kMu * r.normal);
      EXPECT_TRUE(r.sliding);
      EXPECT_NEAR(std::hypot(r.friction_along, r.friction_across), kMu * r.normal, 1e-9 * r.normal) << toString(kind);
      // Against the slip vector.
      EXPECT_NEAR(r.friction_along * r.slip_across, r.friction_across * r.slip_along, 1e-2 * r.normal * r.slip_across);
      EXPECT_LT(r.friction_across * r.slip_across, 0.0);
    }
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
