// The same contact in another world: turned, shifted, mirrored, scaled; and inputs at the edge of what doubles hold.
#include <gtest/gtest.h>

#include <limits>

#include "support/random_contact_cases.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Triangle transformed(const Triangle& t, const Matrix3d& R, const Vector3d& p) {
  return makeTriangle(R * t.v[0] + p, R * t.v[1] + p, R * t.v[2] + p);
}

/// Depths of one case and its image; a few cases in a thousand stand where rounding makes the answer jump.
struct Agreement {
  int run = 0, differ = 0;
  void compare(const TriangleContact& one, const TriangleContact& image, double tolerance) {
    ++run;
    differ += std::abs(one.depth - image.depth) > tolerance || one.feature != image.feature ? 1 : 0;
  }
};

TEST(EllipsoidTriangleInvariance, ATurnedAndShiftedWorldGivesTheSameDepth) {
  RandomContactCases random(1);
  Agreement agreement;
  for (int i = 0; i < 20000; ++i) {
    const ContactCase c = random.next();
    const Matrix3d R = random.rotation();
    const Vector3d p = 10.0 * random.unitVector();
    const PosedEllipsoid moved(R * c.ellipsoid.p_WE + p, R * c.ellipsoid.R_WE, c.ellipsoid.radii);
    agreement.compare(minimumTranslation(c.ellipsoid, c.triangle),
                      minimumTranslation(moved, transformed(c.triangle, R, p)), 1e-10);
  }
  EXPECT_LE(agreement.differ, agreement.run / 1000);
}

TEST(EllipsoidTriangleInvariance, AFarAwayWorldCostsOnlyTheRoundingOfItsCoordinates) {
  RandomContactCases random(2);
  Agreement agreement;
  const Vector3d p(1048576.0, -524288.0, 2097152.0);
  for (int i = 0; i < 20000; ++i) {
    const ContactCase c = random.next(random.wheelRadii(), random.triangle(0.3), random.logUniform(1e-3, 0.2));
    // The corners as they are after rounding, brought back without any: only the contact's own arithmetic is compared.
    std::array<Vector3d, 3> far, near;
    for (int k = 0; k < 3; ++k) {
      far[k] = c.triangle.v[k] + p;
      near[k] = far[k] - p;
    }
    const Vector3d centre = c.ellipsoid.p_WE + p;
    const PosedEllipsoid far_wheel(centre, c.ellipsoid.R_WE, c.ellipsoid.radii);
    const PosedEllipsoid near_wheel(centre - p, c.ellipsoid.R_WE, c.ellipsoid.radii);
    agreement.compare(minimumTranslation(near_wheel, makeTriangle(near[0], near[1], near[2])),
                      minimumTranslation(far_wheel, makeTriangle(far[0], far[1], far[2])), 1e-14);
  }
  EXPECT_EQ(agreement.differ, 0);
}

TEST(EllipsoidTriangleInvariance, AMirroredWorldGivesTheMirroredPush) {
  RandomContactCases random(3);
  int differ = 0;
  const Vector3d flip(1.0, -1.0, 1.0);
  for (int i = 0; i < 20000; ++i) {
    const ContactCase c = random.next(random.wheelRadii(), random.triangle(0.3), random.logUniform(1e-3, 0.2));
    const auto& v = c.triangle.v;
    // Two corners change places: the front stays the front.
    const Triangle image = makeTriangle(flip.cwiseProduct(v[0]), flip.cwiseProduct(v[2]), flip.cwiseProduct(v[1]));
    const PosedEllipsoid wheel(flip.cwiseProduct(c.ellipsoid.p_WE),
                               flip.asDiagonal() * c.ellipsoid.R_WE * flip.asDiagonal(), c.ellipsoid.radii);
    const TriangleContact one = minimumTranslation(c.ellipsoid, c.triangle), other = minimumTranslation(wheel, image);
    differ += std::abs(one.depth - other.depth) > 1e-12 || (one.nhat_W - flip.cwiseProduct(other.nhat_W)).norm() > 1e-9
                  ? 1
                  : 0;
  }
  EXPECT_LE(differ, 20);
}

TEST(EllipsoidTriangleInvariance, AScaledWorldScalesTheDepth) {
  RandomContactCases random(4);
  for (const double scale : {1e-30, 1e-6, 1e6, 1e30}) {
    Agreement agreement;
    for (int i = 0; i < 5000; ++i) {
      const ContactCase c = random.next();
      const auto& v = c.triangle.v;
      const PosedEllipsoid scaled(scale * c.ellipsoid.p_WE, c.ellipsoid.R_WE, scale * c.ellipsoid.radii);
      TriangleContact image = minimumTranslation(scaled, makeTriangle(scale * v[0], scale * v[1], scale * v[2]));
      image.depth /= scale;
      agreement.compare(minimumTranslation(c.ellipsoid, c.triangle), image, 1e-10);
    }
    EXPECT_LE(agreement.differ, agreement.run / 1000) << scale;
  }
}

TEST(EllipsoidTriangleInvariance, TheOrderOfTheCornersDoesNotMatter) {
  RandomContactCases random(5);
  int differ = 0;
  for (int i = 0; i < 20000; ++i) {
    const ContactCase c = random.next();
    const auto& v = c.triangle.v;
    const TriangleContact one = minimumTranslation(c.ellipsoid, c.triangle);
    const TriangleContact other = minimumTranslation(c.ellipsoid, makeTriangle(v[1], v[2], v[0]));
    differ += std::abs(one.depth - other.depth) > 1e-10 ? 1 : 0;
  }
  EXPECT_LE(differ, 20);
}

TEST(EllipsoidTriangleInvariance, TheOrderOfTheAxesDoesNotMatter) {
  RandomContactCases random(6);
  int differ = 0;
  for (int i = 0; i < 20000; ++i) {
    const ContactCase c = random.next();
    Matrix3d R;
    R << c.ellipsoid.R_WE.col(2), c.ellipsoid.R_WE.col(0), c.ellipsoid.R_WE.col(1);
    const Vector3d& r = c.ellipsoid.radii;
    const PosedEllipsoid turned(c.ellipsoid.p_WE, R, {r[2], r[0], r[1]});
    for (const auto rule :
         {&clampedPoint, +[](const PosedEllipsoid&e, const Triangle&t) { return minimumTranslation(e, t); }}) {
      differ += std::abs(rule(c.ellipsoid, c.triangle).depth - rule(turned, c.triangle).depth) > 1e-10 ? 1 : 0;
    }
  }
  EXPECT_LE(differ, 20);
}

/// Runs both rules; fails on anything that is not a finite contact with a unit direction, or a plain none.
void expectSound(const PosedEllipsoid& ellipsoid, const Triangle& triangle, const char* what) {
  for (const TriangleContact& contact : {minimumTranslation(ellipsoid, triangle), clampedPoint(ellipsoid, triangle)}) {
    EXPECT_TRUE(std::isfinite(contact.depth) && contact.depth >= 0.0) << what;
    EXPECT_TRUE(contact.p_WE_lowest.allFinite()) << what;
    EXPECT_NEAR(contact.nhat_W.norm(), contact ? 1.0 : 0.0, 1e-9) << what;
  }
}

TEST(EllipsoidTriangleInvariance, NeedlesAndDiscsOfOneToAMillionGiveSoundAnswers) {
  RandomContactCases random(7);
  for (int i = 0; i < 50000; ++i) {
    const ContactCase c = random.next(1e-6, 1e-7);
    expectSound(c.ellipsoid, c.triangle, "needle or disc");
  }
}

TEST(EllipsoidTriangleInvariance, ADiscOfOneToAMillionOnEdgeKeepsItsDepth) {
  // Upright on its rim across a kerb edge: in the rim's plane a circle of radius 1 touches the edge's line from above.
  const Triangle t = makeTriangle({0.0, -1.0, 0.0}, {0.0, 1.0, 0.0}, {-1.0, 0.0, 0.0});
  const PosedEllipsoid disc({0.6, 0.0, 0.79}, Matrix3d::Identity(), {1.0, 1e-6, 1.0});
  const TriangleContact contact = minimumTranslation(disc, t);
  ASSERT_TRUE(contact);
  EXPECT_NEAR(contact.depth, 1.0 - std::hypot(0.6, 0.79), 1e-15);
  EXPECT_LT((contact.nhat_W - Vector3d(0.6, 0.0, 0.79).normalized()).norm(), 1e-14);
}

TEST(EllipsoidTriangleInvariance, ExtremeSizesGiveNoNaN) {
  RandomContactCases random(8);
  for (const double size : {1e-150, 1e-100, 1e-50, 1e-20, 1.0, 1e20, 1e50, 1e100, 1e150, 1e300}) {
    for (const double triangle_size : {1e-150, 1e-50, 1.0, 1e50, 1e150, 1e300}) {
      for (int i = 0; i < 50; ++i) {
        const ContactCase c = random.next();
        const auto& v = c.triangle.v;
        const PosedEllipsoid ellipsoid(size * c.ellipsoid.p_WE, c.ellipsoid.R_WE, size * c.ellipsoid.radii);
        expectSound(ellipsoid, makeTriangle(triangle_size * v[0], triangle_size * v[1], triangle_size * v[2]),
                    "extreme size");
      }
    }
  }
}

TEST(EllipsoidTriangleInvariance, NonFiniteInputsGiveNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  const Triangle t = makeTriangle({-1.0, 0.0, 0.0}, {0.0, -1.0, 0.0}, {1.0, 0.0, 0.0});
  for (const double bad : {nan, infinity, -infinity}) {
    for (int k = 0; k < 3; ++k) {
      Vector3d c(0.0, 0.01, 0.1), r(0.2, 0.2, 0.2);
      c[k] = bad;
      expectSound({c, Matrix3d::Identity(), r}, t, "centre");
      EXPECT_FALSE(minimumTranslation({c, Matrix3d::Identity(), r}, t));
      c = {0.0, 0.01, 0.1};
      r[k] = bad;
      expectSound({c, Matrix3d::Identity(), r}, t, "semi-axis");
      Triangle broken = t;
      broken.v[k] = Vector3d(0.0, bad, 0.0);
      expectSound({c, Matrix3d::Identity(), {0.2, 0.2, 0.2}}, broken, "corner");
    }
  }
}

// The centre on a corner, on an edge, or with a corner on one of its axes or planes of symmetry.
TEST(EllipsoidTriangleInvariance, ACentreOnTheTrianglesLinesGivesSoundAnswers) {
  const Triangle t = makeTriangle({0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0});
  for (const Vector3d& r : {Vector3d(0.35, 0.12, 0.35), Vector3d(1.0, 1.0, 1.0), Vector3d(1.0, 1e-6, 1.0),
                            Vector3d(1e-6, 1.0, 1e-6), Vector3d(0.3, 0.2, 0.1), Vector3d(0.1, 0.2, 0.3)}) {
    for (const double x : {-0.05, 0.0, 0.3, 1.0, 1.05}) {
      for (const double y : {-0.05, 0.0, 0.3, 1.0}) {
        for (const double z : {-0.01, 0.0, 1e-300, 1e-90, 1e-20, 1e-7, 0.05}) {
          const PosedEllipsoid ellipsoid({x, y, z}, Matrix3d::Identity(), r);
          expectSound(ellipsoid, t, "on the lines");
          EXPECT_TRUE(z > 0.0 || !minimumTranslation(ellipsoid, t));
        }
      }
    }
  }
}

// A wheel that stands across a narrow ridge in its own plane of symmetry has two mirror images for an answer;
// whichever it is, the depth is theirs, and it is the same however the ridge is turned.
TEST(EllipsoidTriangleInvariance, MirrorImagesGiveTheirCommonDepth) {
  RandomContactCases random(9);
  const Triangle t = makeTriangle({-1.0, 0.0, 0.0}, {0.0, -1.0, 0.0}, {1.0, 0.0, 0.0});
  const PosedEllipsoid wheel({0.0, 1e-3, 0.25}, Matrix3d::Identity(), {0.35, 0.12, 0.35});
  const TriangleContact contact = minimumTranslation(wheel, t);
  ASSERT_TRUE(contact);
  for (int i = 0; i < 1000; ++i) {
    const Matrix3d R = random.rotation();
    const PosedEllipsoid turned(R * wheel.p_WE, R, wheel.radii);
    EXPECT_NEAR(minimumTranslation(turned, transformed(t, R, Vector3d::Zero())).depth, contact.depth, 1e-14);
  }
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
