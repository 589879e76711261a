#pragma once

#include <ros/time.h>
#include <visualization_msgs/MarkerArray.h>

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "ellipsoid_vehicle_sim/ros/contact_trail.h"
#include "ellipsoid_vehicle_sim/vehicle/simulator.h"

namespace ellipsoid_vehicle_sim {

/// Contacts for RViz. Each name space is a toggle there; all lengths are forces in one scale:
///   normal         arrow along the normal, as long as the normal force is large; green: sticks, red: slides.
///   force          arrow, yellow: the whole force on the vehicle, normal and friction together.
///   friction       arrow, orange: its part along the ground.
///   friction cone  what the whole force stays within, as high as the normal force; it slides on its rim.
///   trail          where the vehicle touched the ground lately.
/// An ellipsoid's markers keep their id from message to message; those of contacts that ended are deleted.
class ContactMarkers {
 public:
  /// `metres_per_newton` is the arrows' length; no arrow is longer than `longest` [m], about a vehicle's length.
  ContactMarkers(std::string frame, double metres_per_newton, double longest);

  /// Lengths times this, also the longest.
  void setScale(double scale) { scale_ = scale; }

  visualization_msgs::MarkerArray update(const std::vector<ContactReport>& contacts, const ros::Time& stamp);

 private:
  /// Name space and id of a marker.
  using Key = std::pair<std::string, int>;

  visualization_msgs::Marker markerOf(const Key& key, int type, const ros::Time& stamp) const;
  double lengthOf(double force) const;
  visualization_msgs::Marker arrow(const Key& key, const Eigen::Vector3d& p_WC, const Eigen::Vector3d& force_W,
                                   const Eigen::Vector3d& otherwise, double shaft_share, const ros::Time& stamp) const;
  visualization_msgs::Marker cone(const Key& key, const ContactReport& contact, const ros::Time& stamp) const;

  std::string frame_;
  double metres_per_newton_;
  double longest_;
  double scale_ = 1.0;
  ContactTrail trail_;
  int updates_since_trail_ = 0;
  std::vector<Key> shown_;
};

/// "UNSTABLE" above the vehicle: its step is beyond the stability certificate.
visualization_msgs::Marker unstableMarker(const Eigen::Vector3d& p_WR, const std::string& frame, const ros::Time& stamp);

}  // namespace ellipsoid_vehicle_sim
