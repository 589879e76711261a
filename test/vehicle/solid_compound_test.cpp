// The article's car: one rigid body of ellipsoids, whose wheels are treads that run without mass.
#include <gtest/gtest.h>

#include "support/motions.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Vector3d;

SimConfig compoundConfig(IntegratorKind kind) {
  SimConfig config;
  config.integrator = kind;
  config.solid_compound = true;
  return config;
}

Simulator standing(IntegratorKind kind = IntegratorKind::kSemiImplicitEuler) {
  Simulator simulator = make(car(), flatFloor(), compoundConfig(kind));
  standAt(simulator, 0.0, 0.0, 0.0);
  return simulator;
}

TEST(SolidCompound, IsOneRigidBodyWithATreadPerWheel) {
  const Simulator simulator = standing();
  EXPECT_EQ(simulator.model().bodies.size(), 1u);
  EXPECT_EQ(simulator.model().dynamic_joints.size(), 0u);
  EXPECT_EQ(simulator.model().treads.size(), 4u);
  EXPECT_EQ(simulator.model().ellipsoids.size(), 5u);
  EXPECT_NEAR(simulator.model().mass, 1200.0, 1e-9);
  std::vector<ContactReport> contacts;
  simulator.contacts(contacts);
  EXPECT_EQ(contacts.size(), 4u);
}

TEST(SolidCompound, DrivesTenMetresStraight) {
  for (const IntegratorKind kind : allIntegrators()) {
    Simulator simulator = standing(kind);
    for (int i = 0; i < 20000 && simulator.rootPose().p.x() < 10.0; ++i) {
      simulator.command(twist(2.0));
      ASSERT_EQ(simulator.step(), StepStatus::kOk);
    }
    EXPECT_GE(simulator.rootPose().p.x(), 10.0);
    EXPECT_LT(std::abs(simulator.rootPose().p.y()), 1e-3) << toString(kind);
    EXPECT_NEAR(simulator.rootVelocity_W().x(), 2.0, 0.01) << toString(kind);
    EXPECT_NEAR(simulator.encoderSpeed(), 2.0, 0.01) << toString(kind);
  }
}

TEST(SolidCompound, BrakesToStandstillAndStays) {
  for (const IntegratorKind kind : allIntegrators()) {
    Simulator simulator = standing(kind);
    drive(simulator, twist(6.0), 3.0);
    ASSERT_NEAR(simulator.rootVelocity_W().x(), 6.0, 0.05);
    const double x = simulator.rootPose().p.x();
    drive(simulator, twist(0.0), 4.0);
    EXPECT_LT(simulator.rootVelocity_W().norm(), 1e-6) << toString(kind);
    // v^2 / 2a = 3 m at the 6 m/s^2 that the treads are slowed down with.
    EXPECT_NEAR(simulator.rootPose().p.x() - x, 3.0, 0.1) << toString(kind);
    const Vector3d stood = simulator.rootPose().p;
    run(simulator, 10.0);
    EXPECT_LT((simulator.rootPose().p - stood).norm(), 1e-6) << toString(kind);
  }
}

TEST(SolidCompound, SteersOnTheCircleOfItsAxles) {
  for (const double sign : {1.0, -1.0}) {
    Simulator simulator = standing();
    const double delta = sign * 10.0 * M_PI / 180.0;
    drive(simulator, ackermann(2.0, delta), 4.0);
    const double expected = 2.0 * std::tan(delta) / 2.6;
    double yaw_rate = 0.0;
    for (int i = 0; i < 100; ++i) {
      drive(simulator, ackermann(2.0, delta), 0.01);
      yaw_rate += simulator.rootAngularVelocity_W().z() / 100.0;
    }
    // Rear treads run at the speeds of the circle's radii; slip angles of a few thousandths on either axle.
    EXPECT_NEAR(yaw_rate, expected, 0.01 * std::abs(expected));
  }
}

TEST(SolidCompound, CoastsWithoutLoss) {
  // Treads have no mass and no bearing friction: nothing slows it down.
  Simulator simulator = standing(IntegratorKind::kRk4);
  drive(simulator, twist(5.0), 3.0);
  drive(simulator, coast(), 1.0);
  const double before = simulator.rootVelocity_W().x();
  ASSERT_GT(before, 4.9);
  drive(simulator, coast(), 10.0);
  EXPECT_NEAR(simulator.rootVelocity_W().x(), before, 1e-3);
}

TEST(SolidCompound, TreadsOfACoastingCarTurnWithTheGround) {
  Simulator simulator = standing();
  placeAt(simulator, simulator.rootPose().p + Vector3d(0.0, 0.0, 0.01), {3.0, 0.0, 0.0});
  drive(simulator, coast(), 2.0);
  for (const TreadState& tread : simulator.state().treads)
    EXPECT_NEAR(tread.speed * 0.35, simulator.rootVelocity_W().x(), 1e-3);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
