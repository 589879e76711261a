#pragma once

#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/description/inertia_lint.h"
#include "ellipsoid_vehicle_sim/vehicle/vehicle_description.h"

namespace ellipsoid_vehicle_sim {

/// The URDF `text` with every <collision> replaced by the ellipsoids that the loader made of them, as meshes unit_sphere.stl
/// with their semi-axes as scale, each in the link that carries it, and the <inertial> of every link in `repaired` by what
/// the vehicle has. All else stays as it is. Loaded again it gives the same ellipsoids. `text` is one that loaded.
std::string canonicalUrdf(const std::string& text, const VehicleDescription& vehicle,
                          const std::vector<InertiaFinding>& repaired);

}  // namespace ellipsoid_vehicle_sim
