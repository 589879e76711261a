#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <vector>

#include "ellipsoid_vehicle_sim/ContactState.h"
#include "ellipsoid_vehicle_sim/ros/contact_markers.h"
#include "ellipsoid_vehicle_sim/ros/vehicle_setup.h"
#include "ellipsoid_vehicle_sim/fleet/fleet.h"

namespace ellipsoid_vehicle_sim {

/// A vehicle as it collides: contacts, contact_markers, and the latched collision_shapes.
class ContactPublisher {
 public:
  /// `fleet` knows the vehicles that it may touch.
  ContactPublisher(ros::NodeHandle& nh, const VehicleSetup& setup, const Simulator& simulator, const Fleet& fleet,
                   const std::string& frame);

  void publishContacts(const ros::Time& stamp);
  void publishMarkers(const ros::Time& stamp);
  /// Length of the arrows times this.
  void setMarkerScale(double scale) { contact_markers_.setScale(scale); }
  /// Deletes what was drawn, and hands over the publishers: they have to live until that has gone out.
  std::vector<ros::Publisher> leave();

 private:
  const Simulator& simulator_;
  const Fleet& fleet_;
  std::string frame_;
  ContactMarkers contact_markers_;
  ros::Publisher contact_publisher_, marker_publisher_, shape_publisher_;
  std::vector<ContactReport> contacts_;  ///< kept to save its memory.
};

/// A contact of a vehicle with all names in it.
ContactState namedContact(const ContactReport& contact, const Simulator& simulator, const Fleet& fleet);

}  // namespace ellipsoid_vehicle_sim
