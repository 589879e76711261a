#pragma once

#include <cmath>
#include <functional>

#include "ellipsoid_vehicle_sim/world/terrain.h"

namespace ellipsoid_vehicle_sim {

/// Ground z = height(x, y) of 2 n^2 triangles with square cells, its corner at `origin`, front up.
inline TriangleSoup gridSoup(int n, double cell, const std::function<double(double, double)>& height,
                             const Eigen::Vector3d& origin = Eigen::Vector3d::Zero()) {
  TriangleSoup soup;
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      soup.vertices.push_back(origin + Eigen::Vector3d(i * cell, j * cell, height(i * cell, j * cell)));
    }
  }
  const auto at = [n](int i, int j) { return static_cast<std::uint32_t>(j * (n + 1) + i); };
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      soup.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      soup.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return soup;
}

inline TriangleSoup flatSoup(int n, double cell) {
  return gridSoup(n, cell, [](double, double) { return 0.0; });
}

/// Closed unit cube [0, 1]^3, fronts outwards.
inline TriangleSoup cubeSoup() {
  TriangleSoup soup;
  for (int i = 0; i < 8; ++i) soup.vertices.emplace_back(i & 1, (i >> 1) & 1, (i >> 2) & 1);
  const std::array<std::array<std::uint32_t, 4>, 6> faces = {
      {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
  for (const auto& f : faces) {
    soup.triangles.push_back({f[0], f[1], f[2]});
    soup.triangles.push_back({f[0], f[2], f[3]});
  }
  return soup;
}

/// A single triangle.
inline TriangleSoup oneTriangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  TriangleSoup soup;
  soup.vertices = {a, b, c};
  soup.triangles = {{0, 1, 2}};
  return soup;
}

}  // namespace ellipsoid_vehicle_sim
