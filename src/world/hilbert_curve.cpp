#include "hilbert_curve.h"

#include <algorithm>

namespace ellipsoid_vehicle_sim {
namespace {

/// Where a sub-cube's curve enters (a corner, a bit an axis) and along which axis it leaves.
struct State {
  unsigned entry = 0, axis = 0;
};

constexpr unsigned gray(unsigned i) { return i ^ (i >> 1); }
constexpr unsigned trailingOnes(unsigned i) {
  unsigned count = 0;
  for (; i & 1u; i >>= 1) ++count;
  return count;
}

template <unsigned kAxes>
constexpr unsigned rotatedLeft(unsigned bits, unsigned by) {
  return ((bits << by) | (bits >> (kAxes - by))) & ((1u << kAxes) - 1u);
}

/// One level: the place of a part (a bit an axis) on the state's curve, and the state of the curve inside it.
/// [Hamilton2006] algorithm 2.
template <unsigned kAxes>
constexpr unsigned enter(State& state, unsigned part) {
  const unsigned turn = (state.axis + 1) % kAxes;
  const unsigned coded = rotatedLeft<kAxes>(part ^ state.entry, (kAxes - turn) % kAxes);
  const unsigned place = coded ^ (coded >> 1) ^ (coded >> 2);  // the inverse of gray() up to three bits
  const unsigned corner = place == 0 ? 0 : gray((place - 1) & ~1u);
  const unsigned direction = place == 0 ? 0 : trailingOnes(place % 2 == 0 ? place - 1 : place) % kAxes;
  state = {state.entry ^ rotatedLeft<kAxes>(corner, turn), (state.axis + direction + 1) % kAxes};
  return place;
}

/// Several levels at once, for every state and that many parts: the next state, times the number of parts, plus the
/// place.
template <unsigned kAxes, unsigned kLevels>
struct Levels {
  static constexpr unsigned kBits = kAxes * kLevels, kParts = 1u << kBits, kMask = kParts - 1u;
  std::array<std::uint16_t, (1u << kAxes) * kAxes * kParts> next{};
  constexpr Levels() {
    for (unsigned from = 0; from < (1u << kAxes) * kAxes; ++from) {
      for (unsigned parts = 0; parts < kParts; ++parts) {
        State state{from / kAxes, from % kAxes};
        unsigned place = 0;
        for (unsigned level = kLevels; level-- > 0;)
          place = place << kAxes | enter<kAxes>(state, parts >> (level * kAxes) & ((1u << kAxes) - 1u));
        next[from * kParts + parts] = static_cast<std::uint16_t>((state.entry * kAxes + state.axis) * kParts + place);
      }
    }
  }
};
constexpr Levels<2, 2> kPlane;
constexpr Levels<2, 4> kPlaneByFour;
constexpr Levels<3, 2> kSpace;

/// Two levels' bits of one axis, at the places they have among the parts.
constexpr std::uint32_t spread(std::uint32_t two_bits) { return (two_bits & 1u) | (two_bits & 2u) << 2; }

/// The lower sixteen bits, each followed by a zero.
constexpr std::uint32_t spreadInPlane(std::uint32_t x) {
  x &= 0xffffu;
  x = (x | x << 8) & 0x00ff00ffu;
  x = (x | x << 4) & 0x0f0f0f0fu;
  x = (x | x << 2) & 0x33333333u;
  return (x | x << 1) & 0x55555555u;
}

int bitLength(std::int32_t x) { return x == 0 ? 0 : 32 - __builtin_clz(static_cast<unsigned>(x)); }

}  // namespace

HilbertCurve::HilbertCurve(const std::array<std::int32_t, 3>& side) : axis_{0, 1, 2} {
  std::stable_sort(axis_.begin(), axis_.end(), [&](std::uint8_t a, std::uint8_t b) { return side[a] > side[b]; });
  const int bits = bitLength(side[axis_[0]]);
  flat_levels_ = std::min(bits - bitLength(side[axis_[2]]), kPlaceBits / 2 - 1) & ~1;
  deep_levels_ = (kPlaceBits - 2 * flat_levels_) / 3 & ~1;
  shift_ = std::max(0, bits - flat_levels_ - deep_levels_);
}

std::uint32_t HilbertCurve::place(const std::array<std::int32_t, 3>& cell) const {
  std::array<std::uint32_t, 3> at;
  for (std::size_t k = 0; k < 3; ++k) at[k] = static_cast<std::uint32_t>(cell[axis_[k]]) >> shift_;
  // The plane's parts one after the other, two bits a level, the last level in the lowest.
  const std::uint32_t parts = spreadInPlane(at[0] >> deep_levels_) | spreadInPlane(at[1] >> deep_levels_) << 1;
  std::uint32_t place = 0;
  unsigned state = 0;  // times the number of parts of a table
  int level = flat_levels_;
  if (level % 4 != 0) {
    level -= 2;
    const unsigned to = kPlane.next[parts >> 2 * level & kPlane.kMask];
    place = to & kPlane.kMask;
    state = (to & ~kPlane.kMask) << (kPlaneByFour.kBits - kPlane.kBits);
  }
  while (level > 0) {
    level -= 4;
    const unsigned to = kPlaneByFour.next[state + (parts >> 2 * level & kPlaneByFour.kMask)];
    place = place << kPlaneByFour.kBits | (to & kPlaneByFour.kMask);
    state = to & ~kPlaneByFour.kMask;
  }
  state = 0;
  for (int shift = deep_levels_ - 2; shift >= 0; shift -= 2) {
    const unsigned to =
        kSpace.next[state + (spread(at[0] >> shift) | spread(at[1] >> shift) << 1 | spread(at[2] >> shift) << 2)];
    place = place << kSpace.kBits | (to & kSpace.kMask);
    state = to & ~kSpace.kMask;
  }
  return place;
}

}  // namespace ellipsoid_vehicle_sim
