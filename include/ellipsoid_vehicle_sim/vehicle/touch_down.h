#pragma once

#include <string>

#include "ellipsoid_vehicle_sim/vehicle/vehicle_model.h"

namespace ellipsoid_vehicle_sim {

/// Energy above what it came with that a mass may have after it touched its spring and damper within a step, in parts of what it
/// came with: the largest over where in the step it touches and over the whole contact. That a step holds the contact once
/// it presses (the stability certificate) says nothing of this: the first step may go far too deep. From the scalar problem
/// m x'' = max(0, k d - c x'), d = max(0, -x), started at all parts of a step; rk4_events starts where it touches, its steps
/// `substeps` to the tick; dormand_prince at its smallest step; linearly_implicit, a monotone law solved for, adds nothing.
/// `omega_dt` = sqrt(k / m) dt, `damping_ratio` = c / (2 sqrt(k m)). At most kMostTouchDownGain.
double touchDownGain(IntegratorKind kind, double omega_dt, double damping_ratio, double substeps);
constexpr double kMostTouchDownGain = 1e3;

/// The worst of a vehicle's ellipsoids, with the least mass that each feels.
struct TouchDown {
  double gain = 0.0;
  std::string ellipsoid;  ///< its name; empty: nothing touches.
};
TouchDown worstTouchDown(const VehicleModel& model, IntegratorKind kind, double dt, double substeps);

}  // namespace ellipsoid_vehicle_sim
