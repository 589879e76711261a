#pragma once

#include "ellipsoid_vehicle_sim/vehicle/vehicle_dynamics.h"

namespace ellipsoid_vehicle_sim {

/// A state of the right sizes: joints at rest position, velocities zero, brakes on, no contact known.
VehicleState restState(const VehicleModel& model, const VehicleDynamics& dynamics);

/// Puts `state` at rest on the ground below (x, y) [m] facing yaw [rad]: placed just above the ground in its mean slope, then
/// let down under extra damping (SettlingDamper) with friction that holds, until nothing moves. Problems say why there is no
/// such place.
Problems settle(const VehicleModel& model, const SimConfig& config, const Terrain& terrain, VehicleDynamics& dynamics,
                double x, double y, double yaw, VehicleState& state);

}  // namespace ellipsoid_vehicle_sim
