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
};

/// A push that is known, to hold others against: along u, which brings the ellipsoid's lowest point to `p`.
struct KnownPush {
  Vec3 u;             ///< unit.
  Vec3 p;             ///< the triangle point T of that contact [m].
  double half_width;  ///< h(u) [m].
  double depth;       ///< what a contact has to exceed to be of interest, >= 0 [m].
};

/// Lanes of a register: what the kernels are compiled for.
enum class FilterLanes { kTwo, kFour, kEight };
/// The widest that this machine has.
FilterLanes widestFilterLanes();

void testPlanes(const CandidateBlock& block, const FilterEllipsoid& ellipsoid, double slack, PlaneTest& result);
/// Of the lanes in `wanted`, those proved to be of no interest: the depth of `minimumTranslation` with such a triangle is
/// less than `push.depth` by more than rounding, or not above zero. The proof is that of `cannotExceed`
/// (ellipsoid_triangle.h) with a direction of the lane's own: u tilted outwards over the edge of the triangle that the
/// lowest point T0 has left. On flat ground this shows every triangle but the one below to be shallower, with nothing
/// solved.
std::uint32_t testPush(const CandidateBlock& block, std::uint32_t wanted, const FilterEllipsoid& ellipsoid,
                       const KnownPush& push);
/// Of the lanes in `wanted`, those with some corner more than a nanometre above the plane through p square to u. The
/// push clears all others.
std::uint32_t testRise(const CandidateBlock& block, std::uint32_t wanted, const FilterEllipsoid& ellipsoid,
                       const KnownPush& push);
/// The same by kernels of a given width, to show that all give the same bits; the machine must have it.
void testPlanes(FilterLanes lanes, const CandidateBlock& block, const FilterEllipsoid& ellipsoid, double slack,
                PlaneTest& result);
std::uint32_t testPush(FilterLanes lanes, const CandidateBlock& block, std::uint32_t wanted,
                       const FilterEllipsoid& ellipsoid, const KnownPush& push);
std::uint32_t testRise(FilterLanes lanes, const CandidateBlock& block, std::uint32_t wanted,
                       const FilterEllipsoid& ellipsoid, const KnownPush& push);

}  // namespace ellipsoid_vehicle_sim
