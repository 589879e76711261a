#pragma once

#include <map>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/description/shapes_to_ellipsoids.h"
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

/// Bodies that move and have no mass; with `repair` only what no repair can help: nothing.
void checkMasses(const VehicleDescription& vehicle, const UrdfText& urdf, const std::map<std::string, JointRole>& roles,
                 bool repair, Problems& problems);

/// Friction and stiffness of <gazebo reference="LINK"> for the ellipsoids that stand for the link's shapes; and low friction
/// for what stands for a caster without one: round or so called, or all that a vehicle on two wheels leans on, on the
/// ground, and not able to roll along.
void addSurfaces(VehicleDescription& vehicle, const UrdfText& urdf, const std::vector<GroundWheel>& wheels,
                 std::vector<std::string>& notes);

/// One note for the drive joints that have no effort limit, one for limits that read 0.
void noteEffortLimits(const VehicleDescription& vehicle, const UrdfText& urdf, std::vector<std::string>& notes);

}  // namespace ellipsoid_vehicle_sim
