#include "ellipsoid_vehicle_sim/ros/simulator_node.h"

#include <diagnostic_msgs/DiagnosticArray.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <std_msgs/Bool.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "ellipsoid_vehicle_sim/ros/diagnostics.h"

namespace ellipsoid_vehicle_sim {
namespace {

// Exit codes besides 0 and the 1 of a refused start.
constexpr int kExitDiverged = 2;
constexpr int kExitNoCommand = 3;

constexpr double kLongestSleep = 0.05;                // [s] of wall time, so that a shutdown is noticed
constexpr double kShortestSleep = 0.005;              // [s]: ticks that are due meanwhile are made together
constexpr std::int64_t kTicksBetweenCallbacks = 100;  // even if nothing is to be published that often
constexpr double kDistanceRate = 10.0;                // [Hz]
constexpr double kDiagnosticsRate = 1.0;              // [Hz]

double secondsSince(WallPacer::Clock::time_point start) {
  return std::chrono::duration<double>(WallPacer::Clock::now() - start).count();
}

}  // namespace

SimulatorNode::SimulatorNode(ros::NodeHandle nh, ros::NodeHandle nh_priv, NodeSetup setup)
    : options_(setup.options),
      simulator_(std::move(setup.simulator)),
      base_frame_(setup.base_frame),
      clock_(nh, options_, simulator_.config().dt),
      state_(nh, options_, base_frame_, simulator_),
      contacts_(nh, setup, simulator_, state_.worldFrame()),
      commands_(nh, options_, simulator_),
      ready_publisher_(nh.advertise<std_msgs::Bool>("ready", 1, true)),
      diagnostics_publisher_(nh.advertise<diagnostic_msgs::DiagnosticArray>("diagnostics", 10)),
      recorder_(std::move(setup.recorder)),
      running_parameters_(
          nh, nh_priv, options_, [this] { applyRunningParameters(); }, [this] { return simulator_.stepCount(); },
          [this] { return now(); }),
      services_(nh, nh_priv, options_, *this) {
  for (const std::string& note : setup.notes) ROS_INFO("%s", note.c_str());
  setEvents();
  simulator_.setFrictionScale(options_.friction_scale);
}

void SimulatorNode::setEvent(Event& event, const char* key, double rate) const {
  if (event.rate == rate) return;
  const double dt = simulator_.config().dt;
  const std::int64_t period = std::max<std::int64_t>(1, std::llround(1.0 / (rate * dt)));
  const double real_rate = 1.0 / (static_cast<double>(period) * dt);
  if (std::abs(real_rate - rate) > 1e-6 * rate) {
    ROS_INFO("%s: %g Hz becomes %g Hz, one message every %ld ticks", key, rate, real_rate, static_cast<long>(period));
  }
  event = {rate, period};
}

void SimulatorNode::setEvents() {
  setEvent(clock_event_, "clock_rate", options_.clock_rate);
  setEvent(state_event_, "publish_rate", options_.publish_rate);
  setEvent(imu_event_, "imu_rate", options_.imu_rate);
  setEvent(marker_event_, "marker_rate", options_.marker_rate);
  setEvent(diagnostics_event_, "diagnostics", kDiagnosticsRate);
  setEvent(distance_event_, "distance", kDistanceRate);
}

void SimulatorNode::applyRunningParameters() {
  setEvents();
  contacts_.setMarkerScale(options_.marker_scale);
  clock_.setFactor(options_.real_time_factor, simulator_.stepCount());
  simulator_.setFrictionScale(options_.friction_scale);
}

int SimulatorNode::run() {
  if (!clock_.start(simulator_.stepCount())) return 0;
  wall_start_ = last_status_ = WallPacer::Clock::now();
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
  if (!running() || paused_) {
    serveCallbacks(kLongestSleep);
    return;
  }
  serveCallbacks(0.0);  // before the ticks are counted: a reset starts the count again
  if (!running() || paused_ || finished()) return;
  const std::int64_t to_event = ticksToNextEvent();
  const std::int64_t ticks = std::min(clock_.due(simulator_.stepCount()), to_event);
  if (ticks < std::min(to_event, ticksPerWakeUp())) {
    const double wait = clock_.wait(simulator_.stepCount() + std::min(to_event, ticksPerWakeUp()));
    serveCallbacks(std::min(wait, kLongestSleep));
    return;
  }
  advance(ticks);
  if (!running()) return;
  publishDue();
  if (options_.lockstep && state_event_.dueAt(ticksSinceReset())) awaitCommand();
}

std::int64_t SimulatorNode::ticksPerWakeUp() const {
  // A followed clock comes in steps of its own.
  if (clock_.mode() == ClockMode::kFollow) return 1;
  const double factor = std::max(clock_.factor(), 1.0);
  return std::max<std::int64_t>(1, std::llround(kShortestSleep * factor / simulator_.config().dt));
}

std::int64_t SimulatorNode::ticksToNextEvent() const {
  std::int64_t ticks = simulator_.stepCount() == 0 ? 1 : kTicksBetweenCallbacks;  // the first tick starts the clock
  for (const Event* event :
       {&clock_event_, &state_event_, &imu_event_, &marker_event_, &diagnostics_event_, &distance_event_}) {
    ticks = std::min(ticks, event->period - ticksSinceReset() % event->period);
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
    if (recorder_) recorder_->add(simulator_, std::chrono::duration<double>(after - before).count());
    if (status != StepStatus::kOk) {
      ROS_ERROR("the simulation diverged at %.6f s and is frozen at its last good state; ~reset starts again",
                simulator_.time());
      publishReady(false);
      publishDiagnostics();
      return;
    }
    state_.addTick();
    // From the memory: contacts() would evaluate the forces once more, only to count them.
    int contacts = 0;
    for (const ContactMemory& memory : simulator_.state().memory) contacts += memory.count;
    statistics_.addStep(after - before, simulator_.largestPenetration(), contacts);
  }
}

void SimulatorNode::publishDue() {
  const std::int64_t ticks = ticksSinceReset();
  const ros::Time stamp = now();
  if (distance_event_.dueAt(ticks)) statistics_.addPosition(simulator_.rootPose().p);
  // Time first: who gets a message may look at the clock.
  if (simulator_.stepCount() == 1 || clock_event_.dueAt(ticks) || state_event_.dueAt(ticks)) {
    clock_.publish(simulator_.stepCount());
  }
  if (imu_event_.dueAt(ticks)) state_.publishImu(stamp, ticks / imu_event_.period);
  if (marker_event_.dueAt(ticks)) contacts_.publishMarkers(stamp);
  if (state_event_.dueAt(ticks)) {
    contacts_.publishContacts(stamp);
    state_.publishState(stamp);
    if (!announced_ready_) {
      running_parameters_.publish();
      publishReady(true);
    }
  }
  if (diagnostics_event_.dueAt(ticks)) {
    publishDiagnostics();
    reportEvents();
  }
}

void SimulatorNode::awaitCommand() {
  waiting_ = true;
  release_wait_ = false;
  const auto start = last_answer_ = WallPacer::Clock::now();
  while (ros::ok() && !commands_.isComplete() && !release_wait_) {
    serveCallbacks(kLongestSleep);
    if (paused_) last_answer_ = WallPacer::Clock::now();
    const double waited = secondsSince(last_answer_);
    if (options_.lockstep_timeout > 0.0 && waited > options_.lockstep_timeout) {
      failure_ = "lockstep: no command on " + commands_.missing() + " for " + std::to_string(std::lround(waited)) +
                 " s of wall time at simulated time " + std::to_string(simulator_.time()) + " s";
      ROS_ERROR("%s", failure_.c_str());
      break;
    }
  }
  waiting_ = false;
  if (!commands_.isComplete()) return;
  commands_.takeOne();
  // Time stood still meanwhile: what was waited is not behind schedule.
  if (secondsSince(start) > 0.05) clock_.skip(simulator_.stepCount());
}

void SimulatorNode::serveCallbacks(double longest_wait) {
  ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(longest_wait));
}

void SimulatorNode::publishReady(bool ready) {
  std_msgs::Bool message;
  message.data = ready;
  ready_publisher_.publish(message);
  announced_ready_ = true;
  ready_ = ready;
}

void SimulatorNode::publishDiagnostics() {
  const double wall = secondsSince(wall_start_), recent = secondsSince(last_status_);
  RunFacts facts;
  facts.node = ros::this_node::getName().substr(1);
  facts.hardware = base_frame_;
  facts.paused = paused_;
  facts.waiting = waiting_;
  facts.recent_factor = (simulator_.time() - last_status_time_) / std::max(recent, 1e-9);
  facts.mean_factor = simulator_.time() / std::max(wall, 1e-9);
  facts.lost = clock_.lost();
  facts.clock_jumps = clock_.jumps();
  facts.dropped_commands = commands_.dropped();
  facts.last_refusal = commands_.lastRefusal();
  last_status_ = WallPacer::Clock::now();
  last_status_time_ = simulator_.time();
  diagnostic_msgs::DiagnosticArray message;
  message.header.stamp = now();
  message.status.push_back(diagnosticStatus(simulator_, statistics_, facts));
  diagnostics_publisher_.publish(message);
}

void SimulatorNode::reportEvents() {
  const StepEvents& now = simulator_.events();
  if (now.passed_through > reported_events_.passed_through) {
    ROS_WARN("an ellipsoid went through the ground, %ld times so far: too fast for the contact stiffness",
             static_cast<long>(now.passed_through));
  }
  if (now.effort_exceeded > reported_events_.effort_exceeded && effort_.due()) {
    ROS_WARN("a prescribed joint needed more than its effort limit in %ld ticks and held its path",
             static_cast<long>(now.effort_exceeded));
  }
  if (now.command_timeouts > reported_events_.command_timeouts) {
    ROS_WARN("no command for %.3g s: braking", simulator_.config().command_timeout);
  }
  reported_events_ = now;
  if (clock_.lost() > reported_lost_ && behind_.due()) {
    ROS_WARN("behind the wall clock by %.2f s in all: real_time_factor %.3g cannot be held", clock_.lost(),
             clock_.factor());
    reported_lost_ = clock_.lost();
  }
}

int SimulatorNode::finish() {
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
  if (recorder_) {
    for (const Problem& problem : recorder_->finish(simulator_, result)) ROS_ERROR("%s", problem.text().c_str());
  }
  const std::string report = statistics_.report(simulator_.time(), secondsSince(wall_start_), result);
  if (!options_.summary_file.empty()) std::ofstream(options_.summary_file) << report;
  ROS_INFO("%s", report.c_str());
  if (!failure_.empty()) return kExitNoCommand;
  return running() ? 0 : kExitDiverged;
}

}  // namespace ellipsoid_vehicle_sim
