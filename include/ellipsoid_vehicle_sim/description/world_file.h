#pragma once

#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/description/uri_resolver.h"
#include "ellipsoid_vehicle_sim/geometry/problem.h"
#include "ellipsoid_vehicle_sim/world/terrain.h"

namespace ellipsoid_vehicle_sim {

/// Where a vehicle is set down unless somebody says otherwise.
struct WorldStart {
  double x = 0.0;    ///< [m].
  double y = 0.0;    ///< [m].
  double yaw = 0.0;  ///< [rad].
};

/// A world as described, ready for Terrain::build.
struct WorldDescription {
  std::string name;   ///< stem of the file.
  TriangleSoup soup;  ///< all meshes in W, in the order of the file.
  WorldStart start;
  std::vector<std::string> files;  ///< the meshes read, in the order of the file.
};

/// Reads a world: a mesh file as it is, or a YAML file (.yaml, .yml)
///
///     meshes:                            # at least one
///       - file: ground.stl               # relative to this file, or package://NAME/rest through `resolver`
///         scale: 0.0254                  # or [x, y, z]; default 1; a mirror keeps the outside outside
///         pose: [x, y, z, roll, pitch, yaw]   # [m], [rad], fixed axes as in URDF; after the scale; default zeros
///         surface: asphalt               # default: the mesh file's stem
///         mu_static: 0.9                 # default: the vehicle's own
///         mu_kinetic: 0.8                # <= mu_static; default: mu_static
///     start: [x, y, yaw]                 # default [0, 0, 0]
///
/// Several meshes may be of one surface if they agree on its friction. Problems, all at once, with file and line: a key
/// that is not known or given twice, a wrong type, a number that is not finite or out of range, a mesh that cannot be
/// read.
Loaded<WorldDescription> loadWorld(const std::string& path, const UriResolver& resolver);

/// The same with packages looked for in the folder of the file and in the one above, which for a shipped world is the
/// package's own.
Loaded<WorldDescription> loadWorld(const std::string& path);

}  // namespace ellipsoid_vehicle_sim
