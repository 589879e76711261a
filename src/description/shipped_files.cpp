#include "ellipsoid_vehicle_sim/description/shipped_files.h"

#include <filesystem>

#include "ellipsoid_vehicle_sim/world/file_bytes.h"

namespace ellipsoid_vehicle_sim {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPackage = "ellipsoid_vehicle_sim";

bool isWorldYaml(const fs::path& file) {
  const Loaded<std::string> text = readFileBytes(file.string(), "world", kLargestYamlFile);
  return text && (text.value->rfind("meshes:", 0) == 0 || text.value->find("\nmeshes:") != std::string::npos);
}

}  // namespace

std::string shareFolderBesideProgram() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  const fs::path share = program.parent_path().parent_path().parent_path() / "share" / kPackage;
  return !error && fs::is_directory(share, error) ? share.string() : "";
}

ShippedNames shippedVehicles(const std::string& share) {
  ShippedNames names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(fs::path(share) / "urdf", error)) {
    if (entry.path().extension() == ".urdf") names[entry.path().stem()] = entry.path();
  }
  return names;
}

ShippedNames shippedWorlds(const std::string& share) {
  ShippedNames names;
  std::error_code error;
  for (const auto& entry : fs::recursive_directory_iterator(fs::path(share) / "launch", error)) {
    if (entry.path().extension() == ".yaml" && isWorldYaml(entry.path())) names[entry.path().stem()] = entry.path();
  }
  return names;
}

ShippedNames shippedScenes(const std::string& share) {
  ShippedNames names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(fs::path(share) / "launch" / "scenes", error)) {
    if (entry.path().extension() == ".yaml" && !isWorldYaml(entry.path())) names[entry.path().stem()] = entry.path();
  }
  return names;
}

Loaded<std::string> findShipped(const ShippedNames& names, const std::string& what, const std::string& name_or_path,
                                const std::string& where, const std::string& folder) {
  Loaded<std::string> result;
  std::error_code error;
  const auto shipped = names.find(name_or_path);
  const fs::path path = fs::path(folder) / name_or_path;
  if (shipped != names.end()) {
    result.value = shipped->second;
  } else if (!name_or_path.empty() && fs::is_regular_file(path, error)) {
    result.value = fs::absolute(path).string();
  } else {
    std::string known;
    for (const auto& named : names) known += (known.empty() ? "" : ", ") + named.first;
    const bool looks_like_path = name_or_path.find_first_of("/.") != std::string::npos;
    result.problems.push_back(
        {where, "'" + name_or_path + "' is " + (looks_like_path ? "no file that can be read" : "no known " + what) +
                    "; known " + what + "s: " + (known.empty() ? "none" : known) + ", or give the path of a file"});
  }
  return result;
}

UriResolver shippedResolver(std::vector<std::string> package_dirs, const std::string& file, const std::string& share,
                            std::function<std::string(const std::string&)> package_path) {
  const std::string folder = fs::path(file).parent_path().string();
  if (package_dirs.empty()) package_dirs = packageDirsOf(file);
  const UriResolver given = fileResolver(package_dirs, folder);
  return [given, share, package_path](const std::string& uri) -> std::optional<std::string> {
    if (auto found = given(uri)) return found;
    constexpr const char* kScheme = "package://";
    if (uri.rfind(kScheme, 0) != 0) return std::nullopt;
    const std::string rest = uri.substr(std::string(kScheme).size());
    const std::size_t slash = rest.find('/');
    if (slash == std::string::npos) return std::nullopt;
    const std::string package = rest.substr(0, slash);
    const std::string root = package == kPackage ? share : package_path ? package_path(package) : "";
    std::error_code error;
    const fs::path path = fs::path(root) / rest.substr(slash + 1);
    if (root.empty() || !fs::is_regular_file(path, error)) return std::nullopt;
    return path.string();
  };
}

}  // namespace ellipsoid_vehicle_sim
