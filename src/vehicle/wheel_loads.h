#pragma once

#include <vector>

#include "ellipsoid_vehicle_sim/vehicle/vehicle_model.h"

namespace ellipsoid_vehicle_sim {

/// Static load of each dynamic joint on flat ground, along its coordinate [N] or [N m]: what a spring there has to hold.
/// Wheel loads are the least-squares smallest that balance weight and moments; prismatic joints only, others get 0.
std::vector<double> carriedLoads(const VehicleModel& model, const std::vector<int>& owner_joint, double gravity);

/// Positions of the bodies' frames and of the centre of mass in the root link's frame, all joints at zero.
struct RestGeometry {
  std::vector<Pose> X_RB;
  Eigen::Vector3d p_Rcm;
};
RestGeometry restGeometry(const VehicleModel& model);

}  // namespace ellipsoid_vehicle_sim
