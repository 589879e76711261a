#include "ellipsoid_vehicle_sim/ros/collision_shapes.h"

#include "ellipsoid_vehicle_sim/ros/conversions.h"

namespace ellipsoid_vehicle_sim {

visualization_msgs::MarkerArray collisionShapeMarkers(const std::vector<EllipsoidPlacement>& ellipsoids,
                                                      const std::set<std::string>& drawn_links,
                                                      const std::string& prefix) {
  visualization_msgs::MarkerArray markers;
  for (const EllipsoidPlacement& ellipsoid : ellipsoids) {
    visualization_msgs::Marker marker;
    marker.header.frame_id = prefix + ellipsoid.link;  // stamp 0: wherever the link is now
    marker.ns = drawn_links.count(ellipsoid.link) > 0 ? "drawn " : "";
    marker.ns += ellipsoid.ground_wheel ? "wheels" : "bodies";
    marker.id = static_cast<int>(markers.markers.size());
    marker.type = visualization_msgs::Marker::SPHERE;
    marker.action = visualization_msgs::Marker::ADD;
    marker.pose = toPose(ellipsoid.X_LE);
    marker.scale = toVector(2.0 * ellipsoid.radii);
    // See-through, so that a vehicle's own shapes inside stay visible.
    marker.color = ellipsoid.ground_wheel ? toColor(0.1, 0.1, 0.12, 0.75) : toColor(0.95, 0.55, 0.1, 0.45);
    marker.frame_locked = true;
    markers.markers.push_back(marker);
  }
  return markers;
}

}  // namespace ellipsoid_vehicle_sim
