#pragma once

#include <string>

#include "ellipsoid_vehicle_sim/geometry/problem.h"

namespace ellipsoid_vehicle_sim {

/// Whether a file is meant for xacro: its name ends in .xacro.
bool isXacroFile(const std::string& path);

/// The file's text; of a .xacro file what the command `xacro` of the PATH makes of it. Problems: the file cannot be read,
/// there is no such command, it fails (in its own words), or takes longer than a minute.
Loaded<std::string> readVehicleText(const std::string& path);

}  // namespace ellipsoid_vehicle_sim
