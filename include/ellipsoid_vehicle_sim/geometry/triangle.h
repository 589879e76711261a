#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>

namespace ellipsoid_vehicle_sim {

/// A one-sided triangle, counter-clockwise seen from its front; nhat_W points to the front.
struct Triangle {
  std::array<Eigen::Vector3d, 3> v;  ///< corners in W [m]; edge k runs from v[k] to v[(k + 1) % 3].
  Eigen::Vector3d nhat_W;            ///< unit normal, zero when the triangle has no area.
};

/// Twice the area times the normal, from the two shorter edges: a sliver's long edges would cost it digits.
inline Eigen::Vector3d doubleAreaVector(const std::array<Eigen::Vector3d, 3>& v) {
  const std::array<Eigen::Vector3d, 3> e = {v[1] - v[0], v[2] - v[1], v[0] - v[2]};
  const double l0 = e[0].squaredNorm(), l1 = e[1].squaredNorm(), l2 = e[2].squaredNorm();
  if (l0 >= l1 && l0 >= l2) return e[1].cross(e[2]);
  if (l1 >= l2) return e[2].cross(e[0]);
  return e[0].cross(e[1]);
}

/// Longest edge [m], squared.
inline double longestEdgeSquared(const std::array<Eigen::Vector3d, 3>& v) {
  return std::max({(v[1] - v[0]).squaredNorm(), (v[2] - v[1]).squaredNorm(), (v[0] - v[2]).squaredNorm()});
}

/// Below this ratio of 2 area to longest edge squared a triangle counts as having no area and collides with nothing.
constexpr double kNoAreaRatio = 1e-14;

/// Triangle with its normal; nhat_W = 0 when it has no area.
inline Triangle makeTriangle(const Eigen::Vector3d& v0, const Eigen::Vector3d& v1, const Eigen::Vector3d& v2) {
  Triangle triangle{{v0, v1, v2}, Eigen::Vector3d::Zero()};
  const Eigen::Vector3d n = doubleAreaVector(triangle.v);
  const double double_area = n.norm();
  if (double_area > kNoAreaRatio * longestEdgeSquared(triangle.v)) triangle.nhat_W = n / double_area;
  return triangle;
}

inline bool hasArea(const Triangle& triangle) { return !triangle.nhat_W.isZero(0.0); }

}  // namespace ellipsoid_vehicle_sim
