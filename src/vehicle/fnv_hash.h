#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

namespace ellipsoid_vehicle_sim {

/// FNV-1a, 64 bit [FowlerNollVo]. Values are added one by one: padding bytes never count.
class FnvHash {
 public:
  void add(std::uint8_t byte) {
    hash_ ^= byte;
    hash_ *= 1099511628211ull;
  }
  void add(std::uint64_t bits) {
    for (int i = 0; i < 8; ++i) add(static_cast<std::uint8_t>(bits >> (8 * i) & 0xffu));
  }
  void add(double value) {
    std::uint64_t bits;
    std::memcpy(&bits, &value, sizeof bits);
    add(bits);
  }
  void add(const std::string& text) {
    add(static_cast<std::uint64_t>(text.size()));
    for (const char c : text) add(static_cast<std::uint8_t>(c));
  }
  std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 14695981039346656037ull;
};

}  // namespace ellipsoid_vehicle_sim
