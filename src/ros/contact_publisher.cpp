#include "ellipsoid_vehicle_sim/ros/contact_publisher.h"

#include <ros/console.h>

#include <algorithm>

#include "ellipsoid_vehicle_sim/ContactStates.h"
#include "ellipsoid_vehicle_sim/ros/collision_shapes.h"
#include "ellipsoid_vehicle_sim/ros/conversions.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr int kContactQueue = 100;
constexpr int kMarkerQueue = 10;

/// Length of an arrow for one newton: the vehicle's weight is twice as long as the vehicle, so that an arrow on one of
/// four wheels comes out of the wheel; unless told otherwise.
double arrowScale(const NodeSetup& setup, const Simulator& simulator) {
  const double weight = simulator.model().mass * std::max(simulator.config().gravity, 1.0);
  return setup.options.contact_arrow_scale.value_or(2.0 * setup.vehicle_length / weight);
}

}  // namespace

ContactPublisher::ContactPublisher(ros::NodeHandle& nh, const NodeSetup& setup, const Simulator& simulator,
                                   const std::string& frame)
    : simulator_(simulator),
      frame_(frame),
      contact_markers_(frame, arrowScale(setup, simulator), setup.vehicle_length),
      world_markers_(setup.terrain, frame, static_cast<int>(setup.options.world_marker_limit)) {
  contact_publisher_ = nh.advertise<ContactStates>("contacts", kContactQueue);
  marker_publisher_ = nh.advertise<visualization_msgs::MarkerArray>("contact_markers", kMarkerQueue);
  shape_publisher_ = nh.advertise<visualization_msgs::MarkerArray>("collision_shapes", 1, true);
  world_publisher_ = nh.advertise<visualization_msgs::MarkerArray>("world", 1, true);
  setMarkerScale(setup.options.marker_scale);

  shape_publisher_.publish(collisionShapeMarkers(simulator_.ellipsoids(), setup.drawn_links));
  if (const auto world = world_markers_.update(simulator_.rootPose().p)) world_publisher_.publish(*world);
  if (world_markers_.partial()) {
    ROS_INFO(
        "the world has %d triangles, more than world_marker_limit: shown is what lies within %.3g m of the vehicle",
        simulator_.terrain().triangleCount(), world_markers_.halfEdge());
  }
}

void ContactPublisher::publishContacts(const ros::Time& stamp) {
  if (contact_publisher_.getNumSubscribers() == 0) return;
  simulator_.contacts(contacts_);
  ContactStates message;
  message.header.stamp = stamp;
  message.header.frame_id = frame_;
  message.unstable = simulator_.isBeyondCertificate();
  for (const ContactReport& contact : contacts_) {
    message.contacts.push_back(toContactState(contact,
                                              simulator_.ellipsoids()[static_cast<std::size_t>(contact.ellipsoid)],
                                              simulator_.terrain().surface(contact.triangle).name));
  }
  contact_publisher_.publish(message);
}

void ContactPublisher::publishMarkers(const ros::Time& stamp) {
  if (marker_publisher_.getNumSubscribers() > 0) {
    simulator_.contacts(contacts_);
    visualization_msgs::MarkerArray message = contact_markers_.update(contacts_, stamp);
    if (simulator_.isBeyondCertificate()) message.markers.push_back(unstableMarker(simulator_.rootPose().p, frame_, stamp));
    marker_publisher_.publish(message);
  }
  if (world_markers_.partial()) {
    if (const auto world = world_markers_.update(simulator_.rootPose().p)) world_publisher_.publish(*world);
  }
}

}  // namespace ellipsoid_vehicle_sim
