#include "ellipsoid_vehicle_sim/ros/contact_markers.h"

#include <algorithm>

#include "ellipsoid_vehicle_sim/ros/conversions.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr int kIdsPerEllipsoid = 16;   // room for several contacts of one ellipsoid
constexpr double kNormalShaft = 0.02;  // diameter over the longest arrow
constexpr double kFrictionShaft = 0.012;
constexpr double kHeadOverShaft = 2.2;
// Shorter arrows than this share of the longest are a dot in RViz, and one of no length at all is an error there.
constexpr double kShortestShare = 1e-3;

}  // namespace

ContactMarkers::ContactMarkers(std::string frame, double metres_per_newton, double longest)
    : frame_(std::move(frame)), metres_per_newton_(metres_per_newton), longest_(longest) {}

void ContactMarkers::addArrow(const Key& key, const ContactReport& contact, const Eigen::Vector3d& force_W,
                              double shaft_share, const ros::Time& stamp,
                              visualization_msgs::MarkerArray& markers) const {
  const double force = force_W.norm();
  const double length = std::clamp(force * metres_per_newton_, kShortestShare * longest_, longest_);
  const Eigen::Vector3d direction = force > 0.0 ? Eigen::Vector3d(force_W / force) : contact.nhat_W;

  visualization_msgs::Marker arrow;
  arrow.header.frame_id = frame_;
  arrow.header.stamp = stamp;
  arrow.ns = key.first;
  arrow.id = key.second;
  arrow.type = visualization_msgs::Marker::ARROW;
  arrow.action = visualization_msgs::Marker::ADD;
  arrow.pose.orientation.w = 1.0;
  arrow.points = {toPoint(contact.p_WC), toPoint(contact.p_WC + length * direction)};
  arrow.scale.x = shaft_share * longest_;
  arrow.scale.y = kHeadOverShaft * arrow.scale.x;
  arrow.scale.z = std::min(0.4 * length, 2.0 * arrow.scale.y);
  arrow.color = contact.sliding ? toColor(1.0, 0.15, 0.1, 1.0) : toColor(0.1, 0.9, 0.2, 1.0);
  markers.markers.push_back(arrow);
}

visualization_msgs::MarkerArray ContactMarkers::update(const std::vector<ContactReport>& contacts,
                                                       const ros::Time& stamp) {
  visualization_msgs::MarkerArray markers;
  std::vector<Key> shown;
  std::map<int, int> seen;  // contacts so far of each ellipsoid
  for (const ContactReport& contact : contacts) {
    const int ordinal = seen[contact.ellipsoid]++;
    if (ordinal >= kIdsPerEllipsoid) continue;
    const int id = contact.ellipsoid * kIdsPerEllipsoid + ordinal;
    shown.emplace_back("normal", id);
    addArrow(shown.back(), contact, contact.normal_force * contact.nhat_W, kNormalShaft, stamp, markers);
    if (contact.friction_W.norm() * metres_per_newton_ > kShortestShare * longest_) {
      shown.emplace_back("friction", id);
      addArrow(shown.back(), contact, contact.friction_W, kFrictionShaft, stamp, markers);
    }
  }
  for (const Key& old : shown_) {
    if (std::find(shown.begin(), shown.end(), old) != shown.end()) continue;
    visualization_msgs::Marker gone;
    gone.header.frame_id = frame_;
    gone.header.stamp = stamp;
    gone.ns = old.first;
    gone.id = old.second;
    gone.action = visualization_msgs::Marker::DELETE;
    markers.markers.push_back(gone);
  }
  shown_ = std::move(shown);
  return markers;
}

}  // namespace ellipsoid_vehicle_sim
