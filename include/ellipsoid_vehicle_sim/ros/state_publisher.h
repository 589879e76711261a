#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <sensor_msgs/JointState.h>

#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/ros/link_transforms.h"
#include "ellipsoid_vehicle_sim/ros/parameters.h"
#include "ellipsoid_vehicle_sim/vehicle/imu.h"
#include "ellipsoid_vehicle_sim/vehicle/wheel_odometry.h"

namespace ellipsoid_vehicle_sim {

/// What the vehicle tells of itself: odom, ground_truth, tf, joint_states, imu. Reads the simulator and changes nothing
/// in it; what nobody listens to is not worked out.
class StatePublisher {
 public:
  /// `base_frame`: the URDF's root link.
  StatePublisher(ros::NodeHandle& nh, const NodeOptions& options, std::string base_frame, const Simulator& simulator);

  /// One tick of the encoders' odometry, where it is asked for.
  void addTick();
  void publishState(const ros::Time& stamp);
  /// `sample`: number of the sample, for the noise.
  void publishImu(const ros::Time& stamp, std::int64_t sample);

  const std::string& worldFrame() const { return world_frame_; }
  bool hasOdomFrame() const { return world_frame_ != options_.odom_frame; }  ///< of its own, besides the world's.
  /// X_WO: where the odom frame stands in the world; the identity with true odometry.
  Pose odomInWorld() const;
  WheelOdometry& odometry() { return odometry_; }
  const WheelOdometry& odometry() const { return odometry_; }

 private:
  bool encoders() const { return options_.odometry == OdometrySource::kEncoders; }
  void publishTransforms(const Pose& X_OR, const ros::Time& stamp);

  const NodeOptions& options_;
  std::string world_frame_, base_frame_;
  const Simulator& simulator_;
  WheelOdometry odometry_;
  LinkTransforms links_;
  ImuNoise imu_noise_;
  ros::Publisher tf_publisher_, odom_publisher_, truth_publisher_, joint_publisher_, imu_publisher_;

  // Kept to save their memory from message to message.
  std::vector<JointReading> readings_;
  sensor_msgs::JointState joint_message_;
};

}  // namespace ellipsoid_vehicle_sim
