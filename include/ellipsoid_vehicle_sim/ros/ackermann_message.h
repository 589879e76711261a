#pragma once

#include <ros/message_traits.h>
#include <ros/serialization.h>
#include <std_msgs/Header.h>

namespace ellipsoid_vehicle_sim {

/// The same on the wire as ackermann_msgs/AckermannDriveStamped, so that a commander with that package can talk to a
/// simulator without it. Fields are absolute bounds where they say how fast; 0: no bound of its own.
struct AckermannDriveStamped {
  std_msgs::Header header;
  float steering_angle = 0.0F;           ///< of the virtual front wheel, left positive [rad].
  float steering_angle_velocity = 0.0F;  ///< [rad/s].
  float speed = 0.0F;                    ///< forward positive [m/s].
  float acceleration = 0.0F;             ///< [m/s^2].
  float jerk = 0.0F;                     ///< [m/s^3].
};

}  // namespace ellipsoid_vehicle_sim

namespace ros {
namespace message_traits {

template <>
struct IsMessage<ellipsoid_vehicle_sim::AckermannDriveStamped> : TrueType {};
template <>
struct IsMessage<const ellipsoid_vehicle_sim::AckermannDriveStamped> : TrueType {};
template <>
struct HasHeader<ellipsoid_vehicle_sim::AckermannDriveStamped> : TrueType {};
template <>
struct HasHeader<const ellipsoid_vehicle_sim::AckermannDriveStamped> : TrueType {};

template <>
struct MD5Sum<ellipsoid_vehicle_sim::AckermannDriveStamped> {
  static const char* value() { return "1fd5d7f58889cefd44d29f6653240d0c"; }
  static const char* value(const ellipsoid_vehicle_sim::AckermannDriveStamped&) { return value(); }
};

template <>
struct DataType<ellipsoid_vehicle_sim::AckermannDriveStamped> {
  static const char* value() { return "ackermann_msgs/AckermannDriveStamped"; }
  static const char* value(const ellipsoid_vehicle_sim::AckermannDriveStamped&) { return value(); }
};

template <>
struct Definition<ellipsoid_vehicle_sim::AckermannDriveStamped> {
  static const char* value() {
    return "Header header\n"
           "AckermannDrive drive\n"
           "================================================================================\n"
           "MSG: std_msgs/Header\n"
           "uint32 seq\n"
           "time stamp\n"
           "string frame_id\n"
           "================================================================================\n"
           "MSG: ackermann_msgs/AckermannDrive\n"
           "float32 steering_angle\n"
           "float32 steering_angle_velocity\n"
           "float32 speed\n"
           "float32 acceleration\n"
           "float32 jerk\n";
  }
  static const char* value(const ellipsoid_vehicle_sim::AckermannDriveStamped&) { return value(); }
};

}  // namespace message_traits

namespace serialization {

template <>
struct Serializer<ellipsoid_vehicle_sim::AckermannDriveStamped> {
  template <typename Stream, typename Message>
  static void allInOne(Stream& stream, Message message) {
    stream.next(message.header);
    stream.next(message.steering_angle);
    stream.next(message.steering_angle_velocity);
    stream.next(message.speed);
    stream.next(message.acceleration);
    stream.next(message.jerk);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

}  // namespace serialization
}  // namespace ros
