#pragma once

#include <vector>

#include "ellipsoid_vehicle_sim/contact/find_contacts.h"
#include "ellipsoid_vehicle_sim/vehicle/simulator.h"

namespace ellipsoid_vehicle_sim {

/// Explains the contacts of one ellipsoid at the pose `now` was taken at, found with the memory `before`: each triangle
/// is put to the contact search alone, and what it says is compared with what pushes. `reports`: the contacts of all
/// ellipsoids.
ContactExplanation explain(const ContactMemory& now, const ContactMemory& before, const Terrain& terrain,
                           const ContactOptions& options, int ellipsoid, const std::vector<ContactReport>& reports);

}  // namespace ellipsoid_vehicle_sim
