#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "ellipsoid_vehicle_sim/world/terrain.h"

namespace ellipsoid_vehicle_sim {

/// To the report, corners are the same when they round to the same multiple of this part of the bounding box's
/// diagonal: files repeat corners with rounding differences, and an edge is open only if nothing meets it. (Rounding is
/// what mesh tools do; a pair nearer than that may still be parted by a border between two multiples.)
constexpr double kReportWeldRatio = 1e-6;

/// Finds duplicates and open, non-manifold and flipped edges; `read` and `zero_area` are left to the caller. Nothing is
/// changed in the mesh. A triangle that the welding makes into a line counts for nothing.
MeshReport inspectMesh(const std::vector<Eigen::Vector3d>& vertices,
                       const std::vector<std::array<std::uint32_t, 3>>& triangles);

/// For every vertex the lowest-numbered one it is welded to (itself if none): those of equal position for tolerance 0
/// (with -0 = 0), else those that round to the same multiples of the tolerance [m].
std::vector<std::uint32_t> weldVertices(const std::vector<Eigen::Vector3d>& vertices, double tolerance);

}  // namespace ellipsoid_vehicle_sim
