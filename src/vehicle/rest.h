#pragma once

#include "ellipsoid_vehicle_sim/vehicle/vehicle_model.h"
#include "ellipsoid_vehicle_sim/vehicle/vehicle_state.h"

namespace ellipsoid_vehicle_sim {

/// At rest a vehicle is left where it is. The rule asks the present state only, so that a snapshot goes on as the run did:
/// brakes on, no path under way, no slack that is still given back, something touched, and no part faster than kRestSpeed
/// or accelerating by more than kRestAcceleration. Such a state is within kRestSpeed / w + kRestAcceleration / w^2 of where
/// a damped mode of frequency w would end: 6e-9 m at 1 rad/s, the slowest that a ride has.
constexpr double kRestSpeed = 5e-10;        ///< [m/s], [rad/s].
constexpr double kRestAcceleration = 5e-9;  ///< [m/s^2], [rad/s^2].

/// Nothing that is commanded, or on a path, moves the vehicle in this tick (after updateDrive).
bool isLeftAlone(const VehicleState& state);
/// All speeds are below kRestSpeed, and something is touched.
bool isStill(const VehicleState& state);
/// `rate` at the state: all accelerations are below kRestAcceleration.
bool isBalanced(const MotionRate& rate);

}  // namespace ellipsoid_vehicle_sim
