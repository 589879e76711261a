#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/description/urdf_text.h"
#include "ellipsoid_vehicle_sim/geometry/pose.h"
#include "ellipsoid_vehicle_sim/geometry/problem.h"
#include "ellipsoid_vehicle_sim/vehicle/vehicle_description.h"

namespace ellipsoid_vehicle_sim {

/// The order of a description: parents before children, a branch at a time, branches in the order of the file.
struct TreeOrder {
  std::vector<int> links;   ///< indices into UrdfText::links, root first.
  std::vector<int> joints;  ///< indices into UrdfText::joints; joints[i] leads to links[i + 1].
};

/// Finds the tree, or everything that keeps the links from being one: names given twice, joints to links that are not
/// there, links with two parents, several roots, loops.
std::optional<TreeOrder> orderTree(const UrdfText& urdf, const std::string& file, Problems& problems);

/// Index of every link's parent link; -1 for the root.
std::vector<int> parentLinks(const VehicleDescription& vehicle);

/// X_RL of every link with all joints at zero.
std::vector<Pose> linkPosesAtZero(const VehicleDescription& vehicle);

/// A link and all that is fixed to it: what moves as one body with it, each with its pose in that link.
struct GroupedLink {
  int link;
  Pose X_GL;
};
std::vector<GroupedLink> rigidGroup(const VehicleDescription& vehicle, const std::vector<int>& parents, int link);

}  // namespace ellipsoid_vehicle_sim
