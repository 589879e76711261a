#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "ellipsoid_vehicle_sim/description/xacro.h"
#include "ellipsoid_vehicle_sim/vehicle/vehicle_model.h"
#include "support/temporary_files.h"
#include "urdf_samples.h"

namespace ellipsoid_vehicle_sim {
namespace {

std::string gazeboText(const std::string& link, const std::string& inside) {
  return "<gazebo reference=\"" + link + "\">" + inside + "</gazebo>\n";
}

std::string cartText() { return baseText() + rearAxleText() + wheelText("f", "base", "0.2 0 0"); }

// --- Surfaces -------------------------------------------------------------------------------------------------------

TEST(Surfaces, FrictionIsTheSmallerOfTwoAndNonsenseIsTold) {
  const auto loaded = loadText(cartText() + gazeboText("rl", "<mu1>0.6</mu1><mu2>0.4</mu2>") +
                               gazeboText("rr", "<mu1 value=\"100000\"/>") + gazeboText("f", "<mu1>much</mu1>"));
  ASSERT_TRUE(isLoaded(loaded));
  EXPECT_EQ(linkOf(*loaded.value, "rl").ellipsoids.at(0).mu, 0.4);
  EXPECT_FALSE(linkOf(*loaded.value, "rr").ellipsoids.at(0).mu);
  EXPECT_TRUE(notedWith(loaded, {"link 'rl'", "mu1 and mu2 differ", "0.4"}));
  EXPECT_TRUE(notedWith(loaded, {"link 'rr'", "100000 makes no physical sense", "mu_static and mu_kinetic are used"}));
  EXPECT_TRUE(notedWith(loaded, {"gazebo 'f'", "<mu1> reads \"much\"", "makes no physical sense"}));
}

TEST(Surfaces, StiffnessThatHoldsIsTakenAndOtherIsReplacedAndTold) {
  const auto with = [](const std::string& kp, const std::string& kd) {
    const auto loaded = loadText(cartText() + gazeboText("rl", "<kp>" + kp + "</kp><kd>" + kd + "</kd>"));
    EXPECT_TRUE(isLoaded(loaded));
    auto model = compileVehicle(*loaded.value, SimConfig{});
    EXPECT_TRUE(model) << problemText(model.problems);
    return std::move(*model.value);
  };
  const auto wheelOf = [](const VehicleModel& model) -> const ModelEllipsoid& {
    for (const ModelEllipsoid& e : model.ellipsoids)
      if (e.name == "rl") return e;
    throw std::out_of_range("rl");
  };
  const auto reported = [](const VehicleModel& model, const std::string& text) {
    for (const std::string& line : model.report)
      if (line.find(text) != std::string::npos) return true;
    return false;
  };
  const VehicleModel sane = with("100000", "100");
  EXPECT_EQ(wheelOf(sane).law.stiffness, 1e5);
  EXPECT_EQ(wheelOf(sane).law.damping, 100.0);
  const VehicleModel stiff = with("1e12", "1");
  EXPECT_LT(wheelOf(stiff).law.stiffness, 1e8);
  EXPECT_TRUE(reported(stiff, "kp = 1e+12 N/m of the file makes no physical sense"));
  EXPECT_TRUE(reported(with("1", "1"), "its weight alone would sink it in"));
  EXPECT_TRUE(reported(with("100000", "1e9"), "kd = 1e+09 N s/m of the file makes no physical sense"));
}

TEST(Surfaces, ABallOnTheGroundIsACasterUnlessTheFileSaysOtherwise) {
  const std::string ball = linkText("caster", collisionText("<sphere radius=\"0.03\"/>")) +
                           jointText("c", "fixed", "base", "caster", "0.25 0 -0.07", "1 0 0");
  const auto plain = loadText(baseText() + rearAxleText() + ball);
  ASSERT_TRUE(isLoaded(plain));
  EXPECT_EQ(linkOf(*plain.value, "caster").ellipsoids.at(0).mu, 0.005);
  EXPECT_TRUE(notedWith(plain, {"link 'caster'", "taken for a ball or caster"}));
  const auto said = loadText(baseText() + rearAxleText() + ball + gazeboText("caster", "<mu1>0.3</mu1>"));
  EXPECT_EQ(linkOf(*said.value, "caster").ellipsoids.at(0).mu, 0.3);
  const std::string high = linkText("knob", collisionText("<sphere radius=\"0.03\"/>")) +
                           jointText("k", "fixed", "base", "knob", "0.25 0 0.3", "1 0 0");
  EXPECT_FALSE(linkOf(*loadText(baseText() + rearAxleText() + high).value, "knob").ellipsoids.at(0).mu);
}

TEST(Springs, OneThatCannotCarryItsLoadIsReplacedAndTold) {
  const auto with = [](const std::string& spring) {
    std::string text = baseText();
    for (const auto& [name, at] : {std::pair{"fl", "0.2 0.25 0"}, {"fr", "0.2 -0.25 0"}, {"bl", "-0.2 0.25 0"}, {"br", "-0.2 -0.25 0"}})
      text += linkText(std::string(name) + "_carrier", inertialText()) +
              jointText(std::string(name) + "_strut", "prismatic", "base", std::string(name) + "_carrier", at, "0 0 1",
                        "<limit lower=\"-0.05\" upper=\"0.05\" effort=\"1000\" velocity=\"1\"/>" + spring) +
              wheelText(name, std::string(name) + "_carrier", "0 0 0");
    const auto loaded = loadText(text);
    EXPECT_TRUE(isLoaded(loaded));
    auto model = compileVehicle(*loaded.value, SimConfig{});
    EXPECT_TRUE(model) << problemText(model.problems);
    return std::move(*model.value);
  };
  const auto told = [](const VehicleModel& model) {
    for (const std::string& line : model.report)
      if (line.find("makes no physical sense") != std::string::npos) return true;
    return false;
  };
  const VehicleModel sane = with("<dynamics damping=\"10\" spring_stiffness=\"2000\" spring_reference=\"0\"/>");
  EXPECT_EQ(sane.dynamic_joints.at(0).stiffness, 2000.0);
  EXPECT_FALSE(told(sane));
  const VehicleModel weak = with("<dynamics damping=\"10\" spring_stiffness=\"10\"/>");
  EXPECT_GT(weak.dynamic_joints.at(0).stiffness, 100.0);
  EXPECT_TRUE(told(weak));
  // Nothing in the file: mid-travel.
  EXPECT_NEAR(with("").dynamic_joints.at(0).rest, 0.0, 1e-12);
}

// --- Oddities of files ----------------------------------------------------------------------------------------------

TEST(Oddities, LimitsBeyondAnyReachAreNone) {
  const auto loaded = loadText(baseText() + rearAxleText() +
                               linkText("w", inertialText() + collisionText("<sphere radius=\"0.1\"/>")) +
                               jointText("w_axle", "revolute", "base", "w", "0.2 0 0", "0 1 0",
                                         "<limit lower=\"-1e+16\" upper=\"1e+16\" effort=\"1\" velocity=\"1\"/>"));
  ASSERT_TRUE(isLoaded(loaded));
  EXPECT_TRUE(std::isinf(jointOf(*loaded.value, "w_axle").upper));
}

TEST(Oddities, AMaterialInsideAGeometryIsIgnored) {
  const auto loaded = loadText(linkText("base", inertialText() + "<collision><geometry><sphere radius=\"0.1\"/>"
                                                                 "<material name=\"red\"/></geometry></collision>"));
  ASSERT_TRUE(isLoaded(loaded));
  EXPECT_TRUE(notedWith(loaded, {"<material> inside <geometry> is ignored"}));
}

TEST(Oddities, PackagesMayLieAboveTheFileAndInFoldersOfOtherNames) {
  const TemporaryFiles files;
  files.write("checkout/package.xml", "<package><name>cart_description</name></package>");
  files.write("checkout/meshes/a.stl", "x");
  const std::string urdf = files.write("robot/urdf/deep/cart.urdf", "");
  files.write("robot/package.xml", "<package><name>robot_description</name></package>");
  files.write("robot/meshes/b.stl", "x");
  const UriResolver resolver = fileResolver(urdf);
  EXPECT_TRUE(resolver("package://robot_description/meshes/b.stl"));
  EXPECT_TRUE(resolver("package://cart_description/meshes/a.stl"));
  EXPECT_FALSE(resolver("package://cart_description/meshes/none.stl"));
  EXPECT_FALSE(resolver("package://nobody/meshes/a.stl"));
}

// --- Xacro ----------------------------------------------------------------------------------------------------------

class Xacro : public testing::Test {
 protected:
  void SetUp() override { path_ = std::getenv("PATH") ? std::getenv("PATH") : ""; }
  void TearDown() override { setenv("PATH", path_.c_str(), 1); }

  /// A command xacro that is this shell script.
  void provide(const std::string& script) {
    const std::string file = files_.write("bin/xacro", "#!/bin/sh\n" + script);
    std::filesystem::permissions(file, std::filesystem::perms::owner_all);
    setenv("PATH", (files_.folder("bin") + ":" + path_).c_str(), 1);
  }

  TemporaryFiles files_;
  std::string path_;
};

TEST_F(Xacro, ExpandsByTheCommandOfThePath) {
  const std::string plain = files_.write("plain.txt", robotText(cartText()));
  const std::string file = files_.write("a cart.urdf.xacro", "<robot/>");
  provide("[ \"$#\" = 1 ] && [ -f \"$1\" ] && cat '" + plain + "'\n");
  const auto loaded = loadUrdfFile(file);
  ASSERT_TRUE(isLoaded(loaded));
  EXPECT_TRUE(notedWith(loaded, {"expanded by xacro"}));
}

TEST_F(Xacro, ItsFailureIsToldInItsOwnWords) {
  const std::string file = files_.write("cart.xacro", "<robot/>");
  provide("echo 'undefined property: width' >&2; exit 2\n");
  EXPECT_TRUE(refusedWith(loadUrdfFile(file), {"cart.xacro", "xacro cannot expand it", "undefined property: width"}));
}

TEST_F(Xacro, WithoutTheCommandItSaysSo) {
  const std::string file = files_.write("cart.xacro", "<robot/>");
  setenv("PATH", files_.folder("empty").c_str(), 1);
  EXPECT_TRUE(refusedWith(loadUrdfFile(file), {"cart.xacro", "no command xacro in the PATH", "xacro FILE.xacro > FILE.urdf"}));
}

TEST_F(Xacro, WhatItLeavesIsCheckedLikeAnyFile) {
  const std::string file = files_.write("cart.xacro", "<robot/>");
  provide("echo '<robot name=\"a\"><link name=\"${x}\"/></robot>'\n");
  EXPECT_TRUE(refusedWith(loadUrdfFile(file), {"${x}"}));
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
