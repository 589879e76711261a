#include <cmath>
#include <limits>

#include "ellipsoid_vehicle_sim/geometry/ellipsoid_triangle.h"
#include "ellipsoid_vehicle_sim/geometry/plane_contact.h"
#include "ellipsoid_vehicle_sim/geometry/secular_equation.h"

namespace ellipsoid_vehicle_sim {
namespace {

/// Depths closer than this, in parts of the largest semi-axis, are the same depth to rounding.
constexpr double kTie = 1e-14;

/// The point of the triangle nearest to T0, seen from the ellipsoid's centre, and which part of the triangle it is on.
struct ClampedTarget {
  Vec3 p_ET{0.0, 0.0, 0.0};
  Feature feature = Feature::kNone;
};

ClampedTarget clampToTriangle(const PlaneContact& plane, const Triangle& triangle, const FaceSides& sides) {
  ClampedTarget nearest;
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    if (!sides.outside[k]) continue;
    const int l = (k + 1) % 3;
    const Vec3 e = Vec3::from(triangle.v[l]) - Vec3::from(triangle.v[k]);
    const Vec3& from = plane.t[k];
    const Vec3& to = plane.t[l];
    // Measured from the nearer end: along a long edge the other one would cost digits.
    const double length_squared = squaredNorm(e);
    const double forth = dot(plane.p_ET0() - from, e), back = dot(to - plane.p_ET0(), e);
    ClampedTarget target;
    if (forth <= 0.0) {
      target = {from, static_cast<Feature>(static_cast<int>(Feature::kVertex0) + k)};
    } else if (back <= 0.0) {
      target = {to, static_cast<Feature>(static_cast<int>(Feature::kVertex0) + l)};
    } else {
      target.p_ET = forth <= back ? from + (forth / length_squared) * e : to - (back / length_squared) * e;
      target.feature = static_cast<Feature>(static_cast<int>(Feature::kEdge0) + k);
    }
    const double distance = squaredNorm(target.p_ET - plane.p_ET0());
    if (distance < least) {
      least = distance;
      nearest = target;
    }
  }
  return nearest;
}

/// True when edge k passes through the feature: the edge itself, or the two that meet in a corner.
bool passesThrough(int k, Feature feature) {
  const int f = static_cast<int>(feature);
  if (f >= static_cast<int>(Feature::kVertex0)) {
    const int corner = f - static_cast<int>(Feature::kVertex0);
    return k == corner || (k + 1) % 3 == corner;
  }
  return f == static_cast<int>(Feature::kEdge0) + k;
}

}  // namespace

TriangleContact clampedPoint(const PosedEllipsoid& ellipsoid, const Triangle& triangle) {
  PlaneContact plane;
  if (!planeContact(ellipsoid, triangle, 0.0, plane)) return {};
  const FaceSides sides = faceSides(plane, triangle);
  if (sides.isFace()) return {Feature::kFace, plane.d_n, triangle.nhat_W, ellipsoid.p_WE + plane.p_EE0().toEigen()};
  const ClampedTarget target = clampToTriangle(plane, triangle, sides);

  // The secular equation wants its lengths in parts of the largest semi-axis.
  const double scale = 1.0 / ellipsoid.radii.maxCoeff();
  const Vec3 r = scale * plane.radii;
  const Vec3 n = plane.nhat_E;
  const Vec3 p = scale * toFrame(plane.axes, target.p_ET);
  const Vec3 t{withoutZero(p.x, n.x), withoutZero(p.y, n.y), withoutZero(p.z, n.z)};

  TriangleContact best;
  double least = std::numeric_limits<double>::infinity(), best_u_n = 0.0;
  for (const Vec3& u_E : pushDirections({{t.x, t.y, t.z}, {r.x, r.y, r.z}})) {
    const Vec3 u = fromFrame(plane.axes, u_E);
    const double u_n = dot(u, plane.nhat);
    if (!(u_n > 0.0)) continue;
    bool on_wrong_side = false;
    for (int k = 0; k < 3; ++k) {
      if (!sides.outside[k] || !passesThrough(k, target.feature)) continue;
      const Vec3 m = cross(Vec3::from(triangle.v[(k + 1) % 3]) - Vec3::from(triangle.v[k]), plane.nhat);
      on_wrong_side = on_wrong_side || dot(u, m) < -kBorderTolerance * norm(m);
    }
    if (on_wrong_side) continue;

    // Of two equal pushes the one nearer to n, as in the other rule.
    const Vec3 y = times(r, u_E);
    const double h = norm(y);
    const double delta = dot(u_E, t) + h;
    if (!(delta > 0.0) || !(delta < least - kTie || (delta <= least + kTie && u_n > best_u_n))) continue;
    least = delta;
    best_u_n = u_n;
    const Vec3 p_EE = fromFrame(plane.axes, (-1.0 / (h * scale)) * times(r, y));
    best = {target.feature, delta / scale, u.toEigen(), ellipsoid.p_WE + p_EE.toEigen()};
  }
  if (!std::isfinite(best.depth) || !best.nhat_W.allFinite() || !best.p_WE_lowest.allFinite()) return {};
  return best;
}

}  // namespace ellipsoid_vehicle_sim
