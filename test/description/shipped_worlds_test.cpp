#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "ellipsoid_vehicle_sim/description/world_file.h"
#include "ellipsoid_vehicle_sim/world/mesh_file.h"
#include "support/temporary_files.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

const std::string kPackage = PACKAGE_DIR;

Terrain shippedWorld(const std::string& name) {
  Loaded<WorldDescription> world = loadWorld(kPackage + "/launch/" + name + ".yaml");
  EXPECT_TRUE(world) << problemText(world.problems);
  EXPECT_TRUE(world.notes.empty());
  Loaded<Terrain> terrain = Terrain::build(std::move(world.value->soup));
  EXPECT_TRUE(terrain) << problemText(terrain.problems);
  return std::move(*terrain.value);
}

double topOf(const Terrain& terrain, double x, double y) {
  const std::vector<HeightHit> hits = terrain.heights(x, y);
  if (hits.empty() || !hits[0].faces_up) return std::nan("");
  return hits[0].z;
}

int runScript(const std::string& arguments) {
  return std::system(("/usr/bin/python3 -B '" + kPackage + "/scripts/make_meshes.py' " + arguments).c_str());
}

TEST(ShippedMeshes, AreWhatTheScriptMakes) { EXPECT_EQ(runScript("--check"), 0); }

TEST(ShippedMeshes, UnitSphereIsClosedAndItsFrontIsOutside) {
  Loaded<WorldDescription> world = loadWorld(kPackage + "/meshes/unit_sphere.stl");
  ASSERT_TRUE(world) << problemText(world.problems);
  const Loaded<Terrain> sphere = Terrain::build(std::move(world.value->soup));
  ASSERT_TRUE(sphere) << problemText(sphere.problems);
  const MeshReport& report = sphere.value->report();
  EXPECT_EQ(report.open_edges + report.nonmanifold_edges + report.flipped_edges + report.duplicates + report.zero_area,
            0);
  EXPECT_EQ(sphere.value->triangleCount(), 1280);
  for (int i = 0; i < sphere.value->triangleCount(); ++i) {
    const Triangle t = sphere.value->triangle(i);
    for (const Vector3d& v : t.v) EXPECT_NEAR(v.norm(), 1.0, 1e-7);  // float32
    EXPECT_GT(t.nhat_W.dot(t.v[0]), 0.98);
  }
}

TEST(ShippedWorlds, FlatIsASquareOfTwoHundredMetresAtZero) {
  const Terrain flat = shippedWorld("flat");
  EXPECT_EQ(flat.bounds().min(), Vector3d(-100, -100, 0));
  EXPECT_EQ(flat.bounds().max(), Vector3d(100, 100, 0));
  EXPECT_EQ(flat.report().open_edges, 4 * 16);
  EXPECT_EQ(flat.triangle(0).nhat_W, Vector3d::UnitZ());
}

TEST(ShippedWorlds, RampRisesAtTenDegreesFromABentFoot) {
  const Terrain ramp = shippedWorld("ramp");
  EXPECT_EQ(ramp.report().nonmanifold_edges + ramp.report().flipped_edges + ramp.report().zero_area, 0);
  EXPECT_EQ(topOf(ramp, 0.0, 0.0), 0.0);
  EXPECT_EQ(topOf(ramp, 7.9, 3.0), 0.0);
  double before = 0.0;
  for (double x = 8.0; x < 45.0; x += 0.05) {
    const double slope = std::atan2(topOf(ramp, x + 0.05, 1.0) - topOf(ramp, x, 1.0), 0.05) * 180.0 / M_PI;
    // A corner within the 0.05 m mixes two facets; float32 corners.
    EXPECT_LT(std::abs(slope - before), 0.26) << x;
    if (x > 22.0 && x < 33.0) {
      EXPECT_NEAR(slope, 10.0, 1e-3) << x;
    }
    before = slope;
  }
  EXPECT_NEAR(topOf(ramp, 55.0, 0.0), 12.0 * std::sin(M_PI / 18.0) + 160.0 * (1.0 - std::cos(M_PI / 18.0)), 1e-4);
}

TEST(ShippedWorlds, CourseIsOneSheetOpenOnlyAtItsRims) {
  const Terrain course = shippedWorld("course");
  const MeshReport& report = course.report();
  EXPECT_EQ(report.nonmanifold_edges, 0);
  EXPECT_EQ(report.flipped_edges, 0);
  EXPECT_EQ(report.duplicates + report.opposite_duplicates, 0);
  EXPECT_EQ(report.zero_area, 0);
  // The outer rim, and that of the banked curve, which lies on the ground.
  const auto onRim = [&](const Vector3d& v) {
    return v.x() == -10.0 || v.x() == 140.0 || v.y() == -30.0 || v.y() == 30.0;
  };
  int outer = 0;
  for (int i = 0; i < course.triangleCount(); ++i) {
    const Triangle t = course.triangle(i);
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3d &a = t.v[k], &b = t.v[(k + 1) % 3];
      outer += onRim(a) && onRim(b) && onRim(0.5 * (a + b));
    }
  }
  constexpr int kBankRim = 2 * 30 + 2 * 6;
  EXPECT_EQ(report.open_edges, outer + kBankRim);
}

TEST(ShippedWorlds, CourseHasGroundAllAlongTheDriveLineAndItsObstaclesWhereTheFileSays) {
  const Terrain course = shippedWorld("course");
  for (const double y : {-0.9, -0.8, 0.0, 0.75}) {
    for (int i = 0; i <= 1500; ++i) ASSERT_FALSE(std::isnan(topOf(course, -10.0 + 0.1 * i, y))) << i << " " << y;
  }
  // Nothing falls through, however far it goes in a step.
  for (int i = 1; i < 1500; ++i)
    ASSERT_TRUE(course.firstFrontCrossing({-10.0 + 0.1 * i, 0.8, 5.0}, {-10.05 + 0.1 * i, 0.7, -5.0}));
  EXPECT_EQ(topOf(course, 0.0, 0.0), 0.0);
  for (const double bump : {8.75, 12.75, 16.75}) EXPECT_NEAR(topOf(course, bump, 0.0), 0.075, 1e-6);
  EXPECT_NEAR(topOf(course, 36.0, 0.0), 0.05, 1e-6);
  EXPECT_NEAR(std::atan2(topOf(course, 55.0, 0.0) - topOf(course, 50.0, 0.0), 5.0), 10.0 * M_PI / 180.0, 1e-3);
  EXPECT_NEAR(topOf(course, 60.0, 0.0), 1.5, 1e-6);
  for (double x = 71.0; x <= 140.0; x += 0.5) EXPECT_EQ(topOf(course, x, 0.0), 0.0);
  EXPECT_NEAR(topOf(course, 20.75, 13.0), 0.125, 1e-6);  // stairs, second step
  EXPECT_NEAR(topOf(course, 25.0, 13.0), 0.375, 1e-6);
  EXPECT_NEAR(topOf(course, 70.0, -15.0), 0.1, 1e-6);
  EXPECT_NEAR(topOf(course, 40.0, -12.125), 1.5, 1e-6);
  EXPECT_GT(topOf(course, 105.0 + 17.0 * std::sqrt(0.5), 27.0 - 17.0 * std::sqrt(0.5)), 1.2);  // bank
}

TEST(ShippedWorlds, CourseSurfacesHaveTheirOwnFriction) {
  const Terrain course = shippedWorld("course");
  const auto muAt = [&](double x, double y) { return *course.surface(course.heights(x, y).at(0).triangle).mu_static; };
  EXPECT_EQ(muAt(1.0, 1.0), 0.9);
  EXPECT_EQ(muAt(60.0, 1.0), 0.85);
  EXPECT_EQ(muAt(36.0, 1.0), 0.7);
  EXPECT_EQ(muAt(1.0, 20.0), 0.5);
}

TEST(ShippedWorlds, CourseStaysSmallEnoughToCommit) {
  std::uintmax_t size = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kPackage + "/meshes")) {
    if (entry.path().filename().string().rfind("course_", 0) == 0) size += entry.file_size();
  }
  EXPECT_LT(size, 300u * 1024u);
}

TEST(ShippedWorlds, RollingHasAHundredThousandTrianglesOfOneMetre) {
  const TemporaryFiles files;
  files.write("ellipsoid_vehicle_sim/package.xml", "<package><name>ellipsoid_vehicle_sim</name></package>");
  const std::string package = files.folder("ellipsoid_vehicle_sim");
  ASSERT_EQ(runScript("--rolling '" + package + "/meshes/rolling.stl'"), 0);
  Loaded<WorldDescription> world = loadWorld(kPackage + "/launch/rolling.yaml", fileResolver({package}, package));
  ASSERT_TRUE(world) << problemText(world.problems);
  const Loaded<Terrain> terrain = Terrain::build(std::move(world.value->soup));
  ASSERT_TRUE(terrain) << problemText(terrain.problems);
  EXPECT_EQ(terrain.value->triangleCount(), 2 * 316 * 316);
  EXPECT_EQ(terrain.value->report().open_edges, 4 * 316);
  EXPECT_EQ(terrain.value->report().flipped_edges, 0);
  EXPECT_EQ(terrain.value->bounds().sizes().x(), 316.0);
  EXPECT_LE(terrain.value->bounds().max().z(), 0.5);
  EXPECT_GE(terrain.value->bounds().max().z(), 0.4);
  EXPECT_EQ(terrain.value->heights(0.0, 0.0).size(), 1u);
}

TEST(ShippedWorlds, RollingBeforeItIsBuiltSaysWhatIsMissing) {
  const Loaded<WorldDescription> world = loadWorld(kPackage + "/launch/rolling.yaml", nullptr);
  ASSERT_FALSE(world);
  EXPECT_NE(problemText(world.problems).find("'package://ellipsoid_vehicle_sim/meshes/rolling.stl' is not found"),
            std::string::npos);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
