// Two hundred pairs whose least push was found by brute force in long double (support/brute_force_pair.h), kept in
// data/ellipsoid_pairs.csv and worked out anew here.
#include <gtest/gtest.h>

#include <cstdlib>

#include "ellipsoid_vehicle_sim/geometry/ellipsoid_ellipsoid.h"
#include "support/brute_force_pair.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

const std::vector<std::pair<PairCase, PairAnswer>>& vectors() {
  static const auto rows = [] {
    if (const char* path = std::getenv("ELLIPSOID_VEHICLE_SIM_WRITE_PAIRS")) writePairVectors(path);
    return readPairVectors(TEST_DATA_DIR "/ellipsoid_pairs.csv");
  }();
  return rows;
}

double sizeOf(const PairCase& pair) { return pair.first.radii.maxCoeff() + pair.second.radii.maxCoeff(); }

TEST(EllipsoidEllipsoidVectors, DepthMeetsEveryRow) {
  int touching = 0, apart = 0, row = 0;
  for (const auto& [pair, want] : vectors()) {
    const EllipsoidPairContact contact = minimumTranslation(pair.first, pair.second);
    // Rounding of the centres' difference and of h: a few units of the last place of the size.
    EXPECT_NEAR(contact.depth, std::max(0.0, want.depth), 1e-14 * sizeOf(pair)) << "row " << row << ' ' << pair.category;
    ++(want.depth > 0.0 ? touching : apart);
    ++row;
  }
  EXPECT_EQ(row, 200);
  EXPECT_GE(touching, 120);
  EXPECT_GE(apart, 30);
}

TEST(EllipsoidEllipsoidVectors, NormalMeetsEveryRowThatHasOneOnly) {
  int compared = 0, row = -1;
  for (const auto& [pair, want] : vectors()) {
    ++row;
    if (want.depth <= 0.0 || want.runner_up < want.depth + 1e-6) continue;
    const EllipsoidPairContact contact = minimumTranslation(pair.first, pair.second);
    // Brute force finds the least value to 1e-19, so where it is to the root of that over the curvature, 1e-9 and less.
    EXPECT_LT((contact.nhat_W - want.u).norm(), 1e-8) << "row " << row << ' ' << pair.category;
    ++compared;
  }
  EXPECT_GE(compared, 120);
}

TEST(EllipsoidEllipsoidVectors, TheFileIsWhatBruteForceSays) {
  const std::vector<PairCase> cases = pairCases();
  ASSERT_EQ(cases.size(), vectors().size());
  for (std::size_t row = 0; row < cases.size(); row += 10) {
    const auto& [pair, kept] = vectors()[row];
    EXPECT_EQ(pair.category, cases[row].category);
    EXPECT_LT((pair.first.p_WE - cases[row].first.p_WE).norm(), 1e-12) << "row " << row;
    EXPECT_NEAR(SlowPair(pair).solve().depth, kept.depth, 1e-15 * sizeOf(pair)) << "row " << row;
  }
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
