#include <gtest/gtest.h>

#include <cmath>

#include "description/urdf_samples.h"
#include "ellipsoid_vehicle_sim/vehicle/simulator.h"
#include "support/scenes.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

const std::string kLimit = "<limit lower=\"-0.5\" upper=\"0.5\" effort=\"1000\" velocity=\"2\"/>";

std::string mimicText(const std::string& joint, double multiplier, double offset = 0.0) {
  return "<mimic joint=\"" + joint + "\" multiplier=\"" + std::to_string(multiplier) + "\" offset=\"" +
         std::to_string(offset) + "\"/>";
}

std::string bodyText() {
  return linkText("base", inertialText(30.0) + collisionText("<box size=\"0.4 0.3 0.1\"/>", "0 0 0.3"));
}

Simulator simulatorOf(const std::string& text, std::shared_ptr<const Terrain> terrain, double x = 0.0) {
  const auto vehicle = loadText(text);
  EXPECT_TRUE(vehicle) << problemText(vehicle.problems);
  auto simulator = Simulator::create(*vehicle.value, std::move(terrain), SimConfig{});
  EXPECT_TRUE(simulator) << problemText(simulator.problems);
  const Problems problems = simulator.value->setDown(x, 0.0, 0.0);
  EXPECT_TRUE(problems.empty()) << problemText(problems);
  return std::move(*simulator.value);
}

JointReading reading(const Simulator& simulator, const std::string& joint) {
  std::vector<JointReading> readings;
  simulator.jointReadings(readings);
  for (std::size_t i = 0; i < readings.size(); ++i)
    if (simulator.jointNames()[i] == joint) return readings[i];
  ADD_FAILURE() << "no joint " << joint;
  return {};
}

/// Two rockers that a differential makes turn against each other.
std::string roverText(const std::string& mimic) {
  std::string text = bodyText();
  for (const auto& [side, y] : {std::pair{"left", "0.25"}, {"right", "-0.25"}}) {
    const std::string rocker = std::string(side) + "_rocker";
    text += linkText(rocker, inertialText()) +
            jointText(rocker + "_joint", "revolute", "base", rocker, std::string("0 ") + y + " 0.1", "0 1 0",
                      kLimit + (std::string(side) == "right" ? mimic : "")) +
            wheelText(rocker + "_front", rocker, "0.3 0 -0.1") + wheelText(rocker + "_rear", rocker, "-0.3 0 -0.1");
  }
  return text;
}

struct Bump {
  double rocker = 0.0, body = 0.0;  ///< largest angles [rad].
};

/// Over a bump of height h below the left side only.
Bump overBump(const std::string& mimic, double h) {
  TriangleSoup soup = test::floorSoup(20.0, 1);
  test::addQuad(soup, {1.0, 0.0, 0.0}, {1.5, 0.0, h}, {1.5, 1.0, h}, {1.0, 1.0, 0.0});
  test::addQuad(soup, {1.5, 0.0, h}, {4.0, 0.0, h}, {4.0, 1.0, h}, {1.5, 1.0, h});
  Simulator rover = simulatorOf(roverText(mimic), test::terrainOf(soup));
  DriveCommand command;
  command.speed = 0.3;
  Bump bump;
  for (int i = 0; i < 5000; ++i) {
    rover.command(command);
    EXPECT_EQ(rover.step(), StepStatus::kOk);
    const JointReading left = reading(rover, "left_rocker_joint"), right = reading(rover, "right_rocker_joint");
    if (!mimic.empty()) {
      EXPECT_EQ(right.position, -left.position) << i;
      EXPECT_EQ(right.velocity, -left.velocity) << i;
    }
    bump.rocker = std::max(bump.rocker, std::abs(left.position));
    bump.body = std::max(bump.body, std::abs(std::asin((rover.rootPose().q * Vector3d::UnitX()).z())));
  }
  return bump;
}

// The rockers turn against each other by equal angles, so that the body, which the differential hangs between them, keeps the
// mean of their pitches: while the left front wheel alone stands h higher, the left rocker pitches by h / 0.6, the body by
// half of that.
TEST(Mimic, RockersTurnAsOneAndTheBodyKeepsTheirMean) {
  const double h = 0.05;
  const Bump bump = overBump(mimicText("left_rocker_joint", -1.0), h);
  EXPECT_NEAR(bump.rocker, 0.5 * h / 0.6, 0.1 * h / 0.6);
  EXPECT_NEAR(bump.body, 0.5 * h / 0.6, 0.1 * h / 0.6);
}

// Without the differential the body hangs on two free axes like a pendulum, and swings by more.
TEST(Mimic, WithoutItTheBodySwingsOnItsAxes) {
  EXPECT_GT(overBump("", 0.05).body, 2.0 * overBump(mimicText("left_rocker_joint", -1.0), 0.05).body);
}

TEST(Mimic, ASecondStageFollowsTheLiftExactly) {
  const std::string slide = "<limit lower=\"0\" upper=\"0.4\" effort=\"10000\" velocity=\"0.5\"/>";
  const std::string text =
      bodyText() + wheelText("fl", "base", "0.2 0.25 0") + wheelText("fr", "base", "0.2 -0.25 0") + rearAxleText() +
      linkText("mast", inertialText()) + jointText("mast_joint", "prismatic", "base", "mast", "0.2 0 0.4", "0 0 1", slide) +
      linkText("fork", inertialText()) +
      jointText("fork_joint", "prismatic", "mast", "fork", "0.1 0 0", "0 0 1", slide + mimicText("mast_joint", 0.5, 0.02));
  Simulator lift = simulatorOf(text, test::flatFloor());
  EXPECT_EQ(reading(lift, "fork_joint").position, 0.02);
  JointRequest request;
  request.joint = "fork_joint";
  request.position = 0.1;
  const Problems refused = lift.commandJoints({request});
  ASSERT_EQ(refused.size(), 1u);
  EXPECT_NE(refused[0].text().find("mimics 'mast_joint'"), std::string::npos) << refused[0].text();
  request.joint = "mast_joint";
  request.position = 0.2;
  for (int i = 0; i < 3000; ++i) {
    EXPECT_TRUE(lift.commandJoints({request}).empty());
    ASSERT_EQ(lift.step(), StepStatus::kOk);
    ASSERT_NEAR(reading(lift, "fork_joint").position, 0.5 * reading(lift, "mast_joint").position + 0.02, 1e-15);
  }
  EXPECT_NEAR(reading(lift, "fork_joint").position, 0.12, 1e-9);
}

// Both front wheels turned by one angle steer about the centre that the middle between them is right for.
TEST(Mimic, SteeringAsOneTurnsAsTheMiddleSays) {
  std::string text = bodyText() + rearAxleText();
  for (const auto& [side, y] : {std::pair{"l", "0.25"}, {"r", "-0.25"}})
    text += linkText(std::string(side) + "_knuckle", inertialText()) +
            jointText(std::string(side) + "_pin", "revolute", "base", std::string(side) + "_knuckle",
                      std::string("0.3 ") + y + " 0", "0 0 1",
                      kLimit + (std::string(side) == "r" ? mimicText("l_pin", 1.0) : "")) +
            wheelText(side, std::string(side) + "_knuckle", "0 0 0");
  Simulator car = simulatorOf(text, test::flatFloor());
  DriveCommand command;
  command.speed = 0.4;
  command.yaw_rate = 0.2;
  for (int i = 0; i < 6000; ++i) {
    car.command(command);
    ASSERT_EQ(car.step(), StepStatus::kOk);
    ASSERT_EQ(reading(car, "r_pin").position, reading(car, "l_pin").position);
  }
  EXPECT_NEAR(reading(car, "l_pin").position, std::atan(0.5 * 0.2 / 0.4), 1e-6);  // wheelbase 0.5 m
  EXPECT_NEAR(car.rootAngularVelocity_W().z(), 0.2, 0.05 * 0.2);
}

// A gear: two flywheels on one shaft, coupled with ratio 3, spun up by an effort on the slow one. On a heavy body:
// (I_1 + 9 I_2) q'' = tau.
TEST(Mimic, AGearAddsItsInertiaByTheSquareOfItsRatio) {
  VehicleDescription vehicle;
  const auto loaded = loadText(
      linkText("base", inertialText(1e6) + collisionText("<box size=\"1 1 1\"/>")) + rearAxleText() +
      linkText("gear", inertialText(2.0)) +
      jointText("gear_joint", "continuous", "rl", "gear", "0 0.1 0", "0 1 0", mimicText("rl_axle", 2.0)));
  ASSERT_TRUE(isLoaded(loaded));
  SimConfig config;
  const auto model = compileVehicle(*loaded.value, config);
  ASSERT_TRUE(model) << problemText(model.problems);
  ASSERT_EQ(model.value->couplings.size(), 1u);
  // The gear turns on the wheel, twice as fast as the wheel: three times against the body. Wheel 0.01, gear 0.02 kg m^2.
  const int wheel = model.value->couplings[0].leader;
  EXPECT_NEAR(model.value->dynamic_joints[wheel].reflected_inertia, 0.01 + 9.0 * 0.02, 1e-6);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
