#include "ellipsoid_vehicle_sim/world/mesh_tree.h"

#include <algorithm>
#include <cstring>
#include <limits>

namespace ellipsoid_vehicle_sim {

/// Builds a MeshTree from the top down, in place over one array of items.
class MeshTreeBuilder {
 public:
  MeshTreeBuilder(MeshTree& tree, const std::vector<Eigen::Vector3d>& vertices,
                  const std::vector<std::array<std::uint32_t, 3>>& triangles)
      : tree_(tree) {
    items_.reserve(triangles.size());
    for (std::size_t i = 0; i < triangles.size(); ++i) items_.push_back(makeItem(vertices, triangles[i], i));
  }

  void build() {
    // Slightly more than full leaves with full nodes above them; the vector is cut to size at the end.
    tree_.nodes_.reserve(items_.size() / 6 + 16);
    addNode(sizeClasses());
    tree_.nodes_.shrink_to_fit();
  }

 private:
  using Array4f = Eigen::Array4f;
  static constexpr int kWidth = MeshTree::kWidth;
  static constexpr int kBins = 16;
  // Size classes make queries of fine ground under a few huge triangles 1.4 times faster, and cost others nothing.
  static constexpr int kSizeClasses = 6;
  static constexpr float kSizeRatio = 16.0f;
  /// Up to here ranges are cut into full leaves at the median.
  static constexpr std::size_t kSmall = 64;

  /// Box of a triangle; the fourth lane of lo carries the bits of the triangle's index.
  struct Item {
    Array4f lo, hi;
    Array4f doubleCenter() const { return lo + hi; }
    std::uint32_t index() const {
      std::uint32_t i;
      std::memcpy(&i, reinterpret_cast<const char*>(this) + 3 * sizeof(float), sizeof i);
      return i;
    }
  };

  struct Box {
    Array4f lo = Array4f::Constant(std::numeric_limits<float>::infinity());
    Array4f hi = Array4f::Constant(-std::numeric_limits<float>::infinity());
    void add(const Item& item) { lo = lo.min(item.lo), hi = hi.max(item.hi); }
    void add(const Array4f& point) { lo = lo.min(point), hi = hi.max(point); }
    void add(const Box& box) { lo = lo.min(box.lo), hi = hi.max(box.hi); }
    float halfArea() const {
      const Array4f e = hi - lo;
      return e[0] * e[1] + e[1] * e[2] + e[2] * e[0];
    }
  };

  /// A run of items with their common box and the box of their doubled centres.
  struct Range {
    std::size_t begin = 0, end = 0;
    Box box, centers;
    int splits = 0;  ///< how many splits led here.
    std::size_t size() const { return end - begin; }
  };

  /// Up to eight ranges: what becomes the lanes of a node.
  struct Lanes {
    std::array<Range, kWidth> range;
    std::size_t count = 0;
  };

  Item makeItem(const std::vector<Eigen::Vector3d>& vertices, const std::array<std::uint32_t, 3>& triangle,
                std::size_t index) const {
    const Eigen::Vector3d &a = vertices[triangle[0]], &b = vertices[triangle[1]], &c = vertices[triangle[2]];
    const Eigen::Vector3d lo = a.cwiseMin(b).cwiseMin(c) - tree_.center_;
    const Eigen::Vector3d hi = a.cwiseMax(b).cwiseMax(c) - tree_.center_;
    Item item;
    for (int k = 0; k < 3; ++k) item.lo[k] = MeshTree::below(lo[k]), item.hi[k] = MeshTree::above(hi[k]);
    item.hi[3] = 0.0f;
    const std::uint32_t bits = static_cast<std::uint32_t>(index);
    std::memcpy(reinterpret_cast<char*>(&item) + 3 * sizeof(float), &bits, sizeof bits);
    return item;
  }

  Range makeRange(std::size_t begin, std::size_t end, int splits) const {
    Range range;
    range.begin = begin, range.end = end, range.splits = splits;
    for (std::size_t i = begin; i < end; ++i) range.box.add(items_[i]), range.centers.add(items_[i].doubleCenter());
    return range;
  }

  /// Sorts the items by size, largest first, in steps of kSizeRatio.
  Lanes sizeClasses() {
    const auto sizeOf = [](const Item& item) { return (item.hi - item.lo).head<3>().maxCoeff(); };
    float largest = 0.0f;
    for (const Item& item : items_) largest = std::max(largest, sizeOf(item));
    Lanes lanes;
    std::size_t begin = 0;
    float limit = largest;
    for (int c = 0; c < kSizeClasses && begin < items_.size(); ++c) {
      limit /= kSizeRatio;
      auto end = items_.end();
      if (c + 1 < kSizeClasses) {
        const auto isLarge = [&](const Item& item) { return sizeOf(item) >= limit; };
        end = std::partition(items_.begin() + static_cast<std::ptrdiff_t>(begin), items_.end(), isLarge);
      }
      const std::size_t cut = static_cast<std::size_t>(end - items_.begin());
      if (cut == begin) continue;
      lanes.range[lanes.count++] = makeRange(begin, cut, 0);
      begin = cut;
    }
    return lanes;
  }

  /// Splits what is met most often until the lanes are used up or everything fits into one leaf each.
  void fill(Lanes& lanes) {
    while (lanes.count < kWidth) {
      std::size_t widest = kWidth;
      for (std::size_t i = 0; i < lanes.count; ++i) {
        if (lanes.range[i].size() <= kWidth) continue;
        if (widest == kWidth || lanes.range[i].box.halfArea() > lanes.range[widest].box.halfArea()) widest = i;
      }
      if (widest == kWidth) return;
      lanes.range[lanes.count++] = split(lanes.range[widest]);
    }
  }

  /// Appends the node over these lanes and all below it; returns its index.
  std::uint32_t addNode(Lanes lanes) {
    const bool is_leaf = lanes.count == 1 && lanes.range[0].size() <= kWidth;
    if (is_leaf) {
      const Range all = lanes.range[0];
      for (lanes.count = 0; lanes.count < all.size(); ++lanes.count) {
        lanes.range[lanes.count] = makeRange(all.begin + lanes.count, all.begin + lanes.count + 1, 0);
      }
    } else {
      fill(lanes);
    }
    const std::uint32_t index = static_cast<std::uint32_t>(tree_.nodes_.size());
    tree_.nodes_.emplace_back();
    MeshTree::Node node;
    for (std::size_t i = 0; i < kWidth; ++i) {
      const Box box = i < lanes.count ? lanes.range[i].box : Box();
      for (int k = 0; k < 3; ++k) node.bound[k][i] = box.lo[k], node.bound[3 + k][i] = box.hi[k];
      node.child[i] = 0;
      if (i >= lanes.count) continue;
      if (lanes.range[i].size() == 1) {
        node.child[i] = items_[lanes.range[i].begin].index() | MeshTree::kIsTriangle;
      } else {
        Lanes below;
        below.range[0] = lanes.range[i];
        below.count = 1;
        node.child[i] = addNode(below);
      }
    }
    tree_.nodes_[index] = node;
    return index;
  }

  /// Splits off the right part of `range` (more than eight items), which it returns.
  Range split(Range& range) {
    int axis = 0;
    (range.centers.hi - range.centers.lo).head<3>().maxCoeff(&axis);
    // Bins of nothing would divide by it.
    const bool has_extent = range.centers.hi[axis] - range.centers.lo[axis] > 1e-30f;
    if (range.size() > kSmall && has_extent && range.splits < MeshTree::kMaxSplits) return splitBinned(range, axis);
    return splitHalf(range, axis);
  }

  /// Half of the range on either side, rounded so that the left is whole leaves.
  Range splitHalf(Range& range, int axis) {
    const std::size_t leaves = (range.size() + kWidth - 1) / kWidth;
    const std::size_t cut = range.begin + (leaves / 2) * kWidth;
    std::nth_element(at(range.begin), at(cut), at(range.end), [axis](const Item& a, const Item& b) {
      return a.lo[axis] + a.hi[axis] < b.lo[axis] + b.hi[axis];
    });
    const Range right = makeRange(cut, range.end, range.splits + 1);
    range = makeRange(range.begin, cut, range.splits + 1);
    return right;
  }

  /// Splits between the two bins with the least sum of (half area times count). The first and the last bin are never
  /// empty, so both parts have items.
  Range splitBinned(Range& range, int axis) {
    const float lo = range.centers.lo[axis];
    const float scale = static_cast<float>(kBins) / (range.centers.hi[axis] - lo);
    const auto binOf = [=](const Item& item) {
      return static_cast<std::size_t>(std::min(kBins - 1.0f, (item.lo[axis] + item.hi[axis] - lo) * scale));
    };
    std::array<Range, kBins> bins;
    for (std::size_t i = range.begin; i < range.end; ++i) {
      Range& bin = bins[binOf(items_[i])];
      bin.box.add(items_[i]);
      bin.centers.add(items_[i].doubleCenter());
      ++bin.end;
    }
    const auto join = [](Range& sum, const Range& bin) {
      sum.box.add(bin.box), sum.centers.add(bin.centers);
      sum.end += bin.end;
    };
    std::array<Range, kBins> rights;  // rights[b] is bins b and up
    rights[kBins - 1] = bins[kBins - 1];
    for (std::size_t b = kBins - 1; b-- > 1;) join(rights[b] = rights[b + 1], bins[b]);
    Range left, best_left;
    std::size_t best = 0;
    float best_cost = std::numeric_limits<float>::infinity();
    for (std::size_t b = 0; b + 1 < kBins; ++b) {
      join(left, bins[b]);
      const float cost = left.box.halfArea() * static_cast<float>(left.size()) +
                         rights[b + 1].box.halfArea() * static_cast<float>(rights[b + 1].size());
      if (cost < best_cost) best_cost = cost, best = b, best_left = left;
    }
    std::partition(at(range.begin), at(range.end), [&](const Item& item) { return binOf(item) <= best; });
    Range right = rights[best + 1];
    right.begin = range.begin + best_left.size(), right.end = range.end, right.splits = range.splits + 1;
    best_left.begin = range.begin, best_left.end = right.begin, best_left.splits = right.splits;
    range = best_left;
    return right;
  }

  std::vector<Item>::iterator at(std::size_t i) { return items_.begin() + static_cast<std::ptrdiff_t>(i); }

  MeshTree& tree_;
  std::vector<Item> items_;
};

MeshTree::MeshTree(const std::vector<Eigen::Vector3d>& vertices,
                   const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  if (triangles.empty()) return;
  for (const auto& triangle : triangles) {
    for (const std::uint32_t v : triangle) bounds_.extend(vertices[v]);
  }
  center_ = bounds_.center();
  slack_ = kFloatSlack * 0.5 * bounds_.sizes().maxCoeff();
  MeshTreeBuilder(*this, vertices, triangles).build();
}

}  // namespace ellipsoid_vehicle_sim
