#include "ellipsoid_vehicle_sim/vehicle/skid_steer.h"

#include <gtest/gtest.h>

#include <cmath>

namespace ellipsoid_vehicle_sim {
namespace {

SkiddingWheel wheelAt(double x, double y, double rim_speed, double cornering_stiffness) {
  SkiddingWheel wheel;
  wheel.p = {x, y};
  wheel.rim_speed = rim_speed;
  wheel.load = 100.0;
  wheel.mu = 0.8;
  wheel.law.mode = FrictionMode::kBrush;
  wheel.law.tangential_stiffness = cornering_stiffness;
  wheel.law.brush_length = 1.0;
  wheel.law.relaxation_time = 1e-3;
  return wheel;
}

TEST(SteadySkid, TwoWheelsOnOneAxleRollAsTheirDifferenceSays) {
  const auto v = steadySkid({wheelAt(0.1, 0.25, 0.9, 1e4), wheelAt(0.1, -0.25, 1.1, 1e4)});
  ASSERT_TRUE(v);
  EXPECT_NEAR(v->yaw_rate, 0.4, 1e-6);
  EXPECT_NEAR(v->v.x(), 1.0, 1e-6);
  EXPECT_NEAR(v->v.y(), -0.4 * 0.1, 1e-6);
}

// Small slips at equal speeds of rolling: f = -C v / v_r at each wheel. The moment balance of a wheelbase 2a and a track 2b,
// sides at v -+ s, with v_r nearly v, is (s - w b) b = w a^2: w = s b / (a^2 + b^2).
TEST(SteadySkid, SoftTyresTurnByTheSquaresOfWheelbaseAndTrack) {
  const double a = 0.3, b = 0.25, s = 1e-3;
  std::vector<SkiddingWheel> wheels;
  for (const double x : {a, -a})
    for (const double y : {b, -b}) wheels.push_back(wheelAt(x, y, y > 0.0 ? 1.0 - s : 1.0 + s, 100.0));
  const auto v = steadySkid(wheels);
  ASSERT_TRUE(v);
  EXPECT_NEAR(v->yaw_rate, s * b / (a * a + b * b), 2e-3 * v->yaw_rate);  // v_r is not quite one speed
}

// Coulomb everywhere, turning on the spot: each wheel's force opposes its slip (s - w b, w a) at the full cone, so moments
// balance where (s - w b) b = w a^2 again, whatever the loads.
TEST(SteadySkid, CoulombOnTheSpotTurnsLikewise) {
  const double a = 0.3, b = 0.25, s = 0.5;
  std::vector<SkiddingWheel> wheels;
  for (const double x : {a, -a})
    for (const double y : {b, -b}) wheels.push_back(wheelAt(x, y, y > 0.0 ? -s : s, 1e8));
  const auto v = steadySkid(wheels);
  ASSERT_TRUE(v);
  EXPECT_NEAR(v->yaw_rate, s * b / (a * a + b * b), 1e-4 * v->yaw_rate);
  EXPECT_NEAR(v->v.norm(), 0.0, 1e-6);
}

TEST(SteadySkid, AFreeWheelHoldsSidewaysOnly) {
  SkiddingWheel side = wheelAt(0.0, 0.5, 0.0, 1e4);
  side.free = true;
  const auto v = steadySkid({wheelAt(0.0, 0.25, 0.9, 1e4), wheelAt(0.0, -0.25, 1.1, 1e4), side});
  ASSERT_TRUE(v);
  EXPECT_NEAR(v->yaw_rate, 0.4, 1e-6);
}

TEST(SteadySkid, NothingThatCarriesOrDrivesHasNoBalance) {
  EXPECT_FALSE(steadySkid({}));
  SkiddingWheel unloaded = wheelAt(0.0, 0.2, 1.0, 1e4);
  unloaded.load = 0.0;
  EXPECT_FALSE(steadySkid({unloaded}));
  SkiddingWheel free = wheelAt(0.0, 0.2, 1.0, 1e4);
  free.free = true;
  EXPECT_FALSE(steadySkid({free}));
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
