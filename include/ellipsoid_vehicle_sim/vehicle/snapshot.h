#pragma once

#include <cstdint>
#include <vector>

#include "ellipsoid_vehicle_sim/geometry/problem.h"
#include "ellipsoid_vehicle_sim/vehicle/simulator.h"

namespace ellipsoid_vehicle_sim {

/// A simulator's whole state apart from the clock: contact memory, friction anchors, paths, commands with their age,
/// servo integrals. `extra` is carried along for whoever keeps a state beside the simulator's.
struct Snapshot {
  VehicleState state;
  VehicleState home;  ///< what reset() returns to.
  StepEvents events;
  double friction_scale = 1.0;
  std::vector<std::uint8_t> extra;
};

/// Bytes for a file or a message: a mark, the format's version, vehicle, world and parameters it belongs to, the values
/// bit by bit, and a checksum. The same on every machine.
std::vector<std::uint8_t> toBytes(const Snapshot& snapshot, const Simulator& simulator);

/// Reads them back for `simulator`. Problems: not a snapshot, another version, damaged, or of another vehicle, world or
/// parameters, which are named. `where` stands before each.
Loaded<Snapshot> fromBytes(const std::vector<std::uint8_t>& bytes, const Simulator& simulator,
                           const std::string& where);

/// Little-endian values one after the other; for `extra`.
class ByteWriter {
 public:
  void add(std::uint8_t value) { bytes_.push_back(value); }
  void add(std::uint64_t value);
  void add(std::int64_t value) { add(static_cast<std::uint64_t>(value)); }
  void add(double value);
  void add(const std::string& text);
  void add(const std::vector<std::uint8_t>& bytes);
  const std::vector<std::uint8_t>& bytes() const { return bytes_; }

 private:
  std::vector<std::uint8_t> bytes_;
};

/// The other way. After the first value that is not there, everything reads as zero and ok() is false.
class ByteReader {
 public:
  ByteReader(const std::uint8_t* begin, const std::uint8_t* end) : next_(begin), end_(end) {}

  std::uint8_t byte();
  std::uint64_t whole();
  double number();
  std::string text();
  std::vector<std::uint8_t> block();
  bool ok() const { return ok_; }
  bool atEnd() const { return next_ == end_; }

 private:
  const std::uint8_t* next_;
  const std::uint8_t* end_;
  bool ok_ = true;
};

}  // namespace ellipsoid_vehicle_sim
