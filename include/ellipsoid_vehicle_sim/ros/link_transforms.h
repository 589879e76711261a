#pragma once

#include <geometry_msgs/TransformStamped.h>

#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/vehicle/simulator.h"

namespace ellipsoid_vehicle_sim {

/// Where a vehicle's links stand in their parents: what robot_state_publisher works out from joint_states, so that a
/// vehicle that comes while the node runs has its frames without another node.
class LinkTransforms {
 public:
  /// `prefix` stands before every link's name.
  LinkTransforms(const VehicleDescription& vehicle, const std::string& prefix);

  /// `readings` of all movable joints, in the order of Simulator::jointNames().
  void add(const std::vector<JointReading>& readings, const ros::Time& stamp,
           std::vector<geometry_msgs::TransformStamped>& transforms) const;

 private:
  struct Link {
    std::string parent, child;
    Pose X_PJ;
    Eigen::Vector3d axis;
    JointType type;
    int reading;  ///< -1: fixed.
  };
  std::vector<Link> links_;
};

}  // namespace ellipsoid_vehicle_sim
