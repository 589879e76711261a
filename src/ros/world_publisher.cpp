#include "ellipsoid_vehicle_sim/ros/world_publisher.h"

#include <ros/console.h>

namespace ellipsoid_vehicle_sim {

WorldPublisher::WorldPublisher(ros::NodeHandle& nh, std::shared_ptr<const Terrain> terrain, const std::string& frame,
                               int limit, const Eigen::Vector3d& centre)
    : markers_(terrain, frame, limit), publisher_(nh.advertise<visualization_msgs::MarkerArray>("world", 1, true)) {
  if (const auto world = markers_.update(centre)) publisher_.publish(*world);
  if (markers_.partial()) {
    ROS_INFO(
        "the world has %d triangles, more than world_marker_limit: shown is what lies within %.3g m of the vehicle",
        terrain->triangleCount(), markers_.halfEdge());
  }
}

void WorldPublisher::update(const Eigen::Vector3d& centre) {
  if (!markers_.partial()) return;
  if (const auto world = markers_.update(centre)) publisher_.publish(*world);
}

}  // namespace ellipsoid_vehicle_sim
