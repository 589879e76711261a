#pragma once

#include <visualization_msgs/MarkerArray.h>

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>

#include "ellipsoid_vehicle_sim/world/terrain.h"

namespace ellipsoid_vehicle_sim {

/// The triangles as collided. Front sides in their surface's colour (that of its name where it is a known one, such as
/// asphalt, grass or ice), shaded by their normal so that the relief shows; back sides dark violet, a little behind the
/// front. Lists of at most 100,000 triangles.
class WorldMarkers {
 public:
  WorldMarkers(std::shared_ptr<const Terrain> terrain, std::string frame, int limit);

  /// The whole world; if it has more than `limit` triangles, the largest cube around `centre` that holds no more, or
  /// nothing as long as the last cube is still the right one to show.
  std::optional<visualization_msgs::MarkerArray> update(const Eigen::Vector3d& centre);
  /// Only a part is shown.
  bool partial() const { return partial_; }
  /// Half edge of the cube that is shown [m].
  double halfEdge() const { return half_edge_; }

 private:
  std::vector<int> trianglesAround(const Eigen::Vector3d& centre);

  std::shared_ptr<const Terrain> terrain_;
  std::string frame_;
  std::size_t limit_;
  bool partial_;
  bool sent_ = false;
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
  double half_edge_ = 0.0;
  int chunks_ = 0;
};

}  // namespace ellipsoid_vehicle_sim
