#pragma once

#include <algorithm>
#include <limits>

#include "ellipsoid_vehicle_sim/geometry/ray.h"
#include "ellipsoid_vehicle_sim/world/mesh_tree.h"

namespace ellipsoid_vehicle_sim {

/// MeshTree::visitRay, for those who shoot rays.
///
/// The ray is cut to the mesh's box, and told in cells from where it enters. A lane is met while the ray is within all
/// three of its slabs; nearer lanes are looked at first, and none that begins behind the nearest hit so far. A slab is
/// wider on both sides than its lane says: by one cell for the grid's rounding, and by the rounding of doubles that are
/// as large as the ray is long.
template <typename Visit>
void MeshTree::visitRay(const Ray& ray, double range, Visit&& visit) const {
  if (trees_.empty() || cells_per_metre_ <= 0.0) return;
  const double cell = 1.0 / cells_per_metre_;
  const Eigen::Vector3d p_min_O = ray.origin - bounds_.min();
  const double rounding =
      16.0 * std::numeric_limits<double>::epsilon() * (p_min_O.cwiseAbs().maxCoeff() + bounds_.sizes().maxCoeff());
  const double wider = 1.0 + rounding * cells_per_metre_;  // [cells]
  const Eigen::AlignedBox3d box(Eigen::Vector3d(bounds_.min().array() - 2.0 * wider * cell),
                                Eigen::Vector3d(bounds_.max().array() + 2.0 * wider * cell));
  const std::optional<RaySpan> span = raySpan(ray, box, range);
  if (!span) return;
  constexpr double kLeastComponent = 1e-200;  // its inverse times a cell is still a number
  double from[3], inverse[3];                 // [cells], [m/cell]
  for (Eigen::Index k = 0; k < 3; ++k) {
    from[k] = (p_min_O[k] + span->begin * ray.direction[k]) * cells_per_metre_;
    const double d = ray.direction[k];
    inverse[k] = cell / std::copysign(std::max(std::abs(d), kLeastComponent), d);
  }
  double end = span->end - span->begin;  // what is still to be looked at, from where the ray enters [m]

  struct Entry {
    double begin;
    std::uint64_t node;  ///< level and number.
  };
  Entry stack[kStackSize];
  for (const Levels& levels : trees_) {
    int top = 0;
    const std::size_t root = static_cast<std::size_t>(levels.size) - 1;
    stack[top++] = {0.0, static_cast<std::uint64_t>(root) << 32 | levels.begin[root]};
    while (top > 0) {
      const Entry entry = stack[--top];
      if (entry.begin > end) continue;
      const std::size_t level = entry.node >> 32;
      const std::uint32_t at = static_cast<std::uint32_t>(entry.node);
      const MeshTreeNode& node = nodes_[at];
      double begin[kWidth], until[kWidth];
      std::fill_n(begin, kWidth, 0.0);
      std::fill_n(until, kWidth, end);
      const double step = static_cast<double>(1 << node.origin[3]);
      for (std::size_t k = 0; k < 3; ++k) {
        const double low = node.origin[k] - wider - from[k], high = low + 256.0 * step + 2.0 * wider;
        for (int lane = 0; lane < kWidth; ++lane) {
          const double a = (low + step * node.bound[k][lane]) * inverse[k];
          const double b = (high - step * node.bound[k][kWidth + lane]) * inverse[k];
          begin[lane] = std::max(begin[lane], std::min(a, b));
          until[lane] = std::min(until[lane], std::max(a, b));
        }
      }
      const std::uint32_t first = (at - levels.begin[level]) * kWidth;  // of the triangles or nodes below
      const std::uint32_t count = (level == 0 ? levels.triangle_count : levels.count[level - 1]) - first;
      const int lanes = static_cast<int>(std::min<std::uint32_t>(count, kWidth));
      const int bottom = top;
      for (int lane = 0; lane < lanes; ++lane) {
        if (!(begin[lane] <= until[lane])) continue;
        if (level == 0) {
          if (begin[lane] > end) continue;
          const double limit = visit(static_cast<int>(triangles_[levels.first_triangle + first + lane]));
          end = std::min(end, limit - span->begin);
          continue;
        }
        // The nearest last, where it is taken first.
        int place = top++;
        for (; place > bottom && stack[place - 1].begin < begin[lane]; --place) stack[place] = stack[place - 1];
        stack[place] = {begin[lane],
                        static_cast<std::uint64_t>(level - 1) << 32 | (levels.begin[level - 1] + first + lane)};
      }
    }
  }
}

}  // namespace ellipsoid_vehicle_sim
