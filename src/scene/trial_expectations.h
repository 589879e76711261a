#pragma once

#include <string>

#include "ellipsoid_vehicle_sim/scene/free_straight.h"
#include "ellipsoid_vehicle_sim/vehicle/simulator.h"

// What a vehicle is expected to do in a trial, from its model alone and the loads under it at rest.

namespace ellipsoid_vehicle_sim {

/// Unit vector ahead, in the root link's frame.
Eigen::Vector3d forwardOf(const VehicleModel& model);

/// Walking pace: so many radii of the smallest driven wheel a second, between 0.05 and 2 m/s and within the limits [m/s].
double trialSpeed(const VehicleModel& model, const SimConfig& config, double radii_per_second);

/// Room that the ellipsoids take about the root link, joints at zero.
Footprint footprintOf(const VehicleModel& model);

struct TurnExpectation {
  bool possible = false;
  double speed = 0.0;      ///< commanded [m/s].
  double commanded = 0.0;  ///< yaw rate [rad/s].
  double expected = 0.0;   ///< by the law [rad/s].
  std::string law;         ///< its name; why not, if it cannot turn.
};

/// A gentle turn to the left (side 1) or right (-1) for the vehicle as it stands, on level ground.
TurnExpectation turnFor(const Simulator& simulator, double speed, double side);

struct ClimbExpectation {
  bool possible = false;
  std::string text;
};

/// Whether torque and grip of the driven wheels are enough for a slope [rad], with the loads of the present place.
ClimbExpectation climbFor(const Simulator& simulator, double slope);

}  // namespace ellipsoid_vehicle_sim
