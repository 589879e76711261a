// The fast contact against the exhaustive one, a million seeded cases: shallow, deep and degenerate.
#include <gtest/gtest.h>

#include "support/brute_force_contact.h"
#include "support/exhaustive_contact.h"
#include "support/random_contact_cases.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Vector3d;

/// What an answer may be off by [m]: 1e-12 of the largest length from the ellipsoid's centre, and what the triangle's
/// own corners leave open: rounded by a bit, they turn the plane of a sliver by its aspect times as much.
double toleranceOf(const ContactCase& c) {
  double size = std::max(c.ellipsoid.radii.maxCoeff(), c.ellipsoid.p_WE.norm());
  for (const Vector3d& v : c.triangle.v) size = std::max(size, (v - c.ellipsoid.p_WE).norm());
  const double aspect = doubleAreaVector(c.triangle.v).norm() / longestEdgeSquared(c.triangle.v);
  // The definition itself lets a point lie past its region by 1e-10 of the size; on a rim sharper than that (discs and
  // needles of 1 : 1e6) it is felt in the depth.
  const double rim = std::pow(c.ellipsoid.radii.minCoeff(), 2) / c.ellipsoid.radii.maxCoeff();
  return size * (1e-12 + 2.2e-16 / aspect + (rim < 1e-9 * size ? 3e-9 : 0.0));
}

struct Tally {
  int cases = 0, touching = 0, doubtful = 0, wrong = 0;
  double worst = 0.0;  ///< depth error in parts of the tolerance, where the answer is not in doubt.
};

template <typename Next>
Tally compare(int count, const Next& next) {
  Tally tally;
  for (int i = 0; i < count; ++i) {
    const ContactCase c = next(i);
    if (!hasArea(c.triangle)) continue;
    const ExhaustiveContact reference(c.ellipsoid, c.triangle);
    const TriangleContact fast = minimumTranslation(c.ellipsoid, c.triangle);
    const double tolerance = toleranceOf(c);
    ++tally.cases;
    tally.touching += static_cast<bool>(fast);
    tally.doubtful += reference.isDoubtful();
    const bool right = reference.explains(fast.depth, tolerance);
    tally.wrong += !right;
    if (!right && tally.wrong <= 3) {
      ADD_FAILURE() << "case " << i << ": depth " << fast.depth << " m, should be " << reference.depth() << " m; radii "
                    << c.ellipsoid.radii.transpose() << ", feature " << static_cast<int>(fast.feature);
    }
    if (right && !reference.isDoubtful())
      tally.worst = std::max(tally.worst, std::abs(fast.depth - reference.depth()) / tolerance);
  }
  return tally;
}

void expectRight(const Tally& tally, double most_doubtful) {
  EXPECT_EQ(tally.wrong, 0) << "of " << tally.cases;
  EXPECT_GT(tally.touching, tally.cases / 3);
  EXPECT_LE(tally.doubtful, most_doubtful * tally.cases);
  std::printf("%d cases, %d touching, %d in doubt, largest error %.1e of the tolerance\n", tally.cases, tally.touching,
              tally.doubtful, tally.worst);
}

TEST(ExhaustiveReference, IsItselfConfirmedBySearch) {
  // Neither knows how the other works: sampling and descent here, roots there.
  RandomContactCases random(401);
  int confirmed = 0;
  for (int i = 0; i < 300; ++i) {
    const ContactCase c = random.next(0.1, 0.05);
    const ExhaustiveContact reference(c.ellipsoid, c.triangle);
    if (reference.isDoubtful()) continue;
    const BruteForceContact search(c.ellipsoid, c.triangle);
    EXPECT_NEAR(search.depth(), reference.depth(), 1e3 * toleranceOf(c)) << "case " << i;
    confirmed += search.hit();
  }
  EXPECT_GT(confirmed, 100);
}

TEST(ExhaustiveReference, ShallowContactsAgree) {
  RandomContactCases random(402);
  expectRight(compare(400000,
                      [&](int) {
                        const Vector3d r = random.radii(0.02);
                        return random.next(r, random.triangle(1e-3), random.logUniform(1e-8, 0.05));
                      }),
              1e-3);
}

TEST(ExhaustiveReference, DeepContactsAgree) {
  RandomContactCases random(403);
  expectRight(compare(400000,
                      [&](int) {
                        const Vector3d r = random.radii(0.02);
                        return random.next(r, random.triangle(1e-3), random.uniform(0.05, 2.0));
                      }),
              1e-3);
}

TEST(ExhaustiveReference, DegenerateContactsAgree) {
  // Discs and needles of 1 : 1e6, slivers of 1 : 1e6, ellipsoids on their symmetry planes, touches at seams.
  RandomContactCases random(404);
  expectRight(compare(200000,
                      [&](int i) {
                        Vector3d r = random.radii(1e-6);
                        if (i % 4 == 0) r = random.uniform(0.2, 2.0) * Vector3d(1.0, 1.0, 1e-6);
                        if (i % 4 == 1) r = random.uniform(0.2, 2.0) * Vector3d(1.0, 1e-6, 1e-6);
                        ContactCase c = random.next(r, random.triangle(1e-6), random.logUniform(1e-6, 2.0));
                        if (i % 3 == 0) {
                          // Level, the centre straight above a corner, an edge's middle or the centroid.
                          const auto& v = c.triangle.v;
                          const Vector3d middle = (v[0] + v[1] + v[2]) / 3.0;
                          const Vector3d at = i % 2 == 0 ? v[0] : i % 5 == 0 ? middle : Vector3d(0.5 * (v[0] + v[1]));
                          Eigen::Matrix3d R;
                          R.col(2) = c.triangle.nhat_W;
                          R.col(0) = (v[1] - v[0]).normalized();
                          R.col(1) = R.col(2).cross(R.col(0)).normalized();
                          c.ellipsoid = PosedEllipsoid(at + random.uniform(0.01, 1.0) * r[2] * R.col(2), R, r);
                        }
                        return c;
                      }),
              0.5);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
