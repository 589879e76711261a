#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>

#include "ellipsoid_vehicle_sim/vehicle/simulator.h"

namespace ellipsoid_vehicle_sim {

/// White noise of an IMU: standard deviations of one sample on each axis.
struct ImuNoise {
  double orientation = 0.0;       ///< [rad].
  double angular_velocity = 0.0;  ///< [rad/s].
  double acceleration = 0.0;      ///< [m/s^2].
  std::uint64_t seed = 0;
};

/// What an IMU in the root link's origin, with its axes, tells.
struct ImuReading {
  Eigen::Quaterniond q_WR;
  Eigen::Vector3d w_WR_R;  ///< angular velocity [rad/s].
  Eigen::Vector3d f_R;     ///< specific force, a - g: upwards with g at rest (REP-145) [m/s^2].
};

/// `sample`: number of the sample. The noise is a function of seed and number alone, so it has no state to lose.
ImuReading readImu(const Simulator& simulator, const ImuNoise& noise, std::int64_t sample);

/// A standard normal number from (seed, sample, channel): SplitMix64 [Steele2014] and the Box-Muller transform.
double normalNoise(std::uint64_t seed, std::int64_t sample, std::uint64_t channel);

}  // namespace ellipsoid_vehicle_sim
