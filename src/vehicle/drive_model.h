#pragma once

#include <vector>

#include "ellipsoid_vehicle_sim/vehicle/vehicle_model.h"

namespace ellipsoid_vehicle_sim {

/// Wheels, steering, layout and limits of a model whose bodies, joints and ellipsoids are complete. Adds treads to `model`
/// where it is a solid compound. owner_joint: per link, the nearest movable joint of the description above it.
DriveModel buildDriveModel(VehicleModel& model, const std::vector<int>& owner_joint, const SimConfig& config,
                           Problems& problems);

/// Gains of the speed servos and brake torques, once the joints' inertias are known.
void deriveDriveGains(VehicleModel& model, const SimConfig& config);

/// Angle of the virtual steering at p for the path curvature kappa [1/m] of the reference point, left positive [rad]: the
/// wheel's axle points at the turning centre (Ackermann).
double ackermannAngle(double curvature, const Eigen::Vector3d& p_FS, double reference_x);

}  // namespace ellipsoid_vehicle_sim
