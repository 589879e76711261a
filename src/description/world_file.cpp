#include "ellipsoid_vehicle_sim/description/world_file.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <limits>

#include "ellipsoid_vehicle_sim/description/number_text.h"
#include "ellipsoid_vehicle_sim/description/yaml_reader.h"
#include "ellipsoid_vehicle_sim/world/mesh_file.h"

namespace ellipsoid_vehicle_sim {
namespace {

namespace fs = std::filesystem;

const NumberRange kScale{1e-6, 1e6, "a size between 1e-6 and 1e6, negative to mirror"};
const NumberRange kPlace{0.0, 1e9, "between -1e9 and 1e9"};
const NumberRange kFriction{0.0, 100.0, "between 0 and 100"};

/// One entry of `meshes`.
struct MeshEntry {
  std::string file;
  int line = 0;
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();
  Pose X_WM;  ///< pose of the mesh's frame M.
  Surface surface;
};

std::string lowerExtension(const std::string& path) {
  std::string extension = fs::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

/// Adds a mesh's triangles to the soup, scaled and placed.
void append(const MeshData& mesh, const MeshEntry& entry, std::uint16_t surface, TriangleSoup& soup) {
  const std::uint32_t base = static_cast<std::uint32_t>(soup.vertices.size());
  const Eigen::Matrix3d R_WM = entry.X_WM.q.toRotationMatrix();
  // Without a pose the numbers stay those of the file to the last bit, so that meshes that share corners still do.
  const bool turned = !R_WM.isIdentity(0.0);
  for (const Eigen::Vector3d& v : mesh.vertices) {
    const Eigen::Vector3d p_M = entry.scale.cwiseProduct(v);
    soup.vertices.push_back(entry.X_WM.p + (turned ? Eigen::Vector3d(R_WM * p_M) : p_M));
  }
  const bool mirrors = entry.scale.prod() < 0.0;
  for (const auto& t : mesh.triangles) {
    soup.triangles.push_back({base + t[0], base + t[mirrors ? 2 : 1], base + t[mirrors ? 1 : 2]});
  }
  soup.surface.resize(soup.triangles.size(), surface);
}

bool differInFriction(const Surface& a, const Surface& b) {
  return a.mu_static != b.mu_static || a.mu_kinetic != b.mu_kinetic;
}

class WorldReader : private YamlReader {
 public:
  WorldReader(const std::string& path, const UriResolver& resolver) : YamlReader(path), resolver_(resolver) {}

  Loaded<WorldDescription> readMesh() {
    MeshEntry entry;
    entry.file = path();
    entry.surface.name = fs::path(path()).stem().string();
    load(entry);
    return finish();
  }

  Loaded<WorldDescription> readYaml() {
    if (const std::optional<YAML::Node> root = open("world")) readRoot(*root);
    return finish();
  }

 private:
  Loaded<WorldDescription> finish() {
    world_.name = fs::path(path()).stem().string();
    result_.problems = std::move(problems);
    if (result_.problems.empty()) result_.value = std::move(world_);
    return std::move(result_);
  }

  void readRoot(const YAML::Node& root) {
    if (!root.IsMap()) return problem(root, "a world is a dictionary with the keys meshes and start");
    bool has_meshes = false;
    std::vector<MeshEntry> entries;
    forEachKey(root, {"meshes", "start"}, [&](const std::string& key, const YAML::Node& value) {
      if (key == "start") {
        const auto start = numbers(value, "start", 3, kPlace, "[x, y, yaw]");
        if (start) world_.start = {(*start)[0], (*start)[1], (*start)[2]};
        return;
      }
      has_meshes = true;
      if (!value.IsSequence() || value.size() == 0)
        return problem(value, "'meshes' is not a list of at least one mesh");
      for (const YAML::Node& item : value) readEntry(item, entries);
    });
    if (!has_meshes) problem(root, "no 'meshes': a world is made of at least one");
    for (const MeshEntry& entry : entries) load(entry);
  }

  void readEntry(const YAML::Node& node, std::vector<MeshEntry>& entries) {
    if (!node.IsMap()) return problem(node, "a mesh is a dictionary with the key file");
    MeshEntry entry;
    entry.line = node.Mark().line + 1;
    const std::size_t problems_before = problems.size();
    bool has_file = false;
    const std::vector<std::string> keys = {"file", "scale", "pose", "mu_static", "mu_kinetic", "surface"};
    forEachKey(node, keys, [&](const std::string& key, const YAML::Node& value) {
      if (key == "file") {
        has_file = true;
        entry.file = text(value, key);
        entry.line = value.Mark().line + 1;
      } else if (key == "surface") {
        entry.surface.name = text(value, key);
      } else if (key == "scale") {
        readScale(value, entry);
      } else if (key == "pose") {
        const auto pose = numbers(value, key, 6, kPlace, "[x, y, z, roll, pitch, yaw]");
        if (!pose) return;
        entry.X_WM.p = {(*pose)[0], (*pose)[1], (*pose)[2]};
        entry.X_WM.q = quaternionFromRpy((*pose)[3], (*pose)[4], (*pose)[5]);
      } else {
        const std::optional<double> mu = number(value, key, kFriction, false);
        (key == "mu_static" ? entry.surface.mu_static : entry.surface.mu_kinetic) = mu;
      }
    });
    if (!has_file) problem(node, "a mesh without 'file'");
    if (!has_file || problems.size() != problems_before) return;

    Surface& surface = entry.surface;
    if (surface.name.empty()) surface.name = fs::path(entry.file).stem().string();
    if (surface.mu_kinetic && !surface.mu_static) {
      return problem(
          node, "mu_kinetic " + numberText(*surface.mu_kinetic) + " without mu_static; give both or mu_static alone");
    }
    if (surface.mu_static && !surface.mu_kinetic) surface.mu_kinetic = surface.mu_static;
    if (surface.mu_kinetic && *surface.mu_kinetic > *surface.mu_static) {
      return problem(node, "mu_kinetic " + numberText(*surface.mu_kinetic) + " is more than mu_static " +
                               numberText(*surface.mu_static) + "; allowed is up to it");
    }
    entries.push_back(std::move(entry));
  }

  void readScale(const YAML::Node& value, MeshEntry& entry) {
    if (value.IsSequence()) {
      const auto scale = numbers(value, "scale", 3, kScale, "one number or [x, y, z]");
      if (scale) entry.scale = {(*scale)[0], (*scale)[1], (*scale)[2]};
    } else if (const auto scale = number(value, "scale", kScale, true)) {
      entry.scale.setConstant(*scale);
    }
  }

  std::optional<std::string> locate(const MeshEntry& entry) {
    if (entry.line == 0) return entry.file;
    const bool is_uri = entry.file.find("://") != std::string::npos;
    if (!is_uri) return (fs::path(path()).parent_path() / entry.file).string();
    const std::optional<std::string> found = resolver_ ? resolver_(entry.file) : std::nullopt;
    if (!found) {
      problems.push_back({path() + ":" + std::to_string(entry.line),
                                  "'" + entry.file + "' is not found: no such package, or no such file in it"});
    }
    return found;
  }

  std::optional<std::uint16_t> surfaceIndex(const MeshEntry& entry) {
    std::vector<Surface>& surfaces = world_.soup.surfaces;
    const auto found =
        std::find_if(surfaces.begin(), surfaces.end(), [&](const Surface& s) { return s.name == entry.surface.name; });
    const std::string where = path() + ":" + std::to_string(entry.line);
    if (found != surfaces.end() && differInFriction(*found, entry.surface)) {
      problems.push_back({where, "surface '" + entry.surface.name +
                                             "' has another friction further up; name it by another 'surface'"});
      return std::nullopt;
    }
    if (found == surfaces.end()) {
      if (surfaces.size() > std::numeric_limits<std::uint16_t>::max()) {
        problems.push_back({where, "more than 65536 surfaces"});
        return std::nullopt;
      }
      surfaces.push_back(entry.surface);
      return static_cast<std::uint16_t>(surfaces.size() - 1);
    }
    return static_cast<std::uint16_t>(found - surfaces.begin());
  }

  void load(const MeshEntry& entry) {
    const std::optional<std::uint16_t> surface = surfaceIndex(entry);
    const std::optional<std::string> file = locate(entry);
    if (!file) return;
    world_.files.push_back(*file);
    const Loaded<MeshData> mesh = readMeshFile(*file);
    for (Problem problem : mesh.problems) {
      if (entry.line > 0) problem = {path() + ":" + std::to_string(entry.line), problem.text()};
      problems.push_back(std::move(problem));
    }
    result_.notes.insert(result_.notes.end(), mesh.notes.begin(), mesh.notes.end());
    if (!mesh || !surface) return;
    if (world_.soup.vertices.size() + mesh.value->vertices.size() > std::numeric_limits<std::uint32_t>::max()) {
      problems.push_back({path(), "more than 4294967295 vertices in all meshes"});
      return;
    }
    append(*mesh.value, entry, *surface, world_.soup);
  }

  const UriResolver& resolver_;
  Loaded<WorldDescription> result_;
  WorldDescription world_;
};

}  // namespace

Loaded<WorldDescription> loadWorld(const std::string& path, const UriResolver& resolver) {
  WorldReader reader(path, resolver);
  const std::string extension = lowerExtension(path);
  return extension == ".yaml" || extension == ".yml" ? reader.readYaml() : reader.readMesh();
}

Loaded<WorldDescription> loadWorld(const std::string& path) {
  const fs::path folder = fs::absolute(path).parent_path();
  return loadWorld(path, fileResolver({folder.string(), folder.parent_path().string()}, folder.string()));
}

}  // namespace ellipsoid_vehicle_sim
