#include "ellipsoid_vehicle_sim/contact/candidate_cache.h"

#include <gtest/gtest.h>

#include <set>

#include "support/contact_scenes.h"
#include "support/random_contact_cases.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Vector3d;

/// Rolling ground, 40 m square, cells of half a metre.
TriangleSoup hills() {
  TriangleSoup soup = floorSoup(20.0, 80);
  for (Vector3d& v : soup.vertices) v.z() = 0.15 * std::sin(0.9 * v.x()) * std::cos(0.7 * v.y());
  return soup;
}

TEST(CandidateCache, HoldsAtLeastTheTrianglesOfTheBoxInTheirOrder) {
  const auto terrain = terrainOf(hills());
  RandomContactCases random(51);
  CandidateCache cache;
  Vector3d p(0, 0, 0);
  for (int i = 0; i < 3000; ++i) {
    // Steps of millimetres to decimetres, now and then a jump to anywhere.
    p = i % 97 == 0 ? Vector3d(random.uniform(-19, 19), random.uniform(-19, 19), 0.2)
                    : Vector3d(p + random.logUniform(1e-4, 0.2) * random.unitVector());
    const Vector3d half(0.35, random.uniform(0.12, 0.35), 0.35), low = p - half, high = p + half;
    const Vector3d travel = random.logUniform(1e-4, 100.0) * random.unitVector();
    const std::vector<Candidate>& found = cache.around(low, high, travel, *terrain, true);
    std::set<int> indices;
    for (std::size_t j = 0; j < found.size(); ++j) {
      indices.insert(found[j].index);
      if (j == 0) continue;
      EXPECT_LT(found[j - 1].index, found[j].index);
    }
    std::vector<int> needed;
    terrain->query(Eigen::AlignedBox3d(low, high), needed);
    for (const int index : needed) EXPECT_EQ(indices.count(index), 1u) << "step " << i;
  }
}

TEST(CandidateCache, WithoutReuseHoldsExactlyTheTrianglesOfTheBox) {
  const auto terrain = terrainOf(hills());
  RandomContactCases random(52);
  CandidateCache cache;
  for (int i = 0; i < 300; ++i) {
    const Vector3d p(random.uniform(-19, 19), random.uniform(-19, 19), random.uniform(-0.3, 0.3));
    const Vector3d half = Vector3d::Constant(0.35);
    std::vector<int> needed;
    terrain->query(Eigen::AlignedBox3d(p - half, p + half), needed);
    EXPECT_EQ(cache.around(p - half, p + half, Vector3d::UnitX(), *terrain, false).size(), needed.size());
  }
}

TEST(CandidateCache, ChangesNoBitOfALongDriveWithTeleports) {
  const auto terrain = terrainOf(hills());
  for (const ContactsPerEllipsoid contacts : {ContactsPerEllipsoid::kOne, ContactsPerEllipsoid::kValley}) {
    SimConfig with;
    with.contacts_per_ellipsoid = contacts;
    SimConfig without = with;
    with.candidate_cache = true;
    without.candidate_cache = false;
    Simulator cached = make(car(), terrain, with), fresh = make(car(), terrain, without);
    RandomContactCases random(53);
    for (int leg = 0; leg < 8; ++leg) {
      // Off it goes from anywhere, also from the air and from within the ground.
      Pose start;
      start.p = {random.uniform(-8, 8), random.uniform(-8, 8), random.uniform(0.2, 1.0)};
      start.q = Eigen::AngleAxisd(random.uniform(-3, 3), Vector3d::UnitZ());
      for (Simulator* s : {&cached, &fresh}) {
        if (leg % 2 == 0) {
          ASSERT_TRUE(s->place(start, Vector3d(1.0, 0.0, 0.0), Vector3d::Zero()).empty());
        } else {
          s->reset();
        }
      }
      const double speed = random.uniform(-3.0, 8.0), yaw_rate = random.uniform(-0.5, 0.5);
      for (int i = 0; i < 1500; ++i) {
        for (Simulator* s : {&cached, &fresh}) {
          s->command({DriveCommand::Kind::kTwist, speed, yaw_rate, 0.0});
          s->step();
        }
        ASSERT_EQ(cached.stateHash(), fresh.stateHash()) << "leg " << leg << ", step " << i;
      }
    }
  }
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
