#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/description/collision_shape.h"
#include "ellipsoid_vehicle_sim/description/shapes_to_ellipsoids.h"
#include "ellipsoid_vehicle_sim/description/urdf_text.h"
#include "ellipsoid_vehicle_sim/geometry/problem.h"
#include "ellipsoid_vehicle_sim/vehicle/vehicle_description.h"

// What a joint is for, told from where it stands and what hangs on it, not from its type: steering comes as
// "continuous", casters, lidars and masts are "continuous" too, lifts are "prismatic" like shock absorbers. In the root
// link's frame turned about z to look forward (x forward, y left, z up), all joints at zero:
//
//   forward        RoleHints::forward_yaw; else across the axles of the round shapes that turn about level axes: x or -x,
//                  y or -y if they are within 15 degrees of these. Which end is the front, the names of the wheels' joints
//                  and links say where they agree (front, rear, back, left, right, fl, fr, bl, br); else it is x, or y
//   ground wheel   turns at least +-170 degrees (or has both limits 0, for "none") about a level axis, lateral within
//                  20 degrees (below a swivel: any level axis), carries a shape that is round about it and centred on it
//                  within 10 %, and its bottom is within 30 % of its radius of the lowest wheel's
//                  Where the file has no <axis> and the shape is not round about x, URDF's default, but about y, z or its own
//                  axis, that one is taken
//   steer          turns within limits about an axis within 30 degrees of vertical, with wheels below it that stand within
//                  two radii of the axis; farther away, or with a third of the mass, it is a hitch: passive. Without
//                  limits it is a caster's swivel: passive, its wheels free, unless the wheels have no trail and a
//                  <transmission> names it, or every wheel stands below such a joint: nothing else could steer then
//   suspension     slides along an axis within 30 degrees of vertical, with wheels below it and not called a lift, fork,
//                  mast or elevator; or any joint that carries wheels without steering them and has a spring in the file
//   passive        turns about any other axis with wheels below it: rocker, bogie, pivoting axle
//   prescribed     everything else that can move and has a mass, a shape or limits
//   locked         what is left: nothing hangs on it
//
// Which wheels drive: those of RoleHints::drive_joints; else those named by a <transmission>, a <ros2_control> or the
// plugin of a drive (if some of these have a velocity interface and others not, the former: a motor is told its speed, a
// joint that is only read is not); else,
// with steering, the unsteered ones (the steered ones if steering at both ends leaves only wheels between); else all.
// Wheels below a swivel or a hitch are free unless named by drive_joints.

namespace ellipsoid_vehicle_sim {

/// What is known besides the geometry.
struct RoleHints {
  std::vector<TransmissionText> transmissions;
  std::map<std::string, JointRole> roles;  ///< by joint name: overrules everything.
  std::vector<std::string> drive_joints;   ///< the driven wheels, all of them; empty: found out.
  std::optional<double> forward_yaw;       ///< of forward from the root link's x [rad]; empty: found out.
  std::set<std::string> without_axis;      ///< joints for which the file has no <axis>, and x stands in.
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

/// Forward in a word: "x", "-x", "y", "-y"; "auto" or nothing is found out; anything else is a problem at `where`.
std::optional<double> forwardFromWord(const std::string& word, const std::string& where, Problems& problems);

/// The table for the log, a line each: joint, type, role, why. Fixed joints are only counted.
std::vector<std::string> jointTable(const VehicleDescription& vehicle);

}  // namespace ellipsoid_vehicle_sim
