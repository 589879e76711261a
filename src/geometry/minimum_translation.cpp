#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include "ellipsoid_vehicle_sim/geometry/ellipsoid_triangle.h"
#include "ellipsoid_vehicle_sim/geometry/ellipsoid_triangle_kernels.h"
#include "ellipsoid_vehicle_sim/geometry/plane_contact.h"
#include "ellipsoid_vehicle_sim/geometry/small_vector.h"
#include "feature_search.h"

namespace ellipsoid_vehicle_sim {
namespace {

/// Number by number: who reads a pair that was written as a pair does not wait for it, and nor does who reads numbers.
inline TriangleContact contactAt(Feature feature, double depth, const Vec3& n, const Vec3& p) {
  TriangleContact result;
  result.feature = feature;
  result.depth = depth;
  result.nhat_W.x() = n.x, result.nhat_W.y() = n.y, result.nhat_W.z() = n.z;
  result.p_WE_lowest.x() = p.x, result.p_WE_lowest.y() = p.y, result.p_WE_lowest.z() = p.z;
  return result;
}

// Three corners or edges in a register, in the compilers' vector extension: the same operations in the same order on
// every machine, so the same bits. x86 machines with wider or more registers get code of their own, chosen when the
// program runs; nothing else is compiled for them.
using Lanes = double __attribute__((vector_size(32)));
using LaneMask = std::int64_t __attribute__((vector_size(32)));

#define EVS_CORNERS_IN_ONE 0
namespace plain {
#include "corner_lanes.h"
#include "ordinary_contact.h"
}  // namespace plain

#if defined(__x86_64__)
#undef EVS_CORNERS_IN_ONE
#define EVS_CORNERS_IN_ONE 1
#pragma GCC push_options
#pragma GCC target("avx2")
namespace avx2 {
#include "corner_lanes.h"
#include "ordinary_contact.h"
}  // namespace avx2
#pragma GCC pop_options

#pragma GCC push_options
#pragma GCC target("avx512f,avx512dq,avx512vl")
namespace avx512 {
#include "corner_lanes.h"
#include "ordinary_contact.h"
}  // namespace avx512
#pragma GCC pop_options
#endif
#undef EVS_CORNERS_IN_ONE

using Kernel = TriangleContact (*)(const PosedEllipsoid&, const Triangle&, double);

Kernel kernelOf(TriangleKernel kernel) {
  switch (kernel) {
    case TriangleKernel::kDefinition:
      return searchFeatures;
#if defined(__x86_64__)
    case TriangleKernel::kAvx2:
      return avx2::minimumTranslation;
    case TriangleKernel::kAvx512:
      return avx512::minimumTranslation;
#endif
    default:
      return plain::minimumTranslation;
  }
}

const Kernel kBest = kernelOf(triangleKernels().back());

}  // namespace

std::vector<TriangleKernel> triangleKernels() {
  std::vector<TriangleKernel> kernels{TriangleKernel::kDefinition, TriangleKernel::kPlain};
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2")) kernels.push_back(TriangleKernel::kAvx2);
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
    kernels.push_back(TriangleKernel::kAvx512);
#endif
  return kernels;
}

TriangleContact minimumTranslation(const PosedEllipsoid& ellipsoid, const Triangle& triangle, double floor_depth) {
  return kBest(ellipsoid, triangle, floor_depth);
}

TriangleContact minimumTranslation(TriangleKernel kernel, const PosedEllipsoid& ellipsoid, const Triangle& triangle,
                                   double floor_depth) {
  return kernelOf(kernel)(ellipsoid, triangle, floor_depth);
}

bool cannotExceed(const PosedEllipsoid& ellipsoid, const Triangle& triangle, const Eigen::Vector3d& u, double depth) {
  const Vec3 push = Vec3::from(u), c = Vec3::from(ellipsoid.p_WE);
  if (!(depth >= 0.0) || !(dot(push, Vec3::from(triangle.nhat_W)) > 0.0)) return false;

  // delta(u) <= depth, without the root.
  double highest = dot(push, Vec3::from(triangle.v[0]) - c);
  for (int i = 1; i < 3; ++i) highest = std::max(highest, dot(push, Vec3::from(triangle.v[i]) - c));
  const double reach = depth - highest;
  const Vec3 y = times(Vec3::from(ellipsoid.radii), toFrame(columns(ellipsoid.R_WE), push));
  if (!(reach >= 0.0) || !(squaredNorm(y) <= reach * reach)) return false;

  PlaneContact plane;
  if (!planeContact(ellipsoid, triangle, depth, plane)) return true;
  const Vec3& n = plane.nhat_E;
  const Vec3& r = plane.radii;
  if (!isHorizonClear(plane.s, plane.h, squaredNorm(Vec3{n.x / r.x, n.y / r.y, n.z / r.z}))) return false;
  return !faceSides(plane, triangle).isFace();
}

}  // namespace ellipsoid_vehicle_sim
