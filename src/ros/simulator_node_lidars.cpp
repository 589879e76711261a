// What SimulatorNode does for the lidars of its vehicles: one caster of rays for all, each vehicle seen by the others.

#include <ros/ros.h>
#include <tf2_msgs/TFMessage.h>

#include "ellipsoid_vehicle_sim/ros/simulator_node.h"

namespace ellipsoid_vehicle_sim {

void SimulatorNode::mountLidars(ros::NodeHandle nh) {
  if (!vehicles_.back()->carriesLidars()) return;
  if (!caster_) {
    caster_ = makeRayCaster(*terrain_);
    ROS_INFO("rays of lidars: %s", caster_->description().c_str());
  }
  vehicles_.back()->mountLidars(nh, caster_);
  // The topic is latched, and keeps one message: it has to say all.
  tf2_msgs::TFMessage message;
  for (const auto& vehicle : vehicles_) {
    if (!vehicle->lidars()) continue;
    for (geometry_msgs::TransformStamped& transform : vehicle->lidars()->staticTransforms())
      message.transforms.push_back(std::move(transform));
  }
  if (message.transforms.empty()) return;
  if (!static_tf_publisher_) static_tf_publisher_ = nh_.advertise<tf2_msgs::TFMessage>("/tf_static", 10, true);
  static_tf_publisher_.publish(message);
}

void SimulatorNode::publishLidars(std::int64_t ticks, const ros::Time& stamp) {
  std::vector<PosedEllipsoid> others;
  for (const auto& vehicle : vehicles_) {
    if (!vehicle->lidars() || !vehicle->lidars()->isDue(ticks)) continue;
    others.clear();
    for (const auto& other : vehicles_)
      if (other != vehicle) other->appendEllipsoids(others);
    vehicle->lidars()->publishDue(ticks, stamp, others);
  }
}

}  // namespace ellipsoid_vehicle_sim
