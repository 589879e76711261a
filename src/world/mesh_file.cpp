#include "ellipsoid_vehicle_sim/world/mesh_file.h"

#include <assimp/config.h>
#include <assimp/scene.h>
#include <Eigen/LU>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <limits>

#include "mesh_readers.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr const char* kKnownExtensions = ".stl, .obj and .dae";

std::string shortNumber(double x) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.3g", x);
  return buffer;
}

Loaded<std::string> readBytes(const std::string& path) {
  Loaded<std::string> result;
  const auto refuse = [&](const std::string& message) {
    result.problems.push_back({path, message});
    return result;
  };
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) return refuse("there is no such file");
  if (std::filesystem::is_directory(status)) return refuse("is a folder, not a mesh file");
  if (!std::filesystem::is_regular_file(status)) return refuse("is not a regular file");
  std::ifstream file(path, std::ios::binary);
  if (!file) return refuse(std::string("cannot be opened: ") + std::strerror(errno));
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) return refuse("cannot be read: " + error.message());
  if (size == 0) return refuse("is empty (0 bytes)");
  std::string text(size, '\0');
  file.read(text.data(), static_cast<std::streamsize>(size));
  if (!file)
    return refuse("could be read only up to byte " + std::to_string(file.gcount()) + " of " + std::to_string(size));
  if (text.compare(0, 23, "version https://git-lfs") == 0) {
    return refuse("is a git-lfs pointer, not the mesh itself; run 'git lfs pull' in its repository");
  }
  result.value = std::move(text);
  return result;
}

Eigen::Matrix4d matrixOf(const aiMatrix4x4& m) {
  Eigen::Matrix4d result;
  result << m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1, m.c2, m.c3, m.c4, m.d1, m.d2, m.d3, m.d4;
  return result;
}

/// Collects a scene's triangles, node by node in document order.
class SceneWalk {
 public:
  SceneWalk(const aiScene& scene, const std::string& path) : scene_(scene), path_(path) {}

  Loaded<MeshData> walk() {
    if (scene_.mRootNode != nullptr) visit(*scene_.mRootNode, Eigen::Matrix4d::Identity());
    if (!result_.problems.empty()) return std::move(result_);
    if (ignored_ > 0) result_.notes.push_back(path_ + ": " + std::to_string(ignored_) + " points and lines ignored");
    result_.value = std::move(mesh_);
    return std::move(result_);
  }

 private:
  void visit(const aiNode& node, const Eigen::Matrix4d& parent) {
    const Eigen::Matrix4d X_W = parent * matrixOf(node.mTransformation);
    for (unsigned i = 0; i < node.mNumMeshes && result_.problems.empty(); ++i) {
      append(*scene_.mMeshes[node.mMeshes[i]], X_W);
    }
    for (unsigned i = 0; i < node.mNumChildren && result_.problems.empty(); ++i) visit(*node.mChildren[i], X_W);
  }

  void append(const aiMesh& mesh, const Eigen::Matrix4d& X_W) {
    const std::size_t base = mesh_.vertices.size();
    if (base + mesh.mNumVertices > std::numeric_limits<std::uint32_t>::max()) {
      result_.problems.push_back({path_, "more than 4294967295 vertices"});
      return;
    }
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      const Eigen::Vector4d p(mesh.mVertices[v].x, mesh.mVertices[v].y, mesh.mVertices[v].z, 1.0);
      mesh_.vertices.push_back((X_W * p).head<3>());
    }
    // A mirror turns the sense of the corners: turn it back, so that the front stays on the outside.
    const bool mirrors = X_W.topLeftCorner<3, 3>().determinant() < 0.0;
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices < 3) {
        ++ignored_;
        continue;
      }
      polygon_.clear();
      for (unsigned k = 0; k < face.mNumIndices; ++k) {
        if (face.mIndices[k] >= mesh.mNumVertices) {
          result_.problems.push_back({path_, "face " + std::to_string(f) + " (counted from 0) has vertex number " +
                                                 std::to_string(face.mIndices[k]) + " of " +
                                                 std::to_string(mesh.mNumVertices)});
          return;
        }
        polygon_.push_back(static_cast<std::uint32_t>(base) + face.mIndices[k]);
      }
      if (mirrors) std::reverse(polygon_.begin() + 1, polygon_.end());
      appendPolygon(mesh_.vertices, polygon_.data(), polygon_.size(), mesh_.triangles);
    }
  }

  const aiScene& scene_;
  const std::string& path_;
  Loaded<MeshData> result_;
  MeshData mesh_;
  std::vector<std::uint32_t> polygon_;
  std::size_t ignored_ = 0;
};

Loaded<MeshData> readDae(const std::string& text, const std::string& path) {
  Loaded<MeshData> result;
  result.problems = checkDae(text, path);
  if (!result.problems.empty()) return result;

  // No post-processing step: each of them may merge, drop or reorder something.
  Assimp::Importer importer;
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
  const aiScene* scene = importer.ReadFileFromMemory(text.data(), text.size(), 0, "dae");
  if (scene == nullptr) {
    result.problems.push_back({path, std::string("cannot be read: ") + importer.GetErrorString()});
    return result;
  }
  // Without a mesh assimp draws the skeleton of the nodes instead, and says so by this flag.
  if (scene->mFlags & AI_SCENE_FLAGS_INCOMPLETE) {
    result.value = MeshData();
    return result;
  }
  return SceneWalk(*scene, path).walk();
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

Loaded<MeshData> readChecked(const std::string& path) {
  Loaded<MeshData> result;
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const bool is_known = extension == ".stl" || extension == ".obj" || extension == ".dae";

  Loaded<std::string> text = readBytes(path);
  if (!text) {
    result.problems = std::move(text.problems);
  } else if (!is_known) {
    result.problems.push_back({path, "unknown mesh format '" + extension + "'; known are " + kKnownExtensions});
  } else {
    result = extension == ".stl"   ? readStl(*text.value, path)
             : extension == ".obj" ? readObj(*text.value, path)
                                   : readDae(*text.value, path);
    checkMesh(path, extension != ".obj", result);
  }
  return result;
}

}  // namespace

Loaded<MeshData> readMeshFile(const std::string& path) {
  Loaded<MeshData> result;
  try {
    return readChecked(path);
  } catch (const std::bad_alloc&) {
    result.problems.push_back({path, "does not fit into memory"});
  } catch (const std::exception& error) {
    result.problems.push_back({path, std::string("cannot be read: ") + error.what()});
  }
  return result;
}

}  // namespace ellipsoid_vehicle_sim
