#pragma once

#include <cstdint>

#include "ellipsoid_vehicle_sim/contact/candidate_cache.h"
#include "ellipsoid_vehicle_sim/geometry/small_vector.h"

namespace ellipsoid_vehicle_sim {

/// An ellipsoid as the tests of whole blocks need it. Everything along W's axes, in [m].
struct FilterEllipsoid {
  Vec3 c;       ///< centre.
  Frame3 axes;  ///< its axes.
  Vec3 radii, inverse_radii;
  Vec3 half_box;
};

/// Rule 2 for the lanes of a block, to within `slack` [m]: a bit is set where the boxes meet and the plane is reached
/// with the centre in front of it.
struct PlaneTest {
  std::uint32_t near;                                             ///< the ellipsoid may touch the triangle.
  std::uint32_t behind;                                           ///< the boxes meet, and the centre is not in front.
  alignas(64) double height[CandidateBlock::kWidth];              ///< s of every lane [m].
  alignas(64) double half_width_squared[CandidateBlock::kWidth];  ///< h(n)^2 of every lane [m^2].
  alignas(64) double n_E[3][CandidateBlock::kWidth];              ///< n along the ellipsoid's axes, of every lane.
};

/// A push that is known, to hold others against: along u, which brings the ellipsoid's lowest point to `p`.
struct KnownPush {
  Vec3 u;             ///< unit.
  Vec3 p;             ///< the triangle point T of that contact [m].
  double half_width;  ///< h(u) [m].
  double depth;       ///< how far it goes, and what a contact has to exceed to be of interest, >= 0 [m].
};

/// What a known push tells of a block's triangles, a bit for each lane; of lanes that were not wanted it may say
/// anything.
struct PushTest {
  std::uint32_t deep;        ///< the lowest point lies deeper below the plane than push.depth - slack.
  std::uint32_t deep_after;  ///< after the push it lies deeper than -slack.
  std::uint32_t shallower;   ///< proved: `minimumTranslation` is less deep than push.depth by more than rounding, or 0.
  std::uint32_t cleared;     ///< proved: after the push it is 0.
  std::uint32_t rises;       ///< a corner stands more than a nanometre above the plane through p square to u.
};

/// How far an ellipsoid may go before a lane of a block may have a say beside a face contact. Going by N [m] is a way
/// of up to N along `direction`, up to kTravelWidth N backwards and up to kTravelWidth N across, while A changes by up
/// to r_min^2 / 20 (Frobenius), and costs kTravelPerChange r_max |A' - A| / r_min^2 more. A turn changes A; a wheel's
/// spin does not.
struct LaneTravel {
  Vec3 direction;                                     ///< unit, or 0.
  alignas(64) double travel[CandidateBlock::kWidth];  ///< for every lane [m]; below 0 where it may have a say already.
};
constexpr double kTravelWidth = 0.125, kTravelPerChange = 12.0;

/// Lanes of a register: what the kernels are compiled for.
enum class FilterLanes { kTwo, kFour, kEight };
/// The widest that this machine has.
FilterLanes widestFilterLanes();

/// Works out all of a block from the corners and indices of its first `used` lanes, and sets the others.
void fillBlock(CandidateBlock& block, int used);
void testPlanes(const CandidateBlock& block, const FilterEllipsoid& ellipsoid, double slack, PlaneTest& result);
/// The lanes in `wanted`, all of them near by `plane`, held against a push. The proofs are that of `cannotExceed`
/// (ellipsoid_triangle.h) with a direction of the lane's own: u tilted outwards over the edge of the triangle that p is
/// furthest beyond. On flat ground this shows every triangle but the one below to be shallower, with nothing solved.
/// For `travel` the push is that of a face contact: it keeps its direction while the ellipsoid moves, and every proof
/// is a number that has to stay positive. Of those in use each is linear in the way, or bounded by the change of A.
void testPush(const CandidateBlock& block, const PlaneTest& plane, std::uint32_t wanted,
              const FilterEllipsoid& ellipsoid, const KnownPush& push, double slack, PushTest& result,
              LaneTravel* travel = nullptr);
/// The lanes whose triangle c lies straight above or below, seen along its normal.
std::uint32_t lanesBelow(const CandidateBlock& block, const Vec3& c);
/// The same by kernels of a given width, to show that all give the same bits; the machine must have it.
void fillBlock(FilterLanes lanes, CandidateBlock& block, int used);
void testPlanes(FilterLanes lanes, const CandidateBlock& block, const FilterEllipsoid& ellipsoid, double slack,
                PlaneTest& result);
void testPush(FilterLanes lanes, const CandidateBlock& block, const PlaneTest& plane, std::uint32_t wanted,
              const FilterEllipsoid& ellipsoid, const KnownPush& push, double slack, PushTest& result,
              LaneTravel* travel = nullptr);
std::uint32_t lanesBelow(FilterLanes lanes, const CandidateBlock& block, const Vec3& c);

}  // namespace ellipsoid_vehicle_sim
