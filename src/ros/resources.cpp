#include "ellipsoid_vehicle_sim/ros/resources.h"

#include <ros/package.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>

namespace ellipsoid_vehicle_sim {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPackage = "ellipsoid_vehicle_sim";

/// A YAML file with a top-level list of meshes is a world; simulator.yaml beside it is not.
bool isWorldYaml(const fs::path& file) {
  std::ifstream in(file);
  std::string line;
  while (std::getline(in, line)) {
    if (line.rfind("meshes:", 0) == 0) return true;
  }
  return false;
}

/// Name without folder and ending -> path.
std::map<std::string, std::string> shippedVehicles() {
  std::map<std::string, std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(fs::path(shareFolder()) / "urdf", error)) {
    if (entry.path().extension() == ".urdf") names[entry.path().stem()] = entry.path();
  }
  return names;
}

std::map<std::string, std::string> shippedWorlds() {
  std::map<std::string, std::string> names;
  std::error_code error;
  for (const auto& entry : fs::recursive_directory_iterator(fs::path(shareFolder()) / "launch", error)) {
    if (entry.path().extension() == ".yaml" && isWorldYaml(entry.path())) names[entry.path().stem()] = entry.path();
  }
  return names;
}

Loaded<std::string> findIn(const std::map<std::string, std::string>& names, const char* what,
                           const std::string& name_or_path, const std::string& where) {
  Loaded<std::string> result;
  std::error_code error;
  const auto shipped = names.find(name_or_path);
  if (shipped != names.end()) {
    result.value = shipped->second;
  } else if (fs::is_regular_file(name_or_path, error)) {
    result.value = fs::absolute(name_or_path).string();
  } else {
    std::string known;
    for (const auto& [name, path] : names) known += (known.empty() ? "" : ", ") + name;
    const bool looks_like_path = name_or_path.find_first_of("/.") != std::string::npos;
    result.problems.push_back(
        {where, "'" + name_or_path + "' is " +
                    (looks_like_path ? "no file that can be read" : std::string("no known ") + what) + "; known " +
                    what + "s: " + (known.empty() ? "none" : known) + ", or give the path of a file"});
  }
  return result;
}

}  // namespace

std::string shareFolder() {
  std::error_code error;
  // <prefix>/lib/<package>/<program>, installed and in the build tree alike.
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  const fs::path beside = program.parent_path().parent_path().parent_path() / "share" / kPackage;
  if (!error && fs::is_directory(beside, error)) return beside.string();
  return ros::package::getPath(kPackage);
}

Loaded<std::string> findVehicle(const std::string& name_or_path, const std::string& where) {
  return findIn(shippedVehicles(), "vehicle", name_or_path, where);
}

Loaded<std::string> findWorld(const std::string& name_or_path, const std::string& where) {
  return findIn(shippedWorlds(), "world", name_or_path, where);
}

UriResolver packageResolver(std::vector<std::string> package_dirs, const std::string& file) {
  const std::string folder = fs::path(file).parent_path().string();
  if (package_dirs.empty()) package_dirs.push_back(folder);
  const UriResolver given = fileResolver(package_dirs, folder);
  return [given](const std::string& uri) -> std::optional<std::string> {
    if (auto found = given(uri)) return found;
    constexpr const char* kScheme = "package://";
    if (uri.rfind(kScheme, 0) != 0) return std::nullopt;
    const std::string rest = uri.substr(std::string(kScheme).size());
    const std::size_t slash = rest.find('/');
    if (slash == std::string::npos) return std::nullopt;
    const std::string package = rest.substr(0, slash);
    const std::string root = package == kPackage ? shareFolder() : ros::package::getPath(package);
    std::error_code error;
    const fs::path path = fs::path(root) / rest.substr(slash + 1);
    if (root.empty() || !fs::is_regular_file(path, error)) return std::nullopt;
    return path.string();
  };
}

}  // namespace ellipsoid_vehicle_sim
