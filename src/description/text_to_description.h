#pragma once

#include <map>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/description/urdf_text.h"
#include "ellipsoid_vehicle_sim/description/vehicle_tree.h"
#include "ellipsoid_vehicle_sim/vehicle/vehicle_description.h"

namespace ellipsoid_vehicle_sim {

/// Links and joints in tree order with axes, limits, springs and inertias interpreted and checked; no shapes and no
/// roles yet. Where something is a problem a harmless value stands in.
VehicleDescription describe(const UrdfText& urdf, const TreeOrder& order, const std::string& file, Problems& problems,
                            std::vector<std::string>& notes);

/// The checks of describe() alone, for links that make no tree.
void checkJointsAndInertias(const UrdfText& urdf, const std::string& file, Problems& problems,
                            std::vector<std::string>& notes);

/// Bodies that move and have no mass.
void checkMasses(const VehicleDescription& vehicle, const UrdfText& urdf, const std::map<std::string, JointRole>& roles,
                 Problems& problems);

/// One note for the drive joints that have no effort limit, one for limits that read 0.
void noteEffortLimits(const VehicleDescription& vehicle, const UrdfText& urdf, std::vector<std::string>& notes);

}  // namespace ellipsoid_vehicle_sim
