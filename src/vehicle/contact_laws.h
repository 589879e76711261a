#pragma once

#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/dynamics/articulated_body.h"
#include "ellipsoid_vehicle_sim/vehicle/sim_config.h"
#include "ellipsoid_vehicle_sim/vehicle/vehicle_model.h"

namespace ellipsoid_vehicle_sim {

/// Step that derived stiffnesses are made for [s]. A user who steps more coarsely names softer contacts.
constexpr double kDefaultTick = 1e-3;

/// Mass that a contact of an ellipsoid feels, all joints free: the smallest over the places where it may be touched [kg].
struct ContactMasses {
  double normal = 0.0;
  double tangential = 0.0;
};
ContactMasses contactMasses(ArticulatedBody& tree, const ModelEllipsoid& ellipsoid, bool ground_wheel);

/// Constants of the contact of one ellipsoid: what the configuration gives, and the rest from the masses.
/// `stiffness_cap`: no stiffer than this unless the user says so [N/m]. Adds a line to `report`.
ContactLaw contactLaw(const ModelEllipsoid& ellipsoid, bool ground_wheel, const ContactMasses& masses,
                      double stiffness_cap, const SimConfig& config, std::vector<std::string>& report);

}  // namespace ellipsoid_vehicle_sim
