#include "ellipsoid_vehicle_sim/scene/vehicle_trial.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "ellipsoid_vehicle_sim/scene/free_straight.h"
#include "support/scenes.h"
#include "support/temporary_files.h"

namespace ellipsoid_vehicle_sim {
namespace {

const std::string kPackage = PACKAGE_DIR, kShare = SHARE_DIR, kPrograms = PROGRAM_DIR;
using Verdict = TrialCheck::Verdict;

TrialResult tried(const std::string& vehicle, const std::string& world) {
  Loaded<Scene> scene = sceneOf(kPackage + "/urdf/" + vehicle + ".urdf", kPackage + "/launch/" + world + ".yaml", kShare);
  EXPECT_TRUE(scene) << problemText(scene.problems);
  return tryVehicle(*scene.value, kShare);
}

TEST(VehicleTrial, SkidSteerPassesEverythingOnTheFlat) {
  const TrialResult result = tried("skid_steer", "flat");
  EXPECT_TRUE(result.passed()) << trialJson(result);
  EXPECT_EQ(result.ground, "flat");
  std::string names;
  for (const TrialCheck& check : result.checks) names += check.name + " ";
  EXPECT_EQ(names, "stands straight left right stop ");
  EXPECT_NEAR(result.mass, 50.0, 1e-9);
}

TEST(VehicleTrial, CarClimbsTheRamp) {
  const TrialResult result = tried("car", "ramp");
  EXPECT_TRUE(result.passed()) << trialJson(result);
  ASSERT_EQ(result.checks.size(), 2u);
  EXPECT_EQ(result.checks[1].name, "climb");
  EXPECT_GT(result.checks[1].value, 1.2);  // [m] of the foot alone
}

TEST(VehicleTrial, CarFindsAWayOnTheCourse) {
  const TrialResult result = tried("car", "course");
  EXPECT_EQ(result.ground, "other");
  EXPECT_TRUE(result.passed()) << trialJson(result);
}

// The push of the wheels is told, and not climbing is then no failure.
TEST(VehicleTrial, WeakMotorsNeedNotClimb) {
  Loaded<Scene> scene = sceneOf(kPackage + "/urdf/skid_steer.urdf", kPackage + "/launch/ramp.yaml", kShare);
  ASSERT_TRUE(scene);
  scene.value->config.max_drive_torque = 0.5;
  const TrialResult result = tryVehicle(*scene.value, kShare);
  ASSERT_EQ(result.checks.size(), 2u);
  EXPECT_EQ(result.checks[1].verdict, Verdict::kPassed) << result.checks[1].text;
  EXPECT_LT(result.checks[1].value, 1.2);
  EXPECT_NE(result.checks[1].text.find("the slope asks for"), std::string::npos);
}

TEST(VehicleTrial, ARefusedVehicleIsARowWithItsProblems) {
  const TemporaryFiles files;
  files.write("bad.urdf", "<robot name='x'><link name='a'><collision><geometry><sphere radius='-1'/></geometry>"
                          "</collision></link></robot>");
  Loaded<Scene> scene = sceneOf(files.folder("") + "/bad.urdf", kPackage + "/launch/flat.yaml", kShare);
  ASSERT_TRUE(scene);
  const TrialResult result = tryVehicle(*scene.value, kShare);
  EXPECT_FALSE(result.passed());
  EXPECT_FALSE(result.problems.empty());
  EXPECT_NE(trialJson(result).find("bad.urdf:1"), std::string::npos);
}

TEST(FreeStraight, EndsAtAWallAHoleAndTheRim) {
  TriangleSoup soup = test::floorSoup(20.0, 8);
  // A wall 0.1 m thick across the way at x = 4, seen from -x.
  test::addQuad(soup, {4.0, 3.0, 0.0}, {4.0, -3.0, 0.0}, {4.0, -3.0, 1.0}, {4.0, 3.0, 1.0});
  const auto terrain = test::terrainOf(soup);
  const Footprint footprint{0.5, 0.5, 0.3, 0.4, 0.03};
  EXPECT_NEAR(freeStraight(*terrain, footprint, {0.0, 0.0, 0.0}, 10.0), 3.5, 0.06);
  EXPECT_EQ(freeStraight(*terrain, footprint, {0.0, 0.0, M_PI}, 10.0), 10.0);
  EXPECT_NEAR(freeStraight(*terrain, footprint, {-15.0, 0.0, M_PI}, 10.0), 4.5, 0.06);
  EXPECT_LT(freeStraight(*terrain, footprint, {3.8, 0.0, 0.0}, 10.0), 0.0);
  const auto places = findFreeStraights(*terrain, footprint, {0.0, 0.0, 0.0}, 10.0);
  ASSERT_FALSE(places.empty());
  EXPECT_EQ(places.front().length, 10.0);
}

TEST(VehicleTable, WritesARowForEveryPairAndTheRefusalInItsOwnWords) {
  const TemporaryFiles files;
  files.write("vehicles/good/skid_steer.urdf", [] {
    std::ostringstream text;
    text << std::ifstream(kPackage + "/urdf/skid_steer.urdf").rdbuf();
    return text.str();
  }());
  files.write("vehicles/bad/broken.urdf", "<robot name='x'><link name='a'>");
  const std::string out = files.folder("") + "/out";
  const std::string command = "/usr/bin/python3 -B '" + kPackage + "/scripts/vehicle_table.py' --program '" + kPrograms +
                              "/vehicle_trial' --vehicles '" + files.folder("vehicles") + "' --out '" + out +
                              "' > /dev/null";
  ASSERT_EQ(std::system(command.c_str()), 0);
  std::ostringstream csv, page;
  csv << std::ifstream(out + "/vehicle_table.csv").rdbuf();
  page << std::ifstream(out + "/vehicle_table.md").rdbuf();
  EXPECT_NE(csv.str().find("skid_steer,flat,flat,50,differential,yes"), std::string::npos) << csv.str();
  EXPECT_NE(csv.str().find("skid_steer,ramp,ramp,50,differential,yes"), std::string::npos) << csv.str();
  EXPECT_NE(csv.str().find("broken,flat,"), std::string::npos) << csv.str();
  EXPECT_NE(page.str().find("**refused**"), std::string::npos) << page.str();
  EXPECT_NE(page.str().find("malformed XML"), std::string::npos) << page.str();
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
