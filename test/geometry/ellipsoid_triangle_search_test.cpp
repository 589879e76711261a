// The solver against sheer search, and the two shortcuts a caller may take (floor_depth, cannotExceed) against the
// solver.
#include <gtest/gtest.h>

#include <iostream>
#include <limits>

#include "support/brute_force_contact.h"
#include "support/random_contact_cases.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

struct Agreement {
  int run = 0, hits = 0, edges = 0, corners = 0;
};

/// Depth to 1e-9 of the size: where two minima are about to merge delta is flat, and the search stops short by the
/// root of its rounding.
template <typename NextCase>
Agreement compareWithSearch(int count, const NextCase& next) {
  Agreement agreement;
  for (int i = 0; i < count; ++i) {
    const ContactCase c = next();
    const TriangleContact contact = minimumTranslation(c.ellipsoid, c.triangle);
    const BruteForceContact search(c.ellipsoid, c.triangle);
    EXPECT_EQ(static_cast<bool>(contact), search.hit()) << "case " << i;
    EXPECT_EQ(contact.feature == Feature::kFace, search.isFace() && search.hit()) << "case " << i;
    EXPECT_NEAR(contact.depth, search.depth(), 1e-9 * c.ellipsoid.radii.maxCoeff()) << "case " << i;
    const int feature = static_cast<int>(contact.feature);
    ++agreement.run;
    agreement.hits += contact ? 1 : 0;
    agreement.corners += feature >= static_cast<int>(Feature::kVertex0) ? 1 : 0;
    agreement.edges +=
        feature >= static_cast<int>(Feature::kEdge0) && feature < static_cast<int>(Feature::kVertex0) ? 1 : 0;
  }
  std::cout << agreement.run << " cases, " << agreement.hits << " hits, " << agreement.edges << " edges, "
            << agreement.corners << " corners\n";
  return agreement;
}

TEST(EllipsoidTriangleSearch, TheLeastLocalMinimumIsFoundOverAllShapes) {
  RandomContactCases random(1);
  const Agreement agreement = compareWithSearch(14000, [&] { return random.next(); });
  EXPECT_GT(agreement.edges, 5000);
  EXPECT_GT(agreement.corners, 1000);
}

TEST(EllipsoidTriangleSearch, TheLeastLocalMinimumIsFoundForTheWheelWhenShallow) {
  RandomContactCases random(2);
  const Agreement agreement = compareWithSearch(
      4000, [&] { return random.next(random.wheelRadii(), random.triangle(0.1), random.logUniform(1e-5, 0.3)); });
  EXPECT_GT(agreement.edges, 1000);
}

TEST(EllipsoidTriangleSearch, TheLeastLocalMinimumIsFoundForTheWheelWhenDeep) {
  RandomContactCases random(3);
  const Agreement agreement = compareWithSearch(
      4000, [&] { return random.next(random.wheelRadii(), random.triangle(0.1), random.uniform(0.3, 4.0)); });
  EXPECT_GT(agreement.edges, 500);
}

TEST(EllipsoidTriangleSearch, TheLeastLocalMinimumIsFoundForThinShapesAndSlivers) {
  RandomContactCases random(4);
  const Agreement agreement = compareWithSearch(4000, [&] { return random.next(1e-3, 1e-5); });
  EXPECT_GT(agreement.edges, 1000);
}

// A floor may turn an answer into none, and only one that does not exceed it. What is left is the same to the last bit.
TEST(EllipsoidTriangleSearch, AFloorNeverChangesAnAnswerAboveIt) {
  RandomContactCases random(5);
  int kept = 0, dropped = 0;
  for (int i = 0; i < 200000; ++i) {
    const ContactCase c = random.next();
    const TriangleContact whole = minimumTranslation(c.ellipsoid, c.triangle);
    const double scale = whole ? whole.depth : 0.1 * c.ellipsoid.radii.maxCoeff();
    const double floor = scale * random.uniform(0.0, 2.0);
    const TriangleContact cut = minimumTranslation(c.ellipsoid, c.triangle, floor);
    // 1e-14 of the size: the floor is passed by rounding.
    if (whole.depth > floor + 1e-14) {
      ++kept;
      EXPECT_EQ(cut.feature, whole.feature) << "case " << i;
      EXPECT_EQ(cut.depth, whole.depth) << "case " << i;
      EXPECT_EQ(cut.nhat_W, whole.nhat_W) << "case " << i;
      EXPECT_EQ(cut.p_WE_lowest, whole.p_WE_lowest) << "case " << i;
    } else {
      ++dropped;
      EXPECT_TRUE(!cut || cut.depth > floor) << "case " << i;
    }
  }
  EXPECT_GT(kept, 50000);
  EXPECT_GT(dropped, 50000);
}

// A million cases, directions near the answer and far from it, depths just enough for the direction and more.
TEST(EllipsoidTriangleSearch, WhatCannotExceedADepthDoesNotExceedIt) {
  RandomContactCases random(6);
  int proved = 0, proved_below_the_plane = 0;
  for (int i = 0; i < 1000000; ++i) {
    const ContactCase c = random.next();
    const TriangleContact contact = minimumTranslation(c.ellipsoid, c.triangle);
    const Eigen::Vector3d start = contact && random.index(2) == 0 ? contact.nhat_W : c.triangle.nhat_W;
    const Eigen::Vector3d u = (start + random.logUniform(1e-6, 2.0) * random.unitVector()).normalized();
    double highest = -std::numeric_limits<double>::infinity();
    for (const auto& v : c.triangle.v) highest = std::max(highest, u.dot(v - c.ellipsoid.p_WE));
    const double clearing = highest + c.ellipsoid.halfWidth(u);
    const double depth = std::max(0.0, clearing) * (random.index(2) == 0 ? 1.0 + 1e-12 : random.uniform(0.5, 2.0));
    if (!cannotExceed(c.ellipsoid, c.triangle, u, depth)) continue;
    ++proved;
    // Not by the plane's own depth alone.
    const Eigen::Vector3d& n = c.triangle.nhat_W;
    const double s = n.dot(c.ellipsoid.p_WE - c.triangle.v[0]);
    proved_below_the_plane += s > 0.0 && c.ellipsoid.halfWidth(n) - s > depth ? 1 : 0;
    // Rounding of lengths of the order of the triangle.
    EXPECT_LE(contact.depth, depth + 1e-13) << "case " << i;
  }
  std::cout << proved << " proved, " << proved_below_the_plane << " of them not by the plane alone\n";
  EXPECT_GT(proved, 100000);
  EXPECT_GT(proved_below_the_plane, 50000);
}

TEST(EllipsoidTriangleSearch, NothingIsProvedBelowTheDepthOfAContact) {
  RandomContactCases random(7);
  for (int i = 0; i < 100000; ++i) {
    const ContactCase c = random.next();
    const TriangleContact contact = minimumTranslation(c.ellipsoid, c.triangle);
    if (!contact) continue;
    EXPECT_FALSE(cannotExceed(c.ellipsoid, c.triangle, contact.nhat_W, 0.999 * contact.depth)) << "case " << i;
  }
}

// The use it is made for: contacts seen along their own direction.
TEST(EllipsoidTriangleSearch, AShallowWheelsEdgeContactIsBoundedAlongItsOwnDirection) {
  RandomContactCases random(8);
  int run = 0, proved = 0;
  for (int i = 0; i < 20000; ++i) {
    const Triangle triangle = random.triangle(0.1);
    const ContactCase c = random.next(random.wheelRadii(), triangle, random.logUniform(1e-4, 0.1));
    const TriangleContact contact = minimumTranslation(c.ellipsoid, triangle);
    if (contact.feature == Feature::kNone || contact.feature == Feature::kFace) continue;
    ++run;
    proved += cannotExceed(c.ellipsoid, triangle, contact.nhat_W, contact.depth * (1.0 + 1e-9)) ? 1 : 0;
  }
  std::cout << proved << " of " << run << " bounded\n";
  EXPECT_GT(proved, run / 4);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
