// What is worked out beside the ticks of vehicles that touch each other: the estimate of the local error, and the check of
// what is left out.
#include <gtest/gtest.h>

#include <cmath>

#include "../../src/fleet/island_shadow.h"
#include "ellipsoid_vehicle_sim/fleet/fleet.h"
#include "support/meshes.h"
#include "support/motions.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Vector3d;

void add(Fleet& fleet, Simulator vehicle) {
  const Problems problems = fleet.add("v" + std::to_string(fleet.size()), std::move(vehicle));
  ASSERT_TRUE(problems.empty()) << problemText(problems);
}

/// Two cars on gentle hills that meet head-on after half a second.
struct Cars {
  /// What the first one asks for beside its ticks.
  Cars(IntegratorKind kind, double estimate_every, ExactSavings savings) {
    const auto ground = terrainOf(
        gridSoup(40, 1.0, [](double x, double y) { return 0.1 * std::sin(0.5 * x) * std::cos(0.4 * y); }, {-20.0, -20.0, 0.0}));
    SimConfig config;
    config.integrator = kind;
    config.allow_unstable = true;  // explicit Euler
    for (const bool first : {true, false}) {
      config.error_estimate_every = first ? estimate_every : 0.0;
      config.exact_savings = first ? savings : ExactSavings::kOn;
      add(fleet, make(car(), ground, config));
    }
    const Problems problems[] = {fleet.setDown(0, -3.0, 0.0, 0.0), fleet.setDown(1, 3.0, 0.3, 3.1)};
    for (const Problems& p : problems) EXPECT_TRUE(p.empty()) << problemText(p);
    fleet.vehicle(1).setFrictionScale(0.8);
  }
  void run(int ticks) {
    for (int i = 0; i < ticks; ++i) {
      for (const std::size_t vehicle : {0u, 1u}) fleet.vehicle(vehicle).command(twist(5.0));
      ASSERT_EQ(fleet.step(), StepStatus::kOk);
      touched += fleet.touching().empty() ? 0 : 1;
    }
  }

  Fleet fleet;
  int touched = 0;
};

TEST(FleetChecks, ChangeNoBit) {
  for (const IntegratorKind kind : allIntegrators()) {
    Cars plain(kind, 0.0, ExactSavings::kOn), watched(kind, 7.0, ExactSavings::kCheck);
    plain.run(1200);
    watched.run(1200);
    ASSERT_GT(plain.touched, 20) << toString(kind);
    EXPECT_EQ(plain.fleet.stateHash(), watched.fleet.stateHash()) << toString(kind);
    EXPECT_EQ(watched.fleet.vehicle(0).errorEstimate().step, 1197) << toString(kind);
    EXPECT_EQ(watched.fleet.vehicle(1).errorEstimate().step, -1) << toString(kind);
  }
}

TEST(FleetChecks, SavingsChangeNoBitOfCarsThatTouch) {
  for (const IntegratorKind kind : allIntegrators()) {
    Cars cars(kind, 0.0, ExactSavings::kCheck);
    cars.run(1200);
    ASSERT_GT(cars.touched, 20) << toString(kind);
    EXPECT_EQ(cars.fleet.vehicle(0).events().savings_differences, 0) << toString(kind);
  }
}

/// Two balls that press each other, as a fleet takes them.
class PressedBalls : public testing::Test {
 protected:
  static Simulator ball(IntegratorKind kind, double dt, double x, double speed) {
    static const auto space = emptySpace();
    SimConfig config = springConfig(kind, dt, 5e5, 0.0);
    config.error_estimate_every = 1.0;
    Simulator simulator = make(solidBody({0.3, 0.2, 0.25}, 5.0), space, config);
    placeAt(simulator, {x, 0.03 * x, 0.02}, {speed, 0.0, 0.1}, {1.0, 4.0, -2.0});
    return simulator;
  }
  static Fleet pressed(IntegratorKind kind, double dt) {
    Fleet fleet;
    add(fleet, ball(kind, dt, -0.32, 2.0));
    add(fleet, ball(kind, dt, 0.32, -1.0));
    return fleet;
  }
};

TEST_F(PressedBalls, TheEstimateIsWhatATickGetsWrong) {
  for (const IntegratorKind kind : {IntegratorKind::kSemiImplicitEuler, IntegratorKind::kRk4}) {
    Fleet fleet = pressed(kind, 1e-3);
    while (fleet.touching().empty() && fleet.stepCount() < 1000) ASSERT_EQ(fleet.step(), StepStatus::kOk);
    for (int i = 0; i < 3; ++i) ASSERT_EQ(fleet.step(), StepStatus::kOk);
    ASSERT_FALSE(fleet.touching().empty());
    Fleet exact = pressed(IntegratorKind::kRk4, 1e-5);
    ASSERT_TRUE(exact.restore(fleet.save()).empty());
    ASSERT_EQ(fleet.step(), StepStatus::kOk);
    for (int i = 0; i < 100; ++i) ASSERT_EQ(exact.step(), StepStatus::kOk);
    for (const std::size_t i : {0u, 1u}) {
      const ErrorEstimate estimate = fleet.vehicle(i).errorEstimate();
      EXPECT_EQ(estimate.step, fleet.stepCount());
      const Vector3d position = fleet.vehicle(i).rootPose().p - exact.vehicle(i).rootPose().p,
                     velocity = fleet.vehicle(i).rootVelocity_W() - exact.vehicle(i).rootVelocity_W();
      EXPECT_LT((estimate.position_W - position).norm(), 0.2 * position.norm()) << toString(kind);
      EXPECT_LT((estimate.velocity_W - velocity).norm(), 0.2 * velocity.norm()) << toString(kind);
    }
  }
}

// The check is one that can fail: it is told by a last bit of what two vehicles remember of each other.
TEST_F(PressedBalls, TheCheckSeesTheLastBitOfAContact) {
  Simulator balls[] = {ball(IntegratorKind::kRk4, 1e-3, -0.25, 2.0), ball(IntegratorKind::kRk4, 1e-3, 0.25, -1.0)};
  PairCandidate pair;
  pair.member[1] = 1;
  pair.memory.ellipsoid[0] = pair.memory.ellipsoid[1] = 0;

  std::vector<std::unique_ptr<ShadowRun>> runs;
  IslandStepper island;
  IslandShadow shadow;
  for (const int i : {0, 1}) {
    for (int copy = 0; copy < 2; ++copy)
      runs.push_back(std::make_unique<ShadowRun>(balls[i].model(), balls[i].config(), balls[i].terrain(), balls[i].state()));
    island.addVehicle(runs[runs.size() - 2]->vehicle(), i);
    shadow.addVehicle(*runs.back(), balls[i].state(), i);
  }
  const std::vector<PairCandidate*> pairs = {&pair};
  shadow.addPairs(pairs);
  island.addPair(pair);
  ASSERT_TRUE(island.advance());
  EXPECT_FALSE(shadow.agrees(pairs));  // not there yet
  ASSERT_TRUE(shadow.advance());
  ASSERT_TRUE(pair.known);
  EXPECT_TRUE(shadow.agrees(pairs));
  for (double* value : {&pair.memory.depth, &pair.memory.nhat_W.y()}) {
    const double kept = *value;
    *value = std::nextafter(kept, 1e9);
    EXPECT_FALSE(shadow.agrees(pairs));
    *value = kept;
  }
  EXPECT_TRUE(shadow.agrees(pairs));
  pair.known = false;
  EXPECT_FALSE(shadow.agrees(pairs));
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
