#include "ellipsoid_vehicle_sim/ros/conversions.h"

#include <algorithm>
#include <cmath>

namespace ellipsoid_vehicle_sim {
namespace {

// The pose is exact; filters want some variance and take 0 for "unknown" or divide by it. A millimetre and a
// milliradian.
constexpr double kTruthVariance = 1e-6;  // [m^2], [rad^2], and likewise for speeds
// What encoders tell of a speed is off by some slip: a centimetre a second.
constexpr double kEncoderVariance = 1e-4;
// Nothing is known: large, and still harmless to a filter.
constexpr double kUnknownVariance = 1e6;
constexpr double kLeastVariance = 1e-18;  // of an estimated local error: a nanometre squared

bool finite(double value) { return std::isfinite(value); }

bool allFinite(const std::vector<double>& values) { return std::all_of(values.begin(), values.end(), finite); }

}  // namespace

ros::Duration simulatedDuration(std::int64_t steps, double dt) {
  // Whole seconds apart from the rest, so that the nanoseconds keep all their digits on long runs.
  const double seconds = static_cast<double>(steps) * dt;
  const double whole = std::floor(seconds);
  auto sec = static_cast<std::int32_t>(whole);
  auto nsec = static_cast<std::int32_t>(std::llround((seconds - whole) * 1e9));
  if (nsec == 1000000000) {
    ++sec;
    nsec = 0;
  }
  return ros::Duration(sec, nsec);
}

geometry_msgs::Point toPoint(const Eigen::Vector3d& p) {
  geometry_msgs::Point message;
  message.x = p.x();
  message.y = p.y();
  message.z = p.z();
  return message;
}

geometry_msgs::Vector3 toVector(const Eigen::Vector3d& v) {
  geometry_msgs::Vector3 message;
  message.x = v.x();
  message.y = v.y();
  message.z = v.z();
  return message;
}

geometry_msgs::Quaternion toQuaternion(const Eigen::Quaterniond& q) {
  geometry_msgs::Quaternion message;
  message.w = q.w();
  message.x = q.x();
  message.y = q.y();
  message.z = q.z();
  return message;
}

geometry_msgs::Pose toPose(const Pose& X_AB) {
  geometry_msgs::Pose message;
  message.position = toPoint(X_AB.p);
  message.orientation = toQuaternion(X_AB.q);
  return message;
}

std_msgs::ColorRGBA toColor(double red, double green, double blue, double alpha) {
  std_msgs::ColorRGBA color;
  color.r = static_cast<float>(red);
  color.g = static_cast<float>(green);
  color.b = static_cast<float>(blue);
  color.a = static_cast<float>(alpha);
  return color;
}

nav_msgs::Odometry toOdometry(const Pose& X_WR, const Eigen::Vector3d& v_WR_W, const Eigen::Vector3d& w_WR_W,
                              const std::string& odom_frame, const std::string& base_frame, const ros::Time& stamp) {
  nav_msgs::Odometry message;
  message.header.stamp = stamp;
  message.header.frame_id = odom_frame;
  message.child_frame_id = base_frame;
  message.pose.pose = toPose(X_WR);
  message.twist.twist.linear = toVector(X_WR.q.conjugate() * v_WR_W);
  message.twist.twist.angular = toVector(X_WR.q.conjugate() * w_WR_W);
  for (std::size_t i = 0; i < 6; ++i) {
    message.pose.covariance[7 * i] = kTruthVariance;
    message.twist.covariance[7 * i] = kTruthVariance;
  }
  return message;
}

void setCovariance(const ErrorEstimate& estimate, const Eigen::Quaterniond& q_WR, nav_msgs::Odometry& message) {
  const Eigen::Quaterniond q_RW = q_WR.conjugate();
  const Eigen::Vector3d velocity_R = q_RW * estimate.velocity_W, turning_R = q_RW * estimate.angular_velocity_W;
  const auto variance = [](double e) { return std::max(kLeastVariance, e * e); };
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    message.pose.covariance[7 * i] = variance(estimate.position_W[axis]);
    message.pose.covariance[7 * (i + 3)] = variance(estimate.rotation_W[axis]);
    message.twist.covariance[7 * i] = variance(velocity_R[axis]);
    message.twist.covariance[7 * (i + 3)] = variance(turning_R[axis]);
  }
}

void markUnstable(nav_msgs::Odometry& message) {
  for (std::size_t i = 0; i < 36; ++i)
    message.pose.covariance[i] = message.twist.covariance[i] = i % 7 == 0 ? kUnknownVariance : 0.0;
}

void markUnstable(sensor_msgs::Imu& message) {
  // The message's own word for "no estimate".
  message.orientation_covariance[0] = message.angular_velocity_covariance[0] =
      message.linear_acceleration_covariance[0] = -1.0;
}

geometry_msgs::TransformStamped toTransform(const Pose& X_WR, const std::string& odom_frame,
                                            const std::string& base_frame, const ros::Time& stamp) {
  geometry_msgs::TransformStamped message;
  message.header.stamp = stamp;
  message.header.frame_id = odom_frame;
  message.child_frame_id = base_frame;
  message.transform.translation = toVector(X_WR.p);
  message.transform.rotation = toQuaternion(X_WR.q);
  return message;
}

void toJointState(const std::vector<std::string>& names, const std::vector<JointReading>& readings,
                  const ros::Time& stamp, sensor_msgs::JointState& message) {
  message.header.stamp = stamp;
  if (message.name.size() != names.size()) message.name = names;
  message.position.resize(readings.size());
  message.velocity.resize(readings.size());
  message.effort.resize(readings.size());
  for (std::size_t i = 0; i < readings.size(); ++i) {
    message.position[i] = readings[i].position;
    message.velocity[i] = readings[i].velocity;
    message.effort[i] = readings[i].effort;
  }
}

ContactState toContactState(const ContactReport& contact, const EllipsoidPlacement& ellipsoid,
                            const std::string& surface) {
  ContactState message;
  message.ellipsoid = ellipsoid.name;
  message.link = ellipsoid.link;
  message.triangle = contact.triangle;
  message.surface = surface;
  message.point = toPoint(contact.p_WC);
  message.normal = toVector(contact.nhat_W);
  message.depth = contact.depth;
  message.force = toVector(contact.normal_force * contact.nhat_W + contact.friction_W);
  message.normal_force = contact.normal_force;
  message.friction = toVector(contact.friction_W);
  message.sliding = contact.sliding;
  return message;
}

sensor_msgs::Imu toImu(const ImuReading& reading, const ImuNoise& noise, const std::string& frame,
                       const ros::Time& stamp) {
  sensor_msgs::Imu message;
  message.header.stamp = stamp;
  message.header.frame_id = frame;
  message.orientation = toQuaternion(reading.q_WR);
  message.angular_velocity = toVector(reading.w_WR_R);
  message.linear_acceleration = toVector(reading.f_R);
  for (std::size_t i = 0; i < 9; i += 4) {
    message.orientation_covariance[i] = std::max(noise.orientation * noise.orientation, kTruthVariance);
    message.angular_velocity_covariance[i] = std::max(noise.angular_velocity * noise.angular_velocity, kTruthVariance);
    message.linear_acceleration_covariance[i] = std::max(noise.acceleration * noise.acceleration, kTruthVariance);
  }
  return message;
}

nav_msgs::Odometry toOdometry(const WheelOdometry& odometry, double speed, double yaw_rate, const std::string& odom_frame,
                              const std::string& base_frame, const ros::Time& stamp) {
  nav_msgs::Odometry message;
  message.header.stamp = stamp;
  message.header.frame_id = odom_frame;
  message.child_frame_id = base_frame;
  message.pose.pose = toPose(odometry.pose());
  // The encoders tell of the reference point; the root link is elsewhere, and may look elsewhere.
  const Eigen::Vector3d twist = odometry.rootTwist(speed, yaw_rate);
  message.twist.twist.linear.x = twist.x();
  message.twist.twist.linear.y = twist.y();
  message.twist.twist.angular.z = twist.z();
  // Rows and columns x, y, z, roll, pitch, yaw.
  const Eigen::Matrix3d P = odometry.covariance();
  constexpr std::size_t kMeasured[3] = {0, 1, 5};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      message.pose.covariance[6 * kMeasured[i] + kMeasured[j]] =
          P(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
    }
    message.pose.covariance[7 * kMeasured[i]] += kTruthVariance;
    message.twist.covariance[7 * kMeasured[i]] = kEncoderVariance;
  }
  for (const std::size_t unknown : {2U, 3U, 4U}) {
    message.pose.covariance[7 * unknown] = kUnknownVariance;
    message.twist.covariance[7 * unknown] = kUnknownVariance;
  }
  return message;
}

Pose fromPose(const geometry_msgs::Pose& pose) {
  return {Eigen::Vector3d(pose.position.x, pose.position.y, pose.position.z),
          Eigen::Quaterniond(pose.orientation.w, pose.orientation.x, pose.orientation.y, pose.orientation.z)};
}

Eigen::Vector3d fromVector(const geometry_msgs::Vector3& v) { return {v.x, v.y, v.z}; }

DriveCommand toDriveCommand(const AckermannDriveStamped& message) {
  DriveCommand command;
  command.kind = DriveCommand::Kind::kAckermann;
  command.speed = message.speed;
  command.steering_angle = message.steering_angle;
  command.steering_angle_velocity = message.steering_angle_velocity;
  command.acceleration = message.acceleration;
  command.jerk = message.jerk;
  return command;
}

std::vector<JointRequest> toJointRequests(const sensor_msgs::JointState& message) {
  std::vector<JointRequest> requests(message.name.size());
  for (std::size_t i = 0; i < requests.size(); ++i) {
    requests[i].joint = message.name[i];
    if (!message.position.empty()) requests[i].position = message.position[i];
    if (!message.velocity.empty()) requests[i].velocity = message.velocity[i];
    if (!message.effort.empty()) requests[i].effort = message.effort[i];
  }
  return requests;
}

DriveCommand toDriveCommand(const geometry_msgs::Twist& twist) {
  DriveCommand command;
  command.kind = DriveCommand::Kind::kTwist;
  command.speed = twist.linear.x;
  command.yaw_rate = twist.angular.z;
  return command;
}

bool allFinite(const nav_msgs::Odometry& message) {
  const geometry_msgs::Pose& pose = message.pose.pose;
  const geometry_msgs::Twist& twist = message.twist.twist;
  // A sum is finite only if everything in it is; these are far from overflowing together.
  return finite(pose.position.x + pose.position.y + pose.position.z + pose.orientation.w + pose.orientation.x +
                pose.orientation.y + pose.orientation.z + twist.linear.x + twist.linear.y + twist.linear.z +
                twist.angular.x + twist.angular.y + twist.angular.z);
}

bool allFinite(const sensor_msgs::Imu& m) {
  return finite(m.orientation.w + m.orientation.x + m.orientation.y + m.orientation.z + m.angular_velocity.x +
                m.angular_velocity.y + m.angular_velocity.z + m.linear_acceleration.x + m.linear_acceleration.y +
                m.linear_acceleration.z);
}

bool allFinite(const sensor_msgs::JointState& message) {
  return allFinite(message.position) && allFinite(message.velocity) && allFinite(message.effort);
}

}  // namespace ellipsoid_vehicle_sim
