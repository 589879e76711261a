#pragma once

#include <Eigen/Core>
#include <string>

namespace ellipsoid_vehicle_sim {

/// What is wrong with an inertia tensor about the centre of mass; empty if a body can have it.
/// With the principal moments a <= b <= c a body has a > 0 and, since c - a - b = -2 times an integral of a square,
/// c <= a + b. Files carry six digits: a miss of 1e-6 relative is rounding, not an error.
std::string inertiaFault(const Eigen::Matrix3d& I_cm);

}  // namespace ellipsoid_vehicle_sim
