#include "ellipsoid_vehicle_sim/ros/conversions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <sstream>

#include "ellipsoid_vehicle_sim/ros/command_input.h"

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

TEST(AckermannMessage, HasTheBytesOfTheOriginal) {
  // Header (seq 1, stamp 2.000000003 s, frame "ab"), then five little-endian float32.
  const std::vector<std::uint8_t> bytes = {1, 0, 0,    0,    2,   0, 0, 0,    3,    0, 0,    0,    2,
                                           0, 0, 0,    'a',  'b', 0, 0, 0,    0x3f, 0, 0,    0x80, 0x3e,
                                           0, 0, 0x40, 0xc0, 0,   0, 0, 0x40, 0,    0, 0x80, 0x40};
  ros::SerializedMessage wire;
  wire.num_bytes = bytes.size();
  wire.buf.reset(new std::uint8_t[bytes.size()]);
  std::copy(bytes.begin(), bytes.end(), wire.buf.get());
  AckermannDriveStamped message;
  ros::serialization::IStream in(wire.buf.get(), static_cast<std::uint32_t>(wire.num_bytes));
  ros::serialization::deserialize(in, message);
  EXPECT_EQ(message.header.seq, 1U);
  EXPECT_EQ(message.header.stamp, ros::Time(2, 3));
  EXPECT_EQ(message.header.frame_id, "ab");
  EXPECT_EQ(message.steering_angle, 0.5F);
  EXPECT_EQ(message.steering_angle_velocity, 0.25F);
  EXPECT_EQ(message.speed, -3.0F);
  EXPECT_EQ(message.acceleration, 2.0F);
  EXPECT_EQ(message.jerk, 4.0F);

  const ros::SerializedMessage again = ros::serialization::serializeMessage(message);
  const std::uint8_t* begin = again.message_start;
  const std::uint8_t* end = again.buf.get() + again.num_bytes;
  EXPECT_EQ(std::vector<std::uint8_t>(begin, end), bytes);
}

TEST(AckermannMessage, IsKnownByTheNameAndSumOfTheOriginal) {
  namespace traits = ros::message_traits;
  EXPECT_STREQ(traits::datatype<AckermannDriveStamped>(), "ackermann_msgs/AckermannDriveStamped");
  EXPECT_STREQ(traits::md5sum<AckermannDriveStamped>(), "1fd5d7f58889cefd44d29f6653240d0c");
  // interface.py gives this text to rospy, which works the sum out from it.
  std::ifstream in(std::string(PACKAGE_DIR) + "/test/ros/sim_test_tools.py");
  std::ostringstream text;
  text << in.rdbuf();
  EXPECT_NE(text.str().find(std::string("ACKERMANN = \"\"\"") + traits::definition<AckermannDriveStamped>() + "\"\"\""),
            std::string::npos);
}

TEST(Conversions, AnAckermannMessageBecomesACommandWithItsBounds) {
  AckermannDriveStamped message;
  message.steering_angle = 0.25F;
  message.steering_angle_velocity = 0.5F;
  message.speed = -1.0F;
  message.acceleration = 2.0F;
  message.jerk = 4.0F;
  const DriveCommand command = toDriveCommand(message);
  EXPECT_EQ(command.kind, DriveCommand::Kind::kAckermann);
  EXPECT_EQ(command.steering_angle, 0.25);
  EXPECT_EQ(command.steering_angle_velocity, 0.5);
  EXPECT_EQ(command.speed, -1.0);
  EXPECT_EQ(command.acceleration, 2.0);
  EXPECT_EQ(command.jerk, 4.0);
}

// A command as it comes over the wire.
JointCommandMessage received(const sensor_msgs::JointState& sent) {
  const ros::SerializedMessage wire = ros::serialization::serializeMessage(sent);
  JointCommandMessage message;
  ros::SerializedMessage from(wire.buf, wire.num_bytes);
  from.message_start = wire.message_start;
  ros::serialization::deserializeMessage(from, message);
  return message;
}

TEST(Conversions, JointCommandsMustHaveOneValueForEachNameOrNone) {
  sensor_msgs::JointState message;
  message.name = {"a", "b"};
  message.velocity = {1.0, 2.0};
  EXPECT_EQ(refusalOf(received(message)), "");
  const std::vector<JointRequest> requests = toJointRequests(received(message));
  ASSERT_EQ(requests.size(), 2U);
  EXPECT_EQ(requests[1].joint, "b");
  EXPECT_EQ(requests[1].velocity, 2.0);
  EXPECT_FALSE(requests[1].position || requests[1].effort);
  message.effort = {1.0};
  EXPECT_EQ(refusalOf(received(message)), "effort has 1 values for 2 names; allowed are none or one for each");
}

TEST(Conversions, OfAJointCommandNoMoreIsReadThanCouldBeOne) {
  sensor_msgs::JointState message;
  message.header.frame_id = "frame";
  message.name.assign(JointCommandMessage::kLongestArray, "a joint with a name that is stored elsewhere");
  message.position.assign(message.name.size(), 1.0);
  message.effort.assign(message.name.size(), -2.0);
  const JointCommandMessage all = received(message);
  EXPECT_EQ(static_cast<const sensor_msgs::JointState&>(all), message);
  EXPECT_EQ(refusalOf(all), "");

  message.effort.push_back(0.0);
  const JointCommandMessage long_effort = received(message);
  EXPECT_TRUE(long_effort.effort.empty());
  EXPECT_EQ(refusalOf(long_effort), "effort has 1001 values for 1000 names; allowed are none or one for each");

  message.name.push_back("one more");
  const JointCommandMessage long_names = received(message);
  EXPECT_TRUE(long_names.name.empty() && long_names.position.empty());
  EXPECT_EQ(long_names.told[0], 1001U);
}

TEST(Conversions, AJointCommandThatAnnouncesMoreThanItHoldsIsNone) {
  sensor_msgs::JointState message;
  message.name = {"a"};
  message.position = {1.0};
  for (const std::uint32_t announced : {2U, 1000U, 4000000000U}) {
    ros::SerializedMessage wire = ros::serialization::serializeMessage(message);
    // Behind the names, from the end: position, velocity and effort with a length each.
    std::uint8_t* const length = wire.buf.get() + wire.num_bytes - 3 * sizeof(std::uint32_t) - sizeof(double);
    std::memcpy(length, &announced, sizeof announced);
    JointCommandMessage read;
    if (announced <= JointCommandMessage::kLongestArray) {
      EXPECT_THROW(ros::serialization::deserializeMessage(wire, read), ros::serialization::StreamOverrunException);
    } else {
      ros::serialization::deserializeMessage(wire, read);
      EXPECT_EQ(refusalOf(read), "position has 4000000000 values for 1 names; allowed are none or one for each");
    }
  }
}

TEST(Conversions, PlanarOdometryLeavesWhatItCannotKnowUnknown) {
  WheelOdometry odometry(-1.0, OdometryNoise{});
  for (int i = 0; i < 1000; ++i) odometry.advance(2.0, 0.5, 1e-3);
  const nav_msgs::Odometry message = toOdometry(odometry, 2.0, 0.5, "odom", "base_link", ros::Time(3, 0));
  EXPECT_EQ(message.child_frame_id, "base_link");
  EXPECT_EQ(message.twist.twist.linear.x, 2.0);
  EXPECT_EQ(message.twist.twist.linear.y, 0.5);  // the root link is a metre ahead of the point that does not slip
  const Eigen::Matrix3d P = odometry.covariance();
  EXPECT_NEAR(message.pose.covariance[0], P(0, 0), 2e-6);
  EXPECT_EQ(message.pose.covariance[5], P(0, 2));
  EXPECT_EQ(message.pose.covariance[31], P(2, 1));
  for (const std::size_t i : {14U, 21U, 28U}) EXPECT_GE(message.pose.covariance[i], 1e3);
}

TEST(Conversions, ImuCovarianceIsTheNoises) {
  ImuReading reading{Eigen::Quaterniond::Identity(), {1, 2, 3}, {4, 5, 6}};
  ImuNoise noise;
  noise.acceleration = 0.5;
  const sensor_msgs::Imu message = toImu(reading, noise, "base_link", ros::Time(1, 0));
  EXPECT_EQ(message.linear_acceleration.y, 5.0);
  EXPECT_EQ(message.angular_velocity.z, 3.0);
  EXPECT_EQ(message.linear_acceleration_covariance[4], 0.25);
  EXPECT_GT(message.orientation_covariance[0], 0.0) << "0 would mean unknown to some filters";
  EXPECT_EQ(message.linear_acceleration_covariance[1], 0.0);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
