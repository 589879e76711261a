#pragma once

#include <string>

#include "ellipsoid_vehicle_sim/vehicle/simulator.h"

namespace ellipsoid_vehicle_sim {

/// What is wrong with a state that came from outside, for a simulator whose own is of the same sizes: a value that is not
/// finite or absurd, a mode that is none, an index that leads nowhere, a rotation that is none. Empty: it can be stepped.
std::string faultOf(const VehicleState& state, const Simulator& simulator);

}  // namespace ellipsoid_vehicle_sim
