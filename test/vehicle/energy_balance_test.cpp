// The account of energy: in every motion what is there, what is lost and what was supplied add up.
#include <gtest/gtest.h>

#include <cmath>

#include "ellipsoid_vehicle_sim/vehicle/snapshot.h"
#include "support/meshes.h"
#include "support/motions.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Vector3d;

SimConfig accounted(IntegratorKind integrator, double dt) {
  SimConfig config;
  config.integrator = integrator;
  config.dt = dt;
  config.energy_balance = true;
  config.allow_no_wheels = true;
  config.allow_unstable = true;  // explicit Euler on elastic ground
  return config;
}

TriangleSoup hills() {
  return gridSoup(60, 1.0, [](double x, double y) { return 0.3 * std::sin(0.5 * x) * std::cos(0.4 * y); }, {-30.0, -30.0, 0.0});
}
TriangleSoup plain() {
  return gridSoup(60, 1.0, [](double, double) { return 0.0; }, {-30.0, -30.0, 0.0});
}

/// What has changed hands: the scale of what may be missing.
double turnover(const EnergyBalance& b) { return std::abs(b.lost) + std::abs(b.supplied) + std::abs(b.energy - b.start); }

/// Accelerates around a corner, then brakes to a standstill.
EnergyBalance driveAround(SimConfig config, const TriangleSoup& ground, double until = 3.0) {
  config.max_acceleration = config.max_deceleration = 6.0;
  Simulator simulator = make(car(), terrainOf(ground), config);
  standAt(simulator, 0.0, -10.0, 0.0);
  const auto ticks = static_cast<int>(until / config.dt);
  for (int i = 0; i < ticks; ++i) {
    const double t = i * config.dt;
    simulator.command(twist(t < 1.5 ? 5.0 : 0.0, t < 0.7 ? 0.6 : -0.6));
    if (simulator.step() != StepStatus::kOk) throw std::runtime_error("the simulation diverged");
  }
  return simulator.energyBalance();
}

EnergyBalance tumble(const SimConfig& config, double until = 2.0) {
  Simulator simulator = make(solidBody(Vector3d(0.3, 0.2, 0.15), 5.0), terrainOf(hills()), config);
  placeAt(simulator, {0.3, 0.2, 2.0}, {2.0, 1.0, 0.0}, {3.0, -7.0, 1.0});
  for (int i = 0; i < until / config.dt; ++i)
    if (simulator.step() != StepStatus::kOk) throw std::runtime_error("the simulation diverged");
  return simulator.energyBalance();
}

TEST(EnergyBalance, OfACarThatDrivesAndBrakesClosesOnLevelGround) {
  for (const bool solid : {false, true})
    for (const double resistance : {0.0, 0.02}) {
      SCOPED_TRACE(std::string(solid ? "solid" : "jointed") + (resistance > 0.0 ? ", with resistance" : ""));
      SimConfig config = accounted(IntegratorKind::kRk4, 1e-3);
      config.solid_compound = solid;
      config.rolling_resistance = resistance;
      config.drag_area = 20.0 * resistance;
      const EnergyBalance balance = driveAround(config, plain());
      EXPECT_GT(balance.supplied, 1000.0);
      EXPECT_GT(balance.lost, 1000.0);
      EXPECT_LT(std::abs(balance.error()), 1e-4 * turnover(balance)) << balance.error();
    }
}

// What was missing here before was friction that rounding had dropped at the edge of two triangles: 20 J of 8000.
TEST(EnergyBalance, OfACarOverHillsCloses) {
  for (const IntegratorKind integrator : {IntegratorKind::kRk4, IntegratorKind::kRk4Events, IntegratorKind::kDormandPrince}) {
    const EnergyBalance balance = driveAround(accounted(integrator, 5e-4), hills(), 2.0);
    EXPECT_LT(std::abs(balance.error()), 3e-4 * turnover(balance)) << toString(integrator) << " " << balance.error();
  }
}

TEST(EnergyBalance, OfASteeredCarAtAStandstillIsTheWorkOfTheSteering) {
  Simulator simulator = make(car(), terrainOf(plain()), accounted(IntegratorKind::kRk4, 1e-3));
  standAt(simulator, 0.0, 0.0, 0.0);
  drive(simulator, ackermann(0.0, 0.4), 0.2);
  const EnergyBalance turning = simulator.energyBalance();
  EXPECT_GT(turning.supplied, 0.0);
  EXPECT_LT(std::abs(turning.error()), 0.02 * turning.supplied);
}

TEST(EnergyBalance, ErrorIsOfTheIntegratorsOrder) {
  struct Order {
    IntegratorKind integrator;
    double largest_at_1ms;  // parts of the turnover
    double falls_by;        // over ten times smaller steps, at least
  };
  // Touch-downs within a step leave RK4 no more than second order here.
  for (const Order& order : {Order{IntegratorKind::kExplicitEuler, 0.5, 8.0}, Order{IntegratorKind::kSemiImplicitEuler, 0.05, 8.0},
                             Order{IntegratorKind::kRk4, 1e-3, 3.0}, Order{IntegratorKind::kRk4Events, 3e-4, 10.0},
                             Order{IntegratorKind::kDormandPrince, 1e-4, 3.0}, Order{IntegratorKind::kLinearlyImplicit, 0.5, 5.0}}) {
    double error[2];
    for (const bool fine : {false, true}) {
      SimConfig config = accounted(order.integrator, fine ? 1e-4 : 1e-3);
      config.stiffness = 2e5;
      config.damping = 200.0;
      const EnergyBalance balance = tumble(config);
      error[fine ? 1 : 0] = std::abs(balance.error()) / turnover(balance);
      EXPECT_GT(balance.lost, 50.0);
    }
    EXPECT_LT(error[0], order.largest_at_1ms) << toString(order.integrator);
    EXPECT_LT(error[1], error[0] / order.falls_by) << toString(order.integrator) << " " << error[0] << " " << error[1];
  }
}

TEST(EnergyBalance, ChangesNoBitOfTheRun) {
  for (int k = 0; k < kIntegratorCount; ++k) {
    std::uint64_t hash[2];
    for (const bool kept : {false, true}) {
      SimConfig config = accounted(static_cast<IntegratorKind>(k), 1e-3);
      config.energy_balance = kept;
      Simulator simulator = make(car(), terrainOf(hills()), config);
      standAt(simulator, 0.0, -10.0, 0.0);
      for (int i = 0; i < 400; ++i) {
        simulator.command(twist(5.0, 0.5));
        ASSERT_EQ(simulator.step(), StepStatus::kOk);
      }
      hash[kept ? 1 : 0] = simulator.stateHash();
    }
    EXPECT_EQ(hash[0], hash[1]) << toString(static_cast<IntegratorKind>(k));
  }
}

TEST(EnergyBalance, BeginsAnewWhereTheVehicleIsPut) {
  Simulator simulator = make(solidBody(Vector3d(0.3, 0.2, 0.15), 5.0), terrainOf(plain()), accounted(IntegratorKind::kRk4, 1e-3));
  placeAt(simulator, {0.3, 0.2, 0.5}, {2.0, 1.0, 0.0}, {3.0, -7.0, 1.0});
  const double start = simulator.energy();
  EXPECT_EQ(simulator.energyBalance().start, start);
  for (int i = 0; i < 500; ++i) ASSERT_EQ(simulator.step(), StepStatus::kOk);
  EXPECT_GT(simulator.energyBalance().lost, 1.0);
  const Snapshot later = simulator.save();
  const double energy_later = simulator.energy();
  simulator.reset();
  EXPECT_EQ(simulator.energyBalance().lost, 0.0);
  EXPECT_EQ(simulator.energyBalance().start, start);
  simulator.restore(later);
  EXPECT_EQ(simulator.energyBalance().lost, 0.0);
  EXPECT_EQ(simulator.energyBalance().start, energy_later);
  EXPECT_EQ(simulator.energyBalance().error(), 0.0);
}

TEST(EnergyBalance, IsNotKeptUnlessAskedFor) {
  SimConfig config = accounted(IntegratorKind::kRk4, 1e-3);
  config.energy_balance = false;
  const EnergyBalance balance = tumble(config, 0.2);
  EXPECT_EQ(balance.start, 0.0);
  EXPECT_EQ(balance.lost, 0.0);
  EXPECT_EQ(balance.error(), 0.0);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
