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

/// Two levels at once, for every state and two parts: the next state, times the number of parts, plus the place.
template <unsigned kAxes>
struct TwoLevels {
  static constexpr unsigned kParts = 1u << (2 * kAxes), kMask = kParts - 1u;
  std::array<std::uint16_t, (1u << kAxes) * kAxes * kParts> next{};
  constexpr TwoLevels() {
    for (unsigned from = 0; from < (1u << kAxes) * kAxes; ++from) {
      for (unsigned parts = 0; parts < kParts; ++parts) {
        State state{from / kAxes, from % kAxes};
        const unsigned first = enter<kAxes>(state, parts >> kAxes);
        const unsigned second = enter<kAxes>(state, parts & ((1u << kAxes) - 1u));
        next[from * kParts + parts] =
            static_cast<std::uint16_t>((state.entry * kAxes + state.axis) * kParts + (first << kAxes) + second);
      }
    }
  }
};
constexpr TwoLevels<2> kPlane;
constexpr TwoLevels<3> kSpace;

/// Two levels' bits of one axis, at the places they have among the parts.
template <unsigned kAxes>
constexpr std::uint32_t spread(std::uint32_t two_bits) {
  return (two_bits & 1u) | (two_bits & 2u) << (kAxes - 1);
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
  std::uint32_t place = 0;
  unsigned state = 0;
  int shift = flat_levels_ + deep_levels_ - 2;
  for (; shift >= deep_levels_; shift -= 2) {
    const unsigned to = kPlane.next[state + (spread<2>(at[0] >> shift) | spread<2>(at[1] >> shift) << 1)];
    place = place << 4 | (to & kPlane.kMask);
    state = to & ~kPlane.kMask;
  }
  for (state = 0; shift >= 0; shift -= 2) {
    const unsigned to = kSpace.next[state + (spread<3>(at[0] >> shift) | spread<3>(at[1] >> shift) << 1 |
                                             spread<3>(at[2] >> shift) << 2)];
    place = place << 6 | (to & kSpace.kMask);
    state = to & ~kSpace.kMask;
  }
  return place;
}

}  // namespace ellipsoid_vehicle_sim
