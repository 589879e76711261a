#include "ellipsoid_vehicle_sim/ros/lidar_messages.h"

#include <cmath>
#include <cstring>

namespace ellipsoid_vehicle_sim {
namespace {

constexpr std::uint32_t kPointSize = 16;  // three floats, the ring, two bytes of padding
constexpr std::uint32_t kRingOffset = 12;

sensor_msgs::PointField field(const char* name, std::uint32_t offset, std::uint8_t type) {
  sensor_msgs::PointField result;
  result.name = name;
  result.offset = offset;
  result.datatype = type;
  result.count = 1;
  return result;
}

}  // namespace

void toLaserScan(const LidarSpec& spec, const std::vector<double>& ranges, double period, const std::string& frame,
                 const ros::Time& stamp, sensor_msgs::LaserScan& message) {
  message.header.stamp = stamp;
  message.header.frame_id = frame;
  message.angle_min = static_cast<float>(spec.angle_min);
  message.angle_max = static_cast<float>(spec.angle_max);
  message.angle_increment = static_cast<float>(spec.angleIncrement());
  message.time_increment = 0.0f;
  message.scan_time = static_cast<float>(period);
  message.range_min = static_cast<float>(spec.range_min);
  message.range_max = static_cast<float>(spec.range_max);
  message.ranges.resize(ranges.size());
  for (std::size_t i = 0; i < ranges.size(); ++i) message.ranges[i] = static_cast<float>(ranges[i]);
}

void toPointCloud(const Lidar& lidar, const std::vector<double>& ranges, const std::string& frame,
                  const ros::Time& stamp, sensor_msgs::PointCloud2& message) {
  using Field = sensor_msgs::PointField;
  message.header.stamp = stamp;
  message.header.frame_id = frame;
  message.fields = {field("x", 0, Field::FLOAT32), field("y", 4, Field::FLOAT32), field("z", 8, Field::FLOAT32),
                    field("ring", kRingOffset, Field::UINT16)};
  const std::uint16_t one = 1;
  message.is_bigendian = *reinterpret_cast<const unsigned char*>(&one) == 0;
  message.point_step = kPointSize;
  message.is_dense = true;
  message.height = 1;
  message.data.clear();
  const auto fan_size = static_cast<std::size_t>(lidar.spec().fanSize());
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    if (!std::isfinite(ranges[i])) continue;
    const Eigen::Vector3f point = (ranges[i] * lidar.directions()[i]).cast<float>();
    const auto ring = static_cast<std::uint16_t>(i / fan_size);
    std::uint8_t bytes[kPointSize] = {};
    std::memcpy(bytes, point.data(), kRingOffset);
    std::memcpy(bytes + kRingOffset, &ring, sizeof ring);
    message.data.insert(message.data.end(), bytes, bytes + kPointSize);
  }
  message.width = static_cast<std::uint32_t>(message.data.size()) / kPointSize;
  message.row_step = static_cast<std::uint32_t>(message.data.size());
}

}  // namespace ellipsoid_vehicle_sim
