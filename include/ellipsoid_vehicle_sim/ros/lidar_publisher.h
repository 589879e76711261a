#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/PointCloud2.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "ellipsoid_vehicle_sim/sensors/lidar_mount.h"
#include "ellipsoid_vehicle_sim/vehicle/link_poses.h"

namespace ellipsoid_vehicle_sim {

/// The lidars of one vehicle: measures on their ticks and publishes. A scan is a function of the state and of its
/// number; one that nobody subscribes to is not worked out, which changes nothing else.
class LidarPublisher {
 public:
  /// `caster`: of the world, shared by all vehicles. `noise_seed`: of the node. `prefix` stands before all frames.
  LidarPublisher(ros::NodeHandle& nh, const std::vector<NamedLidar>& lidars, std::shared_ptr<const RayCaster> caster,
                 const Simulator& simulator, std::uint64_t noise_seed, const std::string& prefix = "");

  /// Ticks until the next scan, at least 1; `ticks` since the last reset.
  std::int64_t ticksToNext(std::int64_t ticks) const;
  /// Whether publishDue would measure anything.
  bool isDue(std::int64_t ticks) const;
  /// Publishes what is due. `others`: the ellipsoids of all other vehicles, where they are now.
  void publishDue(std::int64_t ticks, const ros::Time& stamp, const std::vector<PosedEllipsoid>& others = {});

  /// Frames of the lidars that stand in none of the URDF's, in the links that carry them.
  std::vector<geometry_msgs::TransformStamped> staticTransforms() const;

 private:
  struct Mounted {
    Lidar lidar;
    std::string link, frame;
    int link_index = 0;
    Pose X_LS;
    std::int64_t period = 1;  ///< [ticks].
    ros::Publisher publisher;
  };
  void publish(Mounted& mounted, std::int64_t sample, const ros::Time& stamp,
               const std::vector<PosedEllipsoid>& others);

  const Simulator& simulator_;
  std::shared_ptr<const RayCaster> caster_;
  LinkPoses links_;
  std::vector<Mounted> lidars_;

  // Kept to save their memory from scan to scan.
  std::vector<PosedEllipsoid> ellipsoids_;
  std::vector<double> ranges_;
  sensor_msgs::LaserScan scan_;
  sensor_msgs::PointCloud2 cloud_;
};

}  // namespace ellipsoid_vehicle_sim
