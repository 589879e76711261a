#include "ellipsoid_vehicle_sim/world/mesh_report.h"

#include <gtest/gtest.h>

#include "ellipsoid_vehicle_sim/world/mesh_file.h"
#include "support/meshes.h"
#include "support/test_data.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

MeshReport reportOf(const TriangleSoup& soup) { return inspectMesh(soup.vertices, soup.triangles); }

void expectCounts(const MeshReport& report, int open, int nonmanifold, int flipped, int duplicates, int opposite) {
  EXPECT_EQ(report.open_edges, open);
  EXPECT_EQ(report.nonmanifold_edges, nonmanifold);
  EXPECT_EQ(report.flipped_edges, flipped);
  EXPECT_EQ(report.duplicates, duplicates);
  EXPECT_EQ(report.opposite_duplicates, opposite);
}

TEST(MeshReport, AClosedSolidHasNothingToReport) { expectCounts(reportOf(cubeSoup()), 0, 0, 0, 0, 0); }

TEST(MeshReport, CountsTheRimOfAnOpenSheet) { expectCounts(reportOf(flatSoup(5, 1.0)), 20, 0, 0, 0, 0); }

TEST(MeshReport, CountsTheEdgesOfATriangleThatIsTurnedOver) {
  TriangleSoup soup = cubeSoup();
  std::swap(soup.triangles[3][0], soup.triangles[3][1]);
  expectCounts(reportOf(soup), 0, 0, 3, 0, 0);
}

TEST(MeshReport, CountsEdgesOfThreeTriangles) {
  TriangleSoup soup = oneTriangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  soup.vertices.insert(soup.vertices.end(), {{0, -1, 0}, {0, 0, 1}});
  soup.triangles.insert(soup.triangles.end(), {{1, 0, 3}, {0, 1, 4}});
  expectCounts(reportOf(soup), 6, 1, 0, 0, 0);
}

TEST(MeshReport, TellsDuplicatesFromTheTwoSidesOfASheet) {
  TriangleSoup soup = oneTriangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  soup.triangles.push_back({1, 2, 0});
  expectCounts(reportOf(soup), 0, 0, 3, 1, 0);
  soup.triangles[1] = {1, 0, 2};
  expectCounts(reportOf(soup), 0, 0, 0, 0, 1);
}

TEST(MeshReport, WeldsCornersThatRoundToTheSameMillionthOfTheDiagonal) {
  // The tolerance is 1e-6 sqrt(2) m: 1 m is 707106.78 of them and a gap of 0.5e-6 m is 0.35, so both round to 707107.
  for (const double gap : {0.5e-6, 3e-6}) {
    TriangleSoup soup = oneTriangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    soup.vertices.insert(soup.vertices.end(), {{1 + gap, 0, 0}, {1, 1, 0}, {0, 1, gap}});
    soup.triangles.push_back({3, 4, 5});
    expectCounts(reportOf(soup), gap < 1e-6 ? 4 : 6, 0, 0, 0, 0);
  }
}

TEST(MeshReport, WeldsMinusZeroToZero) {
  EXPECT_EQ(weldVertices({{0.0, 0.0, 1.0}, {-0.0, 0.0, 1.0}, {0.0, 0.0, 1.0 + 1e-15}}, 0.0),
            (std::vector<std::uint32_t>{0, 0, 2}));
}

/// What numpy found in the files, welded in the same way; read, zero area, open, non-manifold, flipped, duplicates.
void expectReference(const std::string& file, int read, int zero_area, int open, int nonmanifold) {
  const auto path = testData(file);
  if (!path) return;
  Loaded<MeshData> mesh = readMeshFile(*path);
  ASSERT_TRUE(mesh) << problemText(mesh.problems);
  TriangleSoup soup;
  soup.vertices = std::move(mesh.value->vertices);
  soup.triangles = std::move(mesh.value->triangles);
  const Loaded<Terrain> terrain = Terrain::build(std::move(soup));
  ASSERT_TRUE(terrain) << problemText(terrain.problems);
  const MeshReport& report = terrain.value->report();
  EXPECT_EQ(report.read, read);
  EXPECT_EQ(report.zero_area, zero_area);
  expectCounts(report, open, nonmanifold, 0, 0, 0);
}

TEST(RealWorldReport, ObstacleIsAClosedSolid) { expectReference("worlds/obstacle/obstacle_world.stl", 680, 0, 0, 0); }
TEST(RealWorldReport, ObstacleGroundIsAClosedSolid) {
  expectReference("worlds/obstacle/obstacle_world_ground.stl", 492, 0, 0, 0);
}
TEST(RealWorldReport, InspectionHasOpenEdges) {
  expectReference("worlds/inspection/inspection_world.dae", 5767, 0, 677, 0);
}
TEST(RealWorldReport, CloverleafHasOpenAndNonManifoldEdgesAndSlivers) {
  expectReference("worlds/cloverleaf/cloverleaf.obj", 1564, 8, 245, 1);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
