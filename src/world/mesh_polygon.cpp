#include <Eigen/Geometry>

#include "mesh_readers.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector2d;

double cross(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

/// Corners as seen from the front: dropped onto the coordinate plane that Newell's normal is nearest to.
std::vector<Vector2d> flattened(const std::vector<Eigen::Vector3d>& vertices, const std::uint32_t* corners,
                                std::size_t count) {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  const Eigen::Vector3d& origin = vertices[corners[0]];
  for (std::size_t i = 1; i + 1 < count; ++i) {
    normal += (vertices[corners[i]] - origin).cross(vertices[corners[i + 1]] - origin);
  }
  Eigen::Index axis = 2;
  normal.cwiseAbs().maxCoeff(&axis);
  const Eigen::Index x = (axis + 1) % 3, y = (axis + 2) % 3;
  std::vector<Vector2d> flat(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d p = vertices[corners[i]] - origin;
    flat[i] = normal[axis] < 0.0 ? Vector2d(p[y], p[x]) : Vector2d(p[x], p[y]);
  }
  return flat;
}

bool isEar(const std::vector<Vector2d>& flat, const std::vector<std::size_t>& left, std::size_t i,
           std::int64_t& patience) {
  const std::size_t n = left.size();
  const Vector2d &a = flat[left[(i + n - 1) % n]], &b = flat[left[i]], &c = flat[left[(i + 1) % n]];
  --patience;
  if (cross(a, b, c) <= 0.0) return false;
  for (std::size_t k = 2; k + 1 < n; ++k, --patience) {
    const Vector2d& p = flat[left[(i + k) % n]];
    const bool inside = cross(a, b, p) >= 0.0 && cross(b, c, p) >= 0.0 && cross(c, a, p) >= 0.0;
    if (inside && p != a && p != b && p != c) return false;
  }
  return true;
}

bool isConvex(const std::vector<Vector2d>& flat) {
  const std::size_t n = flat.size();
  for (std::size_t i = 0; i < n; ++i) {
    // Turning left everywhere, and everything left of the first corner's view, which a star would not be.
    if (cross(flat[i], flat[(i + 1) % n], flat[(i + 2) % n]) < 0.0) return false;
    if (i > 0 && i + 1 < n && cross(flat[0], flat[i], flat[i + 1]) < 0.0) return false;
  }
  return true;
}

}  // namespace

void PolygonCutter::append(const std::vector<Eigen::Vector3d>& vertices, const std::uint32_t* corners,
                           std::size_t count, std::vector<std::array<std::uint32_t, 3>>& triangles) {
  if (count == 3) {
    triangles.push_back({corners[0], corners[1], corners[2]});
    return;
  }
  const std::vector<Vector2d> flat = flattened(vertices, corners, count);
  std::vector<std::size_t> left(count);
  for (std::size_t i = 0; i < count; ++i) left[i] = i;
  if (!isConvex(flat)) {
    // Testing an ear takes n steps and finding one up to n of those: far beyond what a mesh has, a fan must do.
    constexpr std::size_t kMostCorners = 1000;
    bool found = count <= kMostCorners;
    while (found && left.size() > 3 && patience_ > 0) {
      found = false;
      for (std::size_t i = 0; i < left.size() && !found && patience_ > 0; ++i) {
        if (!isEar(flat, left, i, patience_)) continue;
        const std::size_t n = left.size();
        triangles.push_back({corners[left[(i + n - 1) % n]], corners[left[i]], corners[left[(i + 1) % n]]});
        left.erase(left.begin() + static_cast<std::ptrdiff_t>(i));
        found = true;
      }
    }
    if (count > kMostCorners || patience_ <= 0) ++fanned_;
  }
  for (std::size_t i = 1; i + 1 < left.size(); ++i) {
    triangles.push_back({corners[left[0]], corners[left[i]], corners[left[i + 1]]});
  }
}

}  // namespace ellipsoid_vehicle_sim
