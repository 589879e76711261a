#include "ellipsoid_vehicle_sim/contact/shortest_push.h"

#include <gtest/gtest.h>

#include "support/random_contact_cases.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Vector3d;
using Normals = std::array<Vector3d, kMaxContactsPerEllipsoid>;
using Depths = std::array<double, kMaxContactsPerEllipsoid>;

/// Shortest p along the direction v that clears all, infinite if none does.
double lengthAlong(const Vector3d& v, const Normals& u, const Depths& d, int count) {
  double length = 0.0;
  for (int i = 0; i < count; ++i) {
    if (d[i] <= 0.0 && v.dot(u[i]) >= 0.0) continue;
    if (v.dot(u[i]) <= 0.0) return std::numeric_limits<double>::infinity();
    length = std::max(length, d[i] / v.dot(u[i]));
  }
  return length;
}

/// The conditions that mark the one optimum of a convex program [Karush-Kuhn-Tucker]. Largest violation [m].
double violation(const ShortestPush& push, const Normals& u, const Depths& d, int count) {
  double worst = 0.0;
  Vector3d sum = Vector3d::Zero();
  for (int i = 0; i < count; ++i) {
    const double room = push.p.dot(u[i]) - std::max(0.0, d[i]);
    worst = std::max(worst, -room);
    worst = std::max(worst, -push.weight[i]);
    if (push.weight[i] > 0.0) worst = std::max(worst, std::min(push.weight[i], std::abs(room)));
    sum += push.weight[i] * u[i];
  }
  return std::max(worst, (sum - push.p).norm());
}

TEST(ShortestPush, MeetsTheOptimalityConditionsWhateverTheNormals) {
  RandomContactCases random(21);
  for (int i = 0; i < 20000; ++i) {
    const int count = 1 + random.index(3);
    // Normals of one valley: all within 70 degrees of an axis, so that some push clears them.
    const Vector3d axis = random.unitVector();
    Normals u;
    Depths d{};
    for (int j = 0; j < count; ++j) {
      do u[j] = random.unitVector();
      while (u[j].dot(axis) < std::cos(70.0 * M_PI / 180.0));
      d[j] = random.logUniform(1e-6, 0.1);
    }
    // 1e-9 m: rounding of 1e-16 m, times the condition of normals a few ten-thousandths of a radian apart.
    EXPECT_LE(violation(shortestPush(u, d, count), u, d, count), 1e-9) << "case " << i;
  }
}

TEST(ShortestPush, NoSampledDirectionClearsAllWithLess) {
  RandomContactCases random(22);
  for (int i = 0; i < 200; ++i) {
    const int count = 2 + random.index(2);
    const Vector3d axis = random.unitVector();
    Normals u;
    Depths d{};
    for (int j = 0; j < count; ++j) {
      u[j] = (axis + 0.9 * random.unitVector()).normalized();
      d[j] = random.uniform(0.001, 0.1);
    }
    const ShortestPush push = shortestPush(u, d, count);
    const double length = push.p.norm();
    double sampled = lengthAlong(push.p / length, u, d, count);
    EXPECT_NEAR(sampled, length, 1e-12);
    for (int j = 0; j < 2000; ++j) {
      // Directions everywhere, and more of them close by.
      const Vector3d v = (push.p / length + random.logUniform(1e-4, 3.0) * random.unitVector()).normalized();
      sampled = std::min(sampled, lengthAlong(v, u, d, count));
    }
    EXPECT_GE(sampled, length - 1e-12) << "case " << i;
  }
}

TEST(ShortestPush, OneNormalIsPushedByItsDepth) {
  const Vector3d u = Vector3d(1.0, 2.0, 2.0) / 3.0;
  const ShortestPush push = shortestPush({u, Vector3d::Zero(), Vector3d::Zero()}, {0.02, 0.0, 0.0}, 1);
  EXPECT_EQ(push.p, 0.02 * u);
  EXPECT_EQ(push.weight[0], 0.02);
}

TEST(ShortestPush, NothingToClearIsNoPush) {
  const Normals u = {Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ()};
  for (int count = 0; count <= 3; ++count)
    for (const double depth : {0.0, -0.01})
      EXPECT_TRUE(shortestPush(u, {depth, depth, depth}, count).p.isZero(0.0)) << count << " of depth " << depth;
}

TEST(ShortestPush, SquareNormalsKeepTheirOwnDepths) {
  const Normals u = {Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ()};
  const ShortestPush push = shortestPush(u, {0.01, 0.02, 0.03}, 3);
  EXPECT_TRUE(push.p.isApprox(Vector3d(0.01, 0.02, 0.03), 1e-15));
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(push.weight[i], 0.01 * (i + 1), 1e-17);
}

TEST(ShortestPush, AContactThatAnotherClearsGetsNoWeight) {
  // The push of 0.1 m along z clears 0.05 m along a normal 30 degrees off: 0.1 cos 30 = 0.087.
  const Vector3d tilted(0.5, 0.0, std::sqrt(0.75));
  const ShortestPush push = shortestPush({Vector3d::UnitZ(), tilted, Vector3d::Zero()}, {0.1, 0.05, 0.0}, 2);
  EXPECT_EQ(push.p, Vector3d(0.0, 0.0, 0.1));
  EXPECT_EQ(push.weight[1], 0.0);
}

TEST(ShortestPush, ParallelNormalsCountOnce) {
  RandomContactCases random(23);
  for (const double angle : {0.0, 1e-15, 1e-9, 1e-7, 1e-6, 1e-5}) {
    const Vector3d u = random.unitVector(), v = (u + angle * u.unitOrthogonal()).normalized();
    for (const double other : {0.01, 0.005, 0.02}) {
      const ShortestPush push = shortestPush({u, v, u}, {0.01, other, 0.01}, 3);
      const double deeper = std::max(0.01, other);
      // Two faces a little apart may ask for a little more than the deeper depth, by the square of the angle.
      EXPECT_NEAR(push.p.norm(), deeper, 1e-12 + deeper * angle * angle) << angle;
      EXPECT_NEAR(push.weight[0] + push.weight[1] + push.weight[2], deeper, 1e-12 + deeper * angle * angle) << angle;
    }
  }
}

TEST(ShortestPush, OppositeNormalsPushOutOfTheDeeper) {
  const Vector3d u = Vector3d(3.0, 0.0, 4.0) / 5.0;
  const ShortestPush push = shortestPush({u, -u, Vector3d::Zero()}, {0.01, 0.03, 0.0}, 2);
  EXPECT_TRUE(push.p.isApprox(-0.03 * u, 1e-15));
  EXPECT_EQ(push.weight[0], 0.0);
}

TEST(ShortestPush, PinchedBetweenWallsItStillClearsTheGround) {
  const ShortestPush push =
      shortestPush({Vector3d::UnitX(), -Vector3d::UnitX(), Vector3d::UnitZ()}, {0.01, 0.01, 0.02}, 3);
  EXPECT_NEAR(push.p.z(), 0.02, 1e-17);
  EXPECT_NEAR(std::abs(push.p.x()), 0.01, 1e-17);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
