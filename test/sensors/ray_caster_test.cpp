#include "ellipsoid_vehicle_sim/sensors/ray_caster.h"

#include <gtest/gtest.h>

#include <random>

#include "support/meshes.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

Terrain terrainOf(TriangleSoup soup) { return std::move(*Terrain::build(std::move(soup)).value); }

/// The definition: every triangle asked.
std::optional<RayHit> bruteForce(const Terrain& terrain, const Ray& ray, double range) {
  std::optional<RayHit> first;
  for (int i = 0; i < terrain.triangleCount(); ++i) {
    const auto v = terrain.triangle(i).v;
    const auto t = rayTriangle(ray, v[0], v[1], v[2]);
    if (t && *t <= range && (!first || *t < first->distance)) first = RayHit{*t, i};
  }
  return first;
}

Vector3d randomUnit(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  return Vector3d(normal(random), normal(random), normal(random)).normalized();
}

/// Hills with needles, slivers, upright walls and duplicates among them, and triangles of very different sizes.
TriangleSoup mixedSoup(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  TriangleSoup soup = gridSoup(12, 1.0, [](double x, double y) { return 0.3 * std::sin(x) * std::cos(0.7 * y); });
  const auto add = [&soup](const Vector3d& a, const Vector3d& b, const Vector3d& c) {
    const auto first = static_cast<std::uint32_t>(soup.vertices.size());
    soup.vertices.insert(soup.vertices.end(), {a, b, c});
    soup.triangles.push_back({first, first + 1, first + 2});
  };
  for (int i = 0; i < 150; ++i) {
    const Vector3d at(12.0 * uniform(random), 12.0 * uniform(random), 3.0 * uniform(random));
    const double size = std::pow(10.0, 3.0 * uniform(random) - 2.5);
    const Vector3d along = size * randomUnit(random), across = (i % 3 == 0 ? 1e-4 : 1.0) * size * randomUnit(random);
    add(at, at + along, at + across);
    if (i % 10 == 0) add(at, at + across, at + along);
  }
  add({4.0, 0.0, 0.0}, {4.0, 12.0, 0.0}, {4.0, 12.0, 2.0});
  return soup;
}

struct Placement {
  double scale;
  Vector3d offset;
};

/// Rays of all kinds at a soup that stands at `at`: random, along axes, from outside, from on a corner, short and long.
void comparesWithBruteForce(const RayCaster& caster, const Terrain& terrain, const Placement& at, int rays) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  int hits = 0;
  for (int k = 0; k < rays; ++k) {
    Vector3d origin(14.0 * uniform(random) - 1.0, 14.0 * uniform(random) - 1.0, 4.0 * uniform(random) - 0.5);
    Vector3d direction = randomUnit(random);
    if (k % 5 == 0) direction = Vector3d::Unit(k % 3) * (k % 2 == 0 ? 1.0 : -1.0);
    if (k % 7 == 0) origin += 300.0 * randomUnit(random);
    Vector3d from = at.offset + at.scale * origin;
    if (k % 11 == 0) from = terrain.triangle(k % terrain.triangleCount()).v[0];
    if (k % 7 == 0) direction = (terrain.triangle(k % terrain.triangleCount()).v[1] - from).normalized();
    const double range = at.scale * (k % 4 == 0 ? 2.0 * uniform(random) : 1000.0);
    const Ray ray{from, direction};
    const auto expected = bruteForce(terrain, ray, range), found = caster.firstHit(ray, range);
    ASSERT_EQ(static_cast<bool>(found), static_cast<bool>(expected)) << "ray " << k;
    if (!expected) continue;
    ++hits;
    ASSERT_EQ(found->distance, expected->distance) << "ray " << k;
    ASSERT_EQ(found->triangle, expected->triangle) << "ray " << k;
  }
  EXPECT_GT(hits, rays / 4);
}

const std::vector<Placement> kPlacements = {{1.0, Vector3d::Zero()},
                                            {1.0, Vector3d(1e6, -1e6, 1e5)},
                                            {1e-3, Vector3d(1e6, 2.0, 0.0)},
                                            {1e3, Vector3d(-5e5, 0.0, 0.0)}};

TriangleSoup placed(TriangleSoup soup, const Placement& at) {
  for (Vector3d& v : soup.vertices) v = at.offset + at.scale * v;
  return soup;
}

TEST(RayCaster, OwnTreeFindsWhatAskingEveryTriangleFindsToTheLastBit) {
  for (const Placement& at : kPlacements) {
    const Terrain terrain = terrainOf(placed(mixedSoup(1), at));
    comparesWithBruteForce(*makeOwnTreeRayCaster(terrain), terrain, at, 3000);
  }
}

TEST(RayCaster, EmbreeFindsWhatAskingEveryTriangleFindsToTheLastBit) {
  for (const Placement& at : kPlacements) {
    const Terrain terrain = terrainOf(placed(mixedSoup(1), at));
    std::string why;
    const auto caster = makeEmbreeRayCaster(terrain, why);
    if (!caster) GTEST_SKIP() << why;
    EXPECT_EQ(caster->tracer(), RayTracer::kEmbree);
    comparesWithBruteForce(*caster, terrain, at, 3000);
  }
}

TEST(RayCaster, WhatIsTakenSaysWhatItIs) {
  const Terrain terrain = terrainOf(flatSoup(4, 1.0));
  const auto caster = makeRayCaster(terrain);
  if (caster->tracer() == RayTracer::kEmbree) {
    EXPECT_NE(caster->description().find("Embree 3."), std::string::npos) << caster->description();
  } else {
    EXPECT_EQ(caster->description(),
              "the simulator's own tree: built without Embree (libembree-dev), which is several times faster");
  }
}

// Triangles of a millimetre in a world of a thousand kilometres: floats are 2 m coarse there.
TEST(RayCaster, OwnTreeIsTakenWhereFloatsAreTooCoarse) {
  TriangleSoup soup = flatSoup(20, 1e-3);
  for (int i = 0; i < 3; ++i) soup.vertices.emplace_back(1e6 + i % 2, 1e6 + i / 2, 0.0);
  const auto n = static_cast<std::uint32_t>(soup.vertices.size());
  soup.triangles.push_back({n - 3, n - 2, n - 1});
  const Terrain terrain = terrainOf(std::move(soup));
  const auto caster = makeRayCaster(terrain);
  EXPECT_EQ(caster->tracer(), RayTracer::kOwnTree);
  const auto hit = caster->firstHit({{0.0101, 0.0052, 0.5}, -Vector3d::UnitZ()}, 1.0);
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->distance, 0.5);
}

TEST(RayCaster, ARayThatIsNotANumberMeetsNothing) {
  const Terrain terrain = terrainOf(flatSoup(4, 1.0));
  const double nan = std::nan("");
  const auto one = makeRayCaster(terrain), other = makeOwnTreeRayCaster(terrain);
  for (const RayCaster* caster : {one.get(), other.get()}) {
    EXPECT_FALSE(caster->firstHit({{nan, 0.0, 1.0}, -Vector3d::UnitZ()}, 10.0));
    EXPECT_FALSE(caster->firstHit({{1.0, 1.0, 1.0}, Vector3d(nan, 0.0, 1.0)}, 10.0));
  }
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
