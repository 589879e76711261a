#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <vector>

#include "ellipsoid_vehicle_sim/ros/contact_markers.h"
#include "ellipsoid_vehicle_sim/ros/node_setup.h"
#include "ellipsoid_vehicle_sim/ros/world_markers.h"

namespace ellipsoid_vehicle_sim {

/// Vehicle and world as they collide: contacts, contact_markers, and the latched collision_shapes and world.
class ContactPublisher {
 public:
  ContactPublisher(ros::NodeHandle& nh, const NodeSetup& setup, const Simulator& simulator, const std::string& frame);

  void publishContacts(const ros::Time& stamp);
  void publishMarkers(const ros::Time& stamp);
  /// Length of the arrows times this.
  void setMarkerScale(double scale) { contact_markers_.setScale(scale); }

 private:
  const Simulator& simulator_;
  std::string frame_;
  ContactMarkers contact_markers_;
  WorldMarkers world_markers_;
  ros::Publisher contact_publisher_, marker_publisher_, shape_publisher_, world_publisher_;
  std::vector<ContactReport> contacts_;  ///< kept to save its memory.
};

}  // namespace ellipsoid_vehicle_sim
