#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/PointCloud2.h>

#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/sensors/lidar.h"

namespace ellipsoid_vehicle_sim {

/// A planar scan as Lidar::scan measured it. All rays left at `stamp`, so time_increment is 0; `period` [s] is what
/// lies between two scans.
void toLaserScan(const LidarSpec& spec, const std::vector<double>& ranges, double period, const std::string& frame,
                 const ros::Time& stamp, sensor_msgs::LaserScan& message);

/// A spatial scan: x, y, z [m] in the sensor's frame and `ring` (0 the lowest fan) of every ray that measured
/// something, in the order of the rays. What is too close or not seen has no point, so that the cloud is dense: no NaN,
/// no infinity.
void toPointCloud(const Lidar& lidar, const std::vector<double>& ranges, const std::string& frame,
                  const ros::Time& stamp, sensor_msgs::PointCloud2& message);

}  // namespace ellipsoid_vehicle_sim
