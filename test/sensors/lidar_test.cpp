#include "ellipsoid_vehicle_sim/sensors/lidar.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "support/meshes.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::unique_ptr<const RayCaster> casterOf(TriangleSoup soup) {
  return makeRayCaster(*Terrain::build(std::move(soup)).value);
}

/// An empty world: a triangle out of every ray's way.
std::unique_ptr<const RayCaster> nothing() {
  return casterOf(oneTriangle({1e5, 1e5, 1e5}, {1e5 + 1.0, 1e5, 1e5}, {1e5, 1e5 + 1.0, 1e5}));
}

std::vector<double> scanOf(const LidarSpec& spec, const Pose& X_WS, const RayCaster& caster,
                           const std::vector<PosedEllipsoid>& ellipsoids = {}, std::int64_t sample = 0,
                           std::uint64_t seed = 1) {
  std::vector<double> ranges;
  Lidar(spec, seed).scan(X_WS, caster, ellipsoids.data(), ellipsoids.size(), sample, ranges);
  return ranges;
}

LidarSpec fullTurn(double samples) {
  LidarSpec spec;
  spec.samples = samples;
  spec.angle_min = -M_PI;
  spec.angle_max = M_PI - 2.0 * M_PI / samples;
  return spec;
}

// From (x, y) inside the unit room scaled by 10, along azimuth a: the nearer of the two walls ahead.
double toWall(double x, double y, double a) {
  const double c = std::cos(a), s = std::sin(a);
  const auto ahead = [](double at, double d) { return d == 0.0 ? kInfinity : ((d > 0.0 ? 10.0 : 0.0) - at) / d; };
  return std::min(ahead(x, c), ahead(y, s));
}

TEST(Lidar, RoomIsMeasuredFromInsideThoughItsFrontsLookOut) {
  TriangleSoup room = cubeSoup();
  for (Vector3d& v : room.vertices) v *= 10.0;
  const LidarSpec spec = fullTurn(720);
  const double yaw = 0.7;
  const std::vector<double> ranges = scanOf(spec, {{3.0, 4.0, 5.0}, quaternionFromRpy(0.0, 0.0, yaw)}, *casterOf(room));
  ASSERT_EQ(ranges.size(), 720u);
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const double azimuth = spec.angle_min + static_cast<double>(i) * spec.angleIncrement() + yaw;
    EXPECT_NEAR(ranges[i], toWall(3.0, 4.0, azimuth), 1e-12) << "ray " << i;
  }
}

TEST(Lidar, SameRoomAMillionMetresAwayIsMeasuredAsWellAsDoublesTellIt) {
  const Vector3d far(1e6, -2e6, 1e6);
  TriangleSoup room = cubeSoup();
  for (Vector3d& v : room.vertices) v = far + 10.0 * v;
  const LidarSpec spec = fullTurn(720);
  const std::vector<double> ranges =
      scanOf(spec, {far + Vector3d(3.0, 4.0, 5.0), Eigen::Quaterniond::Identity()}, *casterOf(room));
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const double azimuth = spec.angle_min + static_cast<double>(i) * spec.angleIncrement();
    EXPECT_NEAR(ranges[i], toWall(3.0, 4.0, azimuth), 1e-12) << "ray " << i;
  }
}

TEST(Lidar, SpatialFansMeetTheGroundAtHeightOverSineOfTheirElevation) {
  LidarSpec spec = fullTurn(36);
  spec.kind = LidarKind::kSpatial;
  spec.rings = 5;
  spec.vertical_angle_min = -0.5;
  spec.vertical_angle_max = 0.1;
  const TriangleSoup ground = gridSoup(2, 200.0, [](double, double) { return 0.0; }, {-200.0, -200.0, 0.0});
  const std::vector<double> ranges = scanOf(spec, {{0.0, 0.0, 1.5}, Eigen::Quaterniond::Identity()}, *casterOf(ground));
  ASSERT_EQ(ranges.size(), 180u);
  for (int fan = 0; fan < 5; ++fan) {
    const double elevation = -0.5 + fan * 0.15;
    const double expected = elevation < 0.0 ? 1.5 / std::sin(-elevation) : kInfinity;
    for (int i = 0; i < 36; ++i) {
      const double range = ranges[static_cast<std::size_t>(36 * fan + i)];
      if (expected > spec.range_max) {
        EXPECT_EQ(range, kInfinity);
      } else {
        EXPECT_NEAR(range, expected, 1e-11);
      }
    }
  }
}

TEST(Lidar, EllipsoidsAreMetWhereEveryRayAskedAloneMeetsThem) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto world = nothing();
  int met = 0;
  for (int run = 0; run < 60; ++run) {
    LidarSpec spec;
    spec.kind = run % 2 == 0 ? LidarKind::kPlanar : LidarKind::kSpatial;
    if (run % 2 != 0) {
      spec.rings = 9;
      spec.vertical_angle_min = -1.5;
      spec.vertical_angle_max = 0.5 * M_PI;
    }
    spec.samples = 200;
    spec.angle_min = run % 3 == 0 ? -2.0 * M_PI : -M_PI + 0.3 * uniform(random);
    spec.angle_max = spec.angle_min + (run % 5 == 0 ? 1.0 : 2.0 * M_PI);
    spec.range_min = 0.0;
    spec.range_max = 12.0;
    const Pose X_WS{{uniform(random), uniform(random), uniform(random)},
                    quaternionFromRpy(3.0 * uniform(random), 1.5 * uniform(random), 3.0 * uniform(random))};
    std::vector<PosedEllipsoid> ellipsoids;
    for (int k = 0; k < 8; ++k) {
      const Vector3d radii(0.1 + std::abs(uniform(random)), 0.1 + std::abs(uniform(random)),
                           2.0 * (1.1 + uniform(random)));
      const Vector3d centre = (k == 0 ? 0.5 : 8.0) * Vector3d(uniform(random), uniform(random), uniform(random));
      ellipsoids.emplace_back(
          centre, quaternionFromRpy(uniform(random), uniform(random), uniform(random)).toRotationMatrix(), radii);
    }
    const std::vector<double> ranges = scanOf(spec, X_WS, *world, ellipsoids);
    const Lidar lidar(spec, 1);
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      const Ray ray{X_WS.p, (X_WS.q.toRotationMatrix() * lidar.directions()[i]).normalized()};
      double expected = kInfinity;
      for (const PosedEllipsoid& ellipsoid : ellipsoids)
        if (const auto t = rayEllipsoid(ray, ellipsoid); t && *t <= spec.range_max) expected = std::min(expected, *t);
      ASSERT_EQ(ranges[i], expected) << "run " << run << ", ray " << i;
      met += expected < kInfinity;
    }
  }
  EXPECT_GT(met, 5000);
}

TEST(Lidar, NearerOfVehicleAndWorldIsMeasured) {
  const TriangleSoup wall = oneTriangle({5.0, -50.0, -50.0}, {5.0, 50.0, -50.0}, {5.0, 0.0, 50.0});
  LidarSpec spec;
  spec.samples = 1;
  spec.angle_min = spec.angle_max = 0.0;
  const auto caster = casterOf(wall);
  const auto sphereAt = [](double x) {
    return PosedEllipsoid({x, 0.0, 0.0}, Eigen::Matrix3d::Identity(), {1.0, 1.0, 1.0});
  };
  EXPECT_NEAR(scanOf(spec, Pose{}, *caster)[0], 5.0, 1e-14);
  EXPECT_NEAR(scanOf(spec, Pose{}, *caster, {sphereAt(3.0)})[0], 2.0, 1e-14);
  EXPECT_NEAR(scanOf(spec, Pose{}, *caster, {sphereAt(9.0)})[0], 5.0, 1e-14);
}

TEST(Lidar, LimitsAreToldAsInfinities) {
  const TriangleSoup wall = oneTriangle({5.0, -50.0, -50.0}, {5.0, 50.0, -50.0}, {5.0, 0.0, 50.0});
  LidarSpec spec;
  spec.samples = 1;
  spec.angle_min = spec.angle_max = 0.0;
  const auto at = [&](double range_min, double range_max) {
    spec.range_min = range_min;
    spec.range_max = range_max;
    return scanOf(spec, Pose{}, *casterOf(wall))[0];
  };
  EXPECT_NEAR(at(4.9, 5.1), 5.0, 1e-14);
  EXPECT_EQ(at(5.1, 9.0), -kInfinity);
  EXPECT_EQ(at(0.1, 4.9), kInfinity);
}

TEST(Lidar, NoiseHasItsDeviationAndNoBias) {
  const TriangleSoup ground = gridSoup(2, 200.0, [](double, double) { return 0.0; }, {-200.0, -200.0, 0.0});
  LidarSpec spec;
  spec.samples = 1000;
  spec.noise = 0.05;
  const auto caster = casterOf(ground);
  const Pose down{{0.0, 0.0, 5.0}, quaternionFromRpy(0.0, 0.5 * M_PI, 0.0)};  // x ahead points to the ground
  LidarSpec exact = spec;
  exact.noise = 0.0;
  spec.angle_min = exact.angle_min = -0.5;
  spec.angle_max = exact.angle_max = 0.5;
  const std::vector<double> truth = scanOf(exact, down, *caster);
  double sum = 0.0, squares = 0.0, neighbours = 0.0;
  const int scans = 100, n = scans * 1000;
  for (int k = 0; k < scans; ++k) {
    const std::vector<double> ranges = scanOf(spec, down, *caster, {}, k);
    double before = 0.0;
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      const double error = ranges[i] - truth[i];
      sum += error;
      squares += error * error;
      neighbours += error * before;
      before = error;
    }
  }
  // Four standard errors of mean, deviation, and correlation of neighbours.
  EXPECT_NEAR(sum / n, 0.0, 4.0 * spec.noise / std::sqrt(n));
  EXPECT_NEAR(std::sqrt(squares / n), spec.noise, 4.0 * spec.noise / std::sqrt(2.0 * n));
  EXPECT_NEAR(neighbours / squares, 0.0, 4.0 / std::sqrt(n));
}

TEST(Lidar, NoiseIsAFunctionOfSeedScanAndRay) {
  const TriangleSoup ground = gridSoup(2, 200.0, [](double, double) { return 0.0; }, {-200.0, -200.0, 0.0});
  LidarSpec spec;
  spec.samples = 50;
  spec.noise = 0.01;
  const auto caster = casterOf(ground);
  const Pose down{{0.0, 0.0, 5.0}, quaternionFromRpy(0.0, 0.5 * M_PI, 0.0)};
  spec.angle_min = -0.5;
  spec.angle_max = 0.5;
  // Scans that nobody took in between change nothing.
  std::vector<double> after_others;
  Lidar lidar(spec, 1);
  for (const std::int64_t sample : {3, 4, 7}) lidar.scan(down, *caster, nullptr, 0, sample, after_others);
  EXPECT_EQ(scanOf(spec, down, *caster, {}, 7), after_others);
  EXPECT_NE(scanOf(spec, down, *caster, {}, 8), after_others);
  EXPECT_NE(scanOf(spec, down, *caster, {}, 7, 2), after_others);
  EXPECT_NE(lidarSeed(0, "front"), lidarSeed(0, "rear"));
  EXPECT_NE(lidarSeed(0, "front"), lidarSeed(1, "front"));
}

// A wall just beyond the range: noise brings some of its rays back, as a real sensor's would be.
TEST(Lidar, LimitsApplyToWhatIsMeasured) {
  const TriangleSoup wall = oneTriangle({5.0, -50.0, -50.0}, {5.0, 50.0, -50.0}, {5.0, 0.0, 50.0});
  LidarSpec spec;
  spec.samples = 1;
  spec.angle_min = spec.angle_max = 0.0;
  spec.range_max = 5.0;
  spec.noise = 0.01;
  const auto caster = casterOf(wall);
  int seen = 0;
  for (int k = 0; k < 1000; ++k) {
    const double range = scanOf(spec, Pose{}, *caster, {}, k)[0];
    EXPECT_TRUE(range == kInfinity || range <= 5.0);
    seen += range != kInfinity;
  }
  EXPECT_NEAR(seen, 500, 65);  // four deviations of a coin tossed 1000 times
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
