// What the filter says of whole blocks, against the definition triangle by triangle.
#include "ellipsoid_vehicle_sim/contact/candidate_filter.h"

#include <gtest/gtest.h>

#include <cstring>
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
  int near = 0, shallower = 0, cleared = 0;
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
      PosedEllipsoid after = e;
      after.p_WE += known.depth * known.nhat_W;
      PushTest test;
      testPush(cache.blocks()[b], planes, planes.near, filter, push, 1e-9, test);
      for (int lane = 0; lane < CandidateBlock::kWidth; ++lane) {
        if ((planes.near >> lane & 1u) == 0) continue;
        const std::size_t i = b * CandidateBlock::kWidth + static_cast<std::size_t>(lane);
        const double depth = contacts[i].depth;
        const double left = minimumTranslation(after, candidates[i].triangle).depth;
        if ((test.shallower >> lane & 1u) != 0) {
          ++tally.shallower;
          ASSERT_LT(depth, known.depth * (1.0 - 1e-12));
        }
        if ((test.cleared >> lane & 1u) != 0) {
          ++tally.cleared;
          ASSERT_EQ(left, 0.0) << "cleared by " << known.depth << " m";
        }
        if ((test.deep >> lane & 1u) == 0) {
          ASSERT_LT(depth, known.depth);
        }
        if ((test.deep_after >> lane & 1u) == 0) {
          ASSERT_EQ(left, 0.0);
        }
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
  EXPECT_GT(tally.shallower, 10000);
  EXPECT_GT(tally.cleared, 10000);
}

TEST(CandidateFilter, LeavesLittleToWorkOutBesideAWheelOnRollingGround) {
  // What it is for: a wheel centimetres deep in ground of gentle bends, the deepest contact known.
  RandomContactCases random(64);
  int others = 0, shallower = 0, cleared = 0;
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
      PushTest test;
      testPush(cache.blocks()[b], planes, planes.near, filter, push, 1e-9, test);
      for (int lane = 0; lane < CandidateBlock::kWidth; ++lane) {
        if ((planes.near >> lane & 1u) == 0 || b * CandidateBlock::kWidth + static_cast<std::size_t>(lane) == winner)
          continue;
        ++others;
        shallower += test.shallower >> lane & 1u;
        cleared += test.cleared >> lane & 1u;
      }
    }
  }
  ASSERT_GT(others, 500);
  EXPECT_GT(shallower, 0.9 * others) << shallower << " of " << others;
  EXPECT_GT(cleared, 0.8 * others) << cleared << " of " << others;
}

TEST(CandidateFilter, ClearsNoTriangleThatIsAsDeepFarFromTheOrigin) {
  RandomContactCases random(62);
  Tally tally;
  // A million metres away a corner has 1e-10 m of rounding of its own, which all sides share.
  for (int i = 0; i < 500; ++i) compare(random, Vector3d(1e6, -7e5, 3e5), tally);
  EXPECT_GT(tally.shallower, 0);
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
      PushTest pushed;
      LaneTravel travel;
      travel.direction = Vec3::from(random.unitVector());
      testPush(FilterLanes::kTwo, block, reference, 0xffu, filter, push, 1e-9, pushed, &travel);
      const std::uint32_t below = lanesBelow(FilterLanes::kTwo, block, filter.c);
      for (int lane = 0; lane < CandidateBlock::kWidth; ++lane) {
        double highest = -std::numeric_limits<double>::infinity();
        for (int k = 0; k < 3; ++k)
          highest =
              std::max(highest, u.dot(Vector3d(block.v[k][0][lane], block.v[k][1][lane], block.v[k][2][lane]) - p));
        if (std::abs(highest - 1e-9) < 1e-12) continue;  // within rounding
        ASSERT_EQ(pushed.rises >> lane & 1u, highest > 1e-9 ? 1u : 0u);
      }
      for (const FilterLanes lanes : {FilterLanes::kFour, FilterLanes::kEight}) {
        if (lanes > widest) continue;
        PlaneTest planes;
        testPlanes(lanes, block, filter, 1e-9, planes);
        ASSERT_EQ(planes.near, reference.near);
        ASSERT_EQ(planes.behind, reference.behind);
        PushTest same;
        LaneTravel same_travel = travel;
        testPush(lanes, block, reference, 0xffu, filter, push, 1e-9, same, &same_travel);
        ASSERT_EQ(std::memcmp(same_travel.travel, travel.travel, sizeof travel.travel), 0);
        ASSERT_EQ(std::memcmp(&same, &pushed, sizeof same), 0);
        ASSERT_EQ(lanesBelow(lanes, block, filter.c), below);
        for (int lane = 0; lane < CandidateBlock::kWidth; ++lane) {
          ASSERT_EQ(planes.height[lane], reference.height[lane]);
          ASSERT_EQ(planes.half_width_squared[lane], reference.half_width_squared[lane]);
        }
      }
    }
  }
}

TEST(CandidateFilter, BlocksHoldWhatTheTrianglesAre) {
  RandomContactCases random(65);
  for (int i = 0; i < 2000; ++i) {
    const int used = 1 + i % CandidateBlock::kWidth;
    std::vector<Triangle> triangles;
    CandidateBlock corners;
    // Whatever stands in the lanes that are not used must not show.
    std::memset(&corners, 0xff, sizeof corners);
    for (int lane = 0; lane < used; ++lane) {
      triangles.push_back(random.triangle(1e-6));
      corners.index[lane] = lane;
      for (int k = 0; k < 3; ++k)
        for (int axis = 0; axis < 3; ++axis)
          corners.v[k][axis][lane] = triangles.back().v[static_cast<std::size_t>(k)][axis];
    }
    CandidateBlock reference = corners;
    fillBlock(FilterLanes::kTwo, reference, used);
    for (int lane = 0; lane < used; ++lane) {
      const Triangle& t = triangles[static_cast<std::size_t>(lane)];
      const Triangle made = makeTriangle(t.v[0], t.v[1], t.v[2]);
      for (int axis = 0; axis < 3; ++axis) {
        ASSERT_EQ(reference.nhat[axis][lane], made.nhat_W[axis]);
        ASSERT_EQ(reference.low[axis][lane], std::min({t.v[0][axis], t.v[1][axis], t.v[2][axis]}));
        ASSERT_EQ(reference.high[axis][lane], std::max({t.v[0][axis], t.v[1][axis], t.v[2][axis]}));
      }
      ASSERT_EQ(reference.size[lane], std::sqrt(longestEdgeSquared(t.v)));
      for (std::size_t k = 0; k < 3; ++k) {
        const Vector3d m = (t.v[(k + 1) % 3] - t.v[k]).cross(made.nhat_W).normalized();
        for (int axis = 0; axis < 3; ++axis) ASSERT_NEAR(reference.edge[k][axis][lane], m[axis], 1e-9);
      }
    }
    for (int lane = used; lane < CandidateBlock::kWidth; ++lane) {
      for (int axis = 0; axis < 3; ++axis) {
        ASSERT_GT(reference.low[axis][lane], reference.high[axis][lane]);
        ASSERT_EQ(reference.nhat[axis][lane], reference.nhat[axis][0]);
        for (int k = 0; k < 3; ++k) ASSERT_EQ(reference.v[k][axis][lane], reference.v[k][axis][0]);
      }
    }
    for (const FilterLanes lanes : {FilterLanes::kFour, FilterLanes::kEight}) {
      if (lanes > widestFilterLanes()) continue;
      CandidateBlock same = corners;
      fillBlock(lanes, same, used);
      ASSERT_EQ(std::memcmp(same.v, reference.v, sizeof same.v), 0);
      ASSERT_EQ(std::memcmp(same.low, reference.low, sizeof same.low), 0);
      ASSERT_EQ(std::memcmp(same.high, reference.high, sizeof same.high), 0);
      ASSERT_EQ(std::memcmp(same.nhat, reference.nhat, sizeof same.nhat), 0);
      ASSERT_EQ(std::memcmp(same.edge, reference.edge, sizeof same.edge), 0);
      ASSERT_EQ(std::memcmp(same.size, reference.size, sizeof same.size), 0);
    }
  }
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
