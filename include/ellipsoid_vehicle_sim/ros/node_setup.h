#pragma once

#include <ros/node_handle.h>

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/geometry/problem.h"
#include "ellipsoid_vehicle_sim/ros/parameters.h"
#include "ellipsoid_vehicle_sim/ros/run_recorder.h"
#include "ellipsoid_vehicle_sim/vehicle/simulator.h"

namespace ellipsoid_vehicle_sim {

/// Everything the node needs before it tells anybody that it exists.
struct NodeSetup {
  NodeOptions options;
  std::shared_ptr<const Terrain> terrain;
  Simulator simulator;                ///< set down at its start.
  std::string base_frame;             ///< the URDF's root link.
  double vehicle_length = 1.0;        ///< largest distance across its ellipsoids, joints at zero [m].
  std::set<std::string> drawn_links;  ///< links with a visual that can be drawn.
  std::vector<std::string> notes;
  std::optional<RunRecorder> recorder;  ///< where ~record_folder asks for one.
};

/// Parameters, vehicle, world, simulator, set-down, clock: every problem that can be found, at once. Sets
/// robot_description if nobody has. Advertises nothing.
Loaded<NodeSetup> loadSetup(const ros::NodeHandle& nh, const ros::NodeHandle& nh_priv);

/// All to ROS_ERROR, one line each, and how many there are.
void logProblems(const Problems& problems);

}  // namespace ellipsoid_vehicle_sim
