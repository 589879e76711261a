#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <optional>

#include "ellipsoid_vehicle_sim/geometry/ellipsoid.h"

namespace ellipsoid_vehicle_sim {

/// A half line in W. Points of it are origin + t direction with t >= 0 [m].
struct Ray {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;  ///< unit.
};

/// A ray made ready to be asked about many triangles: S. Woop, C. Benthin, I. Wald, Watertight ray/triangle
/// intersection, Journal of Computer Graphics Techniques 2(1), 2013, in doubles.
///
/// Seen along the ray: the axis along which it goes most becomes z, and space is sheared until the ray runs along it. A
/// triangle is hit when the origin of the x-y plane lies inside its three corners there, told by the signs of three
/// areas. A corner comes out the same for all triangles that share it, and the sign of a difference of two rounded
/// products is never the wrong one, zero at worst, which counts as inside: no ray slips through an edge or a corner
/// that triangles share. Both sides of a triangle are met alike; one seen edge-on is not.
class ShearedRay {
 public:
  explicit ShearedRay(const Ray& ray);

  /// Distance to the triangle; nullopt where the ray misses it. A weighted mean of the corners' distances along z,
  /// never outside of theirs, also for a grazing ray; its error is some roundings of the largest distance of a corner
  /// from the ray's origin, wherever in W that is.
  std::optional<double> meets(const Eigen::Vector3d& v0, const Eigen::Vector3d& v1, const Eigen::Vector3d& v2) const;

 private:
  Eigen::Vector3d origin_;
  Eigen::Index x_, y_, z_;
  double shear_x_, shear_y_, scale_;
};

/// For one triangle.
inline std::optional<double> rayTriangle(const Ray& ray, const Eigen::Vector3d& v0, const Eigen::Vector3d& v1,
                                         const Eigen::Vector3d& v2) {
  return ShearedRay(ray).meets(v0, v1, v2);
}

/// Where a ray first meets the surface of an ellipsoid; from inside, where it leaves it. In the ellipsoid's own axes,
/// each divided by its radius, the surface is the unit sphere: |q + t e| = 1. Told from the point nearest to its
/// centre, t = -b/a, so that nothing cancels for an ellipsoid far away.
std::optional<double> rayEllipsoid(const Ray& ray, const PosedEllipsoid& ellipsoid);

/// The part of a ray inside a box, from t = begin to t = end, both within [0, range]; nullopt where they do not meet.
struct RaySpan {
  double begin, end;
};
inline std::optional<RaySpan> raySpan(const Ray& ray, const Eigen::AlignedBox3d& box, double range) {
  RaySpan span{0.0, range};
  for (Eigen::Index k = 0; k < 3; ++k) {
    const double o = ray.origin[k], d = ray.direction[k];
    if (d == 0.0) {
      if (o < box.min()[k] || o > box.max()[k]) return std::nullopt;
      continue;
    }
    const double a = (box.min()[k] - o) / d, b = (box.max()[k] - o) / d;
    span.begin = std::max(span.begin, std::min(a, b));
    span.end = std::min(span.end, std::max(a, b));
  }
  if (!(span.begin <= span.end)) return std::nullopt;
  return span;
}

}  // namespace ellipsoid_vehicle_sim
