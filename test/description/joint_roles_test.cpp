#include "ellipsoid_vehicle_sim/description/joint_roles.h"

#include <gtest/gtest.h>

#include <cmath>

#include "urdf_samples.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string limits(const std::string& lower, const std::string& upper) {
  return "<limit lower=\"" + lower + "\" upper=\"" + upper + "\" effort=\"10\" velocity=\"2\"/>";
}

JointRole roleOf(const Loaded<VehicleDescription>& loaded, const std::string& joint) {
  if (!loaded) {
    ADD_FAILURE() << problemText(loaded.problems);
    return JointRole::kLocked;
  }
  return jointOf(*loaded.value, joint).role;
}

std::string reasonOf(const Loaded<VehicleDescription>& loaded, const std::string& joint) {
  return loaded ? jointOf(*loaded.value, joint).role_reason : problemText(loaded.problems);
}

DriveLayout layoutOf(const Loaded<VehicleDescription>& loaded) {
  return loaded ? loaded.value->layout : DriveLayout::kNone;
}

/// A wheel below a knuckle below the base.
std::string knuckleText(const std::string& name, const std::string& xyz, const std::string& type,
                        const std::string& rest, const std::string& axis = "0 0 1",
                        const std::string& wheel_at = "0 0 0") {
  return linkText(name + "_knuckle", inertialText()) +
         jointText(name + "_knuckle_joint", type, "base", name + "_knuckle", xyz, axis, rest) +
         wheelText(name, name + "_knuckle", wheel_at);
}

std::string steeredFront(const std::string& type = "revolute", const std::string& rest = limits("-0.6", "0.6")) {
  return knuckleText("fl", "0.2 0.25 0", type, rest) + knuckleText("fr", "0.2 -0.25 0", type, rest);
}

/// A body of 1 kg on a joint of the base.
std::string partText(const std::string& name, const std::string& type, const std::string& axis,
                     const std::string& rest = "", const std::string& inside = inertialText()) {
  return linkText(name, inside) + jointText(name + "_joint", type, "base", name, "0 0 0.5", axis, rest);
}

// --- Wheels ---------------------------------------------------------------------------------------------------------

TEST(JointRoles, RoundLateralLowContinuousJointsAreWheels) {
  const auto loaded = loadText(baseText() + rearAxleText());
  EXPECT_EQ(roleOf(loaded, "rl_axle"), JointRole::kDrive);
  EXPECT_EQ(reasonOf(loaded, "rl_axle"), "continuous about y, wheel r 0.1, lowest, drives: without steering all do");
  EXPECT_EQ(layoutOf(loaded), DriveLayout::kDifferential);
}

TEST(JointRoles, AxesMayPointEitherWay) {
  const auto loaded =
      loadText(baseText() + wheelText("l", "base", "0 0.3 0", "0 1 0") + wheelText("r", "base", "0 -0.3 0", "0 -1 0"));
  EXPECT_EQ(roleOf(loaded, "l_axle"), JointRole::kDrive);
  EXPECT_EQ(roleOf(loaded, "r_axle"), JointRole::kDrive);
  EXPECT_EQ(reasonOf(loaded, "r_axle").find("continuous about -y"), 0u);
}

TEST(JointRoles, ARevoluteWithAFullTurnIsAWheelAndHasNoStops) {
  const std::string wheel = linkText("w", inertialText() + collisionText("<sphere radius=\"0.1\"/>"));
  const auto with = [&](const std::string& limit) {
    return loadText(baseText() + rearAxleText() + wheel +
                    jointText("w_axle", "revolute", "base", "w", "0.2 0 0", "0 1 0", limit));
  };
  const auto full = with(limits("-3.14159", "3.14159"));
  EXPECT_EQ(roleOf(full, "w_axle"), JointRole::kDrive);
  EXPECT_EQ(jointOf(*full.value, "w_axle").upper, kInfinity);
  EXPECT_TRUE(notedWith(full, {"joint 'w_axle'", "taken as unlimited"}));
  EXPECT_EQ(roleOf(with(limits("-2.5", "2.5")), "w_axle"), JointRole::kPrescribed);
}

TEST(JointRoles, LidarsMastsAndRollersAreNoWheels) {
  const std::string roller =
      collisionText("<cylinder radius=\"0.05\" length=\"0.3\"/>", "0 0 0", "1.5707963267948966 0 0");
  const auto loaded =
      loadText(baseText() + rearAxleText() + partText("lidar", "continuous", "0 0 1", "", inertialText() + roller) +
               partText("roller", "continuous", "0 1 0", "", inertialText() + roller) +
               partText("brush", "continuous", "1 0 0", "", inertialText() + roller));
  EXPECT_EQ(roleOf(loaded, "lidar_joint"), JointRole::kPrescribed);
  EXPECT_EQ(roleOf(loaded, "brush_joint"), JointRole::kPrescribed);
  EXPECT_EQ(roleOf(loaded, "roller_joint"), JointRole::kPrescribed);
  EXPECT_NE(reasonOf(loaded, "roller_joint").find("round but 0.55 m above the lowest wheel"), std::string::npos)
      << reasonOf(loaded, "roller_joint");
}

TEST(JointRoles, AnEccentricOrSquareShapeIsNoWheel) {
  const auto with = [](const std::string& shape) {
    return loadText(baseText() + rearAxleText() + linkText("w", inertialText() + shape) +
                    jointText("w_axle", "continuous", "base", "w", "0.2 0 0", "0 1 0"));
  };
  EXPECT_EQ(roleOf(with(collisionText("<sphere radius=\"0.1\"/>", "0.009 0 0")), "w_axle"), JointRole::kDrive);
  EXPECT_EQ(roleOf(with(collisionText("<sphere radius=\"0.1\"/>", "0.02 0 0")), "w_axle"), JointRole::kPrescribed);
  EXPECT_EQ(roleOf(with(collisionText("<box size=\"0.2 0.05 0.15\"/>")), "w_axle"), JointRole::kPrescribed);
}

TEST(JointRoles, WeightlessLeavesAreLocked) {
  const auto loaded = loadText(baseText() + rearAxleText() + partText("virtual_wheel", "continuous", "0 1 0", "", ""));
  EXPECT_EQ(roleOf(loaded, "virtual_wheel_joint"), JointRole::kLocked);
  EXPECT_TRUE(
      notedWith(loaded, {"joint 'virtual_wheel_joint'", "nothing that weighs or collides hangs on it", "locked"}));
}

// --- Steering, casters, hitches -------------------------------------------------------------------------------------

TEST(JointRoles, UprightJointsWithLimitsAboveWheelsSteerWhateverTheirType) {
  for (const char* type : {"revolute", "continuous"}) {
    const auto loaded = loadText(baseText() + rearAxleText() + steeredFront(type));
    EXPECT_EQ(roleOf(loaded, "fl_knuckle_joint"), JointRole::kSteer) << type;
    EXPECT_EQ(roleOf(loaded, "fr_knuckle_joint"), JointRole::kSteer) << type;
    EXPECT_EQ(layoutOf(loaded), DriveLayout::kAckermann);
  }
}

TEST(JointRoles, ARakedKingpinSteersUpToThirtyDegrees) {
  const auto raked = [](double degrees) {
    const double a = degrees * M_PI / 180.0;
    const std::string axis = std::to_string(-std::sin(a)) + " 0 " + std::to_string(std::cos(a));
    return loadText(baseText() + rearAxleText() + knuckleText("f", "0.2 0 0", "revolute", limits("-0.6", "0.6"), axis));
  };
  EXPECT_EQ(roleOf(raked(25.0), "f_knuckle_joint"), JointRole::kSteer);
  EXPECT_EQ(roleOf(raked(35.0), "f_knuckle_joint"), JointRole::kPassive);
}

TEST(JointRoles, ASteeringWheelInTheCabinDoesNotSteer) {
  const auto loaded = loadText(baseText() + rearAxleText() + steeredFront() +
                               partText("wheel", "continuous", "0 0 1", limits("-8", "8")));
  EXPECT_EQ(roleOf(loaded, "wheel_joint"), JointRole::kPrescribed);
}

TEST(JointRoles, AnUprightJointWithoutLimitsIsACasterAndItsWheelIsFree) {
  for (const std::string& rest : {std::string(), limits("-3.14159", "3.14159")}) {
    const auto loaded = loadText(
        baseText() + rearAxleText() +
        knuckleText("caster", "0.2 0 0", rest.empty() ? "continuous" : "revolute", rest, "0 0 1", "-0.04 0 0"));
    EXPECT_EQ(roleOf(loaded, "caster_knuckle_joint"), JointRole::kPassive);
    EXPECT_EQ(roleOf(loaded, "caster_axle"), JointRole::kFreeWheel);
    EXPECT_EQ(jointOf(*loaded.value, "caster_knuckle_joint").upper, kInfinity);
    EXPECT_EQ(layoutOf(loaded), DriveLayout::kDifferential);
  }
}

TEST(JointRoles, ACasterMayPointAnyWayAtZero) {
  const auto loaded =
      loadText(baseText() + rearAxleText() + linkText("swivel", inertialText()) +
               jointText("swivel_joint", "continuous", "base", "swivel", "0.2 0 0", "0 0 1") +
               linkText("c", inertialText() + collisionText("<cylinder radius=\"0.1\" length=\"0.05\"/>", "0 0 0",
                                                            "0 1.5707963267948966 0")) +
               jointText("c_axle", "continuous", "swivel", "c", "0 0.04 0", "1 0 0"));
  EXPECT_EQ(roleOf(loaded, "c_axle"), JointRole::kFreeWheel);
  EXPECT_EQ(roleOf(loaded, "swivel_joint"), JointRole::kPassive);
}

TEST(JointRoles, AnActuatedSwivelWithoutTrailSteers) {
  const std::string swerve = knuckleText("f", "0.2 0 0", "continuous", "");
  EXPECT_EQ(roleOf(loadText(baseText() + rearAxleText() + swerve), "f_knuckle_joint"), JointRole::kPassive);
  EXPECT_EQ(
      roleOf(loadText(baseText() + rearAxleText() + swerve + transmissionText("f_knuckle_joint")), "f_knuckle_joint"),
      JointRole::kSteer);
}

TEST(JointRoles, WheelsFarBehindALimitedUprightJointAreATrailer) {
  const std::string trailer =
      linkText("drawbar", inertialText(5.0)) +
      jointText("hitch", "revolute", "base", "drawbar", "-0.4 0 0", "0 0 1", limits("-1", "1")) +
      wheelText("tl", "drawbar", "-0.5 0.25 0") + wheelText("tr", "drawbar", "-0.5 -0.25 0");
  const auto loaded = loadText(baseText() + rearAxleText() + steeredFront() + trailer);
  EXPECT_EQ(roleOf(loaded, "hitch"), JointRole::kPassive);
  EXPECT_EQ(roleOf(loaded, "tl_axle"), JointRole::kFreeWheel);
  EXPECT_EQ(roleOf(loaded, "rl_axle"), JointRole::kDrive);
  EXPECT_NE(reasonOf(loaded, "hitch").find("hitch"), std::string::npos);
}

TEST(JointRoles, AnAxleThatTurnsAsAWholeSteers) {
  const std::string axle = linkText("turntable", inertialText(5.0)) +
                           jointText("turn", "revolute", "base", "turntable", "0.2 0 0", "0 0 1", limits("-1", "1")) +
                           wheelText("fl", "turntable", "0 0.4 0") + wheelText("fr", "turntable", "0 -0.4 0");
  EXPECT_EQ(roleOf(loadText(baseText() + rearAxleText() + axle), "turn"), JointRole::kSteer);
}

// --- Suspension, rockers, the rest ----------------------------------------------------------------------------------

TEST(JointRoles, UprightSlidesAboveWheelsAreSuspensionAndOthersAreNot) {
  const auto loaded =
      loadText(baseText() + rearAxleText() + knuckleText("f", "0.2 0 0", "prismatic", limits("-0.1", "0.1")) +
               partText("lift", "prismatic", "0 0 1", limits("0", "0.5")));
  EXPECT_EQ(roleOf(loaded, "f_knuckle_joint"), JointRole::kSuspension);
  EXPECT_EQ(roleOf(loaded, "lift_joint"), JointRole::kPrescribed);
}

TEST(JointRoles, LateralAndLongitudinalJointsAboveWheelsArePassive) {
  const auto loaded = loadText(baseText() + rearAxleText() +
                               knuckleText("rocker", "0.2 0.1 0", "revolute", limits("-0.3", "0.3"), "0 1 0") +
                               knuckleText("axle", "0.2 -0.1 0", "revolute", limits("-0.3", "0.3"), "1 0 0"));
  EXPECT_EQ(roleOf(loaded, "rocker_knuckle_joint"), JointRole::kPassive);
  EXPECT_NE(reasonOf(loaded, "rocker_knuckle_joint").find("rocker or bogie"), std::string::npos);
  EXPECT_EQ(roleOf(loaded, "axle_knuckle_joint"), JointRole::kPassive);
  EXPECT_NE(reasonOf(loaded, "axle_knuckle_joint").find("pivoting axle"), std::string::npos);
}

TEST(JointRoles, ASprungSwingArmIsSuspension) {
  const auto loaded = loadText(baseText() + rearAxleText() +
                               knuckleText("arm", "0.4 0 0", "revolute",
                                           limits("-0.3", "0.3") + "<dynamics damping=\"1\" spring_stiffness=\"100\"/>",
                                           "0 1 0", "-0.2 0 0"));
  EXPECT_EQ(roleOf(loaded, "arm_knuckle_joint"), JointRole::kSuspension);
}

// --- Which wheels drive ---------------------------------------------------------------------------------------------

TEST(JointRoles, WithoutAHintTheUnsteeredWheelsDriveAndANoteSaysSo) {
  const auto loaded = loadText(baseText() + rearAxleText() + steeredFront());
  EXPECT_EQ(roleOf(loaded, "rl_axle"), JointRole::kDrive);
  EXPECT_EQ(roleOf(loaded, "fl_axle"), JointRole::kFreeWheel);
  EXPECT_TRUE(notedWith(loaded, {"nothing says which wheels drive", "'rl_axle', 'rr_axle'"}));
}

TEST(JointRoles, TransmissionsSayWhichWheelsDrive) {
  const auto loaded = loadText(baseText() + rearAxleText() + steeredFront() + transmissionText("fl_axle") +
                               transmissionText("fr_axle") + transmissionText("fl_knuckle_joint"));
  EXPECT_EQ(roleOf(loaded, "fl_axle"), JointRole::kDrive);
  EXPECT_EQ(roleOf(loaded, "rl_axle"), JointRole::kFreeWheel);
  EXPECT_EQ(layoutOf(loaded), DriveLayout::kAckermann);
}

TEST(JointRoles, AmongTransmissionsAVelocityInterfaceMarksTheMotors) {
  const auto loaded =
      loadText(baseText() + rearAxleText() + steeredFront() +
               transmissionText("fl_axle", "hardware_interface/VelocityJointInterface") + transmissionText("rl_axle"));
  EXPECT_EQ(roleOf(loaded, "fl_axle"), JointRole::kDrive);
  EXPECT_EQ(roleOf(loaded, "rl_axle"), JointRole::kFreeWheel);
}

TEST(JointRoles, SteeringAtBothEndsLeavesTheMiddleWheelsFree) {
  const auto loaded = loadText(baseText() + knuckleText("f", "0.3 0 0", "revolute", limits("-1", "1")) +
                               knuckleText("b", "-0.3 0 0", "revolute", limits("-1", "1")) +
                               wheelText("l", "base", "0 0.25 0") + wheelText("r", "base", "0 -0.25 0"));
  EXPECT_EQ(roleOf(loaded, "f_axle"), JointRole::kDrive);
  EXPECT_EQ(roleOf(loaded, "b_axle"), JointRole::kDrive);
  EXPECT_EQ(roleOf(loaded, "l_axle"), JointRole::kFreeWheel);
}

TEST(JointRoles, ATricycleSteeredBehindDrivesInFront) {
  const auto loaded = loadText(baseText() + knuckleText("b", "-0.3 0 0", "revolute", limits("-1", "1")) +
                               wheelText("l", "base", "0.3 0.25 0") + wheelText("r", "base", "0.3 -0.25 0"));
  EXPECT_EQ(roleOf(loaded, "l_axle"), JointRole::kDrive);
  EXPECT_EQ(roleOf(loaded, "b_axle"), JointRole::kFreeWheel);
  EXPECT_EQ(layoutOf(loaded), DriveLayout::kAckermann);
}

TEST(JointRoles, DriveJointsOfTheOptionsOverruleTransmissions) {
  UrdfOptions options;
  options.drive_joints = {"rl_axle", "rr_axle"};
  const auto loaded = loadText(baseText() + rearAxleText() + steeredFront() + transmissionText("fl_axle"), options);
  EXPECT_EQ(roleOf(loaded, "rl_axle"), JointRole::kDrive);
  EXPECT_EQ(roleOf(loaded, "fl_axle"), JointRole::kFreeWheel);
}

TEST(JointRoles, RolesOfTheOptionsOverruleEverything) {
  UrdfOptions options;
  options.roles = {{"fl_knuckle_joint", JointRole::kLocked},
                   {"rl_axle", JointRole::kFreeWheel},
                   {"lift_joint", JointRole::kPassive}};
  const auto loaded = loadText(
      baseText() + rearAxleText() + steeredFront() + partText("lift", "prismatic", "0 0 1", limits("0", "0.5")),
      options);
  EXPECT_EQ(roleOf(loaded, "fl_knuckle_joint"), JointRole::kLocked);
  EXPECT_EQ(roleOf(loaded, "rl_axle"), JointRole::kFreeWheel);
  EXPECT_EQ(roleOf(loaded, "lift_joint"), JointRole::kPassive);
  EXPECT_NE(reasonOf(loaded, "lift_joint").find("as asked for by parameter"), std::string::npos);
}

TEST(JointRoles, ANamedWheelNeedNotBeRoundButNeedsAShape) {
  UrdfOptions options;
  options.roles = {{"w_axle", JointRole::kDrive}};
  const auto with = [&options](const std::string& shape) {
    return loadText(baseText() + rearAxleText() + linkText("w", inertialText() + shape) +
                        jointText("w_axle", "continuous", "base", "w", "0.2 0 0", "0 1 0"),
                    options);
  };
  EXPECT_EQ(roleOf(with(collisionText("<box size=\"0.2 0.05 0.15\"/>")), "w_axle"), JointRole::kDrive);
  EXPECT_TRUE(refusedWith(with(""), {"joint 'w_axle'", "nothing that collides turns with it"}));
}

TEST(JointRoles, OneDrivenWheelAloneIsNoLayout) {
  const auto loaded = loadText(baseText() + wheelText("w", "base", "0 0 0"));
  EXPECT_EQ(roleOf(loaded, "w_axle"), JointRole::kDrive);
  EXPECT_EQ(layoutOf(loaded), DriveLayout::kNone);
}

// --- Forward --------------------------------------------------------------------------------------------------------

/// A cart whose axles lie along x, its front pair called so or not.
std::string sidewaysText(const std::string& front, const std::string& rear) {
  return baseText() + wheelText(front + "_a", "base", "0.25 0.2 0", "1 0 0") +
         wheelText(front + "_b", "base", "-0.25 0.2 0", "-1 0 0") + wheelText(rear + "_a", "base", "0.25 -0.2 0", "1 0 0") +
         wheelText(rear + "_b", "base", "-0.25 -0.2 0", "1 0 0");
}

/// wheelText's cylinders stand along y: these stand along x.
std::string alongX(std::string text) {
  const std::string y = "1.5707963267948966 0 0", x = "0 1.5707963267948966 0";
  for (std::size_t at = 0; (at = text.find(y, at)) != std::string::npos;) text.replace(at, y.size(), x);
  return text;
}

TEST(Forward, IsAcrossTheAxlesToTheEndThatIsCalledFront) {
  const auto plain = loadText(baseText() + rearAxleText());
  EXPECT_EQ(plain.value->forward_yaw, 0.0);
  const auto named = loadText(alongX(sidewaysText("rear", "front")));
  ASSERT_TRUE(isLoaded(named));
  EXPECT_NEAR(named.value->forward_yaw, -M_PI / 2.0, 1e-12);
  EXPECT_EQ(layoutOf(named), DriveLayout::kDifferential);
  EXPECT_TRUE(notedWith(named, {"forward is taken to be -y", "names of its wheels"}));
  const auto unnamed = loadText(alongX(sidewaysText("u", "v")));
  ASSERT_TRUE(isLoaded(unnamed));
  EXPECT_NEAR(unnamed.value->forward_yaw, M_PI / 2.0, 1e-12);
  EXPECT_TRUE(notedWith(unnamed, {"forward is taken to be y", "nothing says"}));
}

TEST(Forward, IsBackwardsWhereEveryNameSaysSo) {
  const std::string text = baseText() + wheelText("front_left", "base", "-0.2 -0.25 0") +
                           wheelText("front_right", "base", "-0.2 0.25 0") + wheelText("back_left", "base", "0.2 -0.25 0") +
                           wheelText("back_right", "base", "0.2 0.25 0");
  const auto loaded = loadText(text);
  ASSERT_TRUE(isLoaded(loaded));
  EXPECT_NEAR(std::abs(loaded.value->forward_yaw), M_PI, 1e-12);
  // One name against the others, and x it stays.
  const auto torn = loadText(text + wheelText("front_middle", "base", "0.3 0.25 0"));
  ASSERT_TRUE(isLoaded(torn));
  EXPECT_EQ(torn.value->forward_yaw, 0.0);
}

TEST(Forward, TheParameterOverrulesNames) {
  UrdfOptions options;
  Problems problems;
  options.forward_yaw = forwardFromWord("-x", "parameter forward", problems);
  const auto loaded = loadText(baseText() + rearAxleText(), options);
  ASSERT_TRUE(isLoaded(loaded));
  EXPECT_EQ(loaded.value->forward_yaw, M_PI);
  EXPECT_TRUE(problems.empty());
  EXPECT_FALSE(forwardFromWord("auto", "parameter forward", problems));
  EXPECT_TRUE(problems.empty());
  forwardFromWord("north", "parameter forward", problems);
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_EQ(problems[0].text(), "parameter forward: 'north' is no direction; allowed are auto, x, -x, y, -y of the root link");
}

// --- What drives ----------------------------------------------------------------------------------------------------

TEST(JointRoles, LimitsOfZeroOnARoundWheelAreNone) {
  const auto loaded = loadText(baseText() + rearAxleText() + linkText("w", inertialText() + collisionText("<sphere radius=\"0.1\"/>")) +
                               jointText("w_axle", "revolute", "base", "w", "0.2 0 0", "0 1 0", limits("0", "0")));
  EXPECT_EQ(roleOf(loaded, "w_axle"), JointRole::kDrive);
  EXPECT_EQ(jointOf(*loaded.value, "w_axle").upper, kInfinity);
  EXPECT_TRUE(notedWith(loaded, {"joint 'w_axle'", "both 0", "taken as unlimited"}));
}

TEST(JointRoles, AWheelWithoutAnAxisTurnsAboutItsShapesOwn) {
  std::string left = wheelText("l", "base", "0 0.3 0");
  const std::string axis = "<axis xyz=\"0 1 0\"/>";
  left.erase(left.find(axis), axis.size());
  const auto loaded = loadText(baseText() + left + wheelText("r", "base", "0 -0.3 0"));
  EXPECT_EQ(roleOf(loaded, "l_axle"), JointRole::kDrive);
  EXPECT_TRUE(jointOf(*loaded.value, "l_axle").axis.isApprox(Eigen::Vector3d::UnitY(), 1e-9));
  EXPECT_TRUE(notedWith(loaded, {"joint 'l_axle'", "no <axis>", "that is taken"}));
}

TEST(JointRoles, PluginsOfDrivesAndRos2ControlSayWhatDrives) {
  const std::string front = wheelText("fl", "base", "0.2 0.25 0") + wheelText("fr", "base", "0.2 -0.25 0");
  for (const std::string hint :
       {"<gazebo><plugin name=\"d\" filename=\"libgazebo_ros_diff_drive.so\"><leftJoint>rl_axle</leftJoint>"
        "<rightJoint>rr_axle</rightJoint></plugin></gazebo>\n",
        "<ros2_control name=\"c\" type=\"system\"><joint name=\"rl_axle\"><command_interface name=\"velocity\"/></joint>"
        "<joint name=\"rr_axle\"><command_interface name=\"velocity\"/></joint><joint name=\"fl_axle\">"
        "<state_interface name=\"velocity\"/></joint></ros2_control>\n"}) {
    const auto loaded = loadText(baseText() + rearAxleText() + front + hint);
    EXPECT_EQ(roleOf(loaded, "rl_axle"), JointRole::kDrive) << hint;
    EXPECT_EQ(roleOf(loaded, "fl_axle"), JointRole::kFreeWheel) << hint;
  }
}

TEST(JointRoles, ASlideCalledALiftHoldsEvenWithRollersBelow) {
  const auto with = [](const std::string& name) {
    return loadText(baseText() + rearAxleText() + linkText(name, inertialText()) +
                    jointText(name + "_joint", "prismatic", "base", name, "0.2 0 0", "0 0 1", limits("0", "0.2")) +
                    wheelText("roller", name, "0.1 0 0"));
  };
  EXPECT_EQ(roleOf(with("fork"), "fork_joint"), JointRole::kPrescribed);
  EXPECT_EQ(roleOf(with("strut"), "strut_joint"), JointRole::kSuspension);
}

TEST(JointRoles, SwivelsSteerWhereNothingElseCould) {
  const auto modules = [](const std::string& trail) {
    std::string text = baseText();
    for (const auto& [name, at] : {std::pair{"a", "0.2 0.2 0"}, {"b", "0.2 -0.2 0"}, {"c", "-0.2 0.2 0"}, {"d", "-0.2 -0.2 0"}})
      text += knuckleText(name, at, "continuous", "", "0 0 1", trail);
    return loadText(text);
  };
  EXPECT_EQ(roleOf(modules("0 0 0"), "a_knuckle_joint"), JointRole::kSteer);
  EXPECT_EQ(roleOf(modules("-0.05 0 0"), "a_knuckle_joint"), JointRole::kSteer);
}

// --- The table ------------------------------------------------------------------------------------------------------

TEST(JointTable, HasALineForEveryMovableJointAndCountsTheFixed) {
  const auto loaded = loadText(baseText() + rearAxleText() + linkText("imu", "") +
                               jointText("f", "fixed", "base", "imu", "0 0 0", "1 0 0"));
  ASSERT_TRUE(isLoaded(loaded));
  const auto table = jointTable(*loaded.value);
  ASSERT_EQ(table.size(), 4u);
  EXPECT_EQ(table[0], "joint    type        role   why");
  EXPECT_EQ(table[1],
            "rl_axle  continuous  drive  continuous about y, wheel r 0.1, lowest, drives: without steering all do");
  EXPECT_EQ(table[3], "1 fixed joint, layout: differential");
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
