#pragma once

#include "ellipsoid_vehicle_sim/vehicle/tick_stepper.h"

namespace ellipsoid_vehicle_sim {

/// A vehicle within a tick that it takes with others: what the steps read, and what they change.
struct SteppedVehicle {
  const VehicleModel* model = nullptr;
  const SimConfig* config = nullptr;
  VehicleDynamics* dynamics = nullptr;
  TickStepper* stepper = nullptr;
  VehicleState* state = nullptr;                 ///< its drive is that of the tick.
  std::vector<ContactMemory>* before = nullptr;  ///< gets the contact memory of the tick's start.
  TickOutcome outcome{};
};

}  // namespace ellipsoid_vehicle_sim
