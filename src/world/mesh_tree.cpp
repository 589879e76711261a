#include "ellipsoid_vehicle_sim/world/mesh_tree.h"

#include <algorithm>
#include <limits>
#include <memory>

#include "ellipsoid_vehicle_sim/geometry/small_vector.h"
#include "hilbert_curve.h"

namespace ellipsoid_vehicle_sim {
namespace {

// Size classes make queries of fine ground under a few huge triangles 1.4 times faster, and cost others nothing.
constexpr int kSizeClasses = 6;
constexpr int kSizeRatioBits = 4;  // a class spans sizes of 1 : 16

// A sorted entry: size class, place on the curve, triangle, from the highest bit down.
constexpr int kIndexBits = 31, kClassShift = kIndexBits + HilbertCurve::kPlaceBits;
constexpr std::uint64_t kIndexMask = (std::uint64_t{1} << kIndexBits) - 1;
static_assert(kClassShift + 3 <= 64 && kSizeClasses <= 8, "an entry is 64 bits");

/// Memory that is not set before it is written: fresh memory is slow enough.
template <typename T>
class Room {
 public:
  explicit Room(std::size_t size = 0) : data_(size == 0 ? nullptr : new T[size]), size_(size) {}
  T& operator[](std::size_t i) { return data_[i]; }
  const T& operator[](std::size_t i) const { return data_[i]; }
  T* begin() { return data_.get(); }
  T* end() { return data_.get() + size_; }
  std::size_t size() const { return size_; }
  void swap(Room& other) { data_.swap(other.data_), std::swap(size_, other.size_); }

 private:
  std::unique_ptr<T[]> data_;
  std::size_t size_;
};

/// Stable counting sort by the bits from kIndexBits up, eleven at a time, to and fro between the entries and `sorted`.
/// All digits are counted in one pass of reading; those that all entries share cost no other.
void radixSort(Room<std::uint64_t>& entries, Room<std::uint64_t>& sorted) {
  constexpr int kDigitBits = 11, kDigits = (64 - kIndexBits) / kDigitBits;
  static_assert(kIndexBits + kDigits * kDigitBits == 64);
  constexpr std::uint64_t kDigitMask = (1u << kDigitBits) - 1;
  std::array<std::array<std::uint32_t, kDigitMask + 1>, kDigits> places{};
  for (const std::uint64_t e : entries)
    for (int digit = 0; digit < kDigits; ++digit) ++places[digit][e >> (kIndexBits + digit * kDigitBits) & kDigitMask];
  for (int digit = 0; digit < kDigits; ++digit) {
    const int shift = kIndexBits + digit * kDigitBits;
    auto& place = places[digit];
    if (place[entries[0] >> shift & kDigitMask] == entries.size()) continue;
    std::uint32_t sum = 0;
    for (std::uint32_t& p : place) {
      const std::uint32_t count = p;
      p = sum;
      sum += count;
    }
    for (const std::uint64_t e : entries) sorted[place[e >> shift & kDigitMask]++] = e;
    entries.swap(sorted);
  }
}

int bitLength(std::uint32_t x) { return x == 0 ? 0 : 32 - __builtin_clz(x); }

}  // namespace

/// Builds a MeshTree from the bottom up.
class MeshTreeBuilder {
 public:
  using Corners = std::array<std::uint32_t, 3>;

  MeshTreeBuilder(MeshTree& tree, const std::vector<Eigen::Vector3d>& vertices, const std::vector<Corners>& triangles)
      : tree_(tree),
        triangles_(triangles),
        cells_(vertices.size()),
        entries_(triangles.size()),
        sorted_(triangles.size()) {
    for (std::size_t v = 0; v < vertices.size(); ++v) {
      // Vertices that no triangle uses may lie outside of the grid, or be no numbers; nobody asks for their cells.
      if (!tree_.bounds_.contains(vertices[v])) continue;
      for (Eigen::Index k = 0; k < 3; ++k) cells_[v][static_cast<std::size_t>(k)] = tree_.cellOf(vertices[v][k], k);
      cells_[v][3] = 0;
    }
  }

  void build() {
    sortTriangles();
    std::size_t node_count = 0;
    for (std::size_t begin = 0; begin < entries_.size();) {
      std::size_t end = begin;
      const std::uint64_t size_class = entries_[begin] >> kClassShift;
      while (end < entries_.size() && entries_[end] >> kClassShift == size_class) ++end;
      planTree(begin, end - begin, node_count);
      begin = end;
    }
    for (const MeshTree::Levels& levels : tree_.trees_) orderBlocks(levels.first_triangle, levels.triangle_count);
    tree_.nodes_.resize(node_count);
    tree_.triangles_.resize(entries_.size());
    for (const MeshTree::Levels& levels : tree_.trees_) fillTree(levels);
  }

 private:
  static constexpr int kWidth = MeshTree::kWidth;
  static constexpr std::size_t kBlock = kWidth * kWidth;  // blocks of a leaf each would cost more than they gain
  using Cells = std::array<std::int32_t, 4>;

  CellBox boxOf(std::size_t triangle) const {
    const Corners& t = triangles_[triangle];
    const Cells &a = cells_[t[0]], &b = cells_[t[1]], &c = cells_[t[2]];
    CellBox box;
    for (std::size_t k = 0; k < 4; ++k) {
      box.lo[k] = std::min(std::min(a[k], b[k]), c[k]);
      box.hi[k] = std::max(std::max(a[k], b[k]), c[k]);
    }
    return box;
  }

  static std::uint32_t longestSide(const CellBox& box) {
    return static_cast<std::uint32_t>(std::max({box.hi[0] - box.lo[0], box.hi[1] - box.lo[1], box.hi[2] - box.lo[2]}));
  }

  static std::array<std::int32_t, 3> centreOf(const CellBox& box) {
    std::array<std::int32_t, 3> centre;
    for (std::size_t k = 0; k < 3; ++k) centre[k] = box.lo[k] + (box.hi[k] - box.lo[k]) / 2;
    return centre;
  }

  /// entries_: by size class, then along the curve, then by index.
  void sortTriangles() {
    const std::size_t count = triangles_.size();
    Room<std::uint8_t> size_bits(count);
    const HilbertCurve curve({tree_.cellOf(tree_.bounds_.max().x(), 0), tree_.cellOf(tree_.bounds_.max().y(), 1),
                              tree_.cellOf(tree_.bounds_.max().z(), 2)});
    int least_bits = 31, most_bits = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const CellBox box = boxOf(i);
      entries_[i] = std::uint64_t{curve.place(centreOf(box))} << kIndexBits | i;
      const int bits = bitLength(longestSide(box));
      size_bits[i] = static_cast<std::uint8_t>(bits);
      least_bits = std::min(least_bits, bits);
      most_bits = std::max(most_bits, bits);
    }
    if (most_bits - least_bits >= kSizeRatioBits) {
      for (std::size_t i = 0; i < count; ++i) {
        const int size_class = std::min((most_bits - size_bits[i]) / kSizeRatioBits, kSizeClasses - 1);
        entries_[i] |= static_cast<std::uint64_t>(size_class) << kClassShift;
      }
    }
    radixSort(entries_, sorted_);
    refineRuns(0, count, kIndexBits);
  }

  /// Where many triangles share a place, the curve is drawn again through the cube that they fill.
  void refineRuns(std::size_t begin, std::size_t end, int low_bit) {
    while (begin < end) {
      std::size_t past = begin + 1;
      while (past < end && entries_[past] >> low_bit == entries_[begin] >> low_bit) ++past;
      if (past - begin > kWidth) refineRun(begin, past);
      begin = past;
    }
  }

  void refineRun(std::size_t begin, std::size_t end) {
    std::array<std::int32_t, 3> low = centreOf(boxOf(entries_[begin] & kIndexMask)), side = low;
    for (std::size_t i = begin + 1; i < end; ++i) {
      const auto centre = centreOf(boxOf(entries_[i] & kIndexMask));
      for (std::size_t k = 0; k < 3; ++k) low[k] = std::min(low[k], centre[k]), side[k] = std::max(side[k], centre[k]);
    }
    for (std::size_t k = 0; k < 3; ++k) side[k] -= low[k];
    if (side == std::array<std::int32_t, 3>{}) return;  // all centres in one cell
    const HilbertCurve curve(side);
    const std::uint64_t size_class = entries_[begin] >> kClassShift;
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint64_t index = entries_[i] & kIndexMask;
      auto centre = centreOf(boxOf(index));
      for (std::size_t k = 0; k < 3; ++k) centre[k] -= low[k];
      entries_[i] = size_class << kClassShift | std::uint64_t{curve.place(centre)} << kIndexBits | index;
    }
    std::sort(entries_.begin() + static_cast<std::ptrdiff_t>(begin),
              entries_.begin() + static_cast<std::ptrdiff_t>(end));
    if (!curve.isFinest()) refineRuns(begin, end, kIndexBits);
  }

  /// Adds the levels of a tree over so many triangles; nodes of all trees stand one after the other.
  void planTree(std::size_t first_triangle, std::size_t triangle_count, std::size_t& node_count) {
    MeshTree::Levels levels;
    levels.triangle_count = static_cast<std::uint32_t>(triangle_count);
    levels.first_triangle = static_cast<std::uint32_t>(first_triangle);
    std::size_t count = triangle_count;
    do {
      count = (count + kWidth - 1) / kWidth;
      levels.begin[static_cast<std::size_t>(levels.size)] = static_cast<std::uint32_t>(node_count);
      levels.count[static_cast<std::size_t>(levels.size)] = static_cast<std::uint32_t>(count);
      ++levels.size;
      node_count += count;
    } while (count > 1);
    tree_.trees_.push_back(levels);
  }

  /// A run of entries along the curve that stays together; where its middle is.
  struct Block {
    std::array<std::int32_t, 3> centre;
    std::uint32_t index;
  };

  /// Pieces of the curve are slender and tangled: above them, nodes are filled from blocks halved by position instead.
  void orderBlocks(std::size_t first_entry, std::size_t triangle_count) {
    const std::size_t block_count = triangle_count / kBlock;  // the rest, less than a block, stays at the end
    if (block_count <= kWidth) return;
    std::vector<Block> blocks(block_count);
    for (std::size_t i = 0; i < block_count; ++i) {
      const std::size_t begin = first_entry + i * kBlock;
      const auto a = centreOf(boxOf(entries_[begin] & kIndexMask));
      const auto b = centreOf(boxOf(entries_[begin + kBlock / 2] & kIndexMask));
      const auto c = centreOf(boxOf(entries_[begin + kBlock - 1] & kIndexMask));
      for (std::size_t k = 0; k < 3; ++k) blocks[i].centre[k] = a[k] / 3 + b[k] / 3 + c[k] / 3;
      blocks[i].index = static_cast<std::uint32_t>(i);
    }
    std::size_t child = kWidth;
    while (child * kWidth < block_count) child *= kWidth;
    halve(blocks, 0, block_count, child);
    for (std::size_t i = 0; i < block_count; ++i) {
      const auto from = entries_.begin() + static_cast<std::ptrdiff_t>(first_entry + blocks[i].index * kBlock);
      std::copy(from, from + kBlock, sorted_.begin() + static_cast<std::ptrdiff_t>(i * kBlock));
    }
    std::copy(sorted_.begin(), sorted_.begin() + static_cast<std::ptrdiff_t>(block_count * kBlock),
              entries_.begin() + static_cast<std::ptrdiff_t>(first_entry));
  }

  /// Orders the blocks of a node so that its children, of `child` blocks each, lie apart; then each child's.
  void halve(std::vector<Block>& blocks, std::size_t begin, std::size_t end, std::size_t child) {
    while (end - begin <= child && child > kWidth) child /= kWidth;
    if (end - begin <= child) return;
    std::array<std::int32_t, 3> low = blocks[begin].centre, high = low;
    for (std::size_t i = begin + 1; i < end; ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], blocks[i].centre[k]);
        high[k] = std::max(high[k], blocks[i].centre[k]);
      }
    }
    std::size_t axis = 0;
    for (std::size_t k = 1; k < 3; ++k) axis = high[k] - low[k] > high[axis] - low[axis] ? k : axis;
    const std::size_t children = (end - begin + child - 1) / child, middle = begin + children / 2 * child;
    const auto at = [&](std::size_t i) { return blocks.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(middle), at(end), [axis](const Block& a, const Block& b) {
      return a.centre[axis] != b.centre[axis] ? a.centre[axis] < b.centre[axis] : a.index < b.index;
    });
    halve(blocks, begin, middle, child);
    halve(blocks, middle, end, child);
  }

  void fillTree(const MeshTree::Levels& levels) {
    std::vector<CellBox> below(levels.count[0]), boxes;
    CellBox lanes[kWidth];
    for (std::size_t n = 0; n < levels.count[0]; ++n) {
      const std::size_t begin = n * kWidth, count = std::min<std::size_t>(kWidth, levels.triangle_count - begin);
      for (std::size_t lane = 0; lane < count; ++lane) {
        const std::uint64_t index = entries_[levels.first_triangle + begin + lane] & kIndexMask;
        tree_.triangles_[levels.first_triangle + begin + lane] = static_cast<std::uint32_t>(index);
        lanes[lane] = boxOf(index);
      }
      below[n] = fillNode(tree_.nodes_[levels.begin[0] + n], lanes, count);
    }
    for (std::size_t level = 1; level < static_cast<std::size_t>(levels.size); ++level) {
      boxes.resize(levels.count[level]);
      for (std::size_t n = 0; n < boxes.size(); ++n) {
        const std::size_t begin = n * kWidth, count = std::min<std::size_t>(kWidth, below.size() - begin);
        boxes[n] = fillNode(tree_.nodes_[levels.begin[level] + n], &below[begin], count);
      }
      below.swap(boxes);
    }
  }

  /// Returns the box around the lanes.
  static CellBox fillNode(MeshTreeNode& node, const CellBox* lanes, std::size_t count) {
    CellBox all = lanes[0];
    for (std::size_t lane = 1; lane < count; ++lane) {
      for (std::size_t k = 0; k < 4; ++k) {
        all.lo[k] = std::min(all.lo[k], lanes[lane].lo[k]);
        all.hi[k] = std::max(all.hi[k], lanes[lane].hi[k]);
      }
    }
    node = {};
    node.setFrame(all);
    for (std::size_t lane = 0; lane < count; ++lane) node.setLane(static_cast<int>(lane), lanes[lane]);
    return all;
  }

  MeshTree& tree_;
  const std::vector<Corners>& triangles_;
  Room<Cells> cells_;                     ///< of the vertices.
  Room<std::uint64_t> entries_, sorted_;  ///< sorted_ is room to sort in.
};

MeshTree::MeshTree(const std::vector<Eigen::Vector3d>& vertices,
                   const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  if (triangles.empty()) return;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Vec3 low{kInfinity, kInfinity, kInfinity}, high = -low;
  for (const auto& triangle : triangles) {
    for (const std::uint32_t v : triangle) {
      const Vec3 p = Vec3::from(vertices[v]);
      low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
  }
  bounds_ = {low.toEigen(), high.toEigen()};
  const double side = bounds_.sizes().maxCoeff();
  // Below this side the number of cells in a metre would overflow; then all is in one cell.
  if (side > 1e-290) cells_per_metre_ = kLastCell / side;
  MeshTreeBuilder(*this, vertices, triangles).build();
}

}  // namespace ellipsoid_vehicle_sim
