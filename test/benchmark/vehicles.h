#pragma once

#include <string>

#include "support/scenes.h"
#include "workloads.h"

namespace ellipsoid_vehicle_sim::test {

/// The body of W1.
inline VehicleDescription fiveEllipsoids() {
  VehicleDescription body = solidBody(drop::chassis(), drop::kMass);
  for (const Eigen::Vector3d& p : drop::wheels()) {
    const std::string name = "wheel" + std::to_string(body.links[0].ellipsoids.size());
    body.links[0].ellipsoids.push_back(ellipsoid(name, p, benchmarkWheel()));
  }
  return body;
}

}  // namespace ellipsoid_vehicle_sim::test
