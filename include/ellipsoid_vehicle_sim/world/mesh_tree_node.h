#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace ellipsoid_vehicle_sim {

/// A box on the grid of whole cells that a MeshTree lays over its mesh, both ends included. Cells are counted from 0 to
/// 2^31 - 1, so that differences fit into 32 signed bits. The fourth numbers are padding.
struct CellBox {
  alignas(16) std::array<std::int32_t, 4> lo;
  alignas(16) std::array<std::int32_t, 4> hi;
};

/// Eight boxes in one line of the cache. A lane's bounds are bytes: steps of 2^shift cells from the node's origin, both
/// rounded down. Two numbers rounded down by the same rule keep their order, so a box that meets a lane is never
/// missed, and one whose bytes differ strictly meets it for certain; everything is integer arithmetic, and exact.
struct alignas(64) MeshTreeNode {
  static constexpr int kWidth = 8;

  std::array<std::int32_t, 4> origin;  ///< [cells]; the fourth number is the shift.
  /// By axis: the lanes' lower bounds, then 255 less their upper bounds, so that one kind of comparison does for both.
  std::uint8_t bound[3][2 * kWidth];

  /// Frame of the least steps that reaches from lo to hi.
  void setFrame(const CellBox& box) {
    std::int32_t longest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      origin[k] = box.lo[k];
      longest = std::max(longest, box.hi[k] - box.lo[k]);
    }
    for (origin[3] = 0; (longest >> origin[3]) > 255;) ++origin[3];
  }
  void setLane(int lane, const CellBox& box) {
    for (std::size_t k = 0; k < 3; ++k) {
      bound[k][lane] = static_cast<std::uint8_t>((box.lo[k] - origin[k]) >> origin[3]);
      bound[k][kWidth + lane] = static_cast<std::uint8_t>(255 - ((box.hi[k] - origin[k]) >> origin[3]));
    }
  }
};

/// Which lanes a box meets: bit k of `meeting` for a lane that it may meet, of `certain` for one that it meets whatever
/// rounding has done.
struct MetLanes {
  unsigned meeting, certain;
};

/// The definition, lane by lane.
inline MetLanes metLanesOneByOne(const MeshTreeNode& node, const CellBox& box) {
  MetLanes met{0xff, 0xff};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto byteOf = [&](std::int32_t cell) {
      return std::clamp((cell - node.origin[k]) >> node.origin[3], 0, 255);
    };
    const int low = 255 - byteOf(box.lo[k]), high = byteOf(box.hi[k]);
    for (int lane = 0; lane < MeshTreeNode::kWidth; ++lane) {
      const int lane_low = node.bound[k][lane], lane_high = node.bound[k][MeshTreeNode::kWidth + lane];
      if (lane_low > high || lane_high > low) met.meeting &= ~(1u << lane);
      if (lane_low >= high || lane_high >= low) met.certain &= ~(1u << lane);
    }
  }
  return met;
}

/// The same, all lanes at once where the processor can.
inline MetLanes metLanes(const MeshTreeNode& node, const CellBox& box) {
#ifdef __SSE2__
  const __m128i origin = _mm_load_si128(reinterpret_cast<const __m128i*>(node.origin.data()));
  const __m128i shift = _mm_cvtsi32_si128(node.origin[3]);
  const auto load = [](const std::array<std::int32_t, 4>& cells) {
    return _mm_load_si128(reinterpret_cast<const __m128i*>(cells.data()));
  };
  const __m128i low = _mm_sra_epi32(_mm_sub_epi32(load(box.lo), origin), shift);
  const __m128i high = _mm_sra_epi32(_mm_sub_epi32(load(box.hi), origin), shift);
  // Packing saturates: below the frame becomes 0, above it 255. Bytes: high x y z ., 255 - low x y z .
  const __m128i words = _mm_packs_epi32(high, low);
  const __m128i flipped = _mm_xor_si128(_mm_packus_epi16(words, words), _mm_set_epi32(-1, 0, -1, 0));
  const __m128i pairs = _mm_unpacklo_epi8(flipped, flipped);  // each byte twice
  // Words: high x y z ., low x y z .; each is spread over eight bytes.
  __m128i meets = _mm_set1_epi8(-1), strictly = meets;
  const auto test = [&](const __m128i& spread, const std::uint8_t* bound) {
    const __m128i lanes = _mm_load_si128(reinterpret_cast<const __m128i*>(bound));
    const __m128i no_more = _mm_cmpeq_epi8(_mm_min_epu8(lanes, spread), lanes);
    meets = _mm_and_si128(meets, no_more);
    strictly = _mm_and_si128(strictly, _mm_andnot_si128(_mm_cmpeq_epi8(lanes, spread), no_more));
  };
  test(_mm_shufflehi_epi16(_mm_shufflelo_epi16(pairs, 0x00), 0x00), node.bound[0]);
  test(_mm_shufflehi_epi16(_mm_shufflelo_epi16(pairs, 0x55), 0x55), node.bound[1]);
  test(_mm_shufflehi_epi16(_mm_shufflelo_epi16(pairs, 0xaa), 0xaa), node.bound[2]);
  const auto both = [](const __m128i& mask) {
    const unsigned bits = static_cast<unsigned>(_mm_movemask_epi8(mask));
    return bits & (bits >> MeshTreeNode::kWidth) & 0xffu;
  };
  return {both(meets), both(strictly)};
#else
  return metLanesOneByOne(node, box);
#endif
}

}  // namespace ellipsoid_vehicle_sim
