#pragma once

#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

namespace ellipsoid_vehicle_sim {

/// A folder of its own for the files a test writes; gone with it.
class TemporaryFiles {
 public:
  TemporaryFiles() {
    std::string pattern = (std::filesystem::temp_directory_path() / "ellipsoid_vehicle_sim_XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("no temporary folder " + pattern);
    folder_ = pattern;
  }
  ~TemporaryFiles() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  TemporaryFiles(const TemporaryFiles&) = delete;
  TemporaryFiles& operator=(const TemporaryFiles&) = delete;

  /// Writes the file, and the folders it is in; returns its path.
  std::string write(const std::string& name, const std::string& text) const {
    const std::filesystem::path path = folder_ / name;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << text;
    return path.string();
  }

  std::string folder(const std::string& name) const {
    std::filesystem::create_directories(folder_ / name);
    return (folder_ / name).string();
  }

  /// A message with this folder's name taken out of it.
  std::string withoutFolder(std::string text) const {
    const std::string name = folder_.string() + "/";
    for (std::size_t at = 0; (at = text.find(name, at)) != std::string::npos;) text.erase(at, name.size());
    return text;
  }

 private:
  std::filesystem::path folder_;
};

}  // namespace ellipsoid_vehicle_sim
