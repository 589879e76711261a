#pragma once

#include <ros/serialization.h>
#include <sensor_msgs/PointCloud2.h>

#include <boost/array.hpp>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <vector>

namespace ellipsoid_vehicle_sim {

/// Looks through every field of any ROS message for numbers that are none. A stream as roscpp's serialisation takes it,
/// that writes nothing: the serialiser hands it field after field. Texts that read "nan" count, too.
class NanSearch {
 public:
  template <typename Message>
  static bool finds(const Message& message) {
    NanSearch search;
    search.next(message);
    return search.found_;
  }
  static bool finds(const sensor_msgs::PointCloud2& cloud) {
    NanSearch search;
    search.next(cloud.header);
    for (std::size_t at = 0; at + cloud.point_step <= cloud.data.size() && cloud.point_step > 0; at += cloud.point_step)
      for (const sensor_msgs::PointField& field : cloud.fields) {
        if (field.datatype != sensor_msgs::PointField::FLOAT32) continue;
        float value;
        std::memcpy(&value, &cloud.data[at + field.offset], sizeof value);
        search.next(value);
      }
    return search.found_;
  }

  static const ros::serialization::StreamType stream_type = ros::serialization::stream_types::Output;

  void next(const double& value) { found_ = found_ || std::isnan(value); }
  void next(const float& value) { found_ = found_ || std::isnan(value); }
  void next(const std::string& text) {
    std::string lower;
    for (const char c : text) lower += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    found_ = found_ || lower == "nan" || lower == "-nan";
  }
  void next(const ros::Time&) {}
  void next(const ros::Duration&) {}
  template <typename T, typename Allocator>
  void next(const std::vector<T, Allocator>& values) {
    for (const T& value : values) next(value);
  }
  template <typename T, std::size_t n>
  void next(const boost::array<T, n>& values) {
    for (const T& value : values) next(value);
  }
  template <typename T>
  void next(const T& value) {
    if constexpr (!std::is_arithmetic_v<T>) ros::serialization::Serializer<T>::write(*this, value);
  }

 private:
  bool found_ = false;
};

}  // namespace ellipsoid_vehicle_sim
