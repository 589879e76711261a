// The kernels of minimumTranslation against the definition, and against each other to the last bit.
#include "ellipsoid_vehicle_sim/geometry/ellipsoid_triangle_kernels.h"

#include <gtest/gtest.h>

#include <cstring>

#include "support/random_contact_cases.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Vector3d;

bool sameBits(const TriangleContact& a, const TriangleContact& b) {
  const auto same = [](const double* x, const double* y) { return std::memcmp(x, y, 3 * sizeof(double)) == 0; };
  return a.feature == b.feature && std::memcmp(&a.depth, &b.depth, sizeof a.depth) == 0 &&
         same(a.nhat_W.data(), b.nhat_W.data()) && same(a.p_WE_lowest.data(), b.p_WE_lowest.data());
}

/// Everything from touches to holes right through, thin and round, level and askew, far from the origin too.
ContactCase mixed(RandomContactCases& random, int i) {
  const Vector3d r = random.radii(i % 5 == 0 ? 1e-4 : 0.02);
  ContactCase c = random.next(r, random.triangle(1e-3), random.logUniform(1e-8, i % 3 == 0 ? 2.0 : 0.05));
  if (i % 7 != 0) return c;
  const Vector3d away(1e4, -1e4, 300.0);
  c.triangle = makeTriangle(c.triangle.v[0] + away, c.triangle.v[1] + away, c.triangle.v[2] + away);
  c.ellipsoid = PosedEllipsoid(c.ellipsoid.p_WE + away, c.ellipsoid.R_WE, r);
  return c;
}

TEST(TriangleKernels, GiveTheSameBitsOnEveryProcessor) {
  const std::vector<TriangleKernel> kernels = triangleKernels();
  ASSERT_GE(kernels.size(), 2u);
  EXPECT_EQ(kernels[0], TriangleKernel::kDefinition);
  EXPECT_EQ(kernels[1], TriangleKernel::kPlain);
  RandomContactCases random(451);
  for (int i = 0; i < 30000; ++i) {
    const ContactCase c = mixed(random, i);
    const TriangleContact plain = minimumTranslation(TriangleKernel::kPlain, c.ellipsoid, c.triangle);
    EXPECT_TRUE(sameBits(minimumTranslation(c.ellipsoid, c.triangle), plain)) << "case " << i;
    for (const TriangleKernel kernel : kernels) {
      if (kernel == TriangleKernel::kDefinition) continue;
      EXPECT_TRUE(sameBits(minimumTranslation(kernel, c.ellipsoid, c.triangle), plain))
          << "case " << i << ", kernel " << static_cast<int>(kernel);
    }
  }
}

TEST(TriangleKernels, AgreeWithTheDefinition) {
  RandomContactCases random(452);
  int faces = 0, features = 0, none = 0, other_bits = 0;
  for (int i = 0; i < 60000; ++i) {
    const ContactCase c = mixed(random, i);
    const TriangleContact slow = minimumTranslation(TriangleKernel::kDefinition, c.ellipsoid, c.triangle);
    const TriangleContact fast = minimumTranslation(c.ellipsoid, c.triangle);
    double size = c.ellipsoid.radii.maxCoeff();
    for (const Vector3d& v : c.triangle.v) size = std::max(size, (v - c.ellipsoid.p_WE).norm());
    // Touches by less than rounding are one or the other.
    const double rounding = 1e-13 * size;
    ASSERT_NEAR(fast.depth, slow.depth, rounding) << "case " << i;
    if (fast.depth <= rounding || slow.depth <= rounding) {
      ++none;
      continue;
    }
    if (slow.feature == Feature::kFace || fast.feature == Feature::kFace) {
      ++faces;
      EXPECT_TRUE(sameBits(fast, slow)) << "case " << i;
      continue;
    }
    ++features;
    other_bits += !sameBits(fast, slow);
    // The depth is stationary in u: a direction is known to fewer digits the flatter it is there. Equal depths in two
    // directions are a tie.
    const double sharpness = c.ellipsoid.radii.maxCoeff() / c.ellipsoid.radii.minCoeff();
    const double turn = (fast.nhat_W - slow.nhat_W).norm();
    EXPECT_TRUE(turn < 1e-10 * sharpness * sharpness || fast.feature != slow.feature) << "case " << i << ": " << turn;
    // As long as the ellipsoid's axes are, to the 1e-13 that some of them are given with.
    EXPECT_NEAR(fast.nhat_W.norm(), 1.0, 2e-13) << "case " << i;
    // E is the ellipsoid's point there, as far as its place can be written down.
    const Vector3d E = c.ellipsoid.p_WE + c.ellipsoid.lowestPointFromCentre(fast.nhat_W);
    EXPECT_LT((E - fast.p_WE_lowest).norm(), 1e-12 * size * sharpness + 1e-15 * c.ellipsoid.p_WE.norm())
        << "case " << i;
  }
  EXPECT_GT(faces, 2000);
  EXPECT_GT(features, 20000);
  EXPECT_GT(none, 5000);
  // The short ways are taken: they round differently.
  EXPECT_GT(other_bits, features / 2);
}

TEST(TriangleKernels, AnswersAboveAFloorAreTheSame) {
  RandomContactCases random(453);
  int above = 0, below = 0;
  for (int i = 0; i < 20000; ++i) {
    const ContactCase c = mixed(random, i);
    const TriangleContact whole = minimumTranslation(c.ellipsoid, c.triangle);
    const double floor = whole.depth * random.uniform(0.2, 1.8);
    const TriangleContact bounded = minimumTranslation(c.ellipsoid, c.triangle, floor);
    if (whole.depth > floor) {
      ++above;
      EXPECT_TRUE(sameBits(whole, bounded)) << "case " << i;
    } else {
      ++below;
      EXPECT_FALSE(bounded) << "case " << i;
      EXPECT_EQ(bounded.depth, 0.0);
    }
  }
  EXPECT_GT(above, 5000);
  EXPECT_GT(below, 5000);
}

TEST(TriangleKernels, NeverAnswerWithNaN) {
  RandomContactCases random(454);
  for (int i = 0; i < 20000; ++i) {
    ContactCase c = mixed(random, i);
    const double bad[] = {std::nan(""), 1e200, -1e308, 1e-308, HUGE_VAL, 0.0};
    const double value = bad[random.index(6)];
    switch (random.index(3)) {
      case 0:
        c.ellipsoid.p_WE[random.index(3)] = value;
        break;
      case 1:
        c.triangle.v[static_cast<std::size_t>(random.index(3))][random.index(3)] = value;
        break;
      default:
        c.ellipsoid.radii[random.index(3)] = std::abs(value);
    }
    for (const TriangleKernel kernel : triangleKernels()) {
      const TriangleContact contact = minimumTranslation(kernel, c.ellipsoid, c.triangle);
      EXPECT_TRUE(std::isfinite(contact.depth) && contact.nhat_W.allFinite() && contact.p_WE_lowest.allFinite())
          << "case " << i << ", kernel " << static_cast<int>(kernel);
    }
  }
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
