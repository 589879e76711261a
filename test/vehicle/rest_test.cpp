// Standing still: what is parked stays, with every integrator, and is not paid for.
#include <gtest/gtest.h>

#include <chrono>

#include "ellipsoid_vehicle_sim/vehicle/snapshot.h"
#include "support/motions.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Vector3d;

/// Parked on 30 degrees, mu 0.8, all wheels braked; the largest distance from where it was at 10 s, until 610 s.
double creepOnTheSlope(IntegratorKind kind, bool rest_detection, double dt) {
  SimConfig config;
  config.integrator = kind;
  config.dt = dt;
  config.mu_static = config.mu_kinetic = 0.8;
  config.rest_detection = rest_detection;
  Simulator simulator = make(fourFeet(50.0), terrainOf(floorSoup(500.0, 1, M_PI / 6.0)), config);
  standAt(simulator, 0.0, 0.0, 0.4);
  run(simulator, 10.0);
  const Vector3d start = simulator.rootPose().p;
  double farthest = 0.0;
  for (int i = 0; i < 60; ++i) {
    run(simulator, 10.0);
    farthest = std::max(farthest, (simulator.rootPose().p - start).norm());
  }
  return farthest;
}

class ParkedOnTheSlope : public testing::TestWithParam<IntegratorKind> {};

TEST_P(ParkedOnTheSlope, MovesLessThanAMicrometreInTenMinutes) {
  // Half the step that the certificate allows keeps the test short; the default of a millisecond where it is less.
  SimConfig config;
  config.integrator = GetParam();
  config.allow_unstable = true;
  const double largest = make(fourFeet(50.0), flatFloor(), config).certificate().largestStep(GetParam());
  const double dt = largest > 2e-3 ? std::min(5e-3, 0.5 * largest) : 0.9 * largest;
  EXPECT_LT(creepOnTheSlope(GetParam(), true, dt), 1e-6);
  EXPECT_LT(creepOnTheSlope(GetParam(), false, dt), 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Rest, ParkedOnTheSlope, testing::ValuesIn(allIntegrators()),
                         [](const auto& sheet) { return std::string(toString(sheet.param)); });

Simulator parkedCar(bool rest_detection, IntegratorKind kind = IntegratorKind::kRk4) {
  SimConfig config;
  config.integrator = kind;
  config.mu_static = config.mu_kinetic = 0.8;
  config.rest_detection = rest_detection;
  Simulator simulator = make(car(), terrainOf(floorSoup(500.0, 1, M_PI / 6.0)), config);
  standAt(simulator, 0.0, 0.0, 0.0);
  return simulator;
}

TEST(Rest, IsWithinItsBoundOfTheFullModel) {
  Simulator saved = parkedCar(true), full = parkedCar(false);
  run(saved, 60.0);
  run(full, 60.0);
  EXPECT_TRUE(saved.isResting());
  EXPECT_FALSE(full.isResting());
  EXPECT_LT((saved.rootPose().p - full.rootPose().p).norm(), 6e-9);
}

TEST(Rest, ACommandWakesItAtOnceAndItComesToRestAgain) {
  Simulator simulator = parkedCar(true);
  run(simulator, 30.0);
  ASSERT_TRUE(simulator.isResting());
  const std::int64_t ticks = simulator.stepCount();
  simulator.command(twist(1.0));
  simulator.step();
  EXPECT_FALSE(simulator.isResting());
  EXPECT_EQ(simulator.stepCount(), ticks + 1);
  drive(simulator, twist(-1.0), 1.0);
  EXPECT_GT(simulator.rootVelocity_W().norm(), 0.3);
  run(simulator, 40.0);
  EXPECT_TRUE(simulator.isResting());
}

TEST(Rest, NeitherFlightNorTheTopOfABounceIsRest) {
  SimConfig config = springConfig(IntegratorKind::kRk4, 1e-3, 1e6, 0.0);
  config.gravity = 9.81;
  Simulator ball = make(solidBody(Vector3d::Constant(0.3), 10.0), flatFloor(), config);
  placeAt(ball, {0.0, 0.0, 0.5}, Vector3d::Zero());
  for (int i = 0; i < 2000; ++i) {
    ball.step();
    EXPECT_FALSE(ball.isResting()) << i;
  }
}

TEST(Rest, SnapshotsOfAStandingVehicleGoOnBitForBit) {
  Simulator simulator = parkedCar(true);
  run(simulator, 20.0);
  const Snapshot saved = simulator.save();
  run(simulator, 5.0);
  drive(simulator, twist(1.0), 0.5);
  const std::uint64_t hash = simulator.stateHash();
  Simulator other = parkedCar(true);
  other.restore(saved);
  run(other, 5.0);
  drive(other, twist(1.0), 0.5);
  EXPECT_EQ(other.stateHash(), hash);
}

TEST(Rest, LookingAtItDoesNotDecideIt) {
  Simulator asked = parkedCar(true), left_alone = parkedCar(true);
  for (int i = 0; i < 20000; ++i) {
    if (i == 100) {
      asked.command(twist(0.5));
      left_alone.command(twist(0.5));
    }
    asked.step();
    left_alone.step();
    asked.energy();
  }
  EXPECT_EQ(asked.stateHash(), left_alone.stateHash());
}

TEST(Rest, CostsAtMostATenthOfAStepInContact) {
  const auto timeOf = [](Simulator& simulator) {
    // The least of some: other programs only add.
    double least = 1e300;
    for (int repeat = 0; repeat < 7; ++repeat) {
      const auto begun = std::chrono::steady_clock::now();
      for (int i = 0; i < 3000; ++i) simulator.step();
      least = std::min(least, std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count());
    }
    return least;
  };
  for (const IntegratorKind kind : {IntegratorKind::kSemiImplicitEuler, IntegratorKind::kRk4}) {
    Simulator saved = parkedCar(true, kind), full = parkedCar(false, kind);
    run(saved, 30.0);
    ASSERT_TRUE(saved.isResting());
    EXPECT_LT(timeOf(saved), 0.1 * timeOf(full)) << toString(kind);
  }
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
