// What SimulatorNode does when a service asks for it. Everything happens between two ticks.

#include <ros/ros.h>

#include <cmath>
#include <cstdio>

#include "ellipsoid_vehicle_sim/ros/simulator_node.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr std::uint64_t kStateVersion = 1;  // of what is saved beside the simulator's own state

std::string atTime(double time) {
  char text[40];
  std::snprintf(text, sizeof text, " at simulated time %.6g s", time);
  return text;
}

double yawOf(const Eigen::Quaterniond& q) {
  const Eigen::Vector3d ahead = q * Eigen::Vector3d::UnitX();
  return std::atan2(ahead.y(), ahead.x());
}

}  // namespace

void SimulatorNode::startAgain() {
  reset_step_ = simulator_.stepCount();
  commands_.clear();
  state_.odometry().reset();
  release_wait_ = true;
  reported_events_ = StepEvents();
  statistics_.jump();
  statistics_.addPosition(simulator_.rootPose().p);
  clock_.skip(simulator_.stepCount());
  if (announced_ready_ && !ready_) publishReady(true);
}

Outcome SimulatorNode::reset() {
  simulator_.reset();
  startAgain();
  const std::string message = "back at the start" + atTime(simulator_.time());
  ROS_INFO("reset: %s", message.c_str());
  return {true, message};
}

Outcome SimulatorNode::pause() {
  const std::string message = (paused_ ? "paused already" : "paused") + atTime(simulator_.time());
  paused_ = true;
  return {true, message};
}

Outcome SimulatorNode::resume() {
  const std::string message = (paused_ ? "going on" : "was going on already") + atTime(simulator_.time());
  if (paused_) clock_.skip(simulator_.stepCount());
  paused_ = false;
  if (!running()) return {false, "the simulation has diverged and is frozen: ~reset starts again"};
  return {true, message};
}

Outcome SimulatorNode::advanceBy(std::int64_t ticks) {
  if (!paused_ && !options_.lockstep) return {false, "the simulation is running by itself: call ~pause first"};
  if (!running()) return {false, "the simulation has diverged and is frozen: ~reset starts again"};
  commands_.takeAll();
  const std::int64_t last = simulator_.stepCount() + ticks;
  while (simulator_.stepCount() < last && running() && ros::ok()) {
    advance(std::min(last - simulator_.stepCount(), ticksToNextEvent()));
    if (running()) publishDue();
  }
  // Somebody is there: a lockstep command is awaited anew.
  last_answer_ = WallPacer::Clock::now();
  clock_.skip(simulator_.stepCount());
  // Who steps by hand reads the clock, whatever its rate.
  clock_.publish(simulator_.stepCount());
  if (!running()) return {false, "the simulation diverged" + atTime(simulator_.time())};
  if (simulator_.stepCount() < last) return {false, "shut down" + atTime(simulator_.time())};
  return {true, ""};
}

Outcome SimulatorNode::put(const Placement& placement) {
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
    problems = simulator_.setDown(X_WR.p.x(), X_WR.p.y(), yawOf(X_WR.q));
  }
  if (!problems.empty()) {
    std::string text = problemText(problems);
    text.pop_back();
    return {false, text};
  }
  startAgain();
  return {true, (placement.settle ? "set down" : "placed") + atTime(simulator_.time())};
}

std::vector<std::uint8_t> SimulatorNode::saveState() {
  ByteWriter extra;
  extra.add(kStateVersion);
  // Of the events' phase and of the noise: both are functions of it.
  extra.add(ticksSinceReset());
  const WheelOdometry::Values odometry = state_.odometry().values();
  for (Eigen::Index i = 0; i < odometry.size(); ++i) extra.add(odometry[i]);
  commands_.save(extra);
  Snapshot snapshot = simulator_.save();
  snapshot.extra = extra.bytes();
  return toBytes(snapshot, simulator_);
}

Outcome SimulatorNode::restoreState(const std::vector<std::uint8_t>& bytes, const std::string& where) {
  const Loaded<Snapshot> snapshot = fromBytes(bytes, simulator_, where);
  if (!snapshot) {
    std::string text = problemText(snapshot.problems);
    text.pop_back();
    return {false, text};
  }
  const std::vector<std::uint8_t>& extra = snapshot.value->extra;
  ByteReader in(extra.data(), extra.data() + extra.size());
  const bool known = in.whole() == kStateVersion;
  const auto ticks = static_cast<std::int64_t>(in.whole());
  WheelOdometry::Values odometry;
  for (Eigen::Index i = 0; i < odometry.size(); ++i) odometry[i] = in.number();
  if (!known || ticks < 0 || !odometry.allFinite() || !commands_.restore(in)) {
    return {false, where + ": was not saved by this node, or by another version of it"};
  }
  simulator_.restore(*snapshot.value);
  state_.odometry().setValues(odometry);
  reset_step_ = simulator_.stepCount() - ticks;
  reported_events_ = simulator_.events();
  statistics_.jump();
  statistics_.addPosition(simulator_.rootPose().p);
  clock_.skip(simulator_.stepCount());
  // A lockstep state that was saved between two commands goes on to the next; one that waited for a command waits on.
  if (!state_event_.dueAt(ticks)) release_wait_ = true;
  if (announced_ready_ && !ready_) publishReady(true);
  options_.friction_scale = simulator_.frictionScale();
  running_parameters_.refresh();
  const std::string message = "restored" + atTime(simulator_.time());
  ROS_INFO("restore_state: %s", message.c_str());
  return {true, message};
}

}  // namespace ellipsoid_vehicle_sim
