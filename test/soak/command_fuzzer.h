#pragma once

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <geometry_msgs/Twist.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <sensor_msgs/JointState.h>

#include <limits>
#include <random>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/ros/ackermann_message.h"

namespace ellipsoid_vehicle_sim {

/// Numbers as a broken or malicious program sends them, among sane ones.
class AbsurdNumbers {
 public:
  explicit AbsurdNumbers(std::uint64_t seed) : random_(seed) {}

  double number(double sane) {
    static const double kAbsurd[] = {std::numeric_limits<double>::quiet_NaN(),
                                     std::numeric_limits<double>::infinity(),
                                     -std::numeric_limits<double>::infinity(),
                                     1e308,
                                     -1e308,
                                     std::numeric_limits<double>::denorm_min(),
                                     -0.0,
                                     1e30,
                                     -1e9};
    return one(4) ? kAbsurd[index(9)] : uniform(-sane, sane);
  }
  bool one(int of) { return index(of) == 0; }
  int index(int n) { return static_cast<int>(random_() % static_cast<std::uint64_t>(n)); }
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  /// From the distant past, the distant future, or about now.
  ros::Time stamp(const ros::Time& now) {
    switch (index(4)) {
      case 0:
        return ros::Time(0);
      case 1:
        return ros::Time(4000000000u, 999999999u);
      case 2:
        return now;
      default:
        return ros::Time(std::max(0.0, now.toSec() + uniform(-2.0, 2.0)));
    }
  }

 private:
  std::mt19937_64 random_;
};

/// Everything that commands can be: sane, absurd, malformed, out of order, too many.
class CommandFuzzer {
 public:
  CommandFuzzer(ros::NodeHandle& nh, std::vector<std::string> joints, std::uint64_t seed)
      : joints_(std::move(joints)), random_(seed) {
    cmd_vel_ = nh.advertise<geometry_msgs::Twist>("cmd_vel", 1000);
    ackermann_ = nh.advertise<AckermannDriveStamped>("ackermann_cmd", 1000);
    joint_commands_ = nh.advertise<sensor_msgs::JointState>("joint_commands", 1000);
    initialpose_ = nh.advertise<geometry_msgs::PoseWithCovarianceStamped>("initialpose", 10);
  }

  /// One round: a few commands, or a flood of 10 kHz for a fifth of a second.
  void round() {
    const bool flood = random_.one(20);
    const int count = flood ? 2000 : 1 + random_.index(10);
    // On a machine that has no time for us a flood is no flood, and shall not last for minutes.
    const ros::WallTime latest = ros::WallTime::now() + ros::WallDuration(1.0);
    for (int i = 0; i < count && ros::ok() && ros::WallTime::now() < latest; ++i) {
      one(flood);
      ++sent_;
      ros::WallDuration(flood ? 1e-4 : 2e-3).sleep();
    }
  }
  long sent() const { return sent_; }

 private:
  void one(bool flood) {
    switch (random_.index(flood ? 3 : 10)) {
      case 0:
        return sendAckermann();
      case 1:
        return sendJoints();
      case 9:
        if (random_.one(10)) return sendPose();
        [[fallthrough]];
      default:
        return sendTwist();
    }
  }
  void sendTwist() {
    geometry_msgs::Twist message;
    message.linear.x = random_.number(15.0);
    message.linear.y = random_.one(5) ? random_.number(1.0) : 0.0;
    message.angular.z = random_.number(1.0);
    cmd_vel_.publish(message);
  }
  void sendAckermann() {
    AckermannDriveStamped message;
    message.header.stamp = random_.stamp(ros::Time::now());
    message.steering_angle = static_cast<float>(random_.number(0.6));
    message.speed = static_cast<float>(random_.number(15.0));
    message.acceleration = random_.one(3) ? static_cast<float>(random_.number(5.0)) : 0.0f;
    message.jerk = random_.one(6) ? static_cast<float>(random_.number(5.0)) : 0.0f;
    ackermann_.publish(message);
  }
  void sendJoints() {
    sensor_msgs::JointState message;
    message.header.stamp = random_.stamp(ros::Time::now());
    const int count = random_.one(50) ? 20000 : random_.index(6);
    for (int i = 0; i < count; ++i)
      message.name.push_back(random_.one(6) || joints_.empty()
                                 ? std::string(i % 3 == 0 ? "" : "no_such_joint")
                                 : joints_[static_cast<std::size_t>(random_.index(static_cast<int>(joints_.size())))]);
    const auto fill = [&](std::vector<double>& values) {
      if (random_.one(2)) return;
      values.resize(random_.one(5) ? static_cast<std::size_t>(random_.index(9)) : message.name.size());
      for (double& value : values) value = random_.number(20.0);
    };
    fill(message.position);
    fill(message.velocity);
    fill(message.effort);
    joint_commands_.publish(message);
  }
  void sendPose() {
    geometry_msgs::PoseWithCovarianceStamped message;
    message.header.stamp = random_.stamp(ros::Time::now());
    message.header.frame_id = random_.one(4) ? "no_such_frame" : "odom";
    message.pose.pose.position.x = random_.number(20.0);
    message.pose.pose.position.y = random_.number(3.0);
    message.pose.pose.orientation.z = random_.number(1.0);
    message.pose.pose.orientation.w = random_.number(1.0);
    initialpose_.publish(message);
  }

  std::vector<std::string> joints_;
  AbsurdNumbers random_;
  ros::Publisher cmd_vel_, ackermann_, joint_commands_, initialpose_;
  long sent_ = 0;
};

}  // namespace ellipsoid_vehicle_sim
