// Rolling resistance and drag against closed forms; both absent unless asked for.
#include <gtest/gtest.h>

#include <cmath>

#include "support/meshes.h"
#include "support/motions.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Vector3d;

TEST(Drag, SlowsABodyInTheAirAsTheFormulaSays) {
  // m v' = -rho / 2 c_d A v^2: v = v0 / (1 + rho c_d A v0 t / (2 m)).
  for (const auto integrator : {IntegratorKind::kSemiImplicitEuler, IntegratorKind::kRk4}) {
    SimConfig config;
    config.integrator = integrator;
    config.gravity = 0.0;
    config.drag_area = 0.5;
    config.air_density = 1.2;
    config.allow_no_wheels = true;
    Simulator simulator = make(solidBody(Vector3d(0.3, 0.2, 0.15), 5.0), emptySpace(), config);
    placeAt(simulator, {0.0, 0.0, 50.0}, {30.0, 40.0, 0.0});
    for (int i = 0; i < 2000; ++i) ASSERT_EQ(simulator.step(), StepStatus::kOk);
    const double expected = 50.0 / (1.0 + 1.2 * 0.5 * 50.0 * 2.0 / (2.0 * 5.0));
    const double tolerance = integrator == IntegratorKind::kRk4 ? 1e-9 : 1e-2;
    EXPECT_NEAR(simulator.rootVelocity_W().norm(), expected, tolerance * expected) << toString(integrator);
    EXPECT_NEAR(simulator.rootVelocity_W().y() / simulator.rootVelocity_W().x(), 4.0 / 3.0, 1e-9);
  }
}

/// Mean deceleration of a car that coasts from 5 m/s on level ground, over a second [m/s^2].
double coastingDeceleration(double resistance, bool solid) {
  SimConfig config;
  config.rolling_resistance = resistance;
  config.solid_compound = solid;
  config.max_acceleration = 6.0;
  Simulator simulator = make(car(), terrainOf(flatSoup(40, 10.0)), config);
  standAt(simulator, 100.0, 100.0, 0.0);
  drive(simulator, twist(5.0), 3.0);
  const double before = simulator.rootVelocity_W().norm();
  drive(simulator, coast(), 1.0);
  return before - simulator.rootVelocity_W().norm();
}

TEST(RollingResistance, SlowsACoastingCarInProportion) {
  for (const bool solid : {false, true}) {
    SCOPED_TRACE(solid ? "solid" : "jointed");
    EXPECT_LT(std::abs(coastingDeceleration(0.0, solid)), 2e-3);
    const double one = coastingDeceleration(0.01, solid), three = coastingDeceleration(0.03, solid);
    EXPECT_NEAR(three, 3.0 * one, 0.02 * three);
    // The wheels' own turning has to be slowed down, too: c g m / (m + sum of I / R^2), a few per cent less than c g.
    EXPECT_LE(one, 0.01 * 9.80665 * (solid ? 1.001 : 1.0));
    EXPECT_GE(one, 0.01 * 9.80665 * (solid ? 0.995 : 0.85));
  }
}

TEST(RollingResistance, OnATreadIsTheForceItself) {
  // A tread has no mass: m v' = -c m g.
  EXPECT_NEAR(coastingDeceleration(0.02, true), 0.02 * 9.80665, 2e-4);
}

TEST(RollingResistance, StopsWhatRollsAndMovesNothingThatStands) {
  SimConfig config;
  config.rolling_resistance = 0.05;
  config.max_acceleration = 6.0;
  Simulator simulator = make(car(), terrainOf(flatSoup(40, 10.0)), config);
  standAt(simulator, 100.0, 100.0, 0.0);
  const Vector3d start = simulator.rootPose().p;
  drive(simulator, coast(), 2.0);
  EXPECT_LT((simulator.rootPose().p - start).norm(), 1e-6);
  drive(simulator, twist(1.0), 1.0);
  drive(simulator, coast(), 6.0);
  EXPECT_LT(simulator.rootVelocity_W().norm(), 1e-3);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
