#include "ellipsoid_vehicle_sim/ros/contact_publisher.h"

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
double arrowScale(const VehicleSetup& setup, const Simulator& simulator) {
  const double weight = simulator.model().mass * std::max(simulator.config().gravity, 1.0);
  return setup.options.contact_arrow_scale.value_or(2.0 * setup.vehicle_length / weight);
}

}  // namespace

ContactState namedContact(const ContactReport& contact, const Simulator& simulator, const Fleet& fleet) {
  const EllipsoidPlacement& own = simulator.ellipsoids()[static_cast<std::size_t>(contact.ellipsoid)];
  if (contact.triangle >= 0) return toContactState(contact, own, simulator.terrain().surface(contact.triangle).name);
  ContactState message = toContactState(contact, own, "");
  const int other = fleet.findId(contact.other);
  if (other < 0) return message;
  const auto place = static_cast<std::size_t>(other);
  message.other_vehicle = fleet.name(place);
  message.other_ellipsoid = fleet.vehicle(place).ellipsoids()[static_cast<std::size_t>(contact.other_ellipsoid)].name;
  return message;
}

ContactPublisher::ContactPublisher(ros::NodeHandle& nh, const VehicleSetup& setup, const Simulator& simulator,
                                   const Fleet& fleet, const std::string& frame)
    : simulator_(simulator),
      fleet_(fleet),
      frame_(frame),
      contact_markers_(frame, arrowScale(setup, simulator), setup.vehicle_length) {
  contact_publisher_ = nh.advertise<ContactStates>("contacts", kContactQueue);
  marker_publisher_ = nh.advertise<visualization_msgs::MarkerArray>("contact_markers", kMarkerQueue);
  shape_publisher_ = nh.advertise<visualization_msgs::MarkerArray>("collision_shapes", 1, true);
  setMarkerScale(setup.options.marker_scale);
  shape_publisher_.publish(collisionShapeMarkers(simulator_.ellipsoids(), setup.drawn_links, setup.options.tf_prefix));
}

std::vector<ros::Publisher> ContactPublisher::leave() {
  visualization_msgs::MarkerArray message;
  message.markers.resize(1);
  message.markers[0].header.frame_id = frame_;
  message.markers[0].pose.orientation.w = 1.0;
  message.markers[0].action = visualization_msgs::Marker::DELETEALL;
  marker_publisher_.publish(message);
  shape_publisher_.publish(message);
  return {marker_publisher_, shape_publisher_};
}

void ContactPublisher::publishContacts(const ros::Time& stamp) {
  if (contact_publisher_.getNumSubscribers() == 0) return;
  simulator_.contacts(contacts_);
  ContactStates message;
  message.header.stamp = stamp;
  message.header.frame_id = frame_;
  message.unstable = simulator_.isBeyondCertificate();
  for (const ContactReport& contact : contacts_) {
    message.contacts.push_back(namedContact(contact, simulator_, fleet_));
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
}

}  // namespace ellipsoid_vehicle_sim
