// Contacts proved to be alone: with and without such proofs every answer is the same, up to the border of what they
// cover.
#include "ellipsoid_vehicle_sim/contact/sole_contact.h"

#include <gtest/gtest.h>

#include <limits>

#include "ellipsoid_vehicle_sim/contact/find_contacts.h"
#include "support/contact_scenes.h"
#include "support/random_contact_cases.h"
#include "support/same_contacts.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Ground around the origin: from flat to crumpled, from cells of a tenth of a wheel to cells that hold it; now and
/// then a wall or a valley.
TriangleSoup anyGround(RandomContactCases& random) {
  switch (random.index(8)) {
    case 0:
      return groundAndWallSoup();
    case 1:
      return bendSoup(random.uniform(-1.2, 1.2));
    case 2:
      return sawtoothSoup(random.uniform(0.02, 0.6), random.logUniform(0.1, 3.0), 6);
    case 3:
      return kerbSoup(random.uniform(-0.2, 0.2));
    default: {
      TriangleSoup soup = floorSoup(3.0, 12);
      const double scale = random.logUniform(0.2, 2.0), roughness = scale * random.logUniform(1e-5, 0.3);
      const bool jagged = random.index(2) == 0;
      for (Vector3d& v : soup.vertices) {
        const double wave = std::sin(1.3 * v.x()) * std::cos(0.9 * v.y());
        v = Vector3d(scale * v.x(), scale * v.y(), roughness * (jagged ? random.uniform(-1.0, 1.0) : wave));
      }
      return soup;
    }
  }
}

Vector3d anyRadii(RandomContactCases& random) {
  if (random.index(2) == 0) return random.wheelRadii();
  const double r = random.logUniform(0.1, 0.8);
  return {r, r * random.logUniform(0.1, 1.0), r * random.logUniform(0.1, 1.0)};
}

/// The deepest point of the ground's contact under (x, y) is brought to about this depth: a place to start from.
PosedEllipsoid settled(const PosedEllipsoid& e, const Terrain& terrain, double depth) {
  PosedEllipsoid result = e;
  ContactOptions options;
  options.memory = false;
  for (int i = 0; i < 20; ++i) {
    ContactFinder finder;
    const EllipsoidContacts found = findContacts(result, {}, terrain, options, finder);
    const double lift = found.count > 0 ? found.contact[0].depth - depth : -0.3 * e.radii.minCoeff();
    result = PosedEllipsoid(result.p_WE - Vector3d(0.0, 0.0, -lift), result.R_WE, result.radii);
    if (found.count > 0 && std::abs(lift) < 1e-3) break;
  }
  return result;
}

struct Asked {
  int queries = 0, covered = 0;
};

/// A body goes its way over some ground, a step at a time, bobbing and turning a little: a finder that keeps its proofs
/// against a search of everything.
void drive(RandomContactCases& random, bool with_memory, const Vector3d& offset, Asked& asked) {
  TriangleSoup soup = anyGround(random);
  for (Vector3d& v : soup.vertices) v += offset;
  const auto terrain = terrainOf(std::move(soup));
  PosedEllipsoid e(offset + Vector3d(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), 0.3), random.rotation(),
                   anyRadii(random));
  e = settled(e, *terrain, 0.02 * e.radii.minCoeff());
  const double step = random.logUniform(1e-5, 0.03), bob = step * random.logUniform(1e-3, 1.0);
  const double turn = random.index(2) == 0 ? 0.0 : random.logUniform(1e-6, 1e-2);
  const Vector3d ahead = AngleAxisd(random.uniform(-3.1, 3.1), Vector3d::UnitZ()) * Vector3d(step, 0.0, 0.0);
  const Vector3d axis = random.unitVector();
  ContactOptions kept, anew;
  kept.memory = anew.memory = with_memory;
  kept.contacts = anew.contacts = random.index(2) == 0 ? ContactsPerEllipsoid::kOne : ContactsPerEllipsoid::kValley;
  anew.cache = false;
  ContactFinder finder;
  ContactMemory memory;
  for (int i = 0; i < 60; ++i) {
    ++asked.queries;
    asked.covered += finder.sole.covers(e);
    const EllipsoidContacts found = findContacts(e, memory, *terrain, kept, finder);
    ContactFinder fresh;
    expectSameBits(found, findContacts(e, memory, *terrain, anew, fresh));
    ASSERT_EQ(finder.behind_any, fresh.behind_any);
    if (testing::Test::HasFatalFailure()) return;
    // As a step of four evaluations: the memory is that of the last accepted pose.
    if (i % 4 == 3) memory = rememberContacts(e, found, memory, kept, 1e-3);
    e = PosedEllipsoid(e.p_WE + ahead + bob * random.unitVector(),
                       AngleAxisd(turn * random.uniform(0.5, 1.0), axis).toRotationMatrix() * e.R_WE, e.radii);
  }
}

TEST(SoleContact, ChangesNoBitOfAnyAnswer) {
  RandomContactCases random(81);
  Asked asked;
  for (int i = 0; i < 6000 && !HasFatalFailure(); ++i) drive(random, i % 2 == 0, Vector3d::Zero(), asked);
  EXPECT_GT(asked.covered, asked.queries / 10) << "of " << asked.queries;
  EXPECT_LT(asked.covered, asked.queries);
}

TEST(SoleContact, ChangesNoBitFarFromTheOrigin) {
  RandomContactCases random(82);
  Asked asked;
  for (int i = 0; i < 500 && !HasFatalFailure(); ++i) drive(random, i % 2 == 0, Vector3d(1e6, -7e5, 3e5), asked);
  EXPECT_GT(asked.covered, asked.queries / 20) << "of " << asked.queries;
}

/// The pose `e` moved by `way` and turned about `axis`, both as far as the proof still covers and then back by a random
/// part, mostly a small one.
PosedEllipsoid atTheBorder(RandomContactCases& random, const SoleContact& sole, const PosedEllipsoid& e,
                           const Vector3d& way, const Vector3d& turn) {
  const auto gone = [&](double part) {
    const Vector3d rotation = part * turn;
    return PosedEllipsoid(e.p_WE + part * way,
                          AngleAxisd(rotation.norm(), rotation.stableNormalized()).toRotationMatrix() * e.R_WE,
                          e.radii);
  };
  double low = 0.0, high = 1.0;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (sole.covers(gone(middle)) ? low : high) = middle;
  }
  return gone(low * (1.0 - (random.index(3) == 0 ? random.uniform(0.0, 1.0) : random.logUniform(1e-9, 0.1))));
}

TEST(SoleContact, HoldsUpToItsBorder) {
  RandomContactCases random(83);
  ContactOptions kept, anew;
  kept.memory = anew.memory = anew.cache = false;
  int proofs = 0, poses = 0;
  for (int scene = 0; scene < 30000; ++scene) {
    const auto terrain = terrainOf(anyGround(random));
    PosedEllipsoid e({random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), 0.3}, random.rotation(), anyRadii(random));
    // Up to where proofs end, and that is twice the rim's radius of curvature.
    const double rim = std::pow(e.radii.minCoeff(), 2) / e.radii.maxCoeff();
    e = settled(e, *terrain,
                random.index(2) == 0 ? random.uniform(0.5, 1.8) * rim : random.logUniform(1e-4, 1.0) * rim);
    const Vector3d way = random.index(4) == 0 ? Vector3d::Zero() : Vector3d(1e-3 * random.unitVector());
    // Twice the same triangle, and it is proved to be alone, if it is.
    ContactFinder finder;
    ContactMemory memory;
    memory.fresh = false;
    memory.posed = PosedEllipsoid(e.p_WE - way, e.R_WE, e.radii);
    for (int i = 0; i < 6 && !finder.sole.covers(e); ++i) findContacts(e, memory, *terrain, kept, finder);
    if (!finder.sole.covers(e) || finder.sole.candidate() == SoleContact::kNone) continue;
    ++proofs;
    const int winner = finder.cache.candidates()[static_cast<std::size_t>(finder.sole.candidate())].index;
    for (int i = 0; i < 12; ++i) {
      // Along the level, where other triangles are, and every other way; on, and back; turning alone, and with it.
      Vector3d to = random.unitVector();
      const Vector3d on = way.stableNormalized() + 0.03 * random.unitVector();
      if (i % 6 == 0) to.z() *= 0.01;
      if (i % 6 == 1) to = on;
      if (i % 6 == 2) to = -on;
      if (i % 6 == 3) to.setZero();
      const Vector3d turn = i % 6 < 3 ? Vector3d::Zero() : Vector3d(random.logUniform(1e-2, 1.0) * random.unitVector());
      const PosedEllipsoid there = atTheBorder(random, finder.sole, e, 0.5 * to, turn);
      const TriangleContact contact = minimumTranslation(there, terrain->triangle(winner));
      // Of other contacts of the triangle nothing is claimed.
      if (contact.feature != Feature::kFace || contact.depth > finder.sole.deepest()) continue;
      ++poses;
      ContactFinder fresh;
      const EllipsoidContacts found = findContacts(there, {}, *terrain, anew, fresh);
      ASSERT_EQ(found.count, 1) << "scene " << scene << ", pose " << i;
      ASSERT_EQ(found.contact[0].triangle, winner) << "scene " << scene << ", pose " << i;
      ASSERT_EQ(found.contact[0].depth, contact.depth);
      ASSERT_FALSE(fresh.behind_any) << "scene " << scene << ", pose " << i;
    }
  }
  EXPECT_GT(proofs, 10000);
  EXPECT_GT(poses, 50000);
}

TEST(SoleContact, KnowsThatNothingIsNearUntilItIs) {
  const auto terrain = terrainOf(floorSoup(5.0, 2));
  ContactOptions kept, anew;
  kept.memory = anew.memory = anew.cache = false;
  ContactFinder finder;
  int covered = 0, touching = 0;
  for (double z = 3.0; z > 0.3; z -= 0.003) {
    const PosedEllipsoid e({0.3, 0.9, z}, Matrix3d::Identity(), {0.35, 0.12, 0.35});
    covered += finder.sole.covers(e);
    ContactFinder fresh;
    const EllipsoidContacts found = findContacts(e, {}, *terrain, kept, finder);
    expectSameBits(found, findContacts(e, {}, *terrain, anew, fresh));
    touching += found.count;
  }
  EXPECT_GT(covered, 300);
  EXPECT_GT(touching, 10);
}

TEST(SoleContact, CoversNoPoseThatIsNotANumber) {
  const auto terrain = terrainOf(floorSoup(5.0, 2));
  const PosedEllipsoid e({0.3, 0.9, 0.34}, Matrix3d::Identity(), {0.35, 0.12, 0.35});
  ContactOptions options;
  options.memory = false;
  ContactFinder finder;
  EXPECT_FALSE(finder.sole.covers(e));
  for (int i = 0; i < 6; ++i) findContacts(e, {}, *terrain, options, finder);
  ASSERT_TRUE(finder.sole.covers(e));
  PosedEllipsoid lost = e;
  lost.p_WE.y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(finder.sole.covers(lost));
  lost = e;
  lost.A(0, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(finder.sole.covers(lost));
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
