#pragma once

#include <visualization_msgs/MarkerArray.h>

#include <vector>

#include "ellipsoid_vehicle_sim/vehicle/simulator.h"

namespace ellipsoid_vehicle_sim {

/// Every ellipsoid in its link's frame: what really collides, whatever the URDF draws. Frame-locked, so that one
/// latched message is enough.
visualization_msgs::MarkerArray collisionShapeMarkers(const std::vector<EllipsoidPlacement>& ellipsoids);

}  // namespace ellipsoid_vehicle_sim
