#include "ellipsoid_vehicle_sim/ros/vehicle_node.h"

#include <ros/console.h>
#include <std_msgs/Bool.h>

#include <cmath>
#include <cstdio>

#include "ellipsoid_vehicle_sim/ros/node_setup.h"

namespace ellipsoid_vehicle_sim {
namespace {

std::string atTime(double time) {
  char text[40];
  std::snprintf(text, sizeof text, " at simulated time %.6g s", time);
  return text;
}

double yawOf(const Eigen::Quaterniond& q) {
  const Eigen::Vector3d ahead = q * Eigen::Vector3d::UnitX();
  return std::atan2(ahead.y(), ahead.x());
}

// "red: " before what is told of a vehicle among several.
std::string before(const std::string& name) { return name.empty() ? "" : name + ": "; }

std::size_t placeOf(const Fleet& fleet, const std::string& name) {
  return static_cast<std::size_t>(fleet.find(fleetName(name)));
}

}  // namespace

VehicleNode::VehicleNode(ros::NodeHandle nh, ros::NodeHandle nh_priv, VehicleSetup setup,
                         std::optional<RunRecorder> recorder, Fleet& fleet, VehicleHost& host)
    : name_(setup.name),
      options_(setup.options),
      fleet_(fleet),
      simulator_(fleet.vehicle(placeOf(fleet, setup.name))),
      host_(host),
      base_frame_(setup.base_frame),
      state_(nh, options_, base_frame_, simulator_),
      contacts_(nh, setup, simulator_, fleet, state_.worldFrame()),
      link_poses_(simulator_.model().description),
      commands_(nh, options_, simulator_),
      ready_publisher_(nh.advertise<std_msgs::Bool>("ready", 1, true)),
      recorder_(std::move(recorder)),
      services_(nh, nh_priv, !name_.empty(), *this) {
  simulator_.setFrictionScale(options_.friction_scale);
}

void VehicleNode::mountLidars(ros::NodeHandle nh, std::shared_ptr<const RayCaster> caster) {
  lidars_.emplace(nh, options_.lidars, std::move(caster), simulator_, static_cast<std::uint64_t>(options_.noise_seed),
                  options_.tf_prefix);
}

void VehicleNode::addTick(std::chrono::nanoseconds duration) {
  if (recorder_) recorder_->add(simulator_, std::chrono::duration<double>(duration).count());
  if (simulator_.status() != StepStatus::kOk) return;
  state_.addTick();
  // From the memory: contacts() would evaluate the forces once more, only to count them.
  int contacts = 0;
  for (const ContactMemory& memory : simulator_.state().memory) contacts += memory.count;
  statistics_.addStep(duration, simulator_.largestPenetration(), contacts);
}

void VehicleNode::publishState(const ros::Time& stamp) {
  contacts_.publishContacts(stamp);
  state_.publishState(stamp);
}

void VehicleNode::publishReady(bool ready) {
  std_msgs::Bool message;
  message.data = ready;
  ready_publisher_.publish(message);
  announced_ready_ = true;
  ready_ = ready;
}

diagnostic_msgs::DiagnosticStatus VehicleNode::status(RunFacts facts) const {
  if (!name_.empty()) facts.node += " " + name_;
  facts.hardware = base_frame_;
  facts.dropped_commands = commands_.dropped();
  facts.last_refusal = commands_.lastRefusal();
  return diagnosticStatus(simulator_, statistics_, facts);
}

void VehicleNode::reportEvents() {
  const StepEvents& now = simulator_.events();
  const std::string who = before(name_);
  if (now.passed_through > reported_events_.passed_through) {
    ROS_WARN("%san ellipsoid went through the ground, %ld times so far: too fast for the contact stiffness", who.c_str(),
             static_cast<long>(now.passed_through));
  }
  if (now.effort_exceeded > reported_events_.effort_exceeded && effort_.due()) {
    ROS_WARN("%sa prescribed joint needed more than its effort limit in %ld ticks and held its path", who.c_str(),
             static_cast<long>(now.effort_exceeded));
  }
  if (now.command_timeouts > reported_events_.command_timeouts) {
    ROS_WARN("%sno command for %.3g s: braking", who.c_str(), simulator_.config().command_timeout);
  }
  reported_events_ = now;
}

void VehicleNode::startAgain() {
  commands_.clear();
  state_.odometry().reset();
  reported_events_ = StepEvents();
  statistics_.jump();
  addPosition();
  if (announced_ready_ && !ready_) publishReady(true);
}

void VehicleNode::saveBeside(ByteWriter& out) const {
  const WheelOdometry::Values odometry = state_.odometry().values();
  for (Eigen::Index i = 0; i < odometry.size(); ++i) out.add(odometry[i]);
  commands_.save(out);
}

bool VehicleNode::restoreBeside(ByteReader& in) {
  WheelOdometry::Values odometry;
  for (Eigen::Index i = 0; i < odometry.size(); ++i) odometry[i] = in.number();
  if (!odometry.allFinite() || !commands_.restore(in)) return false;
  state_.odometry().setValues(odometry);
  return true;
}

void VehicleNode::wasRestored() {
  reported_events_ = simulator_.events();
  statistics_.jump();
  addPosition();
  if (announced_ready_ && !ready_) publishReady(true);
}

std::string VehicleNode::result() const {
  // It is the last good height; far below the lowest point of the world means that the vehicle fell off it.
  const double below = simulator_.terrain().bounds().min().z() - simulator_.rootPose().p.z();
  if (simulator_.status() != StepStatus::kOk) return "diverged at " + std::to_string(simulator_.time()) + " s";
  if (simulator_.events().passed_through > 0)
    return "passed through the ground " + std::to_string(simulator_.events().passed_through) + " times";
  return below > 1.0 ? "fell off the world" : "ok";
}

void VehicleNode::finish(const std::string& result) {
  if (!recorder_) return;
  for (const Problem& problem : recorder_->finish(simulator_, result)) ROS_ERROR("%s", problem.text().c_str());
}

Outcome VehicleNode::resetVehicle() {
  simulator_.reset();
  startAgain();
  host_.wasPut(name_);
  return {true, "back at the start" + atTime(host_.simulatedTime())};
}

Outcome VehicleNode::put(const Placement& placement) {
  Pose X_WR = placement.pose;
  std::string frame = placement.frame;
  if (!frame.empty() && frame.front() == '/') frame.erase(0, 1);
  if (!X_WR.allFinite() || !(X_WR.q.norm() > 1e-6)) {
    return {false, "the pose must be finite, and its quaternion not zero"};
  }
  X_WR.q.normalize();
  if (frame == options_.odom_frame) {
    X_WR = state_.odomInWorld() * X_WR;
  } else if (!frame.empty() && frame != state_.worldFrame()) {
    const bool one = state_.worldFrame() == options_.odom_frame;
    return {false, "the pose is in frame '" + placement.frame + "', allowed is '" + options_.odom_frame +
                       (one ? "'" : "' or '" + state_.worldFrame() + "'")};
  }
  Problems problems;
  if (!placement.settle) {
    problems = simulator_.place(X_WR, X_WR.q * placement.v_R, X_WR.q * placement.w_R);
  } else if (!placement.v_R.isZero(0.0) || !placement.w_R.isZero(0.0)) {
    problems = {{"twist", "with settle the vehicle is set down at rest: the twist must be zero"}};
  } else {
    problems = fleet_.setDown(placeOf(fleet_, name_), X_WR.p.x(), X_WR.p.y(), yawOf(X_WR.q));
  }
  if (!problems.empty()) {
    std::string text = problemText(problems);
    text.pop_back();
    return {false, text};
  }
  startAgain();
  host_.wasPut(name_);
  return {true, (placement.settle ? "set down" : "placed") + atTime(host_.simulatedTime())};
}

}  // namespace ellipsoid_vehicle_sim
