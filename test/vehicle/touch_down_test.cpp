// What a touch-down within a step may add: the scalar problem against the simulator itself.
#include "ellipsoid_vehicle_sim/vehicle/touch_down.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/meshes.h"
#include "support/motions.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Vector3d;

/// Largest energy of a ball that falls on a plane without gravity or friction, over what it came with, less one, from all
/// parts of a step.
double measuredGain(IntegratorKind integrator, double omega_dt, double zeta) {
  constexpr double kDt = 1e-3, kMass = 10.0;
  constexpr int kPhases = 64;
  const double omega = omega_dt / kDt, k = kMass * omega * omega, c = 2.0 * zeta * kMass * omega;
  SimConfig config = springConfig(integrator, kDt, k, c);
  config.allow_no_wheels = true;
  Simulator simulator = make(solidBody(Vector3d(0.3, 0.3, 0.3), kMass), terrainOf(flatSoup(10, 2.0)), config);
  double gain = 0.0;
  for (int i = 0; i < kPhases; ++i) {
    const double speed = 0.1;
    placeAt(simulator, {9.3, 9.1, 0.3 + speed * kDt * (2.0 + static_cast<double>(i) / kPhases)}, {0.0, 0.0, -speed});
    const double start = simulator.energy();
    for (int tick = 0; tick < 3 + static_cast<int>(13.0 / omega_dt); ++tick) {
      if (simulator.step() != StepStatus::kOk) return kMostTouchDownGain;
      gain = std::max(gain, simulator.energy() / start - 1.0);
      if (tick > 3 && simulator.rootVelocity_W().z() > 0.0 && simulator.largestPenetration() == 0.0) break;
    }
  }
  return gain;
}

TEST(TouchDown, GainIsThatOfTheSimulator) {
  for (const IntegratorKind integrator : {IntegratorKind::kExplicitEuler, IntegratorKind::kSemiImplicitEuler, IntegratorKind::kRk4})
    for (const double zeta : {0.05, 0.36, 1.0})
      for (const double part : {0.95, 0.6, 0.3}) {
        const double omega_dt = part * oscillatorLimit(integrator, zeta);
        const double predicted = touchDownGain(integrator, omega_dt, zeta, 1.0);
        const double measured = measuredGain(integrator, omega_dt, zeta);
        EXPECT_NEAR(measured, predicted, 0.03 * predicted + 1e-3) << toString(integrator) << " zeta " << zeta << " omega dt " << omega_dt;
      }
}

TEST(TouchDown, SmallStepsAddNothingAndEventsLittle) {
  for (int k = 0; k < kIntegratorCount; ++k)
    EXPECT_LT(touchDownGain(static_cast<IntegratorKind>(k), 0.01, 0.1, 4.0), 1e-4) << toString(static_cast<IntegratorKind>(k));
  // The same step, with and without the moment of touch-down.
  EXPECT_GT(touchDownGain(IntegratorKind::kRk4, 1.5, 0.1, 1.0), 0.1);
  EXPECT_LT(touchDownGain(IntegratorKind::kRk4Events, 1.5, 0.1, 1.0), 0.5 * touchDownGain(IntegratorKind::kRk4, 1.5, 0.1, 1.0));
}

TEST(TouchDown, IsToldAtLoadAndWarnedOf) {
  const auto lineOf = [](double stiffness) {
    SimConfig config = springConfig(IntegratorKind::kRk4, 1e-3, stiffness, 10.0);
    config.allow_no_wheels = true;
    const Simulator simulator = make(solidBody(Vector3d(0.3, 0.3, 0.3), 10.0), terrainOf(flatSoup(10, 2.0)), config);
    for (const std::string& line : simulator.loadReport())
      if (line.find("touch-down: ") != std::string::npos) return line;
    return std::string();
  };
  EXPECT_EQ(lineOf(1e5).rfind("touch-down: ", 0), 0u) << lineOf(1e5);
  EXPECT_EQ(lineOf(5e7).rfind("WARNING touch-down: ", 0), 0u) << lineOf(5e7);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
