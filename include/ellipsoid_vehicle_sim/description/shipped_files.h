#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/description/uri_resolver.h"
#include "ellipsoid_vehicle_sim/geometry/problem.h"

// What comes with the package: vehicles, worlds and scenes by name. No ROS in here.

namespace ellipsoid_vehicle_sim {

/// Name without folder and ending -> path.
using ShippedNames = std::map<std::string, std::string>;

/// The share folder that belongs to the running program, <prefix>/lib/<package>/<program> -> <prefix>/share/<package>,
/// installed and in the build tree alike; "" if there is none.
std::string shareFolderBesideProgram();

/// urdf/*.urdf below the share folder.
ShippedNames shippedVehicles(const std::string& share);
/// YAML files in launch/ with a top-level list of meshes; simulator.yaml beside them is none.
ShippedNames shippedWorlds(const std::string& share);
/// YAML files in launch/scenes/ that are no worlds.
ShippedNames shippedScenes(const std::string& share);

/// A shipped file by its name, or the absolute path of a file that is given as a path, which is looked up in `folder`
/// unless that is "". The problem says `where`, `what` ("vehicle") and which names are known.
Loaded<std::string> findShipped(const ShippedNames& names, const std::string& what, const std::string& name_or_path,
                                const std::string& where, const std::string& folder = "");

/// package://NAME/...: first in `package_dirs` (if empty: the folder of `file`), then in the share folder if NAME is
/// this package, then where `package_path` says NAME is ("" for unknown; may be empty).
UriResolver shippedResolver(std::vector<std::string> package_dirs, const std::string& file, const std::string& share,
                            std::function<std::string(const std::string&)> package_path = {});

}  // namespace ellipsoid_vehicle_sim
