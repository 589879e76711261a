#pragma once

#include <array>
#include <cstdint>

namespace ellipsoid_vehicle_sim {

/// Hilbert's curve through the cells of a box: neighbours on the curve are neighbours in space. While the box's
/// shortest side fits into one cell, the curve is the one through the plane of the other two, so that flat ground is
/// not cut into slices; below that it is the one through space. Source: notation.h [Hamilton2006].
class HilbertCurve {
 public:
  static constexpr int kPlaceBits = 30;

  /// The curve through [0, side] along each axis, 0 <= side < 2^31.
  explicit HilbertCurve(const std::array<std::int32_t, 3>& side);

  /// Place of a cell in the box on the curve, below 2^kPlaceBits; cells nearer than the curve's steps may share one.
  std::uint32_t place(const std::array<std::int32_t, 3>& cell) const;

  /// True when no two cells share a place.
  bool isFinest() const { return shift_ == 0; }

 private:
  std::array<std::uint8_t, 3> axis_;  ///< longest side first.
  int flat_levels_, deep_levels_;     ///< halvings of the plane, then of space; both even.
  int shift_;                         ///< from cells to the curve's steps.
};

}  // namespace ellipsoid_vehicle_sim
