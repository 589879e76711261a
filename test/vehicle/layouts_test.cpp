#include <gtest/gtest.h>

#include <cmath>

#include "description/urdf_samples.h"
#include "ellipsoid_vehicle_sim/vehicle/simulator.h"
#include "support/scenes.h"

// Every layout driven in a curve, on level ground at walking pace, against its kinematic law. Vehicles are URDF text, so
// that what is tested is all of it: roles, layout, drive, wheels on the ground.

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

const std::string kSteering = "<limit lower=\"-1.2\" upper=\"1.2\" effort=\"100\" velocity=\"2\"/>";

/// A body of 30 kg, 0.3 m above the wheels' axles, so that it touches nothing.
std::string bodyText() {
  return linkText("base", inertialText(30.0) + collisionText("<box size=\"0.4 0.3 0.1\"/>", "0 0 0.3"));
}

/// A wheel below a kingpin through its middle.
std::string steeredText(const std::string& name, const std::string& xyz, const std::string& parent = "base") {
  return linkText(name + "_knuckle", inertialText()) +
         jointText(name + "_pin", "revolute", parent, name + "_knuckle", xyz, "0 0 1", kSteering) +
         wheelText(name, name + "_knuckle", "0 0 0");
}

/// A caster whose swivel stands above the ground wheel with a trail of 0.05 m.
std::string casterText(const std::string& name, const std::string& xyz) {
  return linkText(name + "_fork", inertialText()) +
         jointText(name + "_swivel", "continuous", "base", name + "_fork", xyz, "0 0 1") +
         wheelText(name, name + "_fork", "-0.05 0 0");
}

std::string pair(const std::string& name, double x, double half_track, bool steered = false,
                 const std::string& parent = "base") {
  std::string text;
  for (const auto& [side, y] : {std::pair{"_left", half_track}, {"_right", -half_track}}) {
    const std::string at = std::to_string(x) + " " + std::to_string(y) + " 0";
    text += steered ? steeredText(name + side, at, parent) : wheelText(name + side, parent, at);
  }
  return text;
}

struct Curve {
  double yaw_rate = 0.0, speed = 0.0;  ///< of the root link, along its path.
  double hitch = 0.0;                  ///< position of the joint "hitch" at the end, if there is one.
  Vector3d went = Vector3d::Zero();    ///< of the root link in the root link's own start frame [m].
};

/// Drives until steady, then measures over two seconds.
Curve driven(const std::string& text, double speed, double yaw_rate, double settle = 8.0, const UrdfOptions& options = {}) {
  Curve curve;
  const auto vehicle = loadText(text, options);
  EXPECT_TRUE(vehicle) << problemText(vehicle.problems);
  if (!vehicle) return curve;
  auto simulator = Simulator::create(*vehicle.value, test::flatFloor(), SimConfig{});
  EXPECT_TRUE(simulator) << problemText(simulator.problems);
  if (!simulator) return curve;
  Simulator& sim = *simulator.value;
  const Problems problems = sim.setDown(0.0, 0.0, 0.0);
  EXPECT_TRUE(problems.empty()) << problemText(problems);
  DriveCommand command;
  command.speed = speed;
  command.yaw_rate = yaw_rate;
  const auto run = [&](double seconds) {
    for (int i = 0; i < static_cast<int>(1000.0 * seconds); ++i) {
      sim.command(command);
      EXPECT_EQ(sim.step(), StepStatus::kOk);
    }
  };
  run(settle);
  curve.went = sim.rootPose().p;
  const Vector3d x0 = sim.rootPose().q * Vector3d::UnitX();
  double way = 0.0;
  Vector3d at = sim.rootPose().p;
  for (int i = 0; i < 200; ++i) {
    run(0.01);
    way += (sim.rootPose().p - at).norm();
    at = sim.rootPose().p;
  }
  const Vector3d x1 = sim.rootPose().q * Vector3d::UnitX();
  curve.yaw_rate = std::atan2(x0.cross(x1).z(), x0.dot(x1)) / 2.0;
  curve.speed = way / 2.0;
  std::vector<JointReading> readings;
  sim.jointReadings(readings);
  for (std::size_t j = 0; j < readings.size(); ++j)
    if (sim.jointNames()[j] == "hitch") curve.hitch = readings[j].position;
  return curve;
}

constexpr double kTolerance = 0.02;  // slip of the brush at walking pace

TEST(Layouts, AckermannSteeredInFrontTurnsAboutItsRearAxle) {
  const std::string text = bodyText() + pair("rear", -0.3, 0.25) + pair("front", 0.3, 0.25, true);
  for (const double side : {1.0, -1.0}) {
    const Curve c = driven(text, 0.4, side * 0.2);
    EXPECT_NEAR(c.yaw_rate, side * 0.2, kTolerance * 0.2);
    // The root link is 0.3 m ahead of the axle that rolls at 0.4 m/s.
    EXPECT_NEAR(c.speed, std::hypot(0.4, 0.2 * 0.3), kTolerance * 0.4);
  }
}

TEST(Layouts, AckermannSteeredBehindTurnsAboutItsFrontAxle) {
  const std::string text = bodyText() + pair("front", 0.3, 0.25) + pair("rear", -0.3, 0.25, true);
  const Curve c = driven(text, 0.4, 0.2);
  EXPECT_NEAR(c.yaw_rate, 0.2, kTolerance * 0.2);
  EXPECT_NEAR(c.speed, std::hypot(0.4, 0.2 * 0.3), kTolerance * 0.4);
}

TEST(Layouts, FourWheelSteeringTurnsAboutItsMiddle) {
  const std::string text = bodyText() + pair("front", 0.3, 0.25, true) + pair("rear", -0.3, 0.25, true);
  for (const double side : {1.0, -1.0}) {
    const Curve c = driven(text, 0.4, side * 0.4);
    EXPECT_NEAR(c.yaw_rate, side * 0.4, kTolerance * 0.4);
    EXPECT_NEAR(c.speed, 0.4, kTolerance * 0.4);  // the root link is the middle
  }
}

TEST(Layouts, TricycleSteeredBehindLikeAForkliftTurnsAboutItsFrontAxle) {
  const std::string text = bodyText() + pair("front", 0.3, 0.25) + steeredText("rear", "-0.3 0 0");
  const auto loaded = loadText(text);
  ASSERT_TRUE(isLoaded(loaded));
  EXPECT_EQ(loaded.value->layout_text, "tricycle steered behind");
  const Curve c = driven(text, 0.4, -0.3);
  EXPECT_NEAR(c.yaw_rate, -0.3, kTolerance * 0.3);
  EXPECT_NEAR(c.speed, std::hypot(0.4, 0.3 * 0.3), kTolerance * 0.4);
}

TEST(Layouts, DifferentialWithCastersTurnsByTheDifferenceOfItsWheels) {
  const std::string text = bodyText() + pair("drive", 0.0, 0.25) + casterText("front", "0.3 0 0") + casterText("rear", "-0.3 0 0");
  const auto loaded = loadText(text);
  ASSERT_TRUE(isLoaded(loaded));
  EXPECT_EQ(loaded.value->layout_text, "differential, 2 casters");
  for (const double side : {1.0, -1.0}) {
    const Curve c = driven(text, 0.4, side * 0.5);
    EXPECT_NEAR(c.yaw_rate, side * 0.5, kTolerance * 0.5);
    EXPECT_NEAR(c.speed, 0.4, kTolerance * 0.4);
  }
  EXPECT_NEAR(driven(text, 0.0, 0.8).yaw_rate, 0.8, kTolerance * 0.8);  // on the spot
}

// Six driven wheels on a rocker and a bogie each side: what skids has no closed form, but straight on nothing skids, and
// both ways are the same curve.
TEST(Layouts, RockerBogieDrivesStraightAndTurnsAlikeBothWays) {
  std::string text = bodyText();
  for (const auto& [side, y] : {std::pair{"left", "0.25"}, {"right", "-0.25"}}) {
    const std::string rocker = std::string(side) + "_rocker", bogie = std::string(side) + "_bogie";
    text += linkText(rocker, inertialText()) +
            jointText(rocker + "_joint", "revolute", "base", rocker, std::string("0 ") + y + " 0.1", "0 1 0", kSteering) +
            wheelText(rocker + "_front", rocker, "0.35 0 -0.1") + linkText(bogie, inertialText()) +
            jointText(bogie + "_joint", "revolute", rocker, bogie, "-0.15 0 0", "0 1 0", kSteering) +
            wheelText(bogie + "_middle", bogie, "0.15 0 -0.1") + wheelText(bogie + "_rear", bogie, "-0.2 0 -0.1");
  }
  const auto loaded = loadText(text);
  ASSERT_TRUE(isLoaded(loaded));
  EXPECT_EQ(jointOf(*loaded.value, "left_bogie_joint").role, JointRole::kPassive);
  EXPECT_NE(loaded.value->layout_text.find("on rockers"), std::string::npos) << loaded.value->layout_text;
  const Curve straight = driven(text, 0.4, 0.0, 4.0);
  EXPECT_NEAR(straight.speed, 0.4, 0.01 * 0.4);
  EXPECT_LT(std::abs(straight.went.y()), 1e-3);
  const double left = driven(text, 0.3, 0.6).yaw_rate, right = driven(text, 0.3, -0.6).yaw_rate;
  EXPECT_GT(left, 0.1);
  EXPECT_NEAR(left, -right, 0.02 * left);
}

// A trailer hitched h behind the rear axle of a tractor, its own axle l behind the hitch, in steady turning with radius R at
// the tractor's axle: the hitch runs on hypot(R, h), the trailer's axle on sqrt(R^2 + h^2 - l^2), and the angle between
// tractor and trailer is atan(h / R) + atan(l / R_trailer).
TEST(Layouts, ATrailerFollowsAtTheAngleOfSteadyTurning) {
  const double h = 0.2, l = 0.6, speed = 0.4, rate = 0.25, R = speed / rate;
  const std::string text =
      bodyText() + pair("rear", -0.3, 0.25) + pair("front", 0.3, 0.25, true) +
      linkText("trailer", inertialText(20.0).insert(10, "<origin xyz=\"-0.55 0 0\"/>")) +
      jointText("hitch", "revolute", "base", "trailer", "-0.5 0 0", "0 0 1", kSteering) +
      pair("trailer", -l, 0.25, false, "trailer");
  const auto loaded = loadText(text);
  ASSERT_TRUE(isLoaded(loaded));
  EXPECT_EQ(jointOf(*loaded.value, "hitch").role, JointRole::kPassive);
  EXPECT_EQ(loaded.value->layout_text, "steered in front, with a trailer");
  const Curve c = driven(text, speed, rate, 16.0);
  EXPECT_NEAR(c.yaw_rate, rate, kTolerance * rate);
  const double trailer_radius = std::sqrt(R * R + h * h - l * l);
  EXPECT_NEAR(c.hitch, -(std::atan(h / R) + std::atan(l / trailer_radius)), 0.02);
}

// --- Forward is forward ---------------------------------------------------------------------------------------------

std::string cart(const std::string& left_axis, const std::string& right_axis) {
  return bodyText() + wheelText("l", "base", "0 0.25 0", left_axis) + wheelText("r", "base", "0 -0.25 0", right_axis) +
         casterText("a", "0.3 0 0") + casterText("b", "-0.3 0 0");
}

TEST(Forward, APositiveCommandGoesForwardWhicheverWayTheAxlesPoint) {
  for (const std::string left : {"0 1 0", "0 -1 0"})
    for (const std::string right : {"0 1 0", "0 -1 0"}) {
      const Curve c = driven(cart(left, right), 0.4, 0.0, 3.0);
      EXPECT_GT(c.went.x(), 0.9) << left << ", " << right;
      EXPECT_LT(std::abs(c.went.y()), 1e-3);
    }
}

TEST(Forward, AVehicleThatLooksAlongYGoesAndTurnsThere) {
  std::string text = bodyText();
  for (const auto& [name, at] :
       {std::pair{"front_left", "-0.25 0.3 0"}, {"front_right", "0.25 0.3 0"}}) {
    text += linkText(std::string(name) + "_knuckle", inertialText()) +
            jointText(std::string(name) + "_pin", "revolute", "base", std::string(name) + "_knuckle", at, "0 0 1", kSteering) +
            linkText(name, inertialText() + collisionText("<cylinder radius=\"0.1\" length=\"0.05\"/>", "0 0 0",
                                                          "0 1.5707963267948966 0")) +
            jointText(std::string(name) + "_axle", "continuous", std::string(name) + "_knuckle", name, "0 0 0", "1 0 0");
  }
  for (const auto& [name, at] : {std::pair{"rear_left", "-0.25 -0.3 0"}, {"rear_right", "0.25 -0.3 0"}})
    text += linkText(name, inertialText() + collisionText("<cylinder radius=\"0.1\" length=\"0.05\"/>", "0 0 0",
                                                          "0 1.5707963267948966 0")) +
            jointText(std::string(name) + "_axle", "continuous", "base", name, at, "-1 0 0");
  const Curve straight = driven(text, 0.4, 0.0, 3.0);
  EXPECT_GT(straight.went.y(), 0.9);
  EXPECT_LT(std::abs(straight.went.x()), 1e-3);
  const Curve left = driven(text, 0.4, 0.2);
  EXPECT_NEAR(left.yaw_rate, 0.2, kTolerance * 0.2);
  EXPECT_NEAR(left.speed, std::hypot(0.4, 0.2 * 0.3), kTolerance * 0.4);
}

TEST(Forward, TheParameterTurnsACartRound) {
  UrdfOptions options;
  options.forward_yaw = M_PI;
  const Curve c = driven(cart("0 1 0", "0 1 0"), 0.4, 0.0, 3.0, options);
  EXPECT_LT(c.went.x(), -0.9);
  EXPECT_NEAR(driven(cart("0 1 0", "0 1 0"), 0.4, 0.5, 8.0, options).yaw_rate, 0.5, kTolerance * 0.5);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
