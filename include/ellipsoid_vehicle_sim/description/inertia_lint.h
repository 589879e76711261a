#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/description/collision_shape.h"
#include "ellipsoid_vehicle_sim/description/shapes_to_ellipsoids.h"
#include "ellipsoid_vehicle_sim/geometry/problem.h"
#include "ellipsoid_vehicle_sim/vehicle/vehicle_description.h"

// Masses and inertias that no body has, or that do not go with the shapes beside them. For each link with an <inertial>, or
// with shapes and without one:
//
//   mass        0, or no <inertial>, on a body that collides and moves; below 0
//   inertia     a moment <= 0; not positive definite; the largest moment above the sum of the others
//   size        a radius of gyration above the distance of the farthest point of its shapes from the centre of mass, or below
//               a fiftieth of it (an inertia in other units, or of another body)
//   spin        a wheel that is a disc by its shape and has its largest moment about another axis than its own
//   balance     a wheel's centre of mass off its axis by more than 5 % of its radius
//   symmetry    the whole vehicle's centre of mass beside its middle by more than 5 % of its track
//
// Suggested is the inertia of a solid of the link's mass: of a wheel the cylinder of its spheroid's radius and width, of other
// links the box around their shapes; without shapes the nearest inertia a body can have. A mass is suggested from that solid
// with half the density of water. The first two kinds are faults: the file is refused, unless what is fixed to the link, or
// for links that are held still against their parent the vehicle as a whole, makes a body that there can be. The others are
// told. With `repair` all but `symmetry` are replaced by what is suggested.

namespace ellipsoid_vehicle_sim {

struct InertiaFinding {
  enum class Kind { kMass, kInertia, kSize, kSpin, kBalance, kSymmetry };
  Kind kind = Kind::kInertia;
  std::string link;
  int line = 0;
  std::string message;     ///< what was read and what is wrong with it.
  std::string suggestion;  ///< as the file would have it: "<mass value=\"2\"/>", "<inertia ixx=.../>".
  // The same in numbers, in the link's axes; unset where nothing is suggested.
  std::optional<double> mass;
  std::optional<Eigen::Vector3d> p_Lcm;
  std::optional<Eigen::Matrix3d> I_cm_L;
  bool fault = false;      ///< of the first two kinds.
  bool tolerated = false;  ///< a fault that the links around it make up for.
};

const char* toString(InertiaFinding::Kind kind);

/// Everything found, in the order of the links. shapes[i] belong to links[i]; wheels as assignRoles found them.
std::vector<InertiaFinding> lintInertias(const VehicleDescription& vehicle,
                                         const std::vector<std::vector<CollisionShape>>& shapes,
                                         const std::vector<GroundWheel>& wheels);

/// Puts what is suggested into the vehicle; a note for each.
void repairInertias(const std::vector<InertiaFinding>& findings, VehicleDescription& vehicle,
                    std::vector<std::string>& notes);

}  // namespace ellipsoid_vehicle_sim
