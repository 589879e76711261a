#pragma once

#include <ros/node_handle.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/ros/vehicle_setup.h"
#include "ellipsoid_vehicle_sim/fleet/fleet.h"

namespace ellipsoid_vehicle_sim {

/// Everything the node needs before it tells anybody that it exists.
struct NodeSetup {
  NodeOptions options;                ///< of the node as a whole.
  std::shared_ptr<const Terrain> terrain;
  WorldStart world_start;
  std::vector<std::string> world_files;
  ParameterValues common;             ///< what stands under ~, for vehicles that come later.
  Fleet fleet;                        ///< every vehicle set down at its start.
  std::vector<VehicleSetup> vehicles; ///< in the fleet's order; their simulators are there.
  std::vector<std::optional<RunRecorder>> recorders;  ///< likewise, where ~record_folder asks for them.
  std::vector<std::string> notes;
};

/// Parameters, vehicles, world, simulators, set-down, clock: every problem that can be found, at once. Sets
/// robot_description where nobody has. Advertises nothing.
Loaded<NodeSetup> loadSetup(const ros::NodeHandle& nh, const ros::NodeHandle& nh_priv);

/// Name in the fleet: the only vehicle, which has none, is "vehicle".
std::string fleetName(const std::string& name);
/// Takes the simulator over and sets it down. Problems: it is in the fleet no longer.
Problems addToFleet(VehicleSetup& vehicle, Fleet& fleet);

/// All to ROS_ERROR, one line each, and how many there are.
void logProblems(const Problems& problems);

}  // namespace ellipsoid_vehicle_sim
