// What the contact definition guarantees, each claim against a formula or an identity of its own.
#include <gtest/gtest.h>

#include <limits>

#include "support/random_contact_cases.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

bool isEdge(Feature feature) { return feature >= Feature::kEdge0 && feature <= Feature::kEdge2; }

/// A wheel that is shallow enough (3 cm) for every edge and corner to keep its local minimum.
ContactCase shallowWheel(RandomContactCases& random) {
  return random.next(random.wheelRadii(), random.triangle(0.3), random.logUniform(1e-3, 0.25));
}

PosedEllipsoid movedBy(const PosedEllipsoid& ellipsoid, const Vector3d& p) {
  return {ellipsoid.p_WE + p, ellipsoid.R_WE, ellipsoid.radii};
}

TEST(EllipsoidTriangle, DepthFallsByTheShareOfAShiftAlongThePush) {
  RandomContactCases random(1);
  int run = 0;
  for (int i = 0; i < 20000; ++i) {
    const ContactCase c = shallowWheel(random);
    const TriangleContact contact = minimumTranslation(c.ellipsoid, c.triangle);
    if (!contact || contact.depth < 1e-4) continue;
    const Vector3d direction = random.unitVector();
    // h = 1e-6 m: rounding 1e-16/h and the cubic term, h^2 over the square of the least radius of curvature, are
    // below 1e-9.
    constexpr double kStep = 1e-6;
    const TriangleContact ahead = minimumTranslation(movedBy(c.ellipsoid, kStep * direction), c.triangle);
    const TriangleContact behind = minimumTranslation(movedBy(c.ellipsoid, -kStep * direction), c.triangle);
    if (ahead.feature != contact.feature || behind.feature != contact.feature) continue;
    if ((ahead.nhat_W - behind.nhat_W).norm() > 1e-3)
      continue;  // another minimum has become the least, or a fold is near.
    ++run;
    EXPECT_NEAR((ahead.depth - behind.depth) / (2.0 * kStep), -contact.nhat_W.dot(direction), 1e-6) << "case " << i;
  }
  EXPECT_GT(run, 10000);
}

TEST(EllipsoidTriangle, DepthFollowsARotationByTheArmOfThePush) {
  RandomContactCases random(2);
  int run = 0;
  for (int i = 0; i < 20000; ++i) {
    const ContactCase c = shallowWheel(random);
    const TriangleContact contact = minimumTranslation(c.ellipsoid, c.triangle);
    if (!contact || contact.depth < 1e-4) continue;
    const Vector3d axis = random.unitVector();
    constexpr double kStep = 1e-6;
    const auto turned = [&](double angle) {
      return minimumTranslation({c.ellipsoid.p_WE, AngleAxisd(angle, axis) * c.ellipsoid.R_WE, c.ellipsoid.radii},
                                c.triangle);
    };
    const TriangleContact ahead = turned(kStep), behind = turned(-kStep);
    if (ahead.feature != contact.feature || behind.feature != contact.feature) continue;
    if ((ahead.nhat_W - behind.nhat_W).norm() > 1e-3) continue;
    ++run;
    const Vector3d arm = contact.p_WE_lowest - c.ellipsoid.p_WE;
    EXPECT_NEAR((ahead.depth - behind.depth) / (2.0 * kStep), -arm.cross(contact.nhat_W).dot(axis), 1e-6)
        << "case " << i;
  }
  EXPECT_GT(run, 10000);
}

TEST(EllipsoidTriangle, TheLowestPointIsOnTheSurfaceWithThePushForANormal) {
  RandomContactCases random(3);
  for (int i = 0; i < 20000; ++i) {
    const ContactCase c = random.next();
    const TriangleContact contact = minimumTranslation(c.ellipsoid, c.triangle);
    if (!contact) continue;
    const Vector3d p_E = c.ellipsoid.R_WE.transpose() * (contact.p_WE_lowest - c.ellipsoid.p_WE);
    const Vector3d normal_E = p_E.cwiseQuotient(c.ellipsoid.radii.cwiseAbs2());
    // Rounding of the position over the smallest semi-axis, 0.02 of the largest, squared.
    EXPECT_NEAR(p_E.cwiseQuotient(c.ellipsoid.radii).norm(), 1.0, 1e-11) << "case " << i;
    EXPECT_LT((c.ellipsoid.R_WE * normal_E.normalized() + contact.nhat_W).norm(), 1e-9) << "case " << i;
  }
}

TEST(EllipsoidTriangle, ThePushClearsTheWholeTriangle) {
  RandomContactCases random(4);
  for (int i = 0; i < 20000; ++i) {
    const ContactCase c = random.next();
    const TriangleContact contact = minimumTranslation(c.ellipsoid, c.triangle);
    if (!contact) continue;
    const PosedEllipsoid pushed = movedBy(c.ellipsoid, contact.depth * contact.nhat_W);
    const Vector3d lowest = pushed.p_WE + pushed.lowestPointFromCentre(contact.nhat_W);
    for (const Vector3d& v : c.triangle.v) EXPECT_LE(contact.nhat_W.dot(v - lowest), 1e-9) << "case " << i;
  }
}

TEST(EllipsoidTriangle, TheDepthNeverExceedsThePlanes) {
  RandomContactCases random(5);
  for (int i = 0; i < 50000; ++i) {
    const ContactCase c = random.next();
    const Vector3d& n = c.triangle.nhat_W;
    const double d_n = c.ellipsoid.halfWidth(n) - n.dot(c.ellipsoid.p_WE - c.triangle.v[0]);
    const TriangleContact contact = minimumTranslation(c.ellipsoid, c.triangle);
    EXPECT_LE(contact.depth, std::max(0.0, d_n) + 1e-13) << "case " << i;
  }
}

TEST(EllipsoidTriangle, ACutPlaneGivesTheDeepestContactOfThePlane) {
  RandomContactCases random(6);
  for (int i = 0; i < 300; ++i) {
    // A square grid with every inner corner moved about, each cell cut in two, tilted.
    constexpr int kCells = 8;
    const Matrix3d R = random.rotation();
    std::array<std::array<Vector3d, kCells + 1>, kCells + 1> v;
    for (int a = 0; a <= kCells; ++a) {
      for (int b = 0; b <= kCells; ++b) {
        v[a][b] =
            R * Vector3d(0.25 * (a - 4 + random.uniform(-0.4, 0.4)), 0.25 * (b - 4 + random.uniform(-0.4, 0.4)), 0.0);
      }
    }
    const Vector3d radii(0.35, 0.12, 0.25);
    const Vector3d target = R * Vector3d(random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4), 0.0);
    const Vector3d n = R.col(2);
    const double d_n = random.logUniform(1e-4, 0.1);
    const PosedEllipsoid ellipsoid = RandomContactCases::placed(random.rotation(), radii, target, n, d_n);
    if (n.dot(ellipsoid.p_WE) <= 0.0) continue;

    TriangleContact deepest;
    for (int a = 0; a < kCells; ++a) {
      for (int b = 0; b < kCells; ++b) {
        for (const Triangle& t : {makeTriangle(v[a][b], v[a + 1][b], v[a + 1][b + 1]),
                                  makeTriangle(v[a][b], v[a + 1][b + 1], v[a][b + 1])}) {
          const TriangleContact contact = minimumTranslation(ellipsoid, t);
          EXPECT_LE(contact.depth, d_n + 1e-13);
          if (contact.depth > deepest.depth) deepest = contact;
        }
      }
    }
    // Rounding of the corners through the rotation.
    EXPECT_NEAR(deepest.depth, d_n, 1e-14) << "case " << i;
    EXPECT_LT((deepest.nhat_W - n).norm(), 1e-12) << "case " << i;
  }
}

/// Two unit-size triangles that fall away from a shared edge along x at the origin, by `bend` in all.
std::array<Triangle, 2> ridge(double bend) {
  const double c = std::cos(0.5 * bend), s = std::sin(0.5 * bend);
  const Vector3d a(-1.0, 0.0, 0.0), b(1.0, 0.0, 0.0);
  return {makeTriangle(a, b, Vector3d(0.1, 2.0 * c, -2.0 * s)), makeTriangle(b, a, Vector3d(-0.2, -2.0 * c, -2.0 * s))};
}

TEST(EllipsoidTriangle, TheTwoTrianglesOfAConvexEdgeFindTheSameContactOnIt) {
  RandomContactCases random(7);
  int run = 0;
  for (int i = 0; i < 20000; ++i) {
    const double bend = random.uniform(0.1, 2.5);
    const auto [left, right] = ridge(bend);
    const double angle = random.uniform(-0.45, 0.45) * bend;
    const Vector3d u(0.0, std::sin(angle), std::cos(angle));
    const PosedEllipsoid ellipsoid = RandomContactCases::placed(
        random.rotation(), random.wheelRadii(), Vector3d(0.2, 0.0, 0.0), u, random.logUniform(1e-4, 0.02));
    const TriangleContact one = minimumTranslation(ellipsoid, left), other = minimumTranslation(ellipsoid, right);
    if (!isEdge(one.feature) || !isEdge(other.feature)) continue;
    ++run;
    EXPECT_NEAR(one.depth, other.depth, 1e-14) << "case " << i;
    EXPECT_LT((one.nhat_W - other.nhat_W).norm(), 1e-12) << "case " << i;
    EXPECT_LT((one.trianglePoint() - other.trianglePoint()).norm(), 1e-12) << "case " << i;
  }
  EXPECT_GT(run, 10000);
}

TEST(EllipsoidTriangle, DepthAndNormalAreContinuousOverAConvexEdge) {
  RandomContactCases random(8);
  for (int i = 0; i < 30; ++i) {
    const auto [left, right] = ridge(random.uniform(0.1, 1.2));
    const Matrix3d R = random.rotation();
    const Vector3d radii(0.35, 0.2, 0.3);  // least radius of curvature 0.114 m, far from the fold.
    TriangleContact before;
    constexpr double kStep = 1e-4;
    for (double y = -0.3; y < 0.3; y += kStep) {
      // Straight over the ridge, 1 cm deep where it is highest.
      const PosedEllipsoid level({0.0, 0.0, 0.0}, R, radii);
      const PosedEllipsoid ellipsoid({0.1, y, level.halfWidth(Vector3d::UnitZ()) - 0.01}, R, radii);
      const TriangleContact one = minimumTranslation(ellipsoid, left), other = minimumTranslation(ellipsoid, right);
      const TriangleContact contact = one.depth >= other.depth ? one : other;
      EXPECT_LE(std::abs(contact.depth - before.depth), kStep * (1.0 + 1e-9)) << "y " << y;
      if (contact && before) {
        // The normal turns with 1 / (radius of curvature - depth) over an edge.
        EXPECT_LT((contact.nhat_W - before.nhat_W).norm(), 2.0 * kStep / (0.114 - 0.02)) << "y " << y;
      }
      before = contact;
    }
  }
}

/// The wheel upright with its axle along y, over an edge along its rolling direction x; T0 has just left the triangle.
TriangleContact wheelOnEdgeAlongItsWay(double d_n) {
  const Triangle kerb = makeTriangle({-1.0, 0.0, 0.0}, {0.0, -1.0, 0.0}, {1.0, 0.0, 0.0});
  const PosedEllipsoid wheel({0.0, 1e-9, 0.35 - d_n}, Matrix3d::Identity(), {0.35, 0.12, 0.35});
  return minimumTranslation(wheel, kerb);
}

TEST(EllipsoidTriangle, AnEdgeHoldsThePlanesContactUpToTheRadiusOfCurvature) {
  const double rho = 0.12 * 0.12 / 0.35;
  const TriangleContact contact = wheelOnEdgeAlongItsWay(0.98 * rho);
  ASSERT_TRUE(isEdge(contact.feature));
  EXPECT_NEAR(contact.depth, 0.98 * rho, 1e-9);
  EXPECT_NEAR(contact.nhat_W.z(), 1.0, 1e-9);
}

// Beyond it the nearest point of the wheel's outline is off the axis: P_z = a^2 t / (a^2 - b^2) for a point t on the
// major axis.
TEST(EllipsoidTriangle, AnEdgeLosesThePlanesContactBeyondTheRadiusOfCurvature) {
  for (const double d_n : {0.045, 0.05, 0.1}) {
    const double a = 0.35, b = 0.12, t = a - d_n;
    const double p_z = a * a * t / (a * a - b * b), p_y = b * std::sqrt(1.0 - p_z * p_z / (a * a));
    const TriangleContact contact = wheelOnEdgeAlongItsWay(d_n);
    ASSERT_TRUE(isEdge(contact.feature)) << d_n;
    EXPECT_NEAR(contact.depth, std::hypot(p_z - t, p_y), 1e-8) << d_n;
    EXPECT_NEAR(std::atan2(contact.nhat_W.y(), contact.nhat_W.z()), std::atan2(p_y, p_z - t), 1e-6) << d_n;
  }
}

TEST(EllipsoidTriangle, ACentreBehindThePlaneGivesNone) {
  RandomContactCases random(9);
  for (int i = 0; i < 20000; ++i) {
    const ContactCase c = random.next();
    const Vector3d& n = c.triangle.nhat_W;
    const double s = n.dot(c.ellipsoid.p_WE - c.triangle.v[0]);
    const PosedEllipsoid behind = movedBy(c.ellipsoid, -(std::abs(s) + s + 1e-9) * n);
    EXPECT_FALSE(minimumTranslation(behind, c.triangle)) << "case " << i;
    EXPECT_FALSE(clampedPoint(behind, c.triangle)) << "case " << i;
  }
}

TEST(EllipsoidTriangle, ATriangleWithoutAreaGivesNone) {
  const PosedEllipsoid ball({0.0, 0.0, 0.1}, Matrix3d::Identity(), Vector3d::Constant(0.5));
  const Vector3d a(-1.0, 0.0, 0.0), b(1.0, 0.0, 0.0);
  for (const Triangle& t : {makeTriangle(a, a, a), makeTriangle(a, b, b), makeTriangle(a, b, 0.5 * (a + b))}) {
    EXPECT_FALSE(minimumTranslation(ball, t));
    EXPECT_FALSE(clampedPoint(ball, t));
  }
}

TEST(EllipsoidTriangle, OnFacesAndForSpheresBothRulesAgree) {
  RandomContactCases random(10);
  int run = 0;
  for (int i = 0; i < 20000; ++i) {
    const ContactCase c =
        random.next(Vector3d::Constant(random.uniform(0.1, 2.0)), random.triangle(0.1), random.uniform(0.01, 0.8));
    const TriangleContact one = minimumTranslation(c.ellipsoid, c.triangle),
                          other = clampedPoint(c.ellipsoid, c.triangle);
    if (!one || !other) continue;
    ++run;
    EXPECT_NEAR(one.depth, other.depth, 1e-9) << "case " << i;
  }
  EXPECT_GT(run, 10000);
}

TEST(EllipsoidTriangle, ASphereOverAnEdgeIsPushedFromTheNearestPointOfTheEdge) {
  const Triangle t = makeTriangle({-1.0, 0.0, 0.0}, {0.0, -1.0, 0.0}, {1.0, 0.0, 0.0});
  const PosedEllipsoid ball({0.2, 0.03, 0.04}, Matrix3d::Identity(), Vector3d::Constant(0.07));
  const TriangleContact contact = minimumTranslation(ball, t);
  ASSERT_TRUE(isEdge(contact.feature));
  EXPECT_NEAR(contact.depth, 0.02, 1e-16);
  EXPECT_LT((contact.nhat_W - Vector3d(0.0, 0.6, 0.8)).norm(), 1e-15);
  EXPECT_LT((contact.trianglePoint() - Vector3d(0.2, 0.0, 0.0)).norm(), 1e-15);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
