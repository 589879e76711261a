// Bodies on an inclined plane. Source: notation.h [SlopeClosedForm].
#include <gtest/gtest.h>

#include "support/motions.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Vector3d;

constexpr double kDegree = M_PI / 180.0, kGravity = 9.81;

Vector3d downhill(double slope) { return {std::cos(slope), 0.0, -std::sin(slope)}; }
Vector3d uphillNormal(double slope) { return {std::sin(slope), 0.0, std::cos(slope)}; }
std::shared_ptr<const Terrain> plane(double slope) { return terrainOf(floorSoup(500.0, 1, slope)); }

SimConfig slopeConfig(IntegratorKind kind, FrictionMode mode, double mu) {
  SimConfig config;
  config.integrator = kind;
  config.gravity = kGravity;
  config.body_friction = mode;
  config.mu_static = config.mu_kinetic = mu;
  return config;
}

/// Just above the plane, lying along it.
void placeOn(Simulator& simulator, double slope, double height) {
  placeAt(simulator, (height + 1e-9) * uphillNormal(slope), Vector3d::Zero(), Vector3d::Zero(),
          Eigen::Quaterniond(Eigen::AngleAxisd(slope, Vector3d::UnitY())));
}

double accelerationAlong(Simulator& simulator, double slope, double seconds) {
  const double before = simulator.rootVelocity_W().dot(downhill(slope));
  run(simulator, seconds);
  return (simulator.rootVelocity_W().dot(downhill(slope)) - before) / seconds;
}

TEST(Slope, ABlockSlidesWithGravityLessFriction) {
  // Once it has settled on its feet they carry m g cos(slope), whatever each of them does: a = g (sin - mu cos).
  const double slope = 30.0 * kDegree, mu = 0.3;
  for (const FrictionMode mode : {FrictionMode::kAnchored, FrictionMode::kBrush})
    for (const IntegratorKind kind : allIntegrators()) {
      Simulator simulator = make(fourFeet(50.0), plane(slope), slopeConfig(kind, mode, mu));
      placeOn(simulator, slope, 0.1);
      run(simulator, 1.0);
      EXPECT_NEAR(accelerationAlong(simulator, slope, 1.0), kGravity * (std::sin(slope) - mu * std::cos(slope)), 1e-6)
          << toString(kind);
    }
}

/// Largest distance from the start over the time.
double creep(IntegratorKind kind, FrictionMode mode, double seconds) {
  const double slope = 30.0 * kDegree;
  Simulator simulator = make(fourFeet(50.0), plane(slope), slopeConfig(kind, mode, 0.8));
  standAt(simulator, 0.0, 0.0, 0.4);
  run(simulator, 1.0);
  const Vector3d start = simulator.rootPose().p;
  double farthest = 0.0;
  for (int i = 0; i < 60; ++i) {
    run(simulator, seconds / 60.0);
    farthest = std::max(farthest, (simulator.rootPose().p - start).norm());
  }
  return farthest;
}

// Far below anything seen, and far above what 600,000 roundings of 1e-16 m add up to.
constexpr double kNoCreep = 1e-9;

TEST(Slope, AnAnchoredBlockStaysForTenMinutes) {
  EXPECT_LT(creep(IntegratorKind::kSemiImplicitEuler, FrictionMode::kAnchored, 600.0), kNoCreep);
}

TEST(Slope, ABlockOnBrushesStaysForTenMinutes) {
  EXPECT_LT(creep(IntegratorKind::kSemiImplicitEuler, FrictionMode::kBrush, 600.0), kNoCreep);
}

TEST(Slope, TheOtherIntegratorsHoldItToo) {
  for (const FrictionMode mode : {FrictionMode::kAnchored, FrictionMode::kBrush})
    for (const IntegratorKind kind : {IntegratorKind::kExplicitEuler, IntegratorKind::kRk4})
      EXPECT_LT(creep(kind, mode, 60.0), kNoCreep) << toString(kind);
}

TEST(Slope, ViscousFrictionCreepsWithTheWeightOverItsCoefficient) {
  // v = m g sin / f (1 - exp(-f t / m)), f of four feet together. A viscous law never parks.
  const double slope = 10.0 * kDegree, mass = 50.0, f = 1000.0;
  for (const IntegratorKind kind : allIntegrators()) {
    SimConfig config = slopeConfig(kind, FrictionMode::kViscous, 5.0);
    config.viscous_friction = 0.25 * f;
    Simulator simulator = make(fourFeet(mass), plane(slope), config);
    placeOn(simulator, slope, 0.1);
    run(simulator, 4.0);
    // exp(-80) is left of the transient; of the block's rocking, rounding.
    EXPECT_NEAR(simulator.rootVelocity_W().dot(downhill(slope)), mass * kGravity * std::sin(slope) / f, 1e-7)
        << toString(kind);
  }
}

TEST(Slope, ABallRollsWithFiveSevenths) {
  const double slope = 10.0 * kDegree;
  for (const FrictionMode mode : {FrictionMode::kAnchored, FrictionMode::kBrush})
    for (const IntegratorKind kind : allIntegrators()) {
      Simulator simulator = make(solidBody(Vector3d::Constant(0.35), 10.0), plane(slope), slopeConfig(kind, mode, 0.8));
      placeOn(simulator, slope, 0.35);
      run(simulator, 1.0);
      // An anchor that rolls along is a constant force. A brush gives way: its slip is force / C of the speed and grows
      // with it, so the ball's own centre is that fraction faster than rolling, and its spin slower.
      const double expected = 5.0 / 7.0 * kGravity * std::sin(slope);
      const ContactLaw& law = simulator.model().ellipsoids[0].law;
      const double slip = 2.0 / 7.0 * 10.0 * kGravity * std::sin(slope) / (law.tangential_stiffness * law.brush_length);
      const double tolerance = mode == FrictionMode::kBrush ? slip * expected : 1e-6;
      EXPECT_NEAR(accelerationAlong(simulator, slope, 1.0), expected, tolerance) << toString(kind) << " slip " << slip;
    }
}

TEST(Slope, AViscousBallSlipsByAConstantSpeedAsItRolls) {
  // u_s = g sin / lambda, lambda = 7 f / 2 m; the centre gains 5/7 g sin.
  const double slope = 10.0 * kDegree, f = 200.0, mass = 10.0, radius = 0.35;
  SimConfig config = slopeConfig(IntegratorKind::kRk4, FrictionMode::kViscous, 5.0);
  config.viscous_friction = f;
  Simulator simulator = make(solidBody(Vector3d::Constant(radius), mass), plane(slope), config);
  placeOn(simulator, slope, radius);
  run(simulator, 1.0);
  const double slip = simulator.rootVelocity_W().dot(downhill(slope)) - simulator.rootAngularVelocity_W().y() * radius;
  EXPECT_NEAR(slip, kGravity * std::sin(slope) / (3.5 * f / mass), 1e-6);
  EXPECT_NEAR(accelerationAlong(simulator, slope, 1.0), 5.0 / 7.0 * kGravity * std::sin(slope), 1e-6);
}

TEST(Slope, ABallSlipsWhereTheSlopeIsAboveThreeAndAHalfMu) {
  const double slope = 30.0 * kDegree, limit = std::tan(slope) / 3.5;
  for (const double mu : {0.95 * limit, 1.05 * limit}) {
    Simulator simulator = make(solidBody(Vector3d::Constant(0.35), 10.0), plane(slope),
                               slopeConfig(IntegratorKind::kRk4, FrictionMode::kAnchored, mu));
    placeOn(simulator, slope, 0.35);
    run(simulator, 2.0);
    const double rolling = 5.0 / 7.0 * kGravity * std::sin(slope);
    const double slipping = kGravity * (std::sin(slope) - mu * std::cos(slope));
    EXPECT_NEAR(accelerationAlong(simulator, slope, 1.0), mu < limit ? slipping : rolling, 1e-6);
  }
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
