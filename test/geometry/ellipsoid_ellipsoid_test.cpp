#include "ellipsoid_vehicle_sim/geometry/ellipsoid_ellipsoid.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

PosedEllipsoid at(const Vector3d& p, const Vector3d& radii, const Quaterniond& q = Quaterniond::Identity()) {
  return PosedEllipsoid(p, q.normalized().toRotationMatrix(), radii);
}

const Vector3d kWheel(0.35, 0.12, 0.35), kBody(2.0, 0.8, 0.4);

TEST(EllipsoidEllipsoid, SpheresMeetAsTheirCentresSay) {
  const PosedEllipsoid a = at({1.0, 2.0, 3.0}, Vector3d::Constant(0.5)), b = at({1.0, 2.6, 3.8}, Vector3d::Constant(0.7));
  const EllipsoidPairContact contact = minimumTranslation(a, b);
  EXPECT_NEAR(contact.depth, 0.2, 1e-15);
  EXPECT_LT((contact.nhat_W - Vector3d(0.0, -0.6, -0.8)).norm(), 1e-15);
  EXPECT_LT((contact.p_WE_first - Vector3d(1.0, 2.3, 3.4)).norm(), 1e-15);
}

TEST(EllipsoidEllipsoid, ApartThereIsNone) {
  EXPECT_FALSE(minimumTranslation(at({0, 0, 0}, kWheel), at({0.71, 0, 0}, kWheel)));
  // The boxes overlap, the bodies do not.
  const Quaterniond turned(Eigen::AngleAxisd(0.7, Vector3d::UnitZ()));
  EXPECT_FALSE(minimumTranslation(at({0, 0, 0}, kBody, turned), at({1.6, -0.5, 0}, Vector3d::Constant(0.3))));
}

TEST(EllipsoidEllipsoid, TouchingExactlyIsNoContact) {
  EXPECT_EQ(minimumTranslation(at({0, 0, 0}, kWheel), at({0.7, 0, 0}, kWheel)).depth, 0.0);
}

TEST(EllipsoidEllipsoid, ExchangedTheyPushTheOtherWay) {
  const PosedEllipsoid a = at({0.1, 0.2, 0.0}, kBody, {0.9, 0.1, -0.3, 0.2}), b = at({1.5, 0.6, 0.3}, kWheel, {0.5, 0.5, 0.1, -0.4});
  const EllipsoidPairContact one = minimumTranslation(a, b), other = minimumTranslation(b, a);
  ASSERT_TRUE(one);
  EXPECT_NEAR(one.depth, other.depth, 1e-14);
  EXPECT_LT((one.nhat_W + other.nhat_W).norm(), 1e-12);
  EXPECT_LT((one.p_WE_first - other.p_WE_second).norm(), 1e-12);
}

// The envelope theorem: with the wrench k delta u through the line of E1 and E2, half k delta^2 is a potential.
TEST(EllipsoidEllipsoid, DepthIsAPotential) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const auto vector = [&] { return Vector3d(normal(random), normal(random), normal(random)); };
  int tried = 0;
  for (int k = 0; k < 400; ++k) {
    const Vector3d r1 = k % 2 == 0 ? kWheel : kBody, r2(0.3, 0.5, 0.2);
    const Quaterniond q1 = Quaterniond(normal(random), normal(random), normal(random), normal(random)).normalized();
    const PosedEllipsoid b = at(Vector3d::Zero(), r2, Quaterniond(normal(random), normal(random), normal(random), normal(random)));
    const Vector3d p = 0.5 * vector();
    const EllipsoidPairContact contact = minimumTranslation(at(p, r1, q1), b);
    if (contact.depth < 1e-3) continue;
    const Vector3d shift = vector().normalized(), turn = vector().normalized();
    constexpr double h = 1e-6;
    const auto depthAt = [&](double s) {
      const Quaterniond q = Quaterniond(Eigen::AngleAxisd(s, turn)) * q1;
      return minimumTranslation(at(p + s * shift, r1, q), b).depth;
    };
    const double slope = (depthAt(h) - depthAt(-h)) / (2.0 * h);
    const Vector3d moment = (contact.p_WE_first - p).cross(contact.nhat_W);
    // On the medial axis two minima are as good and the depth has a kink: there the slope lies between both.
    const double expected = -(contact.nhat_W.dot(shift) + moment.dot(turn));
    const double forward = (depthAt(h) - depthAt(0.0)) / h;
    if (std::abs(forward - slope) > 1e-3) continue;
    EXPECT_NEAR(slope, expected, 1e-8) << "case " << k;
    ++tried;
  }
  EXPECT_GT(tried, 150);
}

TEST(EllipsoidEllipsoid, TheDeepestPointsLieOnTheLineOfThePush) {
  const PosedEllipsoid a = at({0.0, 0.1, 0.35}, kBody, {0.9, 0.1, -0.3, 0.2}), b = at({0.2, 0.3, -0.2}, kWheel, {0.5, 0.5, 0.1, -0.4});
  const EllipsoidPairContact contact = minimumTranslation(a, b);
  ASSERT_TRUE(contact);
  EXPECT_LT((contact.p_WE_second - contact.p_WE_first - contact.depth * contact.nhat_W).norm(), 1e-14);
  // Moved by the push they let go.
  PosedEllipsoid moved = a;
  moved.p_WE += (contact.depth + 1e-12) * contact.nhat_W;
  EXPECT_FALSE(minimumTranslation(moved, b));
  moved.p_WE -= 2e-12 * contact.nhat_W;
  EXPECT_TRUE(minimumTranslation(moved, b));
}

TEST(EllipsoidEllipsoid, ConcentricSpheresPushUpwards) {
  const EllipsoidPairContact contact = minimumTranslation(at({1, 1, 1}, Vector3d::Ones()), at({1, 1, 1}, Vector3d::Ones()));
  EXPECT_EQ(contact.depth, 2.0);
  EXPECT_EQ(contact.nhat_W, Vector3d::UnitZ());
}

TEST(EllipsoidEllipsoid, NestedBodiesLeaveByTheThinnestWay) {
  const EllipsoidPairContact contact = minimumTranslation(at({0, 0, 0}, kBody), at({0, 0, 0}, Vector3d::Constant(0.1)));
  EXPECT_NEAR(contact.depth, 0.5, 1e-15);
  EXPECT_LT((contact.nhat_W - Vector3d::UnitZ()).norm(), 1e-15);
  // A little lower, it is downwards.
  EXPECT_LT(minimumTranslation(at({0, 0, -0.01}, kBody), at({0, 0, 0}, Vector3d::Constant(0.1))).nhat_W.z(), -0.999);
}

// Side by side along the long axis: the line of centres is a ridge, and the way out is across.
TEST(EllipsoidEllipsoid, LineOfCentresThatIsARidgeIsLeft) {
  const Vector3d needle(1.0, 0.05, 0.06);
  const EllipsoidPairContact contact = minimumTranslation(at({0.5, 0, 0}, needle), at({0, 0, 0}, needle));
  EXPECT_LT(contact.depth, 0.1);
  EXPECT_GT(std::abs(contact.nhat_W.y()), 0.99);
}

TEST(EllipsoidEllipsoid, DiscsOfOneToTenThousand) {
  const Vector3d disc(1.0, 1.0, 1e-4);
  // Face to face, edge to face, edge to edge.
  EXPECT_NEAR(minimumTranslation(at({0.3, 0.1, 1.5e-4}, disc), at({0, 0, 0}, disc)).depth, 4.56e-5, 5e-6);
  const Quaterniond upright(Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitX()));
  EXPECT_NEAR(minimumTranslation(at({0, 0, 0.9}, disc, upright), at({0, 0, 0}, disc)).depth, 0.1001, 1e-12);
  const EllipsoidPairContact edge = minimumTranslation(at({1.9, 0, 0}, disc), at({0, 0, 0}, disc));
  EXPECT_TRUE(edge);
  EXPECT_LE(edge.depth, 2e-4);
  // However they stand: a depth between nothing and the thinnest way, a unit normal, and nothing that is not a number.
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int k = 0; k < 2000; ++k) {
    const auto any = [&] { return Quaterniond(uniform(random), uniform(random), uniform(random), uniform(random)); };
    const Vector3d radii = k % 3 == 0 ? Vector3d(1.0, 1e-4, 1e-4) : disc;
    const EllipsoidPairContact contact =
        minimumTranslation(at({uniform(random), uniform(random), uniform(random)}, radii, any()), at({0, 0, 0}, disc, any()));
    ASSERT_TRUE(contact.depth >= 0.0 && contact.depth <= 1.0 + 2e-4) << contact.depth;
    if (contact) ASSERT_NEAR(contact.nhat_W.norm(), 1.0, 1e-15);
    ASSERT_TRUE(contact.p_WE_first.allFinite() && contact.p_WE_second.allFinite());
  }
}

TEST(EllipsoidEllipsoid, FarFromTheOriginOnlyTheCentresLoseDigits) {
  const Vector3d far(1e6, -2e6, 3e5);
  const PosedEllipsoid a = at({0.0, 0.1, 0.35}, kBody, {0.9, 0.1, -0.3, 0.2}), b = at({0.2, 0.3, -0.2}, kWheel);
  const EllipsoidPairContact here = minimumTranslation(a, b);
  PosedEllipsoid a_far = a, b_far = b;
  a_far.p_WE += far;
  b_far.p_WE += far;
  EXPECT_NEAR(minimumTranslation(a_far, b_far).depth, here.depth, 2e-9);
}

TEST(EllipsoidEllipsoid, SeparatingPlanesProveThatTheyAreApart) {
  const PosedEllipsoid a = at({0, 0, 1.3}, kBody), b = at({0, 0, 0}, kBody);
  EXPECT_TRUE(separates(a, b, Vector3d::UnitZ()));
  EXPECT_FALSE(separates(a, b, Vector3d::UnitX()));
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
