// The extremes: in every cell a passive motion, a refusal at load or a stop at run time, each with its cause.
#include "ellipsoid_vehicle_sim/trade/extremes.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/meshes.h"
#include "support/motions.h"

namespace ellipsoid_vehicle_sim {
namespace {

class Extremes : public testing::TestWithParam<int> {};

// Ticks that a debugging user tries: the finest, the default's neighbours, the coarsest.
constexpr double kTicks[] = {1e-6, 1e-4, 1e-3, 1e-2, 0.1};

TEST_P(Extremes, NeverGainsEnergyUnmarked) {
  const ExtremeAxis& axis = extremeAxes()[static_cast<std::size_t>(GetParam())];
  int moved = 0;
  for (const double value : axis.values)
    for (int k = 0; k < kIntegratorCount; ++k)
      for (const double dt : kTicks) {
        const ExtremeCell cell{axis.name, value, static_cast<IntegratorKind>(k), dt};
        const ExtremeResult result = runExtreme(cell, 250);
        EXPECT_NE(result.outcome, ExtremeOutcome::kGained)
            << axis.name << " " << value << ", " << toString(cell.integrator) << " at " << dt << " s: " << result.gain << ", unaccounted " << result.unaccounted;
        if (result.outcome == ExtremeOutcome::kPassive) {
          ++moved;
        } else {
          EXPECT_FALSE(result.cause.empty());
        }
        // Only what the certificate cannot hold is refused for its step.
        if (result.outcome == ExtremeOutcome::kRefused && result.cause.find("'dt'") != std::string::npos) {
          EXPECT_LT(result.predicted, 1.0);
        }
      }
  // A map of refusals alone would be no map.
  EXPECT_GT(moved, 0) << axis.name;
}

INSTANTIATE_TEST_SUITE_P(Axes, Extremes, testing::Range(0, 12), [](const auto& sheet) {
  return extremeAxes()[static_cast<std::size_t>(sheet.param)].name;
});

// Bounds that no failure could cross would be none: an unstable run crosses them.
TEST(ExtremesBounds, AreCrossedBeyondTheCertificate) {
  SimConfig config;
  config.integrator = IntegratorKind::kSemiImplicitEuler;
  config.stiffness = 1e7;
  config.damping = 100.0;
  config.dt = 2.5e-3;
  config.allow_no_wheels = config.allow_unstable = config.energy_balance = true;
  Simulator simulator = test::make(test::solidBody({0.3, 0.25, 0.2}, 10.0), test::terrainOf(flatSoup(10, 2.0)), config);
  ASSERT_TRUE(simulator.isBeyondCertificate());
  test::placeAt(simulator, {10.0, 10.0, 0.35}, {1.0, 0.3, -1.0}, {0.5, 2.0, 0.3});
  const double spendable = 0.5 * 10.0 * 2.09 + 10.0 * 9.81 * 0.15 + 1.0;
  double gain = 0.0;
  for (int i = 0; i < 200 && simulator.step() == StepStatus::kOk; ++i)
    gain = std::max(gain, (simulator.energyBalance().energy - simulator.energyBalance().start) / spendable);
  EXPECT_GT(gain, energyBound(config.integrator));
}

// Most cells are held to a tenth; only what the scalar problem of a touch-down says is allowed more.
TEST(ExtremesBounds, AreTightWhereTheStepResolvesTheContact) {
  for (int k = 0; k < kIntegratorCount; ++k) {
    if (static_cast<IntegratorKind>(k) == IntegratorKind::kExplicitEuler) continue;  // refused there
    const ExtremeResult result = runExtreme({"mass", 10.0, static_cast<IntegratorKind>(k), 1e-4}, 250);
    ASSERT_EQ(result.outcome, ExtremeOutcome::kPassive);
    EXPECT_LE(result.bound, 0.11) << toString(static_cast<IntegratorKind>(k));
  }
}

TEST(ExtremesMap, HasEveryAxisFromEndToEnd) {
  ASSERT_EQ(extremeAxes().size(), 12u);
  const auto spans = [](const std::string& name, double from, double to) {
    for (const ExtremeAxis& axis : extremeAxes())
      if (axis.name == name) {
        EXPECT_NEAR(axis.values.front(), from, 1e-9 * from) << name;
        EXPECT_NEAR(axis.values.back(), to, 1e-9 * to) << name;
        return;
      }
    ADD_FAILURE() << "no axis " << name;
  };
  spans("mass", 1e-2, 1e5);
  spans("wheel_inertia", 1e-9, 1e3);
  spans("stiffness", 1e3, 1e10);
  spans("damping_ratio", 0.0, 10.0);
  spans("thinness", 1e-4, 1e4);
  spans("triangle", 1e-4, 1e4);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
