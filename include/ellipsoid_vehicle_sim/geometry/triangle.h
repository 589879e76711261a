#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>

#include "ellipsoid_vehicle_sim/geometry/small_vector.h"

namespace ellipsoid_vehicle_sim {

/// A one-sided triangle, counter-clockwise seen from its front; nhat_W points to the front.
struct Triangle {
  std::array<Eigen::Vector3d, 3> v;  ///< corners in W [m]; edge k runs from v[k] to v[(k + 1) % 3].
  Eigen::Vector3d nhat_W;            ///< unit normal, zero when the triangle has no area.
};

/// Twice the area times the normal, from the two shorter edges: a sliver's long edges would cost it digits.
inline Vec3 doubleAreaVector(const Vec3& v0, const Vec3& v1, const Vec3& v2) {
  const Vec3 e0 = v1 - v0, e1 = v2 - v1, e2 = v0 - v2;
  const double l0 = squaredNorm(e0), l1 = squaredNorm(e1), l2 = squaredNorm(e2);
  if (l0 >= l1 && l0 >= l2) return cross(e1, e2);
  if (l1 >= l2) return cross(e2, e0);
  return cross(e0, e1);
}
inline Eigen::Vector3d doubleAreaVector(const std::array<Eigen::Vector3d, 3>& v) {
  return doubleAreaVector(Vec3::from(v[0]), Vec3::from(v[1]), Vec3::from(v[2])).toEigen();
}

/// Longest edge [m], squared.
inline double longestEdgeSquared(const std::array<Eigen::Vector3d, 3>& v) {
  const Vec3 v0 = Vec3::from(v[0]), v1 = Vec3::from(v[1]), v2 = Vec3::from(v[2]);
  return std::max({squaredNorm(v1 - v0), squaredNorm(v2 - v1), squaredNorm(v0 - v2)});
}

/// Below this ratio of 2 area to longest edge squared a triangle counts as having no area and collides with nothing.
constexpr double kNoAreaRatio = 1e-14;

/// Triangle with its normal; nhat_W = 0 when it has no area.
inline Triangle makeTriangle(const Eigen::Vector3d& v0, const Eigen::Vector3d& v1, const Eigen::Vector3d& v2) {
  Triangle triangle{{v0, v1, v2}, Eigen::Vector3d::Zero()};
  const Vec3 n = doubleAreaVector(Vec3::from(v0), Vec3::from(v1), Vec3::from(v2));
  const double double_area = norm(n);
  if (double_area > kNoAreaRatio * longestEdgeSquared(triangle.v))
    triangle.nhat_W = {n.x / double_area, n.y / double_area, n.z / double_area};
  return triangle;
}

inline bool hasArea(const Triangle& triangle) { return !triangle.nhat_W.isZero(0.0); }

}  // namespace ellipsoid_vehicle_sim
