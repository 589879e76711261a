#include "ellipsoid_vehicle_sim/ros/conversions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace ellipsoid_vehicle_sim {
namespace {

TEST(Conversions, OdometryTwistIsInTheChildFrame) {
  // Heading +y (yaw 90 degrees) and moving along +y: forward in the vehicle's own frame.
  const Pose X_WR{{1.0, 2.0, 3.0}, quaternionFromRpy(0.0, 0.0, 0.5 * M_PI)};
  const auto odom = toOdometry(X_WR, {0.0, 4.0, 0.0}, {0.5, 0.0, 0.25}, "odom", "base_link", ros::Time(7, 8));
  constexpr double kRounding = 1e-15;  // of one rotation
  EXPECT_NEAR(odom.twist.twist.linear.x, 4.0, 4 * kRounding);
  EXPECT_NEAR(odom.twist.twist.linear.y, 0.0, 4 * kRounding);
  EXPECT_NEAR(odom.twist.twist.angular.y, -0.5, 4 * kRounding);
  EXPECT_NEAR(odom.twist.twist.angular.z, 0.25, 4 * kRounding);
  EXPECT_EQ(odom.pose.pose.position.y, 2.0);
  EXPECT_EQ(odom.header.frame_id, "odom");
  EXPECT_EQ(odom.child_frame_id, "base_link");
  EXPECT_EQ(odom.header.stamp, ros::Time(7, 8));
}

TEST(Conversions, SimulatedDurationKeepsItsNanosecondsOverDays) {
  EXPECT_EQ(simulatedDuration(1, 1e-3), ros::Duration(0, 1000000));
  EXPECT_EQ(simulatedDuration(999, 1e-3), ros::Duration(0, 999000000));
  EXPECT_EQ(simulatedDuration(1000, 1e-3), ros::Duration(1, 0));
  // 10^9 ticks of a millisecond are 11 days; a double of seconds has 1e-10 s left there.
  EXPECT_EQ(simulatedDuration(1000000001, 1e-3), ros::Duration(1000000, 1000000));
}

TEST(Conversions, TwistBecomesSpeedAndYawRate) {
  geometry_msgs::Twist twist;
  twist.linear.x = -1.5;
  twist.linear.y = 9.0;
  twist.angular.z = 0.25;
  const DriveCommand command = toDriveCommand(twist);
  EXPECT_EQ(command.kind, DriveCommand::Kind::kTwist);
  EXPECT_EQ(command.speed, -1.5);
  EXPECT_EQ(command.yaw_rate, 0.25);
}

TEST(Conversions, NotFiniteIsSeenWhereverItStands) {
  const auto odom = toOdometry(Pose(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), "odom", "base", ros::Time(1));
  EXPECT_TRUE(allFinite(odom));
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    auto broken = odom;
    broken.pose.pose.orientation.z = bad;
    EXPECT_FALSE(allFinite(broken));
    broken = odom;
    broken.twist.twist.angular.x = bad;
    EXPECT_FALSE(allFinite(broken));
  }
  sensor_msgs::JointState joints;
  toJointState({"a", "b"}, {{1.0, 2.0, 3.0}, {4.0, std::nan(""), 6.0}}, ros::Time(1), joints);
  EXPECT_FALSE(allFinite(joints));
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
