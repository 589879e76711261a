#include "ellipsoid_vehicle_sim/dynamics/rigid_inertia.h"

#include <gtest/gtest.h>

#include "ellipsoid_vehicle_sim/dynamics/spatial_inertia.h"
#include "support/slow_tree_dynamics.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

struct PointMass {
  double m;
  Vector3d p;
};

/// Straight from the definition.
RigidInertia inertiaOf(const std::vector<PointMass>& points) {
  RigidInertia result;
  for (const PointMass& point : points) {
    result.mass += point.m;
    result.p_Acm += point.m * point.p;
  }
  result.p_Acm /= result.mass;
  for (const PointMass& point : points) {
    const Vector3d d = point.p - result.p_Acm;
    result.I_cm_A += point.m * (d.squaredNorm() * Matrix3d::Identity() - d * d.transpose());
  }
  return result;
}

std::vector<PointMass> randomPoints(RandomTrees& random, int count) {
  std::vector<PointMass> points;
  for (int i = 0; i < count; ++i) points.push_back({random.uniform(0.1, 2.0), random.vector(1.0)});
  return points;
}

void expectSame(const RigidInertia& a, const RigidInertia& b) {
  EXPECT_NEAR(a.mass, b.mass, 1e-13 * b.mass);
  EXPECT_LT((a.p_Acm - b.p_Acm).norm(), 1e-13);
  EXPECT_LT((a.I_cm_A - b.I_cm_A).norm(), 1e-12 * b.I_cm_A.norm());
}

TEST(RigidInertia, SumOfTwoBodiesIsThatOfAllTheirPoints) {
  RandomTrees random(1);
  std::vector<PointMass> first = randomPoints(random, 5);
  const std::vector<PointMass> second = randomPoints(random, 7);
  const RigidInertia sum = inertiaOf(first) + inertiaOf(second);
  first.insert(first.end(), second.begin(), second.end());
  expectSame(sum, inertiaOf(first));
}

TEST(RigidInertia, SeenFromAnotherFrameIsThatOfTheMovedPoints) {
  RandomTrees random(2);
  std::vector<PointMass> points = randomPoints(random, 6);
  const Pose X_BA{random.vector(2.0), random.rotation()};
  const RigidInertia seen = inertiaOf(points).seenFrom(X_BA);
  for (PointMass& point : points) point.p = X_BA * point.p;
  expectSame(seen, inertiaOf(points));
}

TEST(RigidInertia, ABodyWithoutMassAddsNothing) {
  RandomTrees random(3);
  const RigidInertia body = inertiaOf(randomPoints(random, 4));
  expectSame(body + RigidInertia{}, body);
  expectSame(RigidInertia{} + body, body);
  EXPECT_EQ((RigidInertia{} + RigidInertia{}).mass, 0.0);
}

TEST(RigidInertia, SolidEllipsoidIsTheIntegralOverItsVolume) {
  // Midpoint rule over a scaled ball, 60 cells a side: the surface's staircase leaves about 1e-3.
  const Vector3d radii(0.3, 0.15, 0.2);
  constexpr int kCells = 60;
  Matrix3d sum = Matrix3d::Zero();
  int inside = 0;
  for (int i = 0; i < kCells; ++i)
    for (int j = 0; j < kCells; ++j)
      for (int k = 0; k < kCells; ++k) {
        const Vector3d s = (Vector3d(i, j, k) + Vector3d::Constant(0.5)) * (2.0 / kCells) - Vector3d::Ones();
        if (s.squaredNorm() > 1.0) continue;
        const Vector3d p = radii.cwiseProduct(s);
        sum += p.squaredNorm() * Matrix3d::Identity() - p * p.transpose();
        ++inside;
      }
  const double mass = 5.0;
  const Matrix3d expected = sum * (mass / inside);
  EXPECT_LT((solidEllipsoidInertia(mass, radii) - expected).norm(), 3e-3 * expected.norm());
}

Matrix3d cross(const Vector3d& v) {
  Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

/// [J H; H' M] at O as a plain matrix, angular part first.
Matrix6d spatialMatrix(const RigidInertia& body) {
  const Matrix3d c = cross(body.p_Acm);
  Matrix6d m;
  m << body.I_cm_A - body.mass * c * c, body.mass * c, -body.mass * c, body.mass * Matrix3d::Identity();
  return m;
}

Vector6d vectorOf(const Spatial& s) {
  Vector6d v;
  v << s.angular.toEigen(), s.linear.toEigen();
  return v;
}

Spatial spatialOf(const Vector6d& v) {
  return {Vec3::from(Vector3d(v.head<3>())), Vec3::from(Vector3d(v.tail<3>()))};
}

/// Column by column, as it acts.
Matrix6d matrixOf(const SpatialInertia& inertia) {
  Matrix6d m;
  for (int i = 0; i < 6; ++i) m.col(i) = vectorOf(inertia * spatialOf(Vector6d::Unit(i)));
  return m;
}

TEST(SpatialInertia, PackedFormEqualsTheSixBySixMatrix) {
  RandomTrees random(4);
  for (int trial = 0; trial < 20; ++trial) {
    const RigidInertia body = inertiaOf(randomPoints(random, 5)), other = inertiaOf(randomPoints(random, 5));
    SpatialInertia packed, packed_other;
    packed.setRigid(body.mass, Vec3::from(body.p_Acm), Symmetric3::from(body.I_cm_A));
    packed_other.setRigid(other.mass, Vec3::from(other.p_Acm), Symmetric3::from(other.I_cm_A));
    const Matrix6d full = spatialMatrix(body), full_other = spatialMatrix(other);
    const double tolerance = 1e-13 * full.norm();
    EXPECT_LT((matrixOf(packed) - full).norm(), tolerance);

    const Spatial a{Vec3::from(random.vector(1.0)), Vec3::from(random.vector(1.0))};
    EXPECT_LT((vectorOf(packed * a) - full * vectorOf(a)).norm(), tolerance);
    EXPECT_LT((vectorOf(packed.timesLinear(a.linear)) - full.rightCols<3>() * a.linear.toEigen()).norm(), tolerance);

    // The acceleration under a force is the inverse's product with it.
    const Spatial answer = packed.accelerationUnder(a);
    EXPECT_LT((vectorOf(packed * answer) - vectorOf(a)).norm(), 1e-9);

    // What is left of `other` when the motion a is free in it.
    const Spatial U = packed_other * a;
    const double D = dot(a, U);
    SpatialInertia without = packed;
    without.addWithout(packed_other, U, 1.0 / D);
    const Vector6d u = vectorOf(U);
    EXPECT_LT((matrixOf(without) - (full + full_other - u * u.transpose() / D)).norm(), 1e-12 * full.norm());
  }
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
