#include "ellipsoid_vehicle_sim/world/terrain.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "ellipsoid_vehicle_sim/world/mesh_tree_node.h"
#include "support/meshes.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Terrain built(TriangleSoup soup) {
  Loaded<Terrain> terrain = Terrain::build(std::move(soup));
  EXPECT_TRUE(terrain) << problemText(terrain.problems);
  return std::move(*terrain.value);
}

std::vector<int> queried(const Terrain& terrain, const AlignedBox3d& box) {
  std::vector<int> found;
  terrain.query(box, found);
  std::sort(found.begin(), found.end());
  return found;
}

std::vector<int> bruteForce(const Terrain& terrain, const AlignedBox3d& box) {
  std::vector<int> found;
  for (int i = 0; i < terrain.triangleCount(); ++i) {
    const Triangle t = terrain.triangle(i);
    AlignedBox3d own;
    for (const Vector3d& v : t.v) own.extend(v);
    if (own.intersects(box)) found.push_back(i);
  }
  return found;
}

TriangleSoup randomSoup(int count, double spread, double smallest, double largest, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0), exponent(std::log(smallest), std::log(largest));
  const auto vector = [&] { return Vector3d(unit(random), unit(random), unit(random)); };
  TriangleSoup soup;
  for (int i = 0; i < count; ++i) {
    const Vector3d p = spread * vector();
    const double size = std::exp(exponent(random));
    for (int k = 0; k < 3; ++k) soup.vertices.push_back(p + size * vector());
    const std::uint32_t n = static_cast<std::uint32_t>(3 * i);
    soup.triangles.push_back({n, n + 1, n + 2});
  }
  return soup;
}

void expectQueriesExact(const Terrain& terrain, unsigned seed, int count) {
  std::mt19937_64 random(seed);
  std::uniform_int_distribution<int> pick(0, terrain.triangleCount() - 1);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int i = 0; i < count; ++i) {
    // Boxes hung exactly onto corners of the mesh: touching has to count, missing by the last bit must not.
    const Triangle t = terrain.triangle(pick(random));
    const double size = std::pow(10.0, -5.0 + 8.0 * unit(random));
    const Vector3d v = t.v[static_cast<std::size_t>(i % 3)];
    const Vector3d extent = size * Vector3d(unit(random), unit(random), unit(random));
    for (const AlignedBox3d& box : {AlignedBox3d(v, v + extent), AlignedBox3d(v - extent, v), AlignedBox3d(v, v)}) {
      ASSERT_EQ(queried(terrain, box), bruteForce(terrain, box)) << "query " << i;
    }
    const Vector3d past = v.unaryExpr([](double x) { return std::nextafter(x, kInfinity); });
    const AlignedBox3d beside(past, past + extent);
    ASSERT_EQ(queried(terrain, beside), bruteForce(terrain, beside)) << "query " << i;
  }
}

TEST(Terrain, QueryReturnsExactlyTheBoxesThatMeetOnRollingGround) {
  expectQueriesExact(built(gridSoup(40, 1.0, [](double x, double y) { return std::sin(x) * std::cos(0.7 * y); })), 1,
                     500);
}

TEST(Terrain, QueryIsExactForLongNeedlesBesideTinyTriangles) {
  TriangleSoup soup = randomSoup(3000, 10.0, 1e-4, 1e4, 2);
  const std::uint32_t n = static_cast<std::uint32_t>(soup.vertices.size());
  soup.vertices.insert(soup.vertices.end(), {{-5e3, 0.0, 0.0}, {5e3, 1e-4, 0.0}, {-5e3, 1e-4, 0.0}});
  soup.triangles.push_back({n, n + 1, n + 2});
  expectQueriesExact(built(std::move(soup)), 3, 500);
}

TEST(Terrain, QueryIsExactAMillionMetresFromTheOrigin) {
  const auto height = [](double x, double y) { return 0.1 * std::sin(x + y); };
  expectQueriesExact(built(gridSoup(30, 0.1, height, {1e6, -1e6, 0.0})), 4, 500);
}

TEST(Terrain, QueryIsExactWhenAllCentroidsAreEqual) {
  TriangleSoup soup;
  for (std::uint32_t i = 0; i < 1000; ++i) {
    const double r = 1.0 + 0.01 * i;
    soup.vertices.insert(soup.vertices.end(), {{-r, -r, 0.0}, {r, -r, 0.0}, {-r, r, 0.0}});
    soup.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  for (std::uint32_t i = 0; i < 1000; ++i) soup.triangles.push_back({0, 1, 2});
  expectQueriesExact(built(std::move(soup)), 5, 200);
}

TEST(Terrain, QueryIsExactForEveryCountUpToAHundred) {
  for (int count = 1; count <= 100; ++count) {
    expectQueriesExact(built(randomSoup(count, 1.0, 0.1, 1.0, static_cast<unsigned>(count))), 6, 20);
  }
}

TEST(Terrain, QueryIsExactForFineDetailInAHugeWorld) {
  // A square metre of millimetres in a hundred kilometres: thousands of triangles within a step of the tree's curve.
  TriangleSoup soup =
      gridSoup(40, 1e-3, [](double x, double y) { return 1e-3 * std::sin(1e3 * x) * std::cos(700.0 * y); });
  for (int i = 0; i < 200; ++i) {
    const Vector3d p(1e5 * std::cos(0.3 * i), 1e5 * std::sin(0.7 * i), 10.0 * std::sin(i));
    const std::uint32_t n = static_cast<std::uint32_t>(soup.vertices.size());
    soup.vertices.insert(soup.vertices.end(), {p, p + Vector3d(3e-3, 0, 0), p + Vector3d(0, 3e-3, 1e-3)});
    soup.triangles.push_back({n, n + 1, n + 2});
  }
  expectQueriesExact(built(std::move(soup)), 8, 500);
}

TEST(Terrain, QueryIsExactInAStandingColumn) {
  // Tall and thin: the long side is upright, and the two others are alike.
  TriangleSoup soup = randomSoup(2000, 1.0, 0.01, 0.1, 9);
  for (Vector3d& v : soup.vertices) v.z() *= 300.0;
  expectQueriesExact(built(std::move(soup)), 10, 300);
}

TEST(MeshTreeNode, LanesAllAtOnceMeetWhatTheyMeetOneByOne) {
  std::mt19937 random(11);
  const auto cell = [&](std::int32_t low, std::int32_t high) {
    return std::uniform_int_distribution<std::int32_t>(low, high)(random);
  };
  const auto box = [&](std::int32_t low, std::int32_t high) {
    CellBox b{};
    for (std::size_t k = 0; k < 3; ++k) {
      b.lo[k] = cell(low, high);
      b.hi[k] = cell(b.lo[k], high);
    }
    return b;
  };
  constexpr std::int32_t kLast = 2147483647;
  int meeting = 0, certain = 0;
  for (int i = 0; i < 20000; ++i) {
    // Worlds from one cell to all of them; queries inside, across and beside the node.
    const std::int32_t low = i % 3 == 0 ? 0 : cell(0, kLast / 2), high = low + (cell(0, kLast / 2) >> (i % 31));
    CellBox lanes[MeshTreeNode::kWidth], all = box(low, high);
    for (CellBox& lane : lanes) {
      lane = box(low, high);
      for (std::size_t k = 0; k < 3; ++k) {
        all.lo[k] = std::min(all.lo[k], lane.lo[k]);
        all.hi[k] = std::max(all.hi[k], lane.hi[k]);
      }
    }
    MeshTreeNode node{};
    node.setFrame(all);
    for (int lane = 0; lane < MeshTreeNode::kWidth; ++lane) node.setLane(lane, lanes[lane]);
    const CellBox query = i % 2 == 0 ? box(low, high) : box(0, kLast);
    const MetLanes fast = metLanes(node, query), plain = metLanesOneByOne(node, query);
    ASSERT_EQ(fast.meeting, plain.meeting) << i;
    ASSERT_EQ(fast.certain, plain.certain) << i;
    for (int lane = 0; lane < MeshTreeNode::kWidth; ++lane) {
      bool meets = true;
      for (std::size_t k = 0; k < 3; ++k)
        meets = meets && lanes[lane].lo[k] <= query.hi[k] && lanes[lane].hi[k] >= query.lo[k];
      const bool said = (fast.meeting >> lane & 1u) != 0, sure = (fast.certain >> lane & 1u) != 0;
      ASSERT_TRUE(said || !meets) << i;
      ASSERT_TRUE(meets || !sure) << i;
      meeting += meets;
      certain += sure;
    }
  }
  // Certainty is worth having: most that meet are told to.
  EXPECT_GT(certain, meeting / 2);
}

TEST(Terrain, QueryFindsTheOneTriangle) {
  const Terrain terrain = built(oneTriangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  EXPECT_EQ(queried(terrain, {Vector3d(1, 1, 0), Vector3d(2, 2, 0)}), std::vector<int>{0});
  EXPECT_TRUE(queried(terrain, {Vector3d(0, 0, 1e-300), Vector3d(1, 1, 1)}).empty());
}

TEST(Terrain, QueryBoxMayBeInfiniteEmptyOrNotANumber) {
  const Terrain terrain = built(flatSoup(4, 1.0));
  const Vector3d infinite = Vector3d::Constant(kInfinity), nan = Vector3d::Constant(std::nan(""));
  EXPECT_EQ(queried(terrain, {-infinite, infinite}).size(), 32u);
  EXPECT_TRUE(queried(terrain, AlignedBox3d()).empty());
  EXPECT_TRUE(queried(terrain, {Vector3d(3, 3, 3), Vector3d(1, 1, -1)}).empty());
  EXPECT_TRUE(queried(terrain, {nan, nan}).empty());
}

TEST(Terrain, QueryAppends) {
  const Terrain terrain = built(oneTriangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  std::vector<int> out = {42};
  terrain.query({Vector3d(0, 0, 0), Vector3d(1, 1, 1)}, out);
  EXPECT_EQ(out, (std::vector<int>{42, 0}));
}

TEST(Terrain, DropsAndCountsTrianglesWithoutAreaAndKeepsTheOrderOfTheRest) {
  TriangleSoup soup = flatSoup(1, 2.0);
  soup.triangles.insert(soup.triangles.begin() + 1, {{0, 1, 1}, {0, 0, 0}});
  soup.surfaces = {{"a", {}, {}}, {"b", 0.5, 0.4}};
  soup.surface = {0, 0, 0, 1};
  const Terrain terrain = built(std::move(soup));
  EXPECT_EQ(terrain.triangleCount(), 2);
  EXPECT_EQ(terrain.report().read, 4);
  EXPECT_EQ(terrain.report().zero_area, 2);
  EXPECT_EQ(terrain.surface(0).name, "a");
  EXPECT_EQ(terrain.surface(1).name, "b");
  EXPECT_EQ(terrain.triangle(1).v[2], Vector3d(0, 2, 0));
}

TEST(Terrain, TriangleKeepsItsCornersAndPointsToItsFront) {
  const Terrain terrain = built(oneTriangle({1, 2, 3}, {3, 2, 3}, {1, 5, 3}));
  const Triangle t = terrain.triangle(0);
  EXPECT_EQ(t.v[0], Vector3d(1, 2, 3));
  EXPECT_EQ(t.v[1], Vector3d(3, 2, 3));
  EXPECT_EQ(t.v[2], Vector3d(1, 5, 3));
  EXPECT_EQ(t.nhat_W, Vector3d(0, 0, 1));
  EXPECT_EQ(terrain.bounds().min(), Vector3d(1, 2, 3));
  EXPECT_EQ(terrain.bounds().max(), Vector3d(3, 5, 3));
}

TEST(Terrain, HoldsATwoMillionthPartOfTwoHundredFiftyMegabytesPerTriangle) {
  EXPECT_LE(built(flatSoup(200, 1.0)).memoryBytes() / 80000.0, 120.0);
  // Every corner stored by its triangle, as in an STL file: equal positions are held once.
  TriangleSoup soup;
  const TriangleSoup grid = flatSoup(200, 1.0);
  for (const auto& t : grid.triangles) {
    const std::uint32_t n = static_cast<std::uint32_t>(soup.vertices.size());
    for (const std::uint32_t v : t) soup.vertices.push_back(grid.vertices[v]);
    soup.triangles.push_back({n, n + 1, n + 2});
  }
  EXPECT_LE(built(std::move(soup)).memoryBytes() / 80000.0, 120.0);
}

TEST(Terrain, RefusesANonFiniteCornerAndNamesTheTriangle) {
  TriangleSoup soup = flatSoup(1, 1.0);
  soup.vertices[2].y() = std::nan("");
  const Loaded<Terrain> terrain = Terrain::build(std::move(soup));
  ASSERT_FALSE(terrain);
  EXPECT_NE(problemText(terrain.problems).find("triangle 1"), std::string::npos) << problemText(terrain.problems);
  EXPECT_NE(problemText(terrain.problems).find("nan"), std::string::npos);
}

TEST(Terrain, RefusesCoordinatesBeyondWhatADoubleResolves) {
  const Loaded<Terrain> terrain = Terrain::build(oneTriangle({0, 0, 0}, {1e10, 0, 0}, {0, 1, 0}));
  ASSERT_FALSE(terrain);
  EXPECT_NE(problemText(terrain.problems).find("allowed are finite coordinates up to 1e9 m"), std::string::npos);
}

TEST(Terrain, RefusesAWorldWithoutTriangles) {
  EXPECT_EQ(problemText(Terrain::build({}).problems), "terrain: no triangles; a world needs at least one\n");
  const Loaded<Terrain> line = Terrain::build(oneTriangle({0, 0, 0}, {1, 0, 0}, {2, 0, 0}));
  EXPECT_EQ(problemText(line.problems), "terrain: all 1 triangles have no area\n");
}

TEST(Terrain, RefusesNumbersThatPointNowhere) {
  TriangleSoup soup = flatSoup(1, 1.0);
  soup.triangles[1][0] = 4;
  EXPECT_EQ(problemText(Terrain::build(soup).problems), "terrain triangle 1: vertex number 4 of 4\n");
  soup = flatSoup(1, 1.0);
  soup.surface = {0, 1};
  EXPECT_EQ(problemText(Terrain::build(soup).problems), "terrain triangle 1: surface number 1 of 1\n");
  soup.surface = {0};
  EXPECT_EQ(problemText(Terrain::build(soup).problems), "terrain: 1 surface numbers for 2 triangles\n");
}

TEST(Terrain, HeightsOfACubeAreItsTopAndItsBottom) {
  const Terrain terrain = built(cubeSoup());
  const std::vector<HeightHit> hits = terrain.heights(0.3, 0.6);
  ASSERT_EQ(hits.size(), 2u);
  EXPECT_EQ(hits[0].z, 1.0);
  EXPECT_TRUE(hits[0].faces_up);
  EXPECT_EQ(hits[1].z, 0.0);
  EXPECT_FALSE(hits[1].faces_up);
}

TEST(Terrain, HeightsCountASeamOnceOnEdgesCornersAndTheRim) {
  const Terrain terrain = built(flatSoup(4, 0.3));
  for (const double x : {0.0, 0.1, 0.3, 0.6, 4 * 0.3}) {
    for (const double y : {0.0, 0.1, 0.3, 0.6, 4 * 0.3}) EXPECT_EQ(terrain.heights(x, y).size(), 1u) << x << " " << y;
  }
  EXPECT_TRUE(terrain.heights(-1e-9, 0.1).empty());
}

TEST(Terrain, HeightsNeverFallThroughASeam) {
  // Irrational places, steep faces: points on the seams are rounded to either side of them.
  const auto height = [](double x, double y) { return 3.0 * std::sin(5.0 * x) + 2.0 * std::cos(4.0 * y); };
  const Terrain terrain = built(gridSoup(20, 0.1234567, height, {1e3 / 3.0, -1e3 / 7.0, 0.0}));
  std::mt19937_64 random(9);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int i = 0; i < 20000; ++i) {
    const Triangle t = terrain.triangle(i % terrain.triangleCount());
    const double s = unit(random);
    const Vector3d p =
        (1.0 - s) * t.v[static_cast<std::size_t>(i % 3)] + s * t.v[static_cast<std::size_t>((i + 1) % 3)];
    // The rim may miss by rounding; inside there must be exactly one.
    const Vector3d margin(0.01, 0.01, 100.0);
    if (!AlignedBox3d(terrain.bounds().min() + margin.cwiseProduct(Vector3d(1, 1, -1)),
                      terrain.bounds().max() - margin.cwiseProduct(Vector3d(1, 1, -1)))
             .contains(p)) {
      continue;
    }
    const std::vector<HeightHit> hits = terrain.heights(p.x(), p.y());
    ASSERT_EQ(hits.size(), 1u) << "point " << i;
    // Rounding of x and y (1e-13 m) times a slope of up to 20.
    ASSERT_NEAR(hits[0].z, p.z(), 1e-10);
  }
}

TEST(Terrain, HeightsKeepTheTwoSidesOfASheetApart) {
  TriangleSoup soup = flatSoup(1, 1.0);
  soup.triangles.push_back({0, 2, 1});
  soup.triangles.push_back({0, 3, 2});
  const std::vector<HeightHit> hits = built(std::move(soup)).heights(0.5, 0.5);
  ASSERT_EQ(hits.size(), 2u);
  EXPECT_NE(hits[0].faces_up, hits[1].faces_up);
}

TEST(Terrain, CrossingNeedsToGoFromTheFrontToTheBack) {
  const Terrain terrain = built(oneTriangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  EXPECT_EQ(terrain.firstFrontCrossing({0.2, 0.2, 1}, {0.2, 0.2, -1}), 0);
  EXPECT_FALSE(terrain.firstFrontCrossing({0.2, 0.2, -1}, {0.2, 0.2, 1}));
  EXPECT_FALSE(terrain.firstFrontCrossing({0.2, 0.2, 2}, {0.2, 0.2, 1}));
  EXPECT_FALSE(terrain.firstFrontCrossing({0.2, 0.2, -1}, {0.2, 0.2, -2}));
  EXPECT_FALSE(terrain.firstFrontCrossing({0.7, 0.7, 1}, {0.7, 0.7, -1}));
  EXPECT_FALSE(terrain.firstFrontCrossing({0.2, 0.2, 1}, {0.2, 0.2, 1}));
  EXPECT_FALSE(terrain.firstFrontCrossing({0.2, 0.2, 1}, {0.2, 0.2, std::nan("")}));
}

TEST(Terrain, CrossingIsCountedByOneOfTwoSegmentsThatMeetOnTheSurface) {
  const Terrain terrain = built(flatSoup(1, 1.0));
  EXPECT_FALSE(terrain.firstFrontCrossing({0.5, 0.2, 1}, {0.5, 0.2, 0}));
  EXPECT_TRUE(terrain.firstFrontCrossing({0.5, 0.2, 0}, {0.5, 0.2, -1}));
}

TEST(Terrain, CrossingReportsTheFirstOfManyAndTheLowestIndexOfEqualOnes) {
  TriangleSoup soup = oneTriangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  for (const double z : {2.0, 2.0, 1.0}) {
    const std::uint32_t n = static_cast<std::uint32_t>(soup.vertices.size());
    soup.vertices.insert(soup.vertices.end(), {{0, 0, z}, {1, 0, z}, {0, 1, z}});
    soup.triangles.push_back({n, n + 1, n + 2});
  }
  EXPECT_EQ(built(std::move(soup)).firstFrontCrossing({0.2, 0.2, 3}, {0.2, 0.3, -1}), 1);
}

TEST(Terrain, NothingLeaksThroughSeamsHoweverTheSegmentRuns) {
  const auto height = [](double x, double y) { return std::sin(3.0 * x) + std::cos(2.0 * y); };
  const Terrain terrain = built(gridSoup(30, 0.1234567, height, {100.0 / 3.0, -100.0 / 7.0, 0.0}));
  std::mt19937_64 random(10);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  int tried = 0;
  for (int i = 0; i < 20000; ++i) {
    // Through a point on an edge, or through a corner, from well above to well below.
    const Triangle t = terrain.triangle(i % terrain.triangleCount());
    const double s = i % 5 == 0 ? 0.0 : 0.5 + 0.5 * unit(random);
    const Vector3d p =
        (1.0 - s) * t.v[static_cast<std::size_t>(i % 3)] + s * t.v[static_cast<std::size_t>((i + 1) % 3)];
    const Vector3d d(0.1 * unit(random), 0.1 * unit(random), 10.0);
    const Vector3d rim(0.2, 0.2, -100.0);
    if (!AlignedBox3d(terrain.bounds().min() + rim, terrain.bounds().max() - rim).contains(p)) continue;
    ++tried;
    ASSERT_TRUE(terrain.firstFrontCrossing(p + d, p - d)) << "segment " << i;
    ASSERT_FALSE(terrain.firstFrontCrossing(p - d, p + d)) << "segment " << i;
  }
  EXPECT_GT(tried, 10000);
}

TEST(Terrain, LongSlantedSegmentFindsTheSameTriangleAsABruteForceSearch) {
  const Terrain terrain = built(randomSoup(2000, 10.0, 0.1, 3.0, 11));
  std::mt19937_64 random(12);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  int found = 0;
  for (int i = 0; i < 300; ++i) {
    const Vector3d a = 15.0 * Vector3d(unit(random), unit(random), unit(random));
    const Vector3d b = 15.0 * Vector3d(unit(random), unit(random), unit(random));
    std::optional<int> expected;
    double first = 2.0;
    for (int k = 0; k < terrain.triangleCount(); ++k) {
      // Solve a + s (b - a) = v0 + u e1 + w e2.
      const Triangle t = terrain.triangle(k);
      Eigen::Matrix3d m;
      m << a - b, t.v[1] - t.v[0], t.v[2] - t.v[0];
      const Vector3d suw = m.inverse() * (a - t.v[0]);
      const bool inside = suw.y() >= 0.0 && suw.z() >= 0.0 && suw.y() + suw.z() <= 1.0;
      if (inside && suw.x() >= 0.0 && suw.x() <= 1.0 && t.nhat_W.dot(b - a) < 0.0 && suw.x() < first) {
        first = suw.x();
        expected = k;
      }
    }
    found += expected.has_value();
    ASSERT_EQ(terrain.firstFrontCrossing(a, b), expected) << "segment " << i;
  }
  EXPECT_GT(found, 50);
}

TEST(Terrain, BuildIsTheSameEveryTime) {
  const Terrain a = built(randomSoup(5000, 10.0, 0.01, 3.0, 13)), b = built(randomSoup(5000, 10.0, 0.01, 3.0, 13));
  std::vector<int> from_a, from_b;
  a.query({Vector3d(-3, -3, -3), Vector3d(3, 3, 3)}, from_a);
  b.query({Vector3d(-3, -3, -3), Vector3d(3, 3, 3)}, from_b);
  EXPECT_EQ(from_a, from_b);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
