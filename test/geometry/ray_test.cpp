#include "ellipsoid_vehicle_sim/geometry/ray.h"

#include <gtest/gtest.h>

#include <random>

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

Vector3d randomUnit(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  return Vector3d(normal(random), normal(random), normal(random)).normalized();
}

TEST(RayTriangle, SlantingRayMeetsThePlaneAtHeightOverCosine) {
  const Ray ray{{0.2, 0.1, 2.0}, Vector3d(0.3, 0.2, -1.0).normalized()};
  const auto t = rayTriangle(ray, {-9.0, -9.0, 0.0}, {9.0, -9.0, 0.0}, {0.0, 9.0, 0.0});
  ASSERT_TRUE(t);
  EXPECT_NEAR(*t, 2.0 / -ray.direction.z(), 1e-14);
}

TEST(RayTriangle, BothSidesAreSeenAtOneDistance) {
  const Vector3d a(-9.0, -9.0, 0.0), b(9.0, -9.0, 0.0), c(0.0, 9.0, 0.0);
  const Ray ray{{0.2, 0.1, 2.0}, Vector3d(0.3, 0.2, -1.0).normalized()};
  EXPECT_EQ(rayTriangle(ray, a, b, c).value(), rayTriangle(ray, c, b, a).value());
}

TEST(RayTriangle, WhatLiesBehindTheOriginIsNotMet) {
  const Ray ray{{0.0, 0.0, 1.0}, Vector3d::UnitZ()};
  EXPECT_FALSE(rayTriangle(ray, {-9.0, -9.0, 0.0}, {9.0, -9.0, 0.0}, {0.0, 9.0, 0.0}));
}

TEST(RayTriangle, RayWithinThePlaneMeetsNothing) {
  const Ray ray{{-20.0, 0.0, 0.0}, Vector3d::UnitX()};
  EXPECT_FALSE(rayTriangle(ray, {-9.0, -9.0, 0.0}, {9.0, -9.0, 0.0}, {0.0, 9.0, 0.0}));
}

// A fan of triangles about one corner, no steeper than 30 degrees, and rays from at most 46 degrees aside aimed as well
// as doubles can at its edges and at the corner.
TEST(RayTriangle, NoRaySlipsThroughAnEdgeOrACornerThatTrianglesShare) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int run = 0; run < 2000; ++run) {
    std::vector<Vector3d> rim;
    const int n = 4 + run % 6;
    for (int i = 0; i < n; ++i) {
      const double angle = 2.0 * M_PI * (i + 0.4 * uniform(random)) / n;
      rim.emplace_back(std::cos(angle), std::sin(angle), 0.3 * uniform(random) - 0.15);
    }
    const Vector3d hub(0.1 * uniform(random), 0.1 * uniform(random), 0.1);
    const Vector3d origin(4.0 * uniform(random) - 2.0, 4.0 * uniform(random) - 2.0, 3.0 + 5.0 * uniform(random));
    for (int edge = 0; edge < n; ++edge) {
      const double along = run % 4 == 0 ? 0.0 : uniform(random);
      const Ray ray{origin, (hub + along * (rim[static_cast<std::size_t>(edge)] - hub) - origin).normalized()};
      bool met = false;
      for (int i = 0; i < n; ++i)
        met =
            met || rayTriangle(ray, hub, rim[static_cast<std::size_t>(i)], rim[static_cast<std::size_t>((i + 1) % n)]);
      EXPECT_TRUE(met) << "run " << run << ", edge " << edge;
    }
  }
}

TEST(RayEllipsoid, SphereIsMetAtItsDistanceLessItsRadius) {
  const PosedEllipsoid sphere({5.0, 0.0, 0.0}, Eigen::Matrix3d::Identity(), {2.0, 2.0, 2.0});
  EXPECT_NEAR(rayEllipsoid({{0.0, 0.0, 0.0}, Vector3d::UnitX()}, sphere).value(), 3.0, 1e-15);
  // At an offset of h from the centre's line: sqrt(r^2 - h^2) before it.
  EXPECT_NEAR(rayEllipsoid({{0.0, 1.2, 0.0}, Vector3d::UnitX()}, sphere).value(), 5.0 - 1.6, 1e-14);
  EXPECT_FALSE(rayEllipsoid({{0.0, 2.1, 0.0}, Vector3d::UnitX()}, sphere));
}

TEST(RayEllipsoid, FromInsideTheFarSideIsMet) {
  const PosedEllipsoid sphere({5.0, 0.0, 0.0}, Eigen::Matrix3d::Identity(), {2.0, 2.0, 2.0});
  EXPECT_NEAR(rayEllipsoid({{4.0, 0.0, 0.0}, Vector3d::UnitX()}, sphere).value(), 3.0, 1e-15);
  EXPECT_FALSE(rayEllipsoid({{8.0, 0.0, 0.0}, Vector3d::UnitX()}, sphere)) << "it lies behind";
}

// Whatever the shape: the point lies on the surface, and the ray enters there.
TEST(RayEllipsoid, RandomRaysEnterWhereTheyMeetTheSurface) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  int met = 0;
  for (int run = 0; run < 20000; ++run) {
    const Vector3d radii(std::pow(10.0, uniform(random)), std::pow(10.0, uniform(random)),
                         std::pow(10.0, uniform(random)));
    const Eigen::Matrix3d R =
        Eigen::Quaterniond(Eigen::AngleAxisd(3.0 * uniform(random), randomUnit(random))).toRotationMatrix();
    const Vector3d far = run % 2 == 0 ? Vector3d::Zero() : Vector3d(1e6, -1e6, 3e5);
    const PosedEllipsoid ellipsoid(far, R, radii);
    const Vector3d origin = far + 25.0 * randomUnit(random);
    const Vector3d target =
        far + R * (radii.asDiagonal() * Vector3d(uniform(random), uniform(random), uniform(random)));
    const Ray ray{origin, (target - origin).normalized()};
    const auto t = rayEllipsoid(ray, ellipsoid);
    const Vector3d inner = ((R.transpose() * (target - far)).array() / radii.array()).matrix();
    if (inner.norm() < 0.999) {
      ASSERT_TRUE(t) << "aimed at its inside, run " << run;
    }
    if (!t) continue;
    ++met;
    const Vector3d q = R.transpose() * (origin - far), d = R.transpose() * ray.direction;
    const Vector3d at = ((q + *t * d).array() / radii.array()).matrix();
    // The distance is some roundings of 25 m wrong; the thinnest radius of 0.1 m magnifies that. At 1e6 m the given
    // coordinates themselves are 1e-10 m coarse, but they are what was asked for.
    EXPECT_NEAR(at.norm(), 1.0, 1e-11) << "run " << run;
    EXPECT_LE(at.dot((d.array() / radii.array()).matrix()), 1e-5 / radii.minCoeff()) << "run " << run;
  }
  EXPECT_GT(met, 10000);
}

TEST(RaySpan, IsThePartOfTheRayInsideTheBox) {
  const Eigen::AlignedBox3d box(Vector3d(1.0, -1.0, -1.0), Vector3d(3.0, 1.0, 1.0));
  const auto through = raySpan({{0.0, 0.0, 0.0}, Vector3d::UnitX()}, box, 100.0);
  ASSERT_TRUE(through);
  EXPECT_EQ(through->begin, 1.0);
  EXPECT_EQ(through->end, 3.0);
  EXPECT_EQ(raySpan({{2.0, 0.0, 0.0}, Vector3d::UnitX()}, box, 0.5)->end, 0.5);
  EXPECT_FALSE(raySpan({{0.0, 0.0, 0.0}, -Vector3d::UnitX()}, box, 100.0)) << "it lies behind";
  EXPECT_FALSE(raySpan({{0.0, 0.0, 0.0}, Vector3d::UnitX()}, box, 0.9)) << "it lies beyond the range";
  EXPECT_FALSE(raySpan({{2.0, 2.0, 0.0}, Vector3d::UnitX()}, box, 100.0));
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
