#pragma once

#include <visualization_msgs/MarkerArray.h>

#include <set>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/vehicle/simulator.h"

namespace ellipsoid_vehicle_sim {

/// Every ellipsoid in its link's frame: what really collides, whatever the URDF draws. Frame-locked, so that one
/// latched message is enough. Name spaces: "wheels" and "bodies"; with "drawn " before them where the link is in
/// `drawn_links`, which have something else to look at, so that RViz can show only what would be invisible without.
/// `prefix` stands before the links' frames.
visualization_msgs::MarkerArray collisionShapeMarkers(const std::vector<EllipsoidPlacement>& ellipsoids,
                                                      const std::set<std::string>& drawn_links,
                                                      const std::string& prefix = "");

}  // namespace ellipsoid_vehicle_sim
