#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "ellipsoid_vehicle_sim/world/mesh_tree_node.h"

namespace ellipsoid_vehicle_sim {

struct Ray;  // geometry/ray.h

/// Box tree over triangles, eight children to a node. It proposes triangles; the exact answer is the caller's.
///
/// Triangles are put in the order of a Hilbert curve through their centres and every eight neighbours on it make a
/// leaf, every eight of those a node, and so on: all nodes are full, a child's place follows from its parent's, and
/// building is sorting. Node boxes are bytes on a grid of 2^31 cells along the longest side of the mesh
/// (mesh_tree_node.h): 64 bytes for eight of them, so that most of a large tree fits into the caches. Triangles of very
/// different sizes get trees of their own, so that one of kilometres does not swell the boxes of millimetre neighbours.
/// Source: packed Hilbert R-trees, notation.h [HilbertRTree].
class MeshTree {
 public:
  MeshTree() = default;
  /// Every triangle must be finite and there must be fewer than 2^31 of them.
  MeshTree(const std::vector<Eigen::Vector3d>& vertices, const std::vector<std::array<std::uint32_t, 3>>& triangles);

  const Eigen::AlignedBox3d& bounds() const { return bounds_; }
  std::size_t memoryBytes() const {
    return nodes_.capacity() * sizeof(MeshTreeNode) + triangles_.capacity() * sizeof(std::uint32_t);
  }

  /// Calls visit(triangle, certain) for every triangle whose box may meet `box`; all that do meet it are among them,
  /// and `certain` says that the tree already proves it. Does not allocate.
  template <typename Visit>
  void visit(const Eigen::AlignedBox3d& box, Visit&& visit) const;

  /// Whether visit() would find any; stops at the first. Does not allocate.
  bool mayMeet(const Eigen::AlignedBox3d& box) const;

  /// Calls visit(triangle) for every triangle whose box may meet the segment from a to b. Does not allocate.
  template <typename Visit>
  void visitAlong(const Eigen::Vector3d& a, const Eigen::Vector3d& b, Visit&& visit) const;

  /// Calls limit = visit(triangle) for every triangle whose box may meet the ray within `range` [m], nearer boxes
  /// first; none that begins beyond the least `limit` that was returned. Defined in mesh_tree_rays.h. Does not allocate.
  template <typename Visit>
  void visitRay(const Ray& ray, double range, Visit&& visit) const;

 private:
  friend class MeshTreeBuilder;

  static constexpr int kWidth = MeshTreeNode::kWidth;
  static constexpr int kMostLevels = 11;  // 8^11 > 2^31
  static constexpr int kStackSize = kMostLevels * (kWidth - 1) + 1;
  static constexpr int kLeavesAtOnce = 4 * kWidth;
  static constexpr double kLastCell = 2147483647.0;

  /// The levels of one tree, leaves first: where each begins in nodes_, and how many nodes it has. The last is the
  /// root.
  struct Levels {
    std::array<std::uint32_t, kMostLevels> begin{}, count{};
    int size = 0;
    std::uint32_t triangle_count = 0;
    std::uint32_t first_triangle = 0;  ///< in triangles_.
  };

  std::int32_t cellOf(double x, Eigen::Index axis) const {
    return static_cast<std::int32_t>(std::min(kLastCell, (x - bounds_.min()[axis]) * cells_per_metre_));
  }
  /// `box` on the grid, cut to the mesh; false when they do not meet (also for a box that is empty or not a number).
  bool toCells(const Eigen::AlignedBox3d& box, CellBox& cells) const;

  /// visit(triangle, certain) for the lanes of leaves that meet `box` and for which accept(node, lane) is true all the
  /// way down.
  template <typename Accept, typename Visit>
  void traverse(const Levels& levels, const CellBox& box, Accept&& accept, Visit&& visit) const;

  std::vector<MeshTreeNode> nodes_;
  std::vector<std::uint32_t> triangles_;  ///< in the order of the leaves' lanes.
  std::vector<Levels> trees_;             ///< one for each size of triangles, the largest first.
  Eigen::AlignedBox3d bounds_;
  double cells_per_metre_ = 0.0;
};

inline bool MeshTree::toCells(const Eigen::AlignedBox3d& box, CellBox& cells) const {
  for (Eigen::Index k = 0; k < 3; ++k) {
    const double low = std::max(box.min()[k], bounds_.min()[k]), high = std::min(box.max()[k], bounds_.max()[k]);
    // Also false for NaN, wherever it stands: std::max and std::min keep their first argument then.
    if (!(box.min()[k] <= box.max()[k] && low <= high)) return false;
    cells.lo[static_cast<std::size_t>(k)] = cellOf(low, k);
    cells.hi[static_cast<std::size_t>(k)] = cellOf(high, k);
  }
  cells.lo[3] = cells.hi[3] = 0;
  return true;
}

template <typename Accept, typename Visit>
void MeshTree::traverse(const Levels& levels, const CellBox& box, Accept&& accept, Visit&& visit) const {
  // Level and node in one word: stored in two and read in one, the pair would wait in the processor's store buffer.
  std::uint64_t stack[kStackSize];
  int top = 0;
  const auto push = [&](std::size_t level, std::uint32_t node) {
    stack[top++] = static_cast<std::uint64_t>(level) << 32 | node;
  };
  const auto forEach = [](unsigned mask, std::uint32_t count, auto&& lane_visit) {
    if (count < kWidth) mask &= (1u << count) - 1u;
    for (; mask != 0; mask &= mask - 1) lane_visit(__builtin_ctz(mask));
  };
  // Leaves wait for others: far from the cache's memory, they are fetched together.
  std::uint32_t leaves[kLeavesAtOnce];
  int waiting = 0;
  const auto visitLeaves = [&] {
    for (int i = 0; i < waiting; ++i) {
      const MeshTreeNode& node = nodes_[levels.begin[0] + leaves[i]];
      const std::uint32_t first = leaves[i] * kWidth;
      const std::uint32_t* triangles = &triangles_[levels.first_triangle + first];
      const MetLanes met = metLanes(node, box);
      forEach(met.meeting, levels.triangle_count - first, [&](int lane) {
        if (accept(node, lane)) visit(static_cast<int>(triangles[lane]), ((met.certain >> lane) & 1u) != 0);
      });
    }
    waiting = 0;
  };
  const std::size_t root = static_cast<std::size_t>(levels.size) - 1;
  if (root == 0) {
    leaves[waiting++] = 0;
  } else {
    push(root, 0);
  }
  while (top > 0) {
    const std::uint64_t entry = stack[--top];
    const std::size_t level = entry >> 32, below = level - 1;
    const std::uint32_t at = static_cast<std::uint32_t>(entry), first = at * kWidth;
    const MeshTreeNode& node = nodes_[levels.begin[level] + at];
    forEach(metLanes(node, box).meeting, levels.count[below] - first, [&](int lane) {
      if (!accept(node, lane)) return;
      const std::uint32_t child = first + static_cast<std::uint32_t>(lane);
      __builtin_prefetch(&nodes_[levels.begin[below] + child]);
      if (below > 0) return push(below, child);
      __builtin_prefetch(&triangles_[levels.first_triangle + child * kWidth]);
      leaves[waiting++] = child;
    });
    if (waiting > kLeavesAtOnce - kWidth) visitLeaves();
  }
  visitLeaves();
}

template <typename Visit>
void MeshTree::visit(const Eigen::AlignedBox3d& box, Visit&& visit) const {
  CellBox cells;
  if (trees_.empty() || !toCells(box, cells)) return;
  for (const Levels& levels : trees_)
    traverse(
        levels, cells, [](const MeshTreeNode&, int) { return true; }, visit);
}

inline bool MeshTree::mayMeet(const Eigen::AlignedBox3d& box) const {
  CellBox cells;
  if (trees_.empty() || !toCells(box, cells)) return false;
  bool found = false;
  for (const Levels& levels : trees_)
    traverse(
        levels, cells, [&found](const MeshTreeNode&, int) { return !found; }, [&found](int, bool) { found = true; });
  return found;
}

template <typename Visit>
void MeshTree::visitAlong(const Eigen::Vector3d& a, const Eigen::Vector3d& b, Visit&& visit) const {
  CellBox cells;
  if (trees_.empty() || !toCells(Eigen::AlignedBox3d(a.cwiseMin(b), a.cwiseMax(b)), cells)) return;

  // In cells from here on. Separating axes of a segment and a box: the box's own (the boxes' overlap) and direction x
  // axis, k-th of them below.
  const Eigen::Vector3d direction = (b - a).normalized(), size = direction.cwiseAbs();
  const Eigen::Vector3d middle = (0.5 * (a + b) - bounds_.min()) * cells_per_metre_;
  const double rounding = 1e-14 * (middle.cwiseAbs().sum() + 4.0 * kLastCell);
  const auto accept = [&](const MeshTreeNode& node, int lane) {
    Eigen::Vector3d offset, half;
    for (std::size_t k = 0; k < 3; ++k) {
      const double step = static_cast<double>(1 << node.origin[3]);
      const double low = node.origin[k] + step * node.bound[k][lane];
      // One cell more for the grid's own rounding.
      const double high = node.origin[k] + step * (256 - node.bound[k][kWidth + lane]) + 1.0;
      const auto axis = static_cast<Eigen::Index>(k);
      offset[axis] = 0.5 * (low + high) - middle[axis];
      half[axis] = 0.5 * (high - low) + 1.0;
    }
    const Eigen::Vector3d apart = offset.cross(direction).cwiseAbs();
    return apart.x() <= half.y() * size.z() + half.z() * size.y() + rounding &&
           apart.y() <= half.z() * size.x() + half.x() * size.z() + rounding &&
           apart.z() <= half.x() * size.y() + half.y() * size.x() + rounding;
  };
  for (const Levels& levels : trees_) traverse(levels, cells, accept, [&](int triangle, bool) { visit(triangle); });
}

}  // namespace ellipsoid_vehicle_sim
