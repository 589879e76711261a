#pragma once

#include <ros/time.h>
#include <visualization_msgs/MarkerArray.h>

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "ellipsoid_vehicle_sim/vehicle/simulator.h"

namespace ellipsoid_vehicle_sim {

/// Contacts as arrows: along the normal, as long as the normal force is large; a thinner one along the friction. Green
/// while the contact sticks, red while it slides. An ellipsoid's arrows keep their id from message to message; those of
/// contacts that ended are deleted.
class ContactMarkers {
 public:
  /// `metres_per_newton` is the arrows' length; no arrow is longer than `longest` [m].
  ContactMarkers(std::string frame, double metres_per_newton, double longest);

  visualization_msgs::MarkerArray update(const std::vector<ContactReport>& contacts, const ros::Time& stamp);

 private:
  /// Name space and id of a marker.
  using Key = std::pair<std::string, int>;

  void addArrow(const Key& key, const ContactReport& contact, const Eigen::Vector3d& force_W, double shaft_share,
                const ros::Time& stamp, visualization_msgs::MarkerArray& markers) const;

  std::string frame_;
  double metres_per_newton_;
  double longest_;
  std::vector<Key> shown_;
};

}  // namespace ellipsoid_vehicle_sim
