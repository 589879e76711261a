#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/geometry/ellipsoid.h"
#include "ellipsoid_vehicle_sim/geometry/pose.h"
#include "ellipsoid_vehicle_sim/geometry/problem.h"
#include "ellipsoid_vehicle_sim/sensors/ray_caster.h"
#include "ellipsoid_vehicle_sim/vehicle/parameter_table.h"

namespace ellipsoid_vehicle_sim {

enum class LidarKind {
  kPlanar,  ///< one fan of rays in the sensor's x-y plane.
  kSpatial  ///< several fans, one above the other.
};

/// A lidar as its parameters describe it. The sensor's frame S: x ahead, y left, z up (REP-103); azimuth from x towards
/// y, elevation from the x-y plane towards z.
struct LidarSpec {
  LidarKind kind = LidarKind::kPlanar;
  std::string link;  ///< of the vehicle that carries it; empty: the root link.
  std::vector<double>
      pose;              ///< x, y, z [m], roll, pitch, yaw [rad] of S in that link; empty: S is the link's own frame.
  std::string frame_id;  ///< name of S; empty: the link without a pose, otherwise the lidar's name.
  std::string topic;     ///< empty: NAME/scan, or NAME/points for a spatial one.
  double angle_min = -2.356194490192345;  ///< azimuth of the first ray [rad].
  double angle_max = 2.356194490192345;   ///< of the last one [rad].
  double samples = 1081;                  ///< rays in a fan, both ends included.
  // Spatial only; none: kVerticalAngle up and down, kRings.
  std::optional<double> vertical_angle_min;  ///< elevation of the lowest fan [rad].
  std::optional<double> vertical_angle_max;  ///< of the highest [rad].
  std::optional<double> rings;               ///< fans, both ends included.
  double range_min = 0.1;                    ///< what is measured nearer is too close to tell [m].
  double range_max = 30.0;                   ///< what is measured farther is not seen [m].
  double rate = 40.0;                        ///< scans per simulated second [Hz].
  double noise = 0.0;                        ///< standard deviation of a range [m].
  std::optional<double> seed;                ///< of the noise; none: from the node's noise_seed and the lidar's name.
  bool sees_own_vehicle = false;             ///< the ellipsoids of the vehicle that carries it are in its way.

  static constexpr double kVerticalAngle = 0.2617993877991494;  ///< 15 degrees.
  static constexpr double kRings = 16.0;

  int fanCount() const { return kind == LidarKind::kPlanar ? 1 : static_cast<int>(rings.value_or(kRings)); }
  int fanSize() const { return static_cast<int>(samples); }
  /// [rad]; 0 for a single ray.
  double angleIncrement() const { return samples > 1 ? (angle_max - angle_min) / (samples - 1) : 0.0; }
  double elevation(int fan) const;
  /// X_LS.
  Pose poseInLink() const;
};

/// Every parameter of LidarSpec.
ParameterTable<LidarSpec> lidarParameters();
/// What only several values together can get wrong; `where` stands before the key, "~front/".
Problems checkLidar(const LidarSpec& spec, const std::string& where);

/// Measures ranges by rays: all rays of a scan leave at one moment.
///   - The nearest of the terrain's triangles, either side, and of the given ellipsoids.
///   - Plus noise: normal, a function of seed, number of the scan, and ray alone.
///   - Told as REP-117 says: +infinity where nothing was measured up to range_max, -infinity where what was measured is
///     nearer than range_min. Never a NaN: REP-117 has it for an erroneous measurement, and there are none here.
class Lidar {
 public:
  Lidar(const LidarSpec& spec, std::uint64_t seed);

  const LidarSpec& spec() const { return spec_; }
  /// Unit directions in S, fan by fan from the lowest, each from angle_min on.
  const std::vector<Eigen::Vector3d>& directions() const { return directions_; }

  /// The scan of number `sample`, taken from X_WS. `ranges` in the order of directions() [m]; no allocation once sized.
  void scan(const Pose& X_WS, const RayCaster& terrain, const PosedEllipsoid* ellipsoids, std::size_t ellipsoid_count,
            std::int64_t sample, std::vector<double>& ranges);

 private:
  void shootAtEllipsoid(const Pose& X_WS, const PosedEllipsoid& ellipsoid, std::vector<double>& ranges) const;
  double measured(double distance, std::int64_t sample, std::size_t ray) const;

  LidarSpec spec_;
  std::uint64_t seed_;
  double reach_;  ///< beyond which noise brings nothing back into range [m].
  std::vector<Eigen::Vector3d> directions_;
  std::vector<Eigen::Vector3d> directions_W_;  ///< kept to save its memory.
};

/// The noise's seed of a lidar that has none of its own.
std::uint64_t lidarSeed(std::uint64_t noise_seed, const std::string& name);

}  // namespace ellipsoid_vehicle_sim
