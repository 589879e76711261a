#include "ellipsoid_vehicle_sim/ros/contact_markers.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "ellipsoid_vehicle_sim/ros/conversions.h"

namespace ellipsoid_vehicle_sim {
namespace {

using visualization_msgs::Marker;

constexpr int kIdsPerEllipsoid = 16;   // room for several contacts of one ellipsoid
constexpr double kNormalShaft = 0.02;  // diameter over the longest arrow
constexpr double kForceShaft = 0.014;
constexpr double kFrictionShaft = 0.012;
constexpr double kHeadOverShaft = 2.2;
// Shorter arrows than this share of the longest are a dot in RViz, and one of no length at all is an error there.
constexpr double kShortestShare = 1e-3;
constexpr int kConeSides = 24;
constexpr double kConeAlpha = 0.3;

// Over the longest arrow.
constexpr double kTrailSpacing = 0.1;
constexpr double kTrailWidth = 0.015;
constexpr double kLongestTrailPiece = 2.0;
// A trail that does not change is still sent now and then, for who has just begun to look.
constexpr int kUpdatesBetweenTrails = 20;

std_msgs::ColorRGBA stickOrSlip(bool sliding, double alpha) {
  return sliding ? toColor(1.0, 0.15, 0.1, alpha) : toColor(0.1, 0.9, 0.2, alpha);
}

}  // namespace

ContactMarkers::ContactMarkers(std::string frame, double metres_per_newton, double longest)
    : frame_(std::move(frame)),
      metres_per_newton_(metres_per_newton),
      longest_(longest),
      trail_(kTrailSpacing * longest, kLongestTrailPiece * longest) {}

Marker ContactMarkers::markerOf(const Key& key, int type, const ros::Time& stamp) const {
  Marker marker;
  marker.header.frame_id = frame_;
  marker.header.stamp = stamp;
  marker.ns = key.first;
  marker.id = key.second;
  marker.type = type;
  marker.action = Marker::ADD;
  marker.pose.orientation.w = 1.0;
  return marker;
}

double ContactMarkers::lengthOf(double force) const {
  return scale_ * std::clamp(force * metres_per_newton_, kShortestShare * longest_, longest_);
}

Marker ContactMarkers::arrow(const Key& key, const Eigen::Vector3d& p_WC, const Eigen::Vector3d& force_W,
                             const Eigen::Vector3d& otherwise, double shaft_share, const ros::Time& stamp) const {
  const double force = force_W.norm();
  const double length = lengthOf(force);
  Marker marker = markerOf(key, Marker::ARROW, stamp);
  marker.points = {toPoint(p_WC),
                   toPoint(p_WC + length * (force > 0.0 ? Eigen::Vector3d(force_W / force) : otherwise))};
  marker.scale.x = shaft_share * longest_;
  marker.scale.y = kHeadOverShaft * marker.scale.x;
  marker.scale.z = std::min(0.4 * length, 2.0 * marker.scale.y);
  return marker;
}

Marker ContactMarkers::cone(const Key& key, const ContactReport& contact, const ros::Time& stamp) const {
  const double height = lengthOf(contact.normal_force);
  // Half the opening is atan(mu), whatever the scale.
  const double radius = height * contact.friction_limit / contact.normal_force;
  const Eigen::Vector3d one = contact.nhat_W.unitOrthogonal(), other = contact.nhat_W.cross(one);
  const auto rim = [&](int side) {
    const double angle = 2.0 * M_PI * side / kConeSides;
    return toPoint(contact.p_WC + height * contact.nhat_W + radius * (std::cos(angle) * one + std::sin(angle) * other));
  };
  Marker marker = markerOf(key, Marker::TRIANGLE_LIST, stamp);
  marker.scale.x = marker.scale.y = marker.scale.z = 1.0;
  marker.color = stickOrSlip(contact.sliding, kConeAlpha);
  for (int side = 0; side < kConeSides; ++side) {
    for (const auto& corner : {toPoint(contact.p_WC), rim(side), rim(side + 1)}) marker.points.push_back(corner);
  }
  return marker;
}

visualization_msgs::MarkerArray ContactMarkers::update(const std::vector<ContactReport>& contacts,
                                                       const ros::Time& stamp) {
  visualization_msgs::MarkerArray message;
  std::vector<Marker>& markers = message.markers;
  std::map<int, int> seen;  // contacts so far of each ellipsoid
  for (const ContactReport& contact : contacts) {
    const int ordinal = seen[contact.ellipsoid]++;
    if (ordinal >= kIdsPerEllipsoid) continue;
    const int id = contact.ellipsoid * kIdsPerEllipsoid + ordinal;
    const Eigen::Vector3d normal_W = contact.normal_force * contact.nhat_W;
    const double shortest = kShortestShare * longest_ / metres_per_newton_;  // [N]

    markers.push_back(arrow({"normal", id}, contact.p_WC, normal_W, contact.nhat_W, kNormalShaft, stamp));
    markers.back().color = stickOrSlip(contact.sliding, 1.0);
    if (contact.normal_force > shortest) {
      markers.push_back(
          arrow({"force", id}, contact.p_WC, normal_W + contact.friction_W, contact.nhat_W, kForceShaft, stamp));
      markers.back().color = toColor(1.0, 0.85, 0.1, 1.0);
      if (contact.friction_limit > 0.0) markers.push_back(cone({"friction cone", id}, contact, stamp));
    }
    if (contact.friction_W.norm() > shortest) {
      markers.push_back(
          arrow({"friction", id}, contact.p_WC, contact.friction_W, contact.nhat_W, kFrictionShaft, stamp));
      markers.back().color = toColor(1.0, 0.5, 0.0, 1.0);
    }
  }

  std::vector<Key> shown;
  for (const Marker& marker : markers) shown.emplace_back(marker.ns, marker.id);
  for (const Key& old : shown_) {
    if (std::find(shown.begin(), shown.end(), old) != shown.end()) continue;
    markers.push_back(markerOf(old, Marker::ARROW, stamp));
    markers.back().action = Marker::DELETE;
  }
  shown_ = std::move(shown);

  const bool changed = trail_.update(contacts, stamp);
  if (!trail_.empty() && (changed || ++updates_since_trail_ >= kUpdatesBetweenTrails)) {
    updates_since_trail_ = 0;
    Marker trail = markerOf({"trail", 0}, Marker::LINE_LIST, stamp);
    trail.scale.x = kTrailWidth * longest_;
    trail.color.a = 1.0;
    trail_.draw(trail);
    markers.push_back(std::move(trail));
  }
  return message;
}

Marker unstableMarker(const Eigen::Vector3d& p_WR, const std::string& frame, const ros::Time& stamp) {
  Marker marker;
  marker.header.frame_id = frame;
  marker.header.stamp = stamp;
  marker.ns = "unstable";
  marker.type = Marker::TEXT_VIEW_FACING;
  marker.action = Marker::ADD;
  marker.pose.position = toPoint(p_WR + 1.5 * Eigen::Vector3d::UnitZ());
  marker.pose.orientation.w = 1.0;
  marker.scale.z = 0.5;
  marker.color = toColor(1.0, 0.0, 1.0, 1.0);
  marker.text = "UNSTABLE: step beyond the certificate";
  return marker;
}

}  // namespace ellipsoid_vehicle_sim
