#pragma once

#include "ellipsoid_vehicle_sim/geometry/ellipsoid.h"
#include "ellipsoid_vehicle_sim/geometry/small_vector.h"
#include "ellipsoid_vehicle_sim/geometry/triangle.h"

namespace ellipsoid_vehicle_sim {

/// The borders between face, edge and corner are tested with this tolerance, in parts of the larger of the longest
/// edge and the largest semi-axis: an answer found by two features does no harm, a gap between them would lose the
/// contact.
constexpr double kBorderTolerance = 1e-10;

/// Where an ellipsoid stands towards the plane of a triangle. Source: [ContactDefinition] rules 2 and 3.
struct PlaneContact {
  Vec3 t[3];    ///< the corners, v_i - c [m].
  Frame3 axes;  ///< the ellipsoid's axes.
  Vec3 nhat;    ///< n.
  Vec3 radii;   ///< semi-axes [m].
  Vec3 nhat_E;  ///< n along the ellipsoid's axes.
  Vec3 An;      ///< A n [m^2]: E0 - c = -A n / h.
  double s;     ///< n·(c - v), height of the centre over the plane [m].
  double h;     ///< half width of the ellipsoid along n [m].
  double d_n;   ///< h - s, depth of the lowest point E0 below the plane [m].

  /// E0 - c [m].
  Vec3 p_EE0() const { return (-1.0 / h) * An; }
  /// T0 - c [m], T0 = E0 + d_n n.
  Vec3 p_ET0() const { return p_EE0() + d_n * nhat; }
};

/// Rule 2: false unless the centre is in front of the plane and the lowest point more than floor_depth >= 0 below it;
/// the plane is then void. The half width comes from the semi-axes, not from A: along the thin axis of a disc, A's
/// digits are those of its wide axes. NaN anywhere counts as not reached.
inline bool planeContact(const PosedEllipsoid& ellipsoid, const Triangle& triangle, double floor_depth,
                         PlaneContact& plane) {
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
  plane.An = fromFrame(plane.axes, times(plane.radii, y));
  return plane.d_n > floor_depth;
}

/// On which side of the triangle's edges T0 lies, by more than the tolerance.
struct FaceSides {
  bool outside[3];
  bool inside[3];
  double size_squared;  ///< the larger of the longest edge and the largest semi-axis [m], squared.

  /// Rule 3: T0 lies in the triangle.
  bool isFace() const { return !outside[0] && !outside[1] && !outside[2]; }
};

inline FaceSides faceSides(const PlaneContact& plane, const Triangle& triangle) {
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
    const Vec3 m = cross(e, plane.nhat);
    beyond[k] = -(dot(m, plane.An) + plane.h * dot(m, plane.t[k]));
    sides.size_squared = std::max(sides.size_squared, length_squared[k]);
  }
  // beyond = |e| h m·(T0 - v), where m·n = 0 leaves -m·A n / h of T0: squared on both sides, neither roots of the edges'
  // lengths nor a division are needed.
  const double tolerance = kBorderTolerance * plane.h, tolerance_squared = tolerance * tolerance * sides.size_squared;
  for (int k = 0; k < 3; ++k) {
    const bool clear = beyond[k] * beyond[k] > tolerance_squared * length_squared[k];
    sides.outside[k] = clear && beyond[k] > 0.0;
    sides.inside[k] = clear && beyond[k] < 0.0;
  }
  return sides;
}

}  // namespace ellipsoid_vehicle_sim
