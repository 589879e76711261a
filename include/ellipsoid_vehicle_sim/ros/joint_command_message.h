#pragma once

#include <ros/message_traits.h>
#include <ros/serialization.h>
#include <sensor_msgs/JointState.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace ellipsoid_vehicle_sim {

/// A sensor_msgs/JointState, of which a reader takes no more than could be a command: it stops at the first array that is
/// longer than `kLongestArray`. A megabyte of names then costs no more than a name does, and an announced length no memory.
struct JointCommandMessage : sensor_msgs::JointState {
  static constexpr std::uint32_t kLongestArray = 1000;  // a vehicle has fewer joints

  /// Lengths as the message tells them, of name, position, velocity and effort; 0 beyond the one at which reading stopped.
  std::array<std::uint32_t, 4> told{};
};

}  // namespace ellipsoid_vehicle_sim

namespace ros {
namespace message_traits {

template <>
struct IsMessage<ellipsoid_vehicle_sim::JointCommandMessage> : TrueType {};
template <>
struct IsMessage<const ellipsoid_vehicle_sim::JointCommandMessage> : TrueType {};
template <>
struct HasHeader<ellipsoid_vehicle_sim::JointCommandMessage> : TrueType {};
template <>
struct HasHeader<const ellipsoid_vehicle_sim::JointCommandMessage> : TrueType {};
template <>
struct MD5Sum<ellipsoid_vehicle_sim::JointCommandMessage> : MD5Sum<sensor_msgs::JointState> {};
template <>
struct DataType<ellipsoid_vehicle_sim::JointCommandMessage> : DataType<sensor_msgs::JointState> {};
template <>
struct Definition<ellipsoid_vehicle_sim::JointCommandMessage> : Definition<sensor_msgs::JointState> {};

}  // namespace message_traits

namespace serialization {

/// For subscribers alone.
template <>
struct Serializer<ellipsoid_vehicle_sim::JointCommandMessage> {
  using Message = ellipsoid_vehicle_sim::JointCommandMessage;

  template <typename Stream>
  static void read(Stream& stream, Message& message) {
    stream.next(message.header);
    if (!takesLength(stream, message.told[0])) return;
    message.name.resize(message.told[0]);
    for (std::string& name : message.name) stream.next(name);
    std::vector<double>* const fields[] = {&message.position, &message.velocity, &message.effort};
    for (std::size_t i = 0; i < 3; ++i) {
      if (!takesLength(stream, message.told[i + 1])) return;
      std::vector<double>& values = *fields[i];
      values.resize(message.told[i + 1]);
      const auto bytes = static_cast<std::uint32_t>(values.size() * sizeof(double));
      const void* const from = stream.advance(bytes);
      if (bytes > 0) std::memcpy(values.data(), from, bytes);
    }
  }

 private:
  template <typename Stream>
  static bool takesLength(Stream& stream, std::uint32_t& length) {
    stream.next(length);
    return length <= Message::kLongestArray;
  }
};

}  // namespace serialization
}  // namespace ros
