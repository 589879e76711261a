#pragma once

#include <geometry_msgs/Point.h>
#include <geometry_msgs/Pose.h>
#include <geometry_msgs/TransformStamped.h>
#include <geometry_msgs/Twist.h>
#include <nav_msgs/Odometry.h>
#include <ros/time.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/JointState.h>
#include <std_msgs/ColorRGBA.h>

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/ContactState.h"
#include "ellipsoid_vehicle_sim/geometry/pose.h"
#include "ellipsoid_vehicle_sim/ros/ackermann_message.h"
#include "ellipsoid_vehicle_sim/vehicle/drive_command.h"
#include "ellipsoid_vehicle_sim/vehicle/imu.h"
#include "ellipsoid_vehicle_sim/vehicle/simulator.h"
#include "ellipsoid_vehicle_sim/vehicle/wheel_odometry.h"

// Core values <-> messages, as free functions. The one place that knows that the twist of an Odometry is in the child
// frame.

namespace ellipsoid_vehicle_sim {

/// Time after `steps` ticks of dt [s], to the nanosecond.
ros::Duration simulatedDuration(std::int64_t steps, double dt);

geometry_msgs::Point toPoint(const Eigen::Vector3d& p);
geometry_msgs::Vector3 toVector(const Eigen::Vector3d& v);
geometry_msgs::Quaternion toQuaternion(const Eigen::Quaterniond& q);
geometry_msgs::Pose toPose(const Pose& X_AB);
std_msgs::ColorRGBA toColor(double red, double green, double blue, double alpha);

/// X_WR with v_WR, w_WR given in W; the message's twist is v_WR_R, w_WR_R.
nav_msgs::Odometry toOdometry(const Pose& X_WR, const Eigen::Vector3d& v_WR_W, const Eigen::Vector3d& w_WR_W,
                              const std::string& odom_frame, const std::string& base_frame, const ros::Time& stamp);
/// Covariances of a true odometry: the local error's squares [ErrorEstimate], never below 1e-18; X_WR is the root's pose.
void setCovariance(const ErrorEstimate& estimate, const Eigen::Quaterniond& q_WR, nav_msgs::Odometry& message);
/// Marks what a step beyond the stability certificate says: every variance is "unknown" (1e6; imu: -1).
void markUnstable(nav_msgs::Odometry& message);
void markUnstable(sensor_msgs::Imu& message);
geometry_msgs::TransformStamped toTransform(const Pose& X_WR, const std::string& odom_frame,
                                            const std::string& base_frame, const ros::Time& stamp);
/// Overwrites `message`; keeps its memory.
void toJointState(const std::vector<std::string>& names, const std::vector<JointReading>& readings,
                  const ros::Time& stamp, sensor_msgs::JointState& message);

/// A contact with the names of what touches; where that is another vehicle, `surface` is empty and the caller adds it.
ContactState toContactState(const ContactReport& contact, const EllipsoidPlacement& ellipsoid,
                            const std::string& surface);
/// Diagonal covariances from the noise's deviations, never less than a millionth.
sensor_msgs::Imu toImu(const ImuReading& reading, const ImuNoise& noise, const std::string& frame,
                       const ros::Time& stamp);
/// Planar odometry: z, roll and pitch are unknown (1e6), and the covariance of x, y, yaw is as given.
nav_msgs::Odometry toOdometry(const WheelOdometry& odometry, double speed, double yaw_rate, const std::string& odom_frame,
                              const std::string& base_frame, const ros::Time& stamp);
Pose fromPose(const geometry_msgs::Pose& pose);
Eigen::Vector3d fromVector(const geometry_msgs::Vector3& v);

/// Speed, steering angle and how fast both may change. Not checked for NaN.
DriveCommand toDriveCommand(const AckermannDriveStamped& message);
/// One request a name, with what the message gives. Not checked for NaN; lengths must fit.
std::vector<JointRequest> toJointRequests(const sensor_msgs::JointState& message);
/// Speed and yaw rate; what a ground vehicle cannot do (sideways, up, roll) is ignored. Not checked for NaN.
DriveCommand toDriveCommand(const geometry_msgs::Twist& twist);

/// No NaN or infinity in it.
bool allFinite(const nav_msgs::Odometry& message);
bool allFinite(const sensor_msgs::JointState& message);
bool allFinite(const sensor_msgs::Imu& message);

}  // namespace ellipsoid_vehicle_sim
