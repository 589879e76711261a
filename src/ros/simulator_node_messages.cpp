// What SimulatorNode says: topics, and the messages of a tick, all with the same stamp.

#include <diagnostic_msgs/DiagnosticArray.h>
#include <ros/ros.h>
#include <rosgraph_msgs/Clock.h>
#include <std_msgs/Bool.h>
#include <tf2_msgs/TFMessage.h>

#include "ellipsoid_vehicle_sim/ros/collision_shapes.h"
#include "ellipsoid_vehicle_sim/ros/conversions.h"
#include "ellipsoid_vehicle_sim/ros/simulator_node.h"

namespace ellipsoid_vehicle_sim {
namespace {

// Queue sizes. State goes out in bursts when the simulation runs faster than real time; commands: only the last counts,
// except in lockstep, where none may be lost.
constexpr int kStateQueue = 100;
constexpr int kMarkerQueue = 10;
constexpr int kCommandQueue = 100;

diagnostic_msgs::KeyValue keyValue(const std::string& key, const std::string& value) {
  diagnostic_msgs::KeyValue pair;
  pair.key = key;
  pair.value = value;
  return pair;
}

}  // namespace

void SimulatorNode::advertise() {
  if (options_.clock == ClockMode::kPublish) {
    clock_publisher_ = nh_.advertise<rosgraph_msgs::Clock>("/clock", kStateQueue);
  }
  // Latched in lockstep: a commander that comes late still gets the state that it has to answer, before odom asks for it.
  const bool latch = options_.lockstep;
  // "/tf" is one tree for all, whatever the name space; it can be remapped.
  if (options_.publish_tf) tf_publisher_ = nh_.advertise<tf2_msgs::TFMessage>("/tf", kStateQueue, latch);
  odom_publisher_ = nh_.advertise<nav_msgs::Odometry>("odom", kStateQueue, latch);
  joint_publisher_ = nh_.advertise<sensor_msgs::JointState>("joint_states", kStateQueue, latch);
  contact_publisher_ = nh_.advertise<visualization_msgs::MarkerArray>("contact_markers", kMarkerQueue);
  shape_publisher_ = nh_.advertise<visualization_msgs::MarkerArray>("collision_shapes", 1, true);
  world_publisher_ = nh_.advertise<visualization_msgs::MarkerArray>("world", 1, true);
  ready_publisher_ = nh_.advertise<std_msgs::Bool>("ready", 1, true);
  diagnostics_publisher_ = nh_.advertise<diagnostic_msgs::DiagnosticArray>("diagnostics", kMarkerQueue);
  // No delay: with Nagle's algorithm a lockstep command takes 40 ms.
  command_subscriber_ =
      nh_.subscribe("cmd_vel", kCommandQueue, &SimulatorNode::onCommand, this, ros::TransportHints().tcpNoDelay());
  reset_server_ = nh_priv_.advertiseService("reset", &SimulatorNode::onReset, this);

  shape_publisher_.publish(collisionShapeMarkers(simulator_.ellipsoids(), drawn_links_));
  if (const auto world = world_markers_.update(simulator_.rootPose().p)) world_publisher_.publish(*world);
  if (world_markers_.partial()) {
    ROS_INFO(
        "the world has %d triangles, more than world_marker_limit: shown is what lies within %.3g m of the vehicle",
        simulator_.terrain().triangleCount(), world_markers_.halfEdge());
  }
}

ros::Time SimulatorNode::stamp() const {
  return time_origin_ + simulatedDuration(simulator_.stepCount(), simulator_.config().dt);
}

void SimulatorNode::publishClock() {
  if (options_.clock != ClockMode::kPublish) return;
  rosgraph_msgs::Clock message;
  message.clock = stamp();
  clock_publisher_.publish(message);
}

void SimulatorNode::publishState() {
  const Pose X_WR = simulator_.rootPose();
  const nav_msgs::Odometry odom = toOdometry(X_WR, simulator_.rootVelocity_W(), simulator_.rootAngularVelocity_W(),
                                             options_.odom_frame, base_frame_, stamp());
  simulator_.jointReadings(readings_);
  toJointState(simulator_.jointNames(), readings_, stamp(), joint_message_);
  // The simulator refuses a state that is not finite; a message must not tell otherwise even if it once fails to.
  if (!allFinite(odom) || !allFinite(joint_message_)) {
    ROS_ERROR_THROTTLE(1.0, "a state that is not finite was not published");
    return;
  }
  if (options_.publish_tf) {
    tf2_msgs::TFMessage message;
    message.transforms.push_back(toTransform(X_WR, options_.odom_frame, base_frame_, stamp()));
    tf_publisher_.publish(message);
  }
  joint_publisher_.publish(joint_message_);
  // Last: in lockstep it is what the commander answers.
  odom_publisher_.publish(odom);
}

void SimulatorNode::publishMarkers() {
  if (contact_publisher_.getNumSubscribers() > 0) {
    simulator_.contacts(contacts_);
    contact_publisher_.publish(contact_markers_.update(contacts_, stamp()));
  }
  if (world_markers_.partial()) {
    if (const auto world = world_markers_.update(simulator_.rootPose().p)) world_publisher_.publish(*world);
  }
}

void SimulatorNode::publishReady(bool ready) {
  std_msgs::Bool message;
  message.data = ready;
  ready_publisher_.publish(message);
  announced_ready_ = true;
  ready_ = ready;
}

void SimulatorNode::publishDiagnostics() {
  const StepEvents& events = simulator_.events();
  diagnostic_msgs::DiagnosticStatus status;
  status.name = ros::this_node::getName().substr(1) + ": simulation";
  status.hardware_id = base_frame_;
  if (!running()) {
    status.level = diagnostic_msgs::DiagnosticStatus::ERROR;
    status.message = "diverged: frozen at the last good state, ~reset starts again";
  } else if (events.passed_through > 0) {
    status.level = diagnostic_msgs::DiagnosticStatus::WARN;
    status.message = "an ellipsoid went through the ground";
  } else {
    status.message = simulator_.commandInForce() ? "driven" : "braked: no command";
  }
  const double wall = std::chrono::duration<double>(WallPacer::Clock::now() - wall_start_).count();
  status.values = {keyValue("simulated time [s]", std::to_string(simulator_.time())),
                   keyValue("real-time factor", std::to_string(simulator_.time() / std::max(wall, 1e-9))),
                   keyValue("step time mean [us]", std::to_string(1e6 * statistics_.meanStepTime())),
                   keyValue("step time p99 [us]", std::to_string(1e6 * statistics_.stepTimeQuantile(0.99))),
                   keyValue("largest penetration [mm]", std::to_string(1e3 * statistics_.largestPenetration())),
                   keyValue("energy [J]", std::to_string(simulator_.energy())),
                   keyValue("passed through", std::to_string(events.passed_through)),
                   keyValue("effort exceeded", std::to_string(events.effort_exceeded)),
                   keyValue("command timeouts", std::to_string(events.command_timeouts)),
                   keyValue("dropped commands", std::to_string(dropped_commands_))};
  diagnostic_msgs::DiagnosticArray message;
  message.header.stamp = stamp();
  message.status.push_back(status);
  diagnostics_publisher_.publish(message);
}

}  // namespace ellipsoid_vehicle_sim
