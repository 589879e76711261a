#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/geometry/problem.h"

namespace ellipsoid_vehicle_sim {

/// The triangles of a mesh file, in file order and in the file's own frame: nothing dropped or reordered, zero-area
/// triangles included; every coordinate finite, every index in range. Vertices are as stored, but that those an STL
/// file repeats for each triangle are there once.
struct MeshData {
  std::vector<Eigen::Vector3d> vertices;  ///< in metres, if the file says so or nothing (DAE `unit` applied).
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< counter-clockwise seen from the front.
};

/// Reads a mesh by its extension: .stl (binary or text), .obj, .dae. What is read is what RViz draws:
///  - DAE: node matrices, with non-uniform scale and rotation, and `unit meter` are applied, `up_axis` is not. Under a
///    mirroring matrix the order of the corners is turned, so that the outside as modelled stays the outside.
///  - Polygons are cut into triangles, concave ones too. Points, lines, materials and textures are ignored, with a
///  note.
///  - A binary STL may begin with "solid": the length decides.
/// All are read here, in double precision and with line numbers, and not by assimp as RViz does: mesh_file_*.cpp say why.
/// Never throws and gives one problem that names the file, and the line or triangle, for: no such file, a folder, an
/// unknown extension, a git-lfs pointer, a file that is cut off or announces more than it holds, a number that is none,
/// nan or infinite, an index out of range, no triangles.
Loaded<MeshData> readMeshFile(const std::string& path);

/// The same from bytes; `name` stands for the file in messages, and its extension says what they are.
Loaded<MeshData> readMeshBytes(const std::string& bytes, const std::string& name);

}  // namespace ellipsoid_vehicle_sim
