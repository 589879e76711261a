// Exact savings change no bit: every tick worked out both ways, by the simulator's own check.
#include <gtest/gtest.h>

#include <cmath>

#include "../../src/vehicle/savings_check.h"
#include "support/meshes.h"
#include "support/motions.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Vector3d;

SimConfig checkedWith(int integrator) {
  SimConfig config;
  config.integrator = static_cast<IntegratorKind>(integrator);
  config.exact_savings = ExactSavings::kCheck;
  config.allow_no_wheels = true;
  config.allow_unstable = true;  // explicit Euler on elastic ground
  return config;
}

/// Gentle hills of 60 m by 60 m around the origin.
TriangleSoup rolling() {
  return gridSoup(60, 1.0, [](double x, double y) { return 0.3 * std::sin(0.5 * x) * std::cos(0.4 * y); }, {-30.0, -30.0, 0.0});
}

class Savings : public testing::TestWithParam<int> {};

TEST_P(Savings, ChangeNoBitOfABodyThatTumblesBouncesAndRests) {
  Simulator simulator = make(solidBody(Vector3d(0.3, 0.2, 0.15), 5.0), terrainOf(rolling()), checkedWith(GetParam()));
  placeAt(simulator, {0.3, 0.2, 4.0}, {2.0, 1.0, 0.0}, {3.0, -7.0, 1.0});
  for (int i = 0; i < 3000; ++i) ASSERT_EQ(simulator.step(), StepStatus::kOk);
  EXPECT_EQ(simulator.events().savings_differences, 0);
  // The way began high above the ground, and led down to it.
  EXPECT_GT(simulator.state().memory[0].count, 0);
}

TEST_P(Savings, ChangeNoBitOfACarOverHills) {
  for (const bool solid : {false, true}) {
    SimConfig config = checkedWith(GetParam());
    config.solid_compound = solid;
    config.rolling_resistance = 0.01;
    Simulator simulator = make(car(), terrainOf(rolling()), config);
    standAt(simulator, 0.0, -10.0, 0.0);
    for (int i = 0; i < 1500; ++i) {
      simulator.command(twist(5.0, i < 900 ? 0.5 : -0.5));
      ASSERT_EQ(simulator.step(), StepStatus::kOk);
    }
    EXPECT_EQ(simulator.events().savings_differences, 0) << (solid ? "solid" : "jointed");
  }
}

TEST_P(Savings, OffIsTheSameRun) {
  std::uint64_t hash[2];
  for (const bool off : {false, true}) {
    SimConfig config = checkedWith(GetParam());
    config.exact_savings = off ? ExactSavings::kOff : ExactSavings::kOn;
    Simulator simulator = make(solidBody(Vector3d(0.3, 0.2, 0.15), 5.0), terrainOf(rolling()), config);
    placeAt(simulator, {0.3, 0.2, 6.0}, {2.0, 1.0, 0.0}, {3.0, -7.0, 1.0});
    for (int i = 0; i < 2000; ++i) ASSERT_EQ(simulator.step(), StepStatus::kOk);
    hash[off ? 1 : 0] = simulator.stateHash();
  }
  EXPECT_EQ(hash[0], hash[1]);
}

// The check is one that can fail: it is told by a last bit.
TEST(SavingsCheckItself, SeesTheLastBit) {
  const auto floor = terrainOf(rolling());
  Simulator simulator = make(solidBody(Vector3d(0.3, 0.2, 0.15), 5.0), floor, checkedWith(2));
  placeAt(simulator, {0.3, 0.2, 2.0}, {2.0, 1.0, 0.0}, {3.0, -7.0, 1.0});
  SavingsCheck check(simulator.model(), simulator.config(), *floor, simulator.state());
  ASSERT_EQ(simulator.step(), StepStatus::kOk);  // out of the unknown first state
  check.begin(simulator.state());
  ASSERT_EQ(simulator.step(), StepStatus::kOk);
  VehicleState state = simulator.state();
  EXPECT_TRUE(check.agrees(state));
  SavingsCheck again(simulator.model(), simulator.config(), *floor, simulator.state());
  again.begin(simulator.state());
  ASSERT_EQ(simulator.step(), StepStatus::kOk);
  state = simulator.state();
  state.motion.w_WB.y() = std::nextafter(state.motion.w_WB.y(), 0.0);
  EXPECT_FALSE(again.agrees(state));
}

INSTANTIATE_TEST_SUITE_P(Integrators, Savings, testing::Range(0, kIntegratorCount), [](const auto& sheet) {
  return std::string(toString(static_cast<IntegratorKind>(sheet.param)));
});

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
