#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <string>

#include "ellipsoid_vehicle_sim/ros/world_markers.h"

namespace ellipsoid_vehicle_sim {

/// The world as it collides, latched on `world`; of a large one the part around a point.
class WorldPublisher {
 public:
  WorldPublisher(ros::NodeHandle& nh, std::shared_ptr<const Terrain> terrain, const std::string& frame, int limit,
                 const Eigen::Vector3d& centre);

  void update(const Eigen::Vector3d& centre);

 private:
  WorldMarkers markers_;
  ros::Publisher publisher_;
};

}  // namespace ellipsoid_vehicle_sim
