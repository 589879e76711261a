#pragma once

#include <map>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/description/collision_shape.h"
#include "ellipsoid_vehicle_sim/description/shapes_to_ellipsoids.h"
#include "ellipsoid_vehicle_sim/description/urdf_text.h"
#include "ellipsoid_vehicle_sim/geometry/problem.h"
#include "ellipsoid_vehicle_sim/vehicle/vehicle_description.h"

// What a joint is for, told from where it stands and what hangs on it, not from its type: steering comes as
// "continuous", casters, lidars and masts are "continuous" too, lifts are "prismatic" like shock absorbers. In the root
// link's frame (x forward, y left, z up), all joints at zero:
//
//   ground wheel   turns at least +-170 degrees about a level axis, lateral within 20 degrees (below a swivel: any
//   level
//                  axis), carries a shape that is round about it and centred on it within 10 %, and its bottom is
//                  within 30 % of its radius of the lowest wheel's
//   steer          turns within limits about an axis within 30 degrees of vertical, with wheels below it that stand
//   within
//                  two radii of the axis; farther away it is a hitch: passive. Without limits it is a caster's swivel:
//                  passive, its wheels free, unless a <transmission> names it and the wheels have no trail
//   suspension     slides along an axis within 30 degrees of vertical, with wheels below it; or any joint that carries
//                  wheels without steering them and has a spring in the file
//   passive        turns about any other axis with wheels below it: rocker, bogie, pivoting axle
//   prescribed     everything else that can move and has a mass, a shape or limits
//   locked         what is left: nothing hangs on it
//
// Which wheels drive: those of RoleHints::drive_joints; else those named by a <transmission> (if some of these have a
// velocity interface and others not, the former: a motor is told its speed, a joint that is only read is not); else,
// with steering, the unsteered ones (the steered ones if steering at both ends leaves only wheels between); else all.
// Wheels below a swivel or a hitch are free unless named by drive_joints.

namespace ellipsoid_vehicle_sim {

/// What is known besides the geometry.
struct RoleHints {
  std::vector<TransmissionText> transmissions;
  std::map<std::string, JointRole> roles;  ///< by joint name: overrules everything.
  std::vector<std::string> drive_joints;   ///< the driven wheels, all of them; empty: found out.
};

/// Names in the hints that no joint has, and roles a joint's type cannot play.
void checkHints(const RoleHints& hints, const std::vector<JointText>& joints, const std::string& file,
                Problems& problems);

/// Sets role and role_reason of every joint and the layout; returns the ground wheels. shapes[i] belong to links[i].
std::vector<GroundWheel> assignRoles(VehicleDescription& vehicle,
                                     const std::vector<std::vector<CollisionShape>>& shapes, const RoleHints& hints,
                                     Problems& problems, std::vector<std::string>& notes);

/// Roles given in words, "JOINT=ROLE" each; a word that is none is a problem at `where`.
std::map<std::string, JointRole> rolesFromWords(const std::vector<std::string>& words, const std::string& where,
                                                Problems& problems);

/// The table for the log, a line each: joint, type, role, why. Fixed joints are only counted.
std::vector<std::string> jointTable(const VehicleDescription& vehicle);

}  // namespace ellipsoid_vehicle_sim
