#include "ellipsoid_vehicle_sim/geometry/plane_contact.h"

#include <algorithm>
#include <cmath>

namespace ellipsoid_vehicle_sim {

bool planeContact(const PosedEllipsoid& ellipsoid, const Triangle& triangle, double floor_depth, PlaneContact& plane) {
  const Vec3 c = Vec3::from(ellipsoid.p_WE);
  plane.nhat = Vec3::from(triangle.nhat_W);
  for (int i = 0; i < 3; ++i) plane.t[i] = Vec3::from(triangle.v[i]) - c;
  // The corner nearest to the centre costs the height the fewest digits.
  const double l0 = squaredNorm(plane.t[0]), l1 = squaredNorm(plane.t[1]), l2 = squaredNorm(plane.t[2]);
  const double s0 = dot(plane.nhat, plane.t[0]), s1 = dot(plane.nhat, plane.t[1]), s2 = dot(plane.nhat, plane.t[2]);
  plane.s = -(l0 <= l1 ? (l0 <= l2 ? s0 : s2) : (l1 <= l2 ? s1 : s2));
  if (!(plane.s > 0.0)) return false;

  plane.axes = columns(ellipsoid.R_WE);
  plane.radii = Vec3::from(ellipsoid.radii);
  plane.nhat_E = toFrame(plane.axes, plane.nhat);
  const Vec3 y = times(plane.radii, plane.nhat_E);
  const double h_squared = squaredNorm(y);
  const double reach = plane.s + floor_depth;
  if (!(h_squared > reach * reach) || !std::isfinite(h_squared)) return false;

  plane.h = std::sqrt(h_squared);
  plane.d_n = plane.h - plane.s;
  plane.p_EE0 = fromFrame(plane.axes, (-1.0 / plane.h) * times(plane.radii, y));
  plane.p_ET0 = plane.p_EE0 + plane.d_n * plane.nhat;
  return plane.d_n > floor_depth;
}

FaceSides faceSides(const PlaneContact& plane, const Triangle& triangle) {
  FaceSides sides;
  double beyond[3], length_squared[3];
  const Vec3& r = plane.radii;
  const double r_max = std::max(std::max(r.x, r.y), r.z);
  sides.size_squared = r_max * r_max;
  const Vec3 v[3] = {Vec3::from(triangle.v[0]), Vec3::from(triangle.v[1]), Vec3::from(triangle.v[2])};
  for (int k = 0; k < 3; ++k) {
    // From the corners themselves: two far points seen from the centre would have lost digits.
    const Vec3 e = v[(k + 1) % 3] - v[k];
    length_squared[k] = squaredNorm(e);
    beyond[k] = dot(cross(e, plane.nhat), plane.p_ET0 - plane.t[k]);
    sides.size_squared = std::max(sides.size_squared, length_squared[k]);
  }
  // beyond = |e| m·(T0 - v): squared on both sides, the roots of the edges' lengths are not needed.
  const double tolerance_squared = kBorderTolerance * kBorderTolerance * sides.size_squared;
  for (int k = 0; k < 3; ++k) {
    const bool clear = beyond[k] * beyond[k] > tolerance_squared * length_squared[k];
    sides.outside[k] = clear && beyond[k] > 0.0;
    sides.inside[k] = clear && beyond[k] < 0.0;
  }
  return sides;
}

}  // namespace ellipsoid_vehicle_sim
