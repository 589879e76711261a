#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "ellipsoid_vehicle_sim/geometry/problem.h"

namespace ellipsoid_vehicle_sim {

/// Most bytes of a file: 43 million triangles of a binary STL, and far more than anybody writes by hand.
constexpr std::uintmax_t kLargestMeshFile = std::uintmax_t{2} << 30;
constexpr std::uintmax_t kLargestXmlFile = std::uintmax_t{64} << 20;
constexpr std::uintmax_t kLargestYamlFile = std::uintmax_t{8} << 20;

/// How many bytes of a file are wanted, asked once its first 64 KiB (or all of it) are read; more than there are: all.
using BytesWanted = std::function<std::uintmax_t(const std::string& head)>;

/// Reads a file that somebody named, `what` it should be in words ("mesh"). One problem, and nothing is read, for: no
/// such file, a folder, a pipe, a socket or a device (which may never end), more than `most` bytes. An empty file is
/// an empty value. Without `wanted` the whole file is read.
Loaded<std::string> readFileBytes(const std::string& path, const std::string& what, std::uintmax_t most,
                                  const BytesWanted& wanted = {});

}  // namespace ellipsoid_vehicle_sim
