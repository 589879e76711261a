// What the filter says of whole blocks, against the definition triangle by triangle.
#include "ellipsoid_vehicle_sim/contact/candidate_filter.h"

#include <gtest/gtest.h>

#include <limits>

#include "support/contact_scenes.h"
#include "support/random_contact_cases.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Vector3d;

FilterEllipsoid filterOf(const PosedEllipsoid& e) {
  const Vec3 r = Vec3::from(e.radii);
  return {Vec3::from(e.p_WE), columns(e.R_WE), r, {1 / r.x, 1 / r.y, 1 / r.z}, Vec3::from(e.halfBox())};
}

/// Ground of bends and creases around the origin, its cells from a tenth to three ellipsoids wide.
TriangleSoup crumpled(RandomContactCases& random, const Vector3d& offset) {
  TriangleSoup soup = floorSoup(3.0, 6);
  const double roughness = random.logUniform(1e-6, 0.6), scale = random.logUniform(0.1, 3.0);
  for (Vector3d& v : soup.vertices) {
    v *= scale;
    v.z() += roughness * scale * random.uniform(-1.0, 1.0);
    v += offset;
  }
  return soup;
}

PosedEllipsoid randomEllipsoid(RandomContactCases& random, const Vector3d& offset) {
  const double r = random.logUniform(0.2, 1.0);
  const Vector3d radii(r, r * random.logUniform(0.05, 1.0), r * random.logUniform(0.05, 1.0));
  const Vector3d p(random.uniform(-0.6, 0.6), random.uniform(-0.6, 0.6), random.uniform(-0.2, 1.0));
  return PosedEllipsoid(p + offset, random.rotation(), radii);
}

struct Tally {
  int near = 0, cleared = 0;
};

/// One scene: every lane near is compared, with a push that is the contact of one of them.
void compare(RandomContactCases& random, const Vector3d& offset, Tally& tally) {
  const auto terrain = terrainOf(crumpled(random, offset));
  const PosedEllipsoid e = randomEllipsoid(random, offset);
  const FilterEllipsoid filter = filterOf(e);
  CandidateCache cache;
  const Vector3d half = e.halfBox();
  const std::vector<Candidate>& candidates =
      cache.around(e.p_WE - half, e.p_WE + half, Vector3d::Zero(), *terrain, true);

  std::vector<TriangleContact> contacts;
  for (const Candidate& candidate : candidates) contacts.push_back(minimumTranslation(e, candidate.triangle));
  for (std::size_t b = 0; b < cache.blocks().size(); ++b) {
    PlaneTest planes;
    testPlanes(cache.blocks()[b], filter, 1e-9, planes);
    for (int lane = 0; lane < CandidateBlock::kWidth; ++lane) {
      const std::size_t i = b * CandidateBlock::kWidth + static_cast<std::size_t>(lane);
      if ((planes.near >> lane & 1u) != 0) {
        ++tally.near;
        ASSERT_LT(i, candidates.size());
      } else if (i < candidates.size() && contacts[i].feature == Feature::kFace &&
                 contacts[i].depth < 2.0 * std::pow(e.radii.minCoeff(), 2) / e.radii.maxCoeff()) {
        // Its point lies in the triangle and, up to that depth, in the ellipsoid, so their boxes meet.
        ADD_FAILURE() << "a face contact was filtered out";
      }
    }
    for (const TriangleContact& known : contacts) {
      if (!known) continue;
      const KnownPush push{Vec3::from(known.nhat_W), Vec3::from(known.trianglePoint()), e.halfWidth(known.nhat_W),
                           known.depth};
      const std::uint32_t clear = testPush(cache.blocks()[b], planes.near, filter, push);
      for (int lane = 0; lane < CandidateBlock::kWidth; ++lane) {
        if ((planes.near >> lane & 1u) == 0) continue;
        const TriangleContact& other = contacts[b * CandidateBlock::kWidth + static_cast<std::size_t>(lane)];
        const bool shallower = other.depth < known.depth * (1.0 - 1e-12);
        if ((clear >> lane & 1u) == 0) continue;
        ++tally.cleared;
        ASSERT_TRUE(shallower) << "cleared at " << known.depth << " m, but it is " << other.depth << " m deep";
      }
    }
  }
}

TEST(CandidateFilter, ClearsNoTriangleThatIsAsDeep) {
  RandomContactCases random(61);
  Tally tally;
  for (int i = 0; i < 4000; ++i) compare(random, Vector3d::Zero(), tally);
  // Enough of both that a wrong proof would show.
  EXPECT_GT(tally.near, 10000);
  EXPECT_GT(tally.cleared, 10000);
}

TEST(CandidateFilter, LeavesLittleToWorkOutBesideAWheelOnRollingGround) {
  // What it is for: a wheel centimetres deep in ground of gentle bends, the deepest contact known.
  RandomContactCases random(64);
  int others = 0, cleared = 0;
  for (int i = 0; i < 500; ++i) {
    TriangleSoup soup = floorSoup(3.0, 12);
    for (Vector3d& v : soup.vertices) v.z() = 0.03 * random.uniform(-1.0, 1.0);
    const auto terrain = terrainOf(std::move(soup));
    const Eigen::Matrix3d R = Eigen::AngleAxisd(random.uniform(-3.0, 3.0), Vector3d::UnitZ()).toRotationMatrix();
    const PosedEllipsoid e(Vector3d(random.uniform(-2, 2), random.uniform(-2, 2), 0.34), R, random.wheelRadii());
    CandidateCache cache;
    const Vector3d half = e.halfBox();
    const auto& candidates = cache.around(e.p_WE - half, e.p_WE + half, Vector3d::Zero(), *terrain, true);
    TriangleContact deepest;
    std::size_t winner = 0;
    for (std::size_t j = 0; j < candidates.size(); ++j) {
      const TriangleContact contact = minimumTranslation(e, candidates[j].triangle);
      if (contact.depth > deepest.depth) deepest = contact, winner = j;
    }
    if (!deepest) continue;
    const FilterEllipsoid filter = filterOf(e);
    const KnownPush push{Vec3::from(deepest.nhat_W), Vec3::from(deepest.trianglePoint()), e.halfWidth(deepest.nhat_W),
                         deepest.depth};
    for (std::size_t b = 0; b < cache.blocks().size(); ++b) {
      PlaneTest planes;
      testPlanes(cache.blocks()[b], filter, 1e-9, planes);
      const std::uint32_t clear = testPush(cache.blocks()[b], planes.near, filter, push);
      for (int lane = 0; lane < CandidateBlock::kWidth; ++lane) {
        if ((planes.near >> lane & 1u) == 0 || b * CandidateBlock::kWidth + static_cast<std::size_t>(lane) == winner)
          continue;
        ++others;
        cleared += clear >> lane & 1u;
      }
    }
  }
  ASSERT_GT(others, 500);
  EXPECT_GT(cleared, 0.9 * others) << cleared << " of " << others;
}

TEST(CandidateFilter, ClearsNoTriangleThatIsAsDeepFarFromTheOrigin) {
  RandomContactCases random(62);
  Tally tally;
  // A million metres away a corner has 1e-10 m of rounding of its own, which all sides share.
  for (int i = 0; i < 500; ++i) compare(random, Vector3d(1e6, -7e5, 3e5), tally);
  EXPECT_GT(tally.cleared, 0);
}

TEST(CandidateFilter, EveryWidthGivesTheSameBits) {
  RandomContactCases random(63);
  const FilterLanes widest = widestFilterLanes();
  for (int i = 0; i < 300; ++i) {
    const auto terrain = terrainOf(crumpled(random, Vector3d::Zero()));
    const PosedEllipsoid e = randomEllipsoid(random, Vector3d::Zero());
    const FilterEllipsoid filter = filterOf(e);
    CandidateCache cache;
    const Vector3d half = e.halfBox();
    cache.around(e.p_WE - half, e.p_WE + half, Vector3d::Zero(), *terrain, true);
    const Vector3d u = random.unitVector(), p = e.p_WE - 0.5 * half;
    const KnownPush push{Vec3::from(u), Vec3::from(p), e.halfWidth(u), random.logUniform(1e-4, 1.0)};
    for (const CandidateBlock& block : cache.blocks()) {
      PlaneTest reference;
      testPlanes(FilterLanes::kTwo, block, filter, 1e-9, reference);
      const std::uint32_t cleared = testPush(FilterLanes::kTwo, block, 0xffu, filter, push);
      const std::uint32_t rises = testRise(FilterLanes::kTwo, block, 0xffu, filter, push);
      for (int lane = 0; lane < CandidateBlock::kWidth; ++lane) {
        double highest = -std::numeric_limits<double>::infinity();
        for (int k = 0; k < 3; ++k)
          highest = std::max(highest, u.dot(Vector3d(block.v[k][0][lane], block.v[k][1][lane], block.v[k][2][lane]) - p));
        if (std::abs(highest - 1e-9) < 1e-12) continue;  // within rounding
        ASSERT_EQ(rises >> lane & 1u, highest > 1e-9 ? 1u : 0u);
      }
      for (const FilterLanes lanes : {FilterLanes::kFour, FilterLanes::kEight}) {
        if (lanes > widest) continue;
        PlaneTest planes;
        testPlanes(lanes, block, filter, 1e-9, planes);
        ASSERT_EQ(planes.near, reference.near);
        ASSERT_EQ(planes.behind, reference.behind);
        ASSERT_EQ(testPush(lanes, block, 0xffu, filter, push), cleared);
        ASSERT_EQ(testRise(lanes, block, 0xffu, filter, push), rises);
        for (int lane = 0; lane < CandidateBlock::kWidth; ++lane) {
          ASSERT_EQ(planes.height[lane], reference.height[lane]);
          ASSERT_EQ(planes.half_width_squared[lane], reference.half_width_squared[lane]);
        }
      }
    }
  }
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
