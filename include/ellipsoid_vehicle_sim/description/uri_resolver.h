#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace ellipsoid_vehicle_sim {

/// Turns what a file calls another file ("package://NAME/rest", "file:///...", a path) into the path of an existing
/// file; nullopt if there is none. Passed in, so that the description layer needs no ROS to find packages.
using UriResolver = std::function<std::optional<std::string>(const std::string& uri)>;

/// Looks in the file system alone:
/// - package://NAME/rest: <dir>/NAME/rest for each dir of package_dirs in turn; where a dir is itself called NAME, or it or a
///   folder in it holds a package.xml whose <name> is NAME (a checkout's folder may be called anything), also there;
/// - file:///path, and absolute paths, as they stand;
/// - every other path relative to base_dir, the folder of the file that names it.
UriResolver fileResolver(std::vector<std::string> package_dirs, std::string base_dir);

/// Where the packages of a file are looked for when nobody says: its own folder, and the three above it, for files deep in
/// a package (NAME/urdf/robot.urdf).
std::vector<std::string> packageDirsOf(const std::string& file);

/// The resolver a vehicle or world file gets when nobody says otherwise: its own folder is both package and base
/// folder.
UriResolver fileResolver(const std::string& file);

/// The same resolver, which also keeps a list of the files it found, each once.
UriResolver recordingResolver(UriResolver resolver, std::shared_ptr<std::vector<std::string>> found);

}  // namespace ellipsoid_vehicle_sim
