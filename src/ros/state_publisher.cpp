#include "ellipsoid_vehicle_sim/ros/state_publisher.h"

#include <ros/console.h>
#include <tf2_msgs/TFMessage.h>

#include "ellipsoid_vehicle_sim/ros/conversions.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr int kStateQueue = 100;  // state goes out in bursts when the simulation runs faster than real time

}  // namespace

StatePublisher::StatePublisher(ros::NodeHandle& nh, const NodeOptions& options, std::string base_frame,
                               const Simulator& simulator)
    : options_(options),
      world_frame_(worldFrameOf(options)),
      base_frame_(std::move(base_frame)),
      simulator_(simulator),
      odometry_(simulator.model().drive.reference_x, options.odometry_noise, simulator.model().description.forward_yaw),
      links_(simulator.model().description, options.tf_prefix),
      imu_noise_(options.imu_noise) {
  imu_noise_.seed = static_cast<std::uint64_t>(options.noise_seed);
  // "/tf" is one tree for all, whatever the name space; it can be remapped.
  // Latched in lockstep: a commander that comes late still gets the state that it has to answer, before odom asks for it.
  const bool latch = options.lockstep;
  if (options.publish_tf) tf_publisher_ = nh.advertise<tf2_msgs::TFMessage>("/tf", kStateQueue, latch);
  odom_publisher_ = nh.advertise<nav_msgs::Odometry>("odom", kStateQueue, latch);
  truth_publisher_ = nh.advertise<nav_msgs::Odometry>("ground_truth", kStateQueue);
  joint_publisher_ = nh.advertise<sensor_msgs::JointState>("joint_states", kStateQueue, latch);
  imu_publisher_ = nh.advertise<sensor_msgs::Imu>("imu", kStateQueue);
}

void StatePublisher::addTick() {
  if (encoders()) odometry_.advance(simulator_.encoderSpeed(), simulator_.encoderYawRate(), simulator_.config().dt);
}

Pose StatePublisher::odomInWorld() const {
  return encoders() ? simulator_.rootPose() * odometry_.pose().inverse() : Pose{};
}

void StatePublisher::publishState(const ros::Time& stamp) {
  const Pose X_WR = simulator_.rootPose();
  nav_msgs::Odometry truth = toOdometry(X_WR, simulator_.rootVelocity_W(), simulator_.rootAngularVelocity_W(),
                                        world_frame_, base_frame_, stamp);
  if (simulator_.errorEstimate().step >= 0) setCovariance(simulator_.errorEstimate(), X_WR.q, truth);
  const bool unstable = simulator_.isBeyondCertificate();
  if (unstable) markUnstable(truth);
  const bool joints = options_.lockstep || options_.publish_link_tf || joint_publisher_.getNumSubscribers() > 0;
  if (joints) {
    simulator_.jointReadings(readings_);
    toJointState(simulator_.jointNames(), readings_, stamp, joint_message_);
    // Joint angles have no frame: room for a mark.
    joint_message_.header.frame_id = unstable ? "unstable" : "";
  }
  // The simulator refuses a state that is not finite; a message must not tell otherwise even if it once fails to.
  if (!allFinite(truth) || (joints && !allFinite(joint_message_))) {
    ROS_ERROR_THROTTLE(1.0, "a state that is not finite was not published");
    return;
  }
  if (options_.publish_tf) publishTransforms(encoders() ? odometry_.pose() : X_WR, stamp);
  if (joints) joint_publisher_.publish(joint_message_);
  if (truth_publisher_.getNumSubscribers() > 0) truth_publisher_.publish(truth);
  // Last: in lockstep it is what the commander answers.
  if (encoders()) {
    nav_msgs::Odometry odom = toOdometry(odometry_, simulator_.encoderSpeed(), simulator_.encoderYawRate(),
                                         options_.odom_frame, base_frame_, stamp);
    if (unstable) markUnstable(odom);
    odom_publisher_.publish(odom);
  } else {
    truth.header.frame_id = options_.odom_frame;
    odom_publisher_.publish(truth);
  }
}

void StatePublisher::publishTransforms(const Pose& X_OR, const ros::Time& stamp) {
  if (!options_.lockstep && tf_publisher_.getNumSubscribers() == 0) return;
  tf2_msgs::TFMessage message;
  message.transforms.push_back(toTransform(X_OR, options_.odom_frame, base_frame_, stamp));
  if (hasOdomFrame() && options_.publish_world_tf) {
    message.transforms.push_back(toTransform(odomInWorld(), world_frame_, options_.odom_frame, stamp));
  }
  if (options_.publish_link_tf) links_.add(readings_, stamp, message.transforms);
  tf_publisher_.publish(message);
}

void StatePublisher::publishImu(const ros::Time& stamp, std::int64_t sample) {
  if (imu_publisher_.getNumSubscribers() == 0) return;
  sensor_msgs::Imu message = toImu(readImu(simulator_, imu_noise_, sample), imu_noise_, base_frame_, stamp);
  if (simulator_.isBeyondCertificate()) markUnstable(message);
  if (allFinite(message)) imu_publisher_.publish(message);
}

}  // namespace ellipsoid_vehicle_sim
