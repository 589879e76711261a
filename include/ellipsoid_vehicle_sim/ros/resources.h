#pragma once

#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/description/uri_resolver.h"
#include "ellipsoid_vehicle_sim/geometry/problem.h"

namespace ellipsoid_vehicle_sim {

/// The package's share folder, installed or in the build tree: found from where the running program stands, so that it
/// needs no environment; "" if there is none.
std::string shareFolder();

/// Path of a shipped vehicle or world by its name ("car", "flat"), or of a file that is given as a path. Problems list
/// the known names.
Loaded<std::string> findVehicle(const std::string& name_or_path, const std::string& where);
Loaded<std::string> findWorld(const std::string& name_or_path, const std::string& where);

/// package://NAME/...: first in `package_dirs` (if empty: the folder of `file`), then this package's own share folder,
/// then what ROS knows.
UriResolver packageResolver(std::vector<std::string> package_dirs, const std::string& file);

}  // namespace ellipsoid_vehicle_sim
