#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

namespace ellipsoid_vehicle_sim {

/// What vertices are told apart by: three doubles, compared bit by bit (so that NaNs, too, are equal to themselves).
struct VertexKey {
  std::array<std::uint64_t, 3> bits;

  /// Adding +0 turns -0 into 0.
  VertexKey(double x, double y, double z) {
    const std::array<double, 3> values = {x + 0.0, y + 0.0, z + 0.0};
    std::memcpy(bits.data(), values.data(), sizeof bits);
  }
  bool operator==(const VertexKey& other) const { return bits == other.bits; }

  std::uint64_t hash() const {
    return mix(bits[0] * 0x9e3779b97f4a7c15u ^ mix(bits[1] * 0xd1342543de82ef95u ^ mix(bits[2])));
  }

 private:
  static std::uint64_t mix(std::uint64_t h) {
    h ^= h >> 32;
    h *= 0x9e3779b97f4a7c15u;
    h ^= h >> 29;
    h *= 0xbf58476d1ce4e5b9u;
    return h ^ (h >> 32);
  }
};

/// Open addressing over vertices that stand elsewhere, at half load or less; grows as they come.
class VertexTable {
 public:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  explicit VertexTable(std::size_t expected) { slots_.assign(sizeFor(expected), kNone); }

  /// The number that was entered with this key, or `number`, which then is entered. keyOf(i): key of number i.
  template <typename KeyOf>
  std::uint32_t findOrEnter(const VertexKey& key, std::uint32_t number, KeyOf&& keyOf) {
    std::uint32_t& slot = slots_[place(key, keyOf)];
    if (slot != kNone) return slot;
    slot = number;
    if (2 * ++used_ > slots_.size()) grow(keyOf);
    return number;
  }

 private:
  static std::size_t sizeFor(std::size_t n) {
    std::size_t size = 16;
    while (size < 2 * n) size *= 2;
    return size;
  }

  template <typename KeyOf>
  std::size_t place(const VertexKey& key, KeyOf&& keyOf) const {
    const std::size_t last = slots_.size() - 1;
    std::size_t i = key.hash() & last;
    while (slots_[i] != kNone && !(keyOf(slots_[i]) == key)) i = (i + 1) & last;
    return i;
  }

  template <typename KeyOf>
  void grow(KeyOf&& keyOf) {
    const std::vector<std::uint32_t> old = std::move(slots_);
    slots_.assign(2 * old.size(), kNone);
    for (const std::uint32_t number : old)
      if (number != kNone) slots_[place(keyOf(number), keyOf)] = number;
  }

  std::vector<std::uint32_t> slots_;
  std::size_t used_ = 0;
};

/// Numbers vertices as they come, equal ones (-0 = 0) once: files that repeat them then take a sixth of the memory.
class VertexWelder {
 public:
  explicit VertexWelder(std::vector<Eigen::Vector3d>& vertices) : vertices_(vertices), table_(vertices.size()) {}

  std::uint32_t numberOf(const Eigen::Vector3d& v) {
    const auto keyOf = [this](std::uint32_t i) { return VertexKey(vertices_[i].x(), vertices_[i].y(), vertices_[i].z()); };
    const auto next = static_cast<std::uint32_t>(vertices_.size());
    vertices_.push_back(v);
    const std::uint32_t number = table_.findOrEnter(VertexKey(v.x(), v.y(), v.z()), next, keyOf);
    if (number != next) vertices_.pop_back();
    return number;
  }

 private:
  std::vector<Eigen::Vector3d>& vertices_;
  VertexTable table_;
};

}  // namespace ellipsoid_vehicle_sim
