// Every contact of data/vectors.csv: 1,319 cases computed at 50 digits and cross-checked by brute force, for both
// rules. Rows whose answer is not unique or ill-conditioned say so in their flag and are counted instead of compared.
#include <gtest/gtest.h>

#include <iostream>

#include "support/contact_vectors.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

struct Count {
  int run = 0;
  int skipped = 0;
};

const std::vector<ContactVector>& vectors() {
  static const std::vector<ContactVector> rows = readContactVectors(TEST_DATA_DIR "/vectors.csv");
  return rows;
}

/// Compares every comparable row; one failure per row that misses.
template <typename Rule>
Count compare(const char* name, ExpectedContact ContactVector::*expected, Rule rule) {
  Count count;
  double worst = 0.0;
  for (const ContactVector& row : vectors()) {
    const ExpectedContact& want = row.*expected;
    if (want.flag & kNotComparable) {
      ++count.skipped;
      continue;
    }
    ++count.run;
    const TriangleContact contact = rule(row);
    const double error = errorInTolerances(row, want, contact);
    worst = std::max(worst, error);
    EXPECT_LE(error, 1.0) << name << " row " << row.id << " (" << row.category << "): expected " << want.feature
                          << " depth " << want.depth << ", got " << featureName(contact.feature) << " depth "
                          << contact.depth;
  }
  std::cout << name << ": " << count.run << " rows run, " << count.skipped << " skipped, worst error " << worst
            << " tolerances\n";
  return count;
}

TEST(EllipsoidTriangleVectors, MinimumTranslationMeetsEveryComparableRow) {
  const Count count = compare("minimum_translation", &ContactVector::minimum_translation,
                              [](const ContactVector& row) { return minimumTranslation(row.ellipsoid, row.triangle); });
  EXPECT_EQ(count.run, 1287);
  EXPECT_EQ(count.skipped, 32);
}

TEST(EllipsoidTriangleVectors, ClampedPointMeetsEveryComparableRow) {
  const Count count = compare("clamped_point", &ContactVector::clamped_point,
                              [](const ContactVector& row) { return clampedPoint(row.ellipsoid, row.triangle); });
  EXPECT_EQ(count.run, 1281);
  EXPECT_EQ(count.skipped, 38);
}

TEST(EllipsoidTriangleVectors, AFloorBelowTheDepthChangesNothingAndOneAboveItGivesNone) {
  int run = 0;
  for (const ContactVector& row : vectors()) {
    const ExpectedContact& want = row.minimum_translation;
    if ((want.flag & kNotComparable) || !want.hit) continue;
    ++run;
    const TriangleContact below = minimumTranslation(row.ellipsoid, row.triangle, 0.999 * want.depth);
    EXPECT_LE(errorInTolerances(row, want, below), 1.0) << "row " << row.id;
    EXPECT_FALSE(minimumTranslation(row.ellipsoid, row.triangle, 1.001 * want.depth)) << "row " << row.id;
  }
  EXPECT_EQ(run, 1042);
}

// The answer is never NaN and never without a unit direction, on the rows that cannot be compared as well.
TEST(EllipsoidTriangleVectors, EveryRowAnswersWithFiniteNumbers) {
  for (const ContactVector& row : vectors()) {
    for (const TriangleContact& contact :
         {minimumTranslation(row.ellipsoid, row.triangle), clampedPoint(row.ellipsoid, row.triangle)}) {
      EXPECT_TRUE(std::isfinite(contact.depth) && contact.p_WE_lowest.allFinite()) << "row " << row.id;
      EXPECT_NEAR(contact.nhat_W.norm(), contact ? 1.0 : 0.0, 1e-12) << "row " << row.id;
    }
  }
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
