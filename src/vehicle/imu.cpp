#include "ellipsoid_vehicle_sim/vehicle/imu.h"

#include <cmath>

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

constexpr double kTwoPi = 6.283185307179586476925;

std::uint64_t mixed(std::uint64_t z) {
  z += 0x9e3779b97f4a7c15ull;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  return z ^ (z >> 31);
}

/// In (0, 1): 53 bits and a half.
double uniform(std::uint64_t bits) { return (static_cast<double>(bits >> 11) + 0.5) * 0x1.0p-53; }

Vector3d noiseVector(const ImuNoise& noise, double deviation, std::int64_t sample, std::uint64_t first_channel) {
  Vector3d v;
  for (std::uint64_t i = 0; i < 3; ++i)
    v[static_cast<Eigen::Index>(i)] = deviation * normalNoise(noise.seed, sample, first_channel + i);
  return v;
}

}  // namespace

double normalNoise(std::uint64_t seed, std::int64_t sample, std::uint64_t channel) {
  const std::uint64_t key = mixed(mixed(mixed(seed) ^ static_cast<std::uint64_t>(sample)) ^ channel);
  return std::sqrt(-2.0 * std::log(uniform(key))) * std::cos(kTwoPi * uniform(mixed(key)));
}

ImuReading readImu(const Simulator& simulator, const ImuNoise& noise, std::int64_t sample) {
  ImuReading reading;
  reading.q_WR = simulator.rootPose().q;
  const Vector3d gravity_W(0.0, 0.0, -simulator.config().gravity);
  reading.w_WR_R = reading.q_WR.conjugate() * simulator.rootAngularVelocity_W();
  reading.f_R = reading.q_WR.conjugate() * (simulator.rootAcceleration_W() - gravity_W);
  if (noise.orientation > 0.0) {
    const Vector3d error = noiseVector(noise, noise.orientation, sample, 0);
    reading.q_WR = (reading.q_WR * quaternionFromRotationVector(error)).normalized();
  }
  if (noise.angular_velocity > 0.0) reading.w_WR_R += noiseVector(noise, noise.angular_velocity, sample, 3);
  if (noise.acceleration > 0.0) reading.f_R += noiseVector(noise, noise.acceleration, sample, 6);
  return reading;
}

}  // namespace ellipsoid_vehicle_sim
