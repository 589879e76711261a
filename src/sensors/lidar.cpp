#include "ellipsoid_vehicle_sim/sensors/lidar.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ellipsoid_vehicle_sim/vehicle/imu.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kPi = 3.14159265358979323846;
/// normalNoise is never larger: Box and Muller's root of -2 ln 2^-54.
constexpr double kLargestNoise = 8.7;
/// More than the rounding of azimuths [rad].
constexpr double kAngleRounding = 1e-9;

}  // namespace

double LidarSpec::elevation(int fan) const {
  if (kind == LidarKind::kPlanar) return 0.0;
  const double low = vertical_angle_min.value_or(-kVerticalAngle), high = vertical_angle_max.value_or(kVerticalAngle);
  return fanCount() == 1 ? low : low + fan * (high - low) / (fanCount() - 1);
}

Pose LidarSpec::poseInLink() const {
  if (pose.size() != 6) return Pose{};
  return {{pose[0], pose[1], pose[2]}, quaternionFromRpy(pose[3], pose[4], pose[5])};
}

Lidar::Lidar(const LidarSpec& spec, std::uint64_t seed)
    : spec_(spec), seed_(seed), reach_(spec.range_max + kLargestNoise * spec.noise) {
  for (int fan = 0; fan < spec_.fanCount(); ++fan) {
    const double elevation = spec_.elevation(fan);
    for (int i = 0; i < spec_.fanSize(); ++i) {
      const double azimuth = spec_.angle_min + i * spec_.angleIncrement();
      directions_.emplace_back(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                               std::sin(elevation));
    }
  }
  directions_W_.resize(directions_.size());
}

void Lidar::scan(const Pose& X_WS, const RayCaster& terrain, const PosedEllipsoid* ellipsoids,
                 std::size_t ellipsoid_count, std::int64_t sample, std::vector<double>& ranges) {
  const Eigen::Matrix3d R_WS = X_WS.q.toRotationMatrix();
  for (std::size_t i = 0; i < directions_.size(); ++i) directions_W_[i] = (R_WS * directions_[i]).normalized();
  ranges.assign(directions_.size(), kInfinity);
  // Ellipsoids first: behind one, the terrain need not be asked.
  for (std::size_t k = 0; k < ellipsoid_count; ++k) shootAtEllipsoid(X_WS, ellipsoids[k], ranges);
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const double range = std::min(ranges[i], reach_);
    if (const auto hit = terrain.firstHit({X_WS.p, directions_W_[i]}, range))
      ranges[i] = std::min(ranges[i], hit->distance);
    ranges[i] = measured(ranges[i], sample, i);
  }
}

// Only rays that can meet the sphere about the ellipsoid are shot: those whose azimuth and elevation are within the
// angles under which it is seen.
void Lidar::shootAtEllipsoid(const Pose& X_WS, const PosedEllipsoid& ellipsoid, std::vector<double>& ranges) const {
  const Vector3d p_SE = X_WS.q.conjugate() * (ellipsoid.p_WE - X_WS.p);
  const double radius = ellipsoid.radii.maxCoeff(), distance = p_SE.norm(), level = p_SE.head<2>().norm();
  if (distance - radius > reach_) return;
  const double elevation = std::atan2(p_SE.z(), level);
  const double up = (distance > radius ? std::asin(radius / distance) : kPi) + kAngleRounding;
  const double azimuth = std::atan2(p_SE.y(), p_SE.x());
  const double aside = (level > radius ? std::asin(radius / level) : kPi) + kAngleRounding;
  const double increment = spec_.angleIncrement();
  for (int fan = 0; fan < spec_.fanCount(); ++fan) {
    if (std::abs(spec_.elevation(fan) - elevation) > up) continue;
    for (int turn = -1; turn <= 1; ++turn) {
      const double from = azimuth - aside + 2.0 * kPi * turn - spec_.angle_min, to = from + 2.0 * aside;
      int first = 0, last = 0;
      if (increment > 0.0) {
        first = static_cast<int>(std::max(0.0, std::ceil(from / increment)));
        last = static_cast<int>(std::min(spec_.samples - 1.0, std::floor(to / increment)));
      } else if (from > 0.0 || to < 0.0) {
        continue;  // a single ray
      }
      for (int i = first; i <= last; ++i) {
        const auto ray =
            static_cast<std::size_t>(fan) * static_cast<std::size_t>(spec_.fanSize()) + static_cast<std::size_t>(i);
        const std::optional<double> t = rayEllipsoid({X_WS.p, directions_W_[ray]}, ellipsoid);
        if (t && *t < ranges[ray] && *t <= reach_) ranges[ray] = *t;
      }
    }
  }
}

double Lidar::measured(double distance, std::int64_t sample, std::size_t ray) const {
  if (distance == kInfinity) return distance;
  if (spec_.noise > 0.0) distance += spec_.noise * normalNoise(seed_, sample, ray);
  if (distance < spec_.range_min) return -kInfinity;
  return distance > spec_.range_max ? kInfinity : distance;
}

}  // namespace ellipsoid_vehicle_sim
