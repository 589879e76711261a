#include "ellipsoid_vehicle_sim/world/mesh_file.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <exception>
#include <filesystem>
#include <limits>

#include "ellipsoid_vehicle_sim/world/file_bytes.h"
#include "mesh_readers.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr const char* kKnownExtensions = ".stl, .obj and .dae";

std::string shortNumber(double x) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.3g", x);
  return buffer;
}

/// What every mesh has to keep, whoever read it.
void checkMesh(const std::string& path, bool as_float, Loaded<MeshData>& result) {
  if (!result.value) return;
  const MeshData& mesh = *result.value;
  double largest = 0.0;
  for (std::size_t i = 0; i < mesh.triangles.size() && result.problems.empty(); ++i) {
    for (const std::uint32_t v : mesh.triangles[i]) {
      const Eigen::Vector3d& p = mesh.vertices[v];
      largest = std::max(largest, p.cwiseAbs().maxCoeff());
      if (p.allFinite()) continue;
      result.problems.push_back({path, "triangle " + std::to_string(i) + " (counted from 0) has the corner (" +
                                           shortNumber(p.x()) + ", " + shortNumber(p.y()) + ", " + shortNumber(p.z()) +
                                           "); allowed are finite coordinates"});
      break;
    }
  }
  if (mesh.triangles.empty()) result.problems.push_back({path, "holds no triangles"});
  if (!result.problems.empty()) {
    result.value.reset();
    return;
  }
  const double step = largest * std::numeric_limits<float>::epsilon();
  if (as_float && step > 1e-3) {
    result.notes.push_back(path + ": coordinates up to " + shortNumber(largest) + " are read as float, in steps of " +
                           shortNumber(step) + "; move the mesh nearer to its origin and place it by its pose");
  }
}

std::string extensionOf(const std::string& name) {
  std::string extension = std::filesystem::path(name).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

bool isText(const std::string& extension) { return extension == ".obj" || extension == ".dae"; }

Loaded<MeshData> readChecked(const std::string& bytes, const std::string& name) {
  Loaded<MeshData> result;
  const auto refuse = [&](const std::string& message) {
    result.problems.push_back({name, message});
    return result;
  };
  const std::string extension = extensionOf(name);
  if (bytes.empty()) return refuse("is empty (0 bytes)");
  if (bytes.compare(0, 23, "version https://git-lfs") == 0)
    return refuse("is a git-lfs pointer, not the mesh itself; run 'git lfs pull' in its repository");
  if (extension != ".stl" && !isText(extension))
    return refuse("unknown mesh format '" + extension + "'; known are " + kKnownExtensions);
  if (isText(extension) && bytes.find('\0') != std::string::npos) return refuse("holds zero bytes, so it is no text");
  result = extension == ".stl" ? readStl(bytes, name) : extension == ".obj" ? readObj(bytes, name) : readDae(bytes, name);
  checkMesh(name, extension == ".stl", result);
  return result;
}

/// A file is allowed to be larger than its triangles need; what is no text needs no reading to its end.
BytesWanted wantedOf(const std::string& extension) {
  return [extension](const std::string& head) -> std::uintmax_t {
    if (extension == ".stl") return bytesOfStl(head);
    return head.find('\0') == std::string::npos && isText(extension) ? kLargestMeshFile : 0;
  };
}

}  // namespace

Loaded<MeshData> readMeshBytes(const std::string& bytes, const std::string& name) {
  Loaded<MeshData> result;
  try {
    return readChecked(bytes, name);
  } catch (const std::bad_alloc&) {
    result.problems.push_back({name, "does not fit into memory"});
  } catch (const std::exception& error) {
    result.problems.push_back({name, std::string("cannot be read: ") + error.what()});
  }
  return result;
}

Loaded<MeshData> readMeshFile(const std::string& path) {
  try {
    const Loaded<std::string> bytes = readFileBytes(path, "mesh", kLargestMeshFile, wantedOf(extensionOf(path)));
    if (bytes) return readMeshBytes(*bytes.value, path);
    return {std::nullopt, bytes.problems, {}};
  } catch (const std::exception&) {
    return {std::nullopt, {{path, "does not fit into memory"}}, {}};
  }
}

}  // namespace ellipsoid_vehicle_sim
