#include "ellipsoid_vehicle_sim/description/uri_resolver.h"

#include <tinyxml2.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "ellipsoid_vehicle_sim/world/file_bytes.h"

namespace ellipsoid_vehicle_sim {
namespace {

namespace fs = std::filesystem;

std::optional<std::string> existingFile(const fs::path& path) {
  std::error_code error;
  if (fs::is_regular_file(path, error) && !error) return path.string();
  return std::nullopt;
}

/// The name the package.xml in this folder gives; empty if there is none to read.
std::string packageName(const fs::path& folder) {
  const Loaded<std::string> xml = readFileBytes((folder / "package.xml").string(), "package", kLargestXmlFile);
  tinyxml2::XMLDocument document;
  if (!xml || document.Parse(xml.value->data(), xml.value->size()) != tinyxml2::XML_SUCCESS) return {};
  const tinyxml2::XMLElement* package = document.FirstChildElement("package");
  const tinyxml2::XMLElement* name = package ? package->FirstChildElement("name") : nullptr;
  const char* text = name ? name->GetText() : nullptr;
  if (!text) return {};
  const std::string all = text;
  const auto first = all.find_first_not_of(" \t\r\n");
  if (first == std::string::npos) return {};
  return all.substr(first, all.find_last_not_of(" \t\r\n") - first + 1);
}

std::string folderName(const fs::path& folder) {
  std::error_code error;
  fs::path whole = fs::absolute(folder, error).lexically_normal();
  if (whole.filename().empty()) whole = whole.parent_path();  // "dir/" ends in an empty name
  return whole.filename().string();
}

std::optional<std::string> inPackage(const std::vector<std::string>& dirs, const std::string& name,
                                     const std::string& rest) {
  for (const std::string& dir : dirs) {
    if (auto file = existingFile(fs::path(dir) / name / rest)) return file;
    if (folderName(dir) == name || packageName(dir) == name) {
      if (auto file = existingFile(fs::path(dir) / rest)) return file;
    }
  }
  // Checkouts in folders of other names, one below.
  for (const std::string& dir : dirs) {
    std::error_code error;
    std::vector<fs::path> folders;
    for (fs::directory_iterator at(dir, fs::directory_options::skip_permission_denied, error), end; !error && at != end;
         at.increment(error)) {
      std::error_code ignored;
      if (at->is_directory(ignored) && fs::exists(at->path() / "package.xml", ignored)) folders.push_back(at->path());
    }
    std::sort(folders.begin(), folders.end());  // the same one everywhere, whatever order the disk has
    for (const fs::path& folder : folders) {
      if (packageName(folder) != name) continue;
      if (auto file = existingFile(folder / rest)) return file;
    }
  }
  return std::nullopt;
}

}  // namespace

UriResolver fileResolver(std::vector<std::string> package_dirs, std::string base_dir) {
  return [dirs = std::move(package_dirs),
          base = fs::path(std::move(base_dir))](const std::string& uri) -> std::optional<std::string> {
    const std::string package = "package://", file = "file://";
    if (uri.compare(0, package.size(), package) == 0) {
      const auto slash = uri.find('/', package.size());
      if (slash == std::string::npos || slash == package.size()) return std::nullopt;
      return inPackage(dirs, uri.substr(package.size(), slash - package.size()), uri.substr(slash + 1));
    }
    if (uri.compare(0, file.size(), file) == 0) return existingFile(uri.substr(file.size()));
    if (uri.empty() || uri.find("://") != std::string::npos) return std::nullopt;
    return existingFile(base / uri);  // an absolute path replaces the base
  };
}

std::vector<std::string> packageDirsOf(const std::string& file) {
  std::error_code error;
  std::vector<std::string> dirs;
  fs::path folder = fs::absolute(file, error).lexically_normal().parent_path();
  for (int i = 0; i < 4 && !error && folder.has_relative_path(); ++i) {
    dirs.push_back(folder.string());
    folder = folder.parent_path();
  }
  if (dirs.empty()) dirs.push_back(".");
  return dirs;
}

UriResolver fileResolver(const std::string& file) {
  std::string folder = fs::path(file).parent_path().string();
  if (folder.empty()) folder = ".";
  return fileResolver(packageDirsOf(file), folder);
}

UriResolver recordingResolver(UriResolver resolver, std::shared_ptr<std::vector<std::string>> found) {
  return [resolver = std::move(resolver), found = std::move(found)](const std::string& uri) {
    std::optional<std::string> path = resolver(uri);
    if (path && std::find(found->begin(), found->end(), *path) == found->end()) found->push_back(*path);
    return path;
  };
}

}  // namespace ellipsoid_vehicle_sim
