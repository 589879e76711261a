#pragma once

#include "ellipsoid_vehicle_sim/fleet/fleet.h"

namespace ellipsoid_vehicle_sim::test {

/// Linear momentum of all vehicles [N s].
inline Eigen::Vector3d momentumOf(const Fleet& fleet) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < fleet.size(); ++i) sum += fleet.vehicle(i).momentum_W();
  return sum;
}

/// Of all vehicles and of the springs between them [J].
inline double energyOf(const Fleet& fleet) {
  double sum = fleet.energyBetween();
  for (std::size_t i = 0; i < fleet.size(); ++i) sum += fleet.vehicle(i).energy();
  return sum;
}

}  // namespace ellipsoid_vehicle_sim::test
