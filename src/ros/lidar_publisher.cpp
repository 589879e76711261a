#include "ellipsoid_vehicle_sim/ros/lidar_publisher.h"

#include <ros/console.h>

#include <algorithm>
#include <cmath>

#include "ellipsoid_vehicle_sim/ros/conversions.h"
#include "ellipsoid_vehicle_sim/ros/lidar_messages.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr int kScanQueue = 20;

}  // namespace

LidarPublisher::LidarPublisher(ros::NodeHandle& nh, const std::vector<NamedLidar>& lidars,
                               std::shared_ptr<const RayCaster> caster, const Simulator& simulator,
                               std::uint64_t noise_seed, const std::string& prefix)
    : simulator_(simulator), caster_(std::move(caster)), links_(simulator.model().description) {
  const VehicleDescription& vehicle = simulator.model().description;
  const double dt = simulator.config().dt;
  for (const NamedLidar& named : lidars) {
    const LidarSpec& spec = named.spec;
    const std::int64_t period = std::max<std::int64_t>(1, std::llround(1.0 / (spec.rate * dt)));
    const double real_rate = 1.0 / (static_cast<double>(period) * dt);
    if (std::abs(real_rate - spec.rate) > 1e-6 * spec.rate)
      ROS_INFO("lidar '%s': %g Hz becomes %g Hz, one scan every %ld ticks", named.name.c_str(), spec.rate, real_rate,
               static_cast<long>(period));
    Mounted mounted{Lidar(spec, named.seed(noise_seed)),
                    prefix + named.link(vehicle),
                    prefix + named.frame(vehicle),
                    0,
                    spec.poseInLink(),
                    period,
                    ros::Publisher()};
    mounted.link_index = links_.find(named.link(vehicle));
    mounted.publisher = spec.kind == LidarKind::kPlanar
                            ? nh.advertise<sensor_msgs::LaserScan>(named.topic(), kScanQueue)
                            : nh.advertise<sensor_msgs::PointCloud2>(named.topic(), kScanQueue);
    lidars_.push_back(std::move(mounted));
  }
}

std::int64_t LidarPublisher::ticksToNext(std::int64_t ticks) const {
  std::int64_t next = lidars_.front().period;
  for (const Mounted& mounted : lidars_) next = std::min(next, mounted.period - ticks % mounted.period);
  return next;
}

bool LidarPublisher::isDue(std::int64_t ticks) const {
  return std::any_of(lidars_.begin(), lidars_.end(), [ticks](const Mounted& mounted) {
    return ticks % mounted.period == 0 && mounted.publisher.getNumSubscribers() > 0;
  });
}

void LidarPublisher::publishDue(std::int64_t ticks, const ros::Time& stamp, const std::vector<PosedEllipsoid>& others) {
  for (Mounted& mounted : lidars_) {
    if (ticks % mounted.period == 0 && mounted.publisher.getNumSubscribers() > 0)
      publish(mounted, ticks / mounted.period, stamp, others);
  }
}

void LidarPublisher::publish(Mounted& mounted, std::int64_t sample, const ros::Time& stamp,
                             const std::vector<PosedEllipsoid>& others) {
  const LidarSpec& spec = mounted.lidar.spec();
  ellipsoids_ = others;
  if (spec.sees_own_vehicle) {
    appendPosedEllipsoids(simulator_, links_, ellipsoids_);
  } else {
    links_.update(simulator_);
  }
  const Pose X_WS = links_.poses()[static_cast<std::size_t>(mounted.link_index)] * mounted.X_LS;
  mounted.lidar.scan(X_WS, *caster_, ellipsoids_.data(), ellipsoids_.size(), sample, ranges_);
  if (spec.kind == LidarKind::kPlanar) {
    const double period = static_cast<double>(mounted.period) * simulator_.config().dt;
    toLaserScan(spec, ranges_, period, mounted.frame, stamp, scan_);
    mounted.publisher.publish(scan_);
  } else {
    toPointCloud(mounted.lidar, ranges_, mounted.frame, stamp, cloud_);
    mounted.publisher.publish(cloud_);
  }
}

std::vector<geometry_msgs::TransformStamped> LidarPublisher::staticTransforms() const {
  std::vector<geometry_msgs::TransformStamped> transforms;
  for (const Mounted& mounted : lidars_) {
    if (mounted.frame != mounted.link)
      transforms.push_back(toTransform(mounted.X_LS, mounted.link, mounted.frame, ros::Time(0)));
  }
  return transforms;
}

}  // namespace ellipsoid_vehicle_sim
