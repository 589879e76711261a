#pragma once

#include <string>

#include "ellipsoid_vehicle_sim/geometry/problem.h"
#include "ellipsoid_vehicle_sim/vehicle/parameter_table.h"

namespace ellipsoid_vehicle_sim {

/// Reads `key: value` pairs from a YAML file; whether there are such parameters is for the tables to say. Problems: a
/// file that cannot be read, no YAML, no dictionary, a value that is a dictionary or a mixed list, a key given twice.
Loaded<ParameterValues> readParameterFile(const std::string& path);
/// The same from a text; `where` stands for its path.
Loaded<ParameterValues> readParameterText(const std::string& text, const std::string& where);

}  // namespace ellipsoid_vehicle_sim
