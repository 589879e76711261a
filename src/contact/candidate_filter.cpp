#include "ellipsoid_vehicle_sim/contact/candidate_filter.h"

#include <cmath>
#include <cstring>
#include <limits>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace ellipsoid_vehicle_sim {
namespace {

// Relative tolerance above all rounding in a lane's arithmetic, of the depth and of the lengths that enter [-].
constexpr double kDepthMargin = 1e-11, kLengthMargin = 1e-14;
// T0 counts as outside an edge by ten times what the face test forgives [-].
constexpr double kOutsideMargin = 1e-9;
// Relative tolerance of the horizon test, above what a corner a kilometre away costs the height [-].
constexpr double kHorizonMargin = 1e-9;
// q.n of the direction that clears a triangle, above the rounding of m.n = 0 [-].
constexpr double kForwardMargin = 1e-9;
// Taken off everything that has to stay positive while an ellipsoid travels [m].
constexpr double kTravelMargin = 1e-9;
// Keeps a quotient a number where nothing falls [m/m].
constexpr double kLeastSpeed = 1e-9;
// The slight tilt, in parts of the best one [-].
constexpr double kSlightTilt = 0.125;
// Least height over a plane, in parts of h: bounds what a change of A costs [-].
constexpr double kLeastHeight = 0.5;
// A corner this far above a plane counts as above [m]: far below any contact's sag.
constexpr double kAbove = 1e-9;

// The lanes of a register, in the compilers' vector extension: the same operations in the same order on every machine,
// so the same bits whatever its width. x86 machines with wider registers get code of their own, chosen when the program
// runs; nothing else is compiled for them.
namespace plain {
#define EVS_LANES 2
#include "candidate_filter_lanes.h"
#undef EVS_LANES
}  // namespace plain

#if defined(__x86_64__)
#pragma GCC push_options
#pragma GCC target("avx2")
namespace avx2 {
#define EVS_LANES 4
#include "candidate_filter_lanes.h"
#undef EVS_LANES
}  // namespace avx2
#pragma GCC pop_options

#pragma GCC push_options
#pragma GCC target("avx512f,avx512dq,avx512vl")
namespace avx512 {
#define EVS_LANES 8
#include "candidate_filter_lanes.h"
#undef EVS_LANES
}  // namespace avx512
#pragma GCC pop_options
#endif

struct Kernels {
  void (*fill)(CandidateBlock&, int);
  void (*planes)(const CandidateBlock&, const FilterEllipsoid&, double, PlaneTest&);
  void (*pushes)(const CandidateBlock&, const PlaneTest&, std::uint32_t, const FilterEllipsoid&, const KnownPush&,
                 double, PushTest&, LaneTravel*);
  std::uint32_t (*overs)(const CandidateBlock&, const Vec3&);
};

Kernels kernelsFor(FilterLanes lanes) {
#if defined(__x86_64__)
  if (lanes == FilterLanes::kEight) return {avx512::fill, avx512::planes, avx512::pushes, avx512::overs};
  if (lanes == FilterLanes::kFour) return {avx2::fill, avx2::planes, avx2::pushes, avx2::overs};
#endif
  return {plain::fill, plain::planes, plain::pushes, plain::overs};
}

const Kernels kBest = kernelsFor(widestFilterLanes());

}  // namespace

FilterLanes widestFilterLanes() {
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
    return FilterLanes::kEight;
  if (__builtin_cpu_supports("avx2")) return FilterLanes::kFour;
#endif
  return FilterLanes::kTwo;
}

void fillBlock(CandidateBlock& block, int used) { kBest.fill(block, used); }
void fillBlock(FilterLanes lanes, CandidateBlock& block, int used) { kernelsFor(lanes).fill(block, used); }

void testPlanes(const CandidateBlock& block, const FilterEllipsoid& ellipsoid, double slack, PlaneTest& result) {
  kBest.planes(block, ellipsoid, slack, result);
}
void testPlanes(FilterLanes lanes, const CandidateBlock& block, const FilterEllipsoid& ellipsoid, double slack,
                PlaneTest& result) {
  kernelsFor(lanes).planes(block, ellipsoid, slack, result);
}

void testPush(const CandidateBlock& block, const PlaneTest& plane, std::uint32_t wanted,
              const FilterEllipsoid& ellipsoid, const KnownPush& push, double slack, PushTest& result,
              LaneTravel* travel) {
  kBest.pushes(block, plane, wanted, ellipsoid, push, slack, result, travel);
}
void testPush(FilterLanes lanes, const CandidateBlock& block, const PlaneTest& plane, std::uint32_t wanted,
              const FilterEllipsoid& ellipsoid, const KnownPush& push, double slack, PushTest& result,
              LaneTravel* travel) {
  kernelsFor(lanes).pushes(block, plane, wanted, ellipsoid, push, slack, result, travel);
}

std::uint32_t lanesBelow(const CandidateBlock& block, const Vec3& c) { return kBest.overs(block, c); }
std::uint32_t lanesBelow(FilterLanes lanes, const CandidateBlock& block, const Vec3& c) {
  return kernelsFor(lanes).overs(block, c);
}

}  // namespace ellipsoid_vehicle_sim
