// The live estimate of the local error: what it says, and that the run does not know of it.
#include <gtest/gtest.h>

#include "support/motions.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Vector3d;

TEST(LocalError, DoesNotChangeTheRunByABit) {
  for (const IntegratorKind kind : allIntegrators()) {
    std::uint64_t hash[2];
    for (const int with : {0, 1}) {
      SimConfig config;
      config.integrator = kind;
      config.error_estimate_every = with == 0 ? 0.0 : 3.0;
      Simulator simulator = make(car(), flatFloor(), config);
      standAt(simulator, 0.0, 0.0, 0.0);
      drive(simulator, ackermann(5.0, 0.1), 1.0);
      hash[with] = simulator.stateHash();
      EXPECT_EQ(simulator.errorEstimate().step, with == 0 ? -1 : 999) << toString(kind);
    }
    EXPECT_EQ(hash[0], hash[1]) << toString(kind);
  }
}

/// A tumbling body without contact: estimate of the first tick, and its true error from a hundred times finer steps.
TEST(LocalError, IsWhatATickGetsWrong) {
  for (const IntegratorKind kind : oneStepIntegrators()) {
    const auto tumbled = [&](IntegratorKind method, double dt, int ticks) {
      SimConfig config = springConfig(method, dt, 1e5, 0.0);
      config.error_estimate_every = 1.0;
      Simulator simulator = make(solidBody({0.3, 0.2, 0.1}, 5.0), emptySpace(), config);
      placeAt(simulator, Vector3d::Zero(), Vector3d::Zero(), {2.0, 8.0, 1.0});
      for (int i = 0; i < ticks; ++i) simulator.step();
      return simulator;
    };
    const double dt = kind == IntegratorKind::kRk4 ? 0.02 : 2e-3;
    const Simulator tick = tumbled(kind, dt, 1);
    const Simulator truth = tumbled(IntegratorKind::kRk4, 0.01 * dt, 100);
    const Vector3d error = tick.rootAngularVelocity_W() - truth.rootAngularVelocity_W();
    EXPECT_LT((tick.errorEstimate().angular_velocity_W - error).norm(), 0.1 * error.norm()) << toString(kind);
    const Eigen::Quaterniond turned = tick.rootPose().q * truth.rootPose().q.conjugate();
    const Vector3d angle = 2.0 * turned.vec();
    EXPECT_LT((tick.errorEstimate().rotation_W - angle).norm(), 0.1 * angle.norm() + 1e-15) << toString(kind);
  }
}

TEST(LocalError, ComesEverySoManyTicksAndAfterResetAnew) {
  SimConfig config;
  config.error_estimate_every = 10.0;
  Simulator simulator = make(car(), flatFloor(), config);
  standAt(simulator, 0.0, 0.0, 0.0);
  EXPECT_EQ(simulator.errorEstimate().step, -1);
  drive(simulator, twist(3.0), 0.025);
  EXPECT_EQ(simulator.errorEstimate().step, 20);
  EXPECT_GT(simulator.errorEstimate().position_W.norm(), 0.0);
  EXPECT_LT(simulator.errorEstimate().position_W.norm(), 1e-3);
  simulator.reset();
  EXPECT_EQ(simulator.errorEstimate().step, -1);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
