#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/description/collision_shape.h"
#include "ellipsoid_vehicle_sim/description/inertia_lint.h"
#include "ellipsoid_vehicle_sim/description/uri_resolver.h"
#include "ellipsoid_vehicle_sim/geometry/problem.h"
#include "ellipsoid_vehicle_sim/vehicle/vehicle_description.h"

namespace ellipsoid_vehicle_sim {

/// What the user says beside the URDF.
struct UrdfOptions {
  std::map<std::string, JointRole> roles;  ///< by joint name; overrules what joint_roles.h finds out.
  std::vector<std::string> drive_joints;   ///< the driven wheels, all of them; empty: found out.
  std::optional<double> forward_yaw;       ///< of forward from the root link's x [rad]; empty: found out.
  std::vector<std::string> package_dirs;   ///< for package:// without a resolver; empty: the folder of the URDF.
  bool repair_inertia = false;             ///< replace masses and inertias that cannot be by inertia_lint.h's suggestions.
  std::vector<InertiaFinding>* findings = nullptr;  ///< if given, everything the lint found, whatever came of the file.
  int body_ellipsoids = 1;                 ///< for each shape of the body, at most (shapes_to_ellipsoids.h).
  MeshVertexReader read_mesh;              ///< empty: readMeshVertices.
};

/// Reads a vehicle from a URDF: the links with masses and ellipsoids (shapes_to_ellipsoids.h), the joints with their
/// roles (joint_roles.h), parents before children. Fixed joints stay joints.
///
/// Either the file is right, or every problem in it is told at once, each with file and line, the value read and what
/// is allowed. Besides what URDF itself asks for, refused are: numbers that are not finite decimals, masses below 0,
/// bodies that move without mass and inertias no body can have (inertia_lint.h), shapes of no size, more than one tree, joints that are not
/// simulated (floating, planar), collision meshes that cannot be read, xacro that was not run, and everything urdfdom
/// would drop without a word. What had to be assumed or replaced is told in the notes. Nothing is thrown.
///
/// An empty resolver stands for fileResolver with the options' package_dirs.
Loaded<VehicleDescription> loadUrdfFile(const std::string& path, const UriResolver& resolver = {},
                                        const UrdfOptions& options = {});

/// The same from a text; `name` stands for the file in messages, relative paths are looked up in the working folder.
Loaded<VehicleDescription> loadUrdfText(const std::string& text, const std::string& name,
                                        const UriResolver& resolver = {}, const UrdfOptions& options = {});

}  // namespace ellipsoid_vehicle_sim
