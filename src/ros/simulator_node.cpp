#include "ellipsoid_vehicle_sim/ros/simulator_node.h"

#include <ros/callback_queue.h>
#include <ros/ros.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "ellipsoid_vehicle_sim/ros/conversions.h"

namespace ellipsoid_vehicle_sim {
namespace {

// Exit codes besides 0 and the 1 of a refused start.
constexpr int kExitDiverged = 2;
constexpr int kExitNoCommand = 3;

constexpr double kLongestSleep = 0.05;                // [s] of wall time, so that a shutdown is noticed
constexpr double kShortestSleep = 0.005;              // [s]: ticks that are due meanwhile are made together
constexpr std::int64_t kTicksBetweenCallbacks = 100;  // even if nothing is to be published that often
constexpr std::size_t kLongestQueue = 100;            // commands waiting in lockstep
constexpr double kDistanceRate = 10.0;                // [Hz]
constexpr double kDiagnosticsRate = 1.0;              // [Hz]

/// Length of an arrow for one newton: the vehicle's weight is twice as long as the vehicle, so that an arrow on one of
/// four wheels comes out of the wheel; unless told otherwise.
double arrowScale(const NodeSetup& setup) {
  const double weight = setup.simulator.model().mass * std::max(setup.simulator.config().gravity, 1.0);
  return setup.options.contact_arrow_scale.value_or(2.0 * setup.vehicle_length / weight);
}

}  // namespace

SimulatorNode::SimulatorNode(ros::NodeHandle nh, ros::NodeHandle nh_priv, NodeSetup setup)
    : nh_(std::move(nh)),
      nh_priv_(std::move(nh_priv)),
      options_(setup.options),
      contact_markers_(options_.odom_frame, arrowScale(setup), setup.vehicle_length),
      world_markers_(setup.terrain, options_.odom_frame, static_cast<int>(options_.world_marker_limit)),
      simulator_(std::move(setup.simulator)),
      base_frame_(setup.base_frame),
      drawn_links_(setup.drawn_links),
      clock_event_(eventAt("clock_rate", options_.clock_rate)),
      state_event_(eventAt("publish_rate", options_.publish_rate)),
      marker_event_(eventAt("marker_rate", options_.marker_rate)),
      diagnostics_event_(eventAt("diagnostics", kDiagnosticsRate)),
      distance_event_(eventAt("distance", kDistanceRate)),
      // A clock that is followed sets the pace itself.
      pacer_(options_.clock == ClockMode::kFollow ? 0.0 : options_.real_time_factor, simulator_.config().dt) {
  for (const std::string& note : setup.notes) ROS_INFO("%s", note.c_str());
  advertise();
}

SimulatorNode::Event SimulatorNode::eventAt(const char* key, double rate) const {
  const double dt = simulator_.config().dt;
  const std::int64_t period = std::max<std::int64_t>(1, std::llround(1.0 / (rate * dt)));
  const double real_rate = 1.0 / (static_cast<double>(period) * dt);
  if (std::abs(real_rate - rate) > 1e-6 * rate) {
    ROS_INFO("%s: %g Hz becomes %g Hz, one message every %ld ticks", key, rate, real_rate, static_cast<long>(period));
  }
  return {period};
}

int SimulatorNode::run() {
  if (options_.clock == ClockMode::kFollow) {
    while (ros::ok() && ros::Time::now().isZero()) {
      ROS_WARN_THROTTLE(5.0, "waiting for somebody to publish /clock");
      ros::WallDuration(0.02).sleep();
    }
  }
  // Wall time, or the followed clock's; with our own clock the simulation starts at zero.
  if (options_.clock != ClockMode::kPublish) time_origin_ = ros::Time::now();
  wall_start_ = WallPacer::Clock::now();
  pacer_.start(wall_start_, simulator_.stepCount());
  statistics_.addPosition(simulator_.rootPose().p);
  while (ros::ok() && !finished()) runOnce();
  return finish();
}

bool SimulatorNode::finished() const {
  if (!failure_.empty()) return true;
  // A run of given length is a batch job: it ends when it diverges, nobody will come to reset it.
  return options_.duration > 0.0 &&
         (!running() || simulator_.time() >= options_.duration - 0.5 * simulator_.config().dt);
}

void SimulatorNode::runOnce() {
  if (!running()) {
    serveCallbacks(kLongestSleep);
    return;
  }
  serveCallbacks(0.0);  // before the ticks are counted: a reset starts the count again
  const std::int64_t to_event = ticksToNextEvent();
  const std::int64_t ticks = std::min(ticksDue(), to_event);
  if (ticks < std::min(to_event, ticksPerWakeUp())) {
    const double wait =
        pacer_.wait(WallPacer::Clock::now(), simulator_.stepCount() + std::min(to_event, ticksPerWakeUp()));
    // The pacer does not know when a followed clock moves: look again after a millisecond.
    serveCallbacks(options_.clock == ClockMode::kFollow ? 1e-3 : std::min(wait, kLongestSleep));
    return;
  }
  advance(ticks);
  if (!running()) return;
  publishDue();
  if (options_.lockstep && state_event_.dueAt(ticksSinceReset())) awaitCommand();
}

std::int64_t SimulatorNode::ticksPerWakeUp() const {
  // A followed clock comes in steps of its own.
  if (options_.clock == ClockMode::kFollow) return 1;
  const double factor = std::max(options_.real_time_factor, 1.0);
  return std::max<std::int64_t>(1, std::llround(kShortestSleep * factor / simulator_.config().dt));
}

std::int64_t SimulatorNode::ticksDue() {
  if (options_.clock != ClockMode::kFollow) return pacer_.due(WallPacer::Clock::now(), simulator_.stepCount());
  const double ahead = (ros::Time::now() - stamp()).toSec();
  return static_cast<std::int64_t>(std::floor(ahead / simulator_.config().dt + 1e-6));
}

std::int64_t SimulatorNode::ticksToNextEvent() const {
  std::int64_t ticks = simulator_.stepCount() == 0 ? 1 : kTicksBetweenCallbacks;  // the first tick starts the clock
  for (const Event& event : {clock_event_, state_event_, marker_event_, diagnostics_event_, distance_event_}) {
    ticks = std::min(ticks, event.period - ticksSinceReset() % event.period);
  }
  if (options_.duration > 0.0) {
    const std::int64_t last = std::llround(options_.duration / simulator_.config().dt);
    ticks = std::min(ticks, std::max<std::int64_t>(1, last - simulator_.stepCount()));
  }
  return ticks;
}

void SimulatorNode::advance(std::int64_t ticks) {
  for (std::int64_t i = 0; i < ticks; ++i) {
    const auto before = WallPacer::Clock::now();
    const StepStatus status = simulator_.step();
    const auto after = WallPacer::Clock::now();
    if (status != StepStatus::kOk) {
      ROS_ERROR("the simulation diverged at %.6f s and is frozen at its last good state; ~reset starts again",
                simulator_.time());
      publishReady(false);
      publishDiagnostics();
      return;
    }
    // From the memory: contacts() would evaluate the forces once more, only to count them.
    int contacts = 0;
    for (const ContactMemory& memory : simulator_.state().memory) contacts += memory.count;
    statistics_.addStep(after - before, simulator_.largestPenetration(), contacts);
  }
}

void SimulatorNode::publishDue() {
  const std::int64_t ticks = ticksSinceReset();
  if (distance_event_.dueAt(ticks)) statistics_.addPosition(simulator_.rootPose().p);
  // Time first: who gets a message may look at the clock.
  if (simulator_.stepCount() == 1 || clock_event_.dueAt(ticks) || state_event_.dueAt(ticks)) publishClock();
  if (state_event_.dueAt(ticks)) {
    publishState();
    if (!announced_ready_) publishReady(true);
  }
  if (marker_event_.dueAt(ticks)) publishMarkers();
  if (diagnostics_event_.dueAt(ticks)) {
    publishDiagnostics();
    reportEvents();
  }
}

void SimulatorNode::awaitCommand() {
  const auto start = WallPacer::Clock::now();
  release_wait_ = false;
  while (ros::ok() && waiting_commands_.empty() && !release_wait_) {
    serveCallbacks(kLongestSleep);
    const double waited = std::chrono::duration<double>(WallPacer::Clock::now() - start).count();
    if (options_.lockstep_timeout > 0.0 && waited > options_.lockstep_timeout) {
      failure_ = "lockstep: no command on '" + command_subscriber_.getTopic() + "' for " +
                 std::to_string(std::lround(waited)) + " s of wall time at simulated time " +
                 std::to_string(simulator_.time()) + " s (" + std::to_string(command_subscriber_.getNumPublishers()) +
                 " publishers)";
      ROS_ERROR("%s", failure_.c_str());
      return;
    }
  }
  if (waiting_commands_.empty()) return;
  simulator_.command(waiting_commands_.front());
  waiting_commands_.pop_front();
  // Time stood still meanwhile: what was waited is not behind schedule.
  const auto now = WallPacer::Clock::now();
  if (now - start > std::chrono::milliseconds(50)) pacer_.start(now, simulator_.stepCount());
}

void SimulatorNode::serveCallbacks(double longest_wait) {
  ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(longest_wait));
}

void SimulatorNode::onCommand(const geometry_msgs::Twist& twist) {
  const DriveCommand command = toDriveCommand(twist);
  // Also what a ground vehicle does not look at: a NaN anywhere means that the sender is broken.
  const double sum =
      twist.linear.x + twist.linear.y + twist.linear.z + twist.angular.x + twist.angular.y + twist.angular.z;
  if (!std::isfinite(sum)) {
    ++dropped_commands_;
    // Not ROS_WARN_THROTTLE: it counts simulated time, says nothing in its first second, and in lockstep that may be
    // all.
    const auto now = WallPacer::Clock::now();
    if (now - last_drop_warning_ > std::chrono::seconds(1)) {
      last_drop_warning_ = now;
      ROS_WARN("%s: a command that is not finite was dropped (%ld so far)", command_subscriber_.getTopic().c_str(),
               static_cast<long>(dropped_commands_));
    }
    return;
  }
  if (!options_.lockstep) {
    simulator_.command(command);
    return;
  }
  waiting_commands_.push_back(command);
  if (waiting_commands_.size() > kLongestQueue) waiting_commands_.pop_front();
  if (waiting_commands_.size() > kLongestQueue / 10) {
    ROS_WARN_THROTTLE(5.0, "lockstep: %zu commands wait; send one for each odom message", waiting_commands_.size());
  }
}

bool SimulatorNode::onReset(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  simulator_.reset();
  reset_step_ = simulator_.stepCount();
  waiting_commands_.clear();
  release_wait_ = true;
  reported_events_ = StepEvents();
  statistics_.jump();
  statistics_.addPosition(simulator_.rootPose().p);
  pacer_.start(WallPacer::Clock::now(), simulator_.stepCount());
  if (announced_ready_ && !ready_) publishReady(true);
  response.success = true;
  response.message = "back at the start at simulated time " + std::to_string(simulator_.time()) + " s";
  ROS_INFO("reset: %s", response.message.c_str());
  return true;
}

void SimulatorNode::reportEvents() {
  const StepEvents& now = simulator_.events();
  if (now.passed_through > reported_events_.passed_through) {
    ROS_WARN("an ellipsoid went through the ground, %ld times so far: too fast for the contact stiffness",
             static_cast<long>(now.passed_through));
  }
  if (now.effort_exceeded > reported_events_.effort_exceeded) {
    ROS_WARN_THROTTLE(5.0, "a prescribed joint needed more than its effort limit in %ld ticks and held its path",
                      static_cast<long>(now.effort_exceeded));
  }
  if (now.command_timeouts > reported_events_.command_timeouts) {
    ROS_WARN("no command for %.3g s on %s: braking", simulator_.config().command_timeout,
             command_subscriber_.getTopic().c_str());
  }
  reported_events_ = now;
  if (pacer_.lost() > reported_lost_) {
    ROS_WARN_THROTTLE(5.0, "behind the wall clock by %.2f s in all: real_time_factor %.3g cannot be held",
                      pacer_.lost(), options_.real_time_factor);
    reported_lost_ = pacer_.lost();
  }
}

int SimulatorNode::finish() {
  const double wall = std::chrono::duration<double>(WallPacer::Clock::now() - wall_start_).count();
  // It is the last good height; far below the lowest point of the world means that the vehicle fell off it.
  const Eigen::AlignedBox3d world = simulator_.terrain().bounds();
  const double below = world.min().z() - simulator_.rootPose().p.z();
  std::string result = "ok";
  if (!running()) result = "diverged at " + std::to_string(simulator_.time()) + " s";
  if (!failure_.empty()) result = failure_;
  if (result == "ok" && simulator_.events().passed_through > 0) {
    result = "passed through the ground " + std::to_string(simulator_.events().passed_through) + " times";
  }
  if (result == "ok" && below > 1.0) result = "fell off the world";
  const std::string report = statistics_.report(simulator_.time(), wall, result);
  if (!options_.summary_file.empty()) std::ofstream(options_.summary_file) << report;
  ROS_INFO("%s", report.c_str());
  if (!failure_.empty()) return kExitNoCommand;
  return running() ? 0 : kExitDiverged;
}

}  // namespace ellipsoid_vehicle_sim
