#pragma once

#include <vector>

#include "ellipsoid_vehicle_sim/geometry/problem.h"
#include "ellipsoid_vehicle_sim/vehicle/sim_config.h"
#include "ellipsoid_vehicle_sim/vehicle/vehicle_model.h"
#include "ellipsoid_vehicle_sim/vehicle/vehicle_state.h"

namespace ellipsoid_vehicle_sim {

/// From the command in force to targets of wheels, treads and steering for the coming tick: timeout, speed and acceleration
/// limits, steering geometry, servo integrals. Speeds asked of wheels run linearly through the tick, as a ramp does: a stair
/// of ticks would be ahead of it by half a tick, and every method of first order in dt. A joint with a command of its own
/// that is not too old obeys that; the others obey the vehicle's. `timed_out` is set in the tick in which a command becomes
/// too old.
void updateDrive(const VehicleModel& model, const SimConfig& config, VehicleState& state, bool& timed_out);

/// Motor torques of the wheel units for joint angles q and speeds qd, `elapsed` seconds after the moment of `drive`: pure, so
/// every stage of a step may ask. [N m], sign of the joint. The servos' integral of the speed's error is that of the angle:
/// no rule of summation comes between it and the step's own order.
void driveTorques(const VehicleModel& model, const SimConfig& config, const DriveState& drive, double elapsed,
                  const std::vector<double>& q, const std::vector<double>& qd, std::vector<double>& torque);

/// Takes targets and integrals of the servos on over a step of dt, at whose end the joints are at q.
void carryDrive(const VehicleModel& model, double dt, const std::vector<double>& q, bool ends_tick, DriveState& drive);

/// Brake torque available at a wheel unit now [N m].
double brakeTorque(const WheelUnit& wheel, const DriveState& drive);

/// Joints on a path that mimic others put where these are, moving as they move.
void followLeaders(const VehicleModel& model, VehicleState& state);

/// Why a command for so many joints is refused before any name is looked at; empty if it is not. Each joint can be named
/// once, and a flood of commands that are a megabyte each shall not cost what looking at them would.
std::string countRefusal(const VehicleModel& model, std::size_t count);

/// Takes requests for joints into the state, all or none; problems say why none. Limits, not age, are applied later.
Problems takeJointRequests(const VehicleModel& model, const std::vector<JointRequest>& requests, DriveState& drive);

/// A prescribed joint whose last tick needed more effort than it has, and would go on that way: it holds instead. The way
/// back is always open.
bool effortExceeded(const PrescribedJoint& joint, const ProfileState& profile);

/// Curvature of the path of the drive's reference point for the steering as it stands `ahead` seconds from now, within the
/// tick [1/m], left positive.
double actualCurvature(const VehicleModel& model, const VehicleState& state, double ahead = 0.0);

}  // namespace ellipsoid_vehicle_sim
