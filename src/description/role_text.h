#pragma once

#include <Eigen/Core>
#include <string>

#include "ellipsoid_vehicle_sim/vehicle/vehicle_description.h"

namespace ellipsoid_vehicle_sim {

std::string typeText(JointType type);
/// "y", "-z", or the vector if it is more than a degree off.
std::string axisText(const Eigen::Vector3d& axis);
/// "-0.6 ... 0.6".
std::string limitsText(const JointDescription& joint);
/// "1 wheel", "2 wheels".
std::string wheelCount(std::size_t count);

}  // namespace ellipsoid_vehicle_sim
