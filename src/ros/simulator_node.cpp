#include "ellipsoid_vehicle_sim/ros/simulator_node.h"

#include <diagnostic_msgs/DiagnosticArray.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <std_msgs/Bool.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "ellipsoid_vehicle_sim/ros/diagnostics.h"
#include "ellipsoid_vehicle_sim/ros/interrupt.h"

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
    : nh_(nh),
      nh_priv_(nh_priv),
      options_(setup.options),
      dt_(setup.fleet.vehicle(0).config().dt),
      terrain_(setup.terrain),
      world_start_(setup.world_start),
      world_files_(std::move(setup.world_files)),
      common_(std::move(setup.common)),
      fleet_(std::move(setup.fleet)),
      clock_(nh, options_, dt_),
      world_(nh, terrain_, worldFrameOf(options_), static_cast<int>(options_.world_marker_limit),
             fleet_.vehicle(0).rootPose().p),
      diagnostics_publisher_(nh.advertise<diagnostic_msgs::DiagnosticArray>("diagnostics", 10)),
      running_parameters_(
          nh, nh_priv, options_, [this] { applyRunningParameters(); }, [this] { return fleet_.stepCount(); },
          [this] { return now(); }),
      services_(nh, nh_priv, options_, *this) {
  for (const std::string& note : setup.notes) ROS_INFO("%s", note.c_str());
  for (std::size_t i = 0; i < setup.vehicles.size(); ++i)
    addVehicle(std::move(setup.vehicles[i]), std::move(setup.recorders[i]));
  if (!isPlain()) {
    ready_publisher_ = nh.advertise<std_msgs::Bool>("ready", 1, true);
    ROS_INFO("%zu vehicles, on %d core%s", vehicles_.size(), fleet_.threads(), fleet_.threads() == 1 ? "" : "s");
  }
  setEvents();
}

void SimulatorNode::addVehicle(VehicleSetup setup, std::optional<RunRecorder> recorder) {
  const std::string name = setup.name;
  vehicles_.push_back(std::make_unique<VehicleNode>(name.empty() ? nh_ : ros::NodeHandle(nh_, name),
                                                    name.empty() ? nh_priv_ : ros::NodeHandle(nh_priv_, name),
                                                    std::move(setup), std::move(recorder), fleet_, static_cast<VehicleHost&>(*this)));
  mountLidars(name.empty() ? nh_ : ros::NodeHandle(nh_, name));
}

void SimulatorNode::setEvent(Event& event, const char* key, double rate) const {
  if (event.rate == rate) return;
  const double dt = dt_;
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
  clock_.setFactor(options_.real_time_factor, fleet_.stepCount());
  for (const auto& vehicle : vehicles_) {
    vehicle->contacts().setMarkerScale(options_.marker_scale);
    vehicle->simulator().setFrictionScale(options_.friction_scale);
  }
}

int SimulatorNode::run() {
  if (!clock_.start(fleet_.stepCount())) return 0;
  wall_start_ = last_status_ = WallPacer::Clock::now();
  for (const auto& vehicle : vehicles_) vehicle->addPosition();
  while (ros::ok() && !interrupted() && !finished()) runOnce();
  return finish();
}

bool SimulatorNode::finished() const {
  if (!failure_.empty()) return true;
  // A run of given length is a batch job: it ends when it diverges, nobody will come to reset it.
  return options_.duration > 0.0 &&
         (!running() || fleet_.time() >= options_.duration - 0.5 * dt_);
}

void SimulatorNode::runOnce() {
  if (!running() || paused_) {
    serveCallbacks(kLongestSleep);
    return;
  }
  serveCallbacks(0.0);  // before the ticks are counted: a reset starts the count again
  if (!running() || paused_ || finished()) return;
  const std::int64_t to_event = ticksToNextEvent();
  const std::int64_t ticks = std::min(clock_.due(fleet_.stepCount()), to_event);
  if (ticks < std::min(to_event, ticksPerWakeUp())) {
    const double wait = clock_.wait(fleet_.stepCount() + std::min(to_event, ticksPerWakeUp()));
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
  return std::max<std::int64_t>(1, std::llround(kShortestSleep * factor / dt_));
}

std::int64_t SimulatorNode::ticksToNextEvent() const {
  std::int64_t ticks = fleet_.stepCount() == 0 ? 1 : kTicksBetweenCallbacks;  // the first tick starts the clock
  for (const Event* event :
       {&clock_event_, &state_event_, &imu_event_, &marker_event_, &diagnostics_event_, &distance_event_}) {
    ticks = std::min(ticks, event->period - ticksSinceReset() % event->period);
  }
  for (const auto& vehicle : vehicles_)
    if (vehicle->lidars()) ticks = std::min(ticks, vehicle->lidars()->ticksToNext(ticksSinceReset()));
  if (options_.duration > 0.0) {
    const std::int64_t last = std::llround(options_.duration / dt_);
    ticks = std::min(ticks, std::max<std::int64_t>(1, last - fleet_.stepCount()));
  }
  return ticks;
}

void SimulatorNode::advance(std::int64_t ticks) {
  for (std::int64_t i = 0; i < ticks; ++i) {
    const auto before = WallPacer::Clock::now();
    const StepStatus status = fleet_.step();
    const auto duration = WallPacer::Clock::now() - before;
    for (const auto& vehicle : vehicles_) vehicle->addTick(duration);
    if (status != StepStatus::kOk) {
      for (const auto& vehicle : vehicles_) {
        if (vehicle->simulator().status() == StepStatus::kOk) continue;
        ROS_ERROR("%sthe simulation diverged at %.6f s and is frozen at its last good state; ~reset starts again",
                  vehicle->name().empty() ? "" : (vehicle->name() + ": ").c_str(), fleet_.time());
        vehicle->publishReady(false);
      }
      publishReady(false);
      publishDiagnostics();
      return;
    }
  }
}

void SimulatorNode::publishDue() {
  const std::int64_t ticks = ticksSinceReset();
  const ros::Time stamp = now();
  // Time first: who gets a message may look at the clock.
  if (fleet_.stepCount() == 1 || clock_event_.dueAt(ticks) || state_event_.dueAt(ticks)) {
    clock_.publish(fleet_.stepCount());
  }
  for (const auto& vehicle : vehicles_) {
    if (distance_event_.dueAt(ticks)) vehicle->addPosition();
    if (imu_event_.dueAt(ticks)) vehicle->publishImu(stamp, ticks / imu_event_.period);
    if (marker_event_.dueAt(ticks)) vehicle->contacts().publishMarkers(stamp);
  }
  publishLidars(ticks, stamp);
  if (marker_event_.dueAt(ticks) && !vehicles_.empty()) world_.update(vehicles_.front()->simulator().rootPose().p);
  if (state_event_.dueAt(ticks)) {
    for (const auto& vehicle : vehicles_) vehicle->publishState(stamp);
    if (!announced_ready_) running_parameters_.publish();
    for (const auto& vehicle : vehicles_)
      if (!vehicle->announcedReady()) vehicle->publishReady(true);
    if (!announced_ready_) publishReady(true);
  }
  if (diagnostics_event_.dueAt(ticks)) {
    publishDiagnostics();
    reportEvents();
    returnMemory();
  }
  while (!leaving_.empty() && ros::WallTime::now() > leaving_.front().first) leaving_.pop_front();
}

bool SimulatorNode::allCommandsAreThere() const {
  return std::all_of(vehicles_.begin(), vehicles_.end(), [](const auto& v) { return v->commands().isComplete(); });
}

std::string SimulatorNode::missingCommands() const {
  std::string text;
  for (const auto& vehicle : vehicles_)
    if (const std::string missing = vehicle->commands().missing(); !missing.empty())
      text += (text.empty() ? "" : ", ") + missing;
  return text;
}

void SimulatorNode::awaitCommand() {
  waiting_ = true;
  release_wait_ = false;
  const auto start = last_answer_ = WallPacer::Clock::now();
  while (ros::ok() && !interrupted() && !allCommandsAreThere() && !release_wait_) {
    serveCallbacks(kLongestSleep);
    if (paused_) last_answer_ = WallPacer::Clock::now();
    const double waited = secondsSince(last_answer_);
    if (options_.lockstep_timeout > 0.0 && waited > options_.lockstep_timeout) {
      failure_ = "lockstep: no command on " + missingCommands() + " for " + std::to_string(std::lround(waited)) +
                 " s of wall time at simulated time " + std::to_string(fleet_.time()) + " s";
      ROS_ERROR("%s", failure_.c_str());
      break;
    }
  }
  waiting_ = false;
  if (!allCommandsAreThere()) return;
  for (const auto& vehicle : vehicles_) vehicle->commands().takeOne();
  // Time stood still meanwhile: what was waited is not behind schedule.
  if (secondsSince(start) > 0.05) clock_.skip(fleet_.stepCount());
}

void SimulatorNode::serveCallbacks(double longest_wait) {
  ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(longest_wait));
}

void SimulatorNode::returnMemory() {
#ifdef __GLIBC__
  // What a flood of commands or a slow subscriber's queue needed for a moment would stay ours for ever.
  if (memory_.due()) malloc_trim(0);
#endif
}

void SimulatorNode::publishReady(bool ready) {
  announced_ready_ = true;
  if (!ready_publisher_) return;  // the vehicle's own says it
  std_msgs::Bool message;
  message.data = ready;
  ready_publisher_.publish(message);
}

void SimulatorNode::publishDiagnostics() {
  const double wall = secondsSince(wall_start_), recent = secondsSince(last_status_);
  RunFacts facts;
  facts.node = ros::this_node::getName().substr(1);
  facts.paused = paused_;
  facts.waiting = waiting_;
  facts.recent_factor = (fleet_.time() - last_status_time_) / std::max(recent, 1e-9);
  facts.mean_factor = fleet_.time() / std::max(wall, 1e-9);
  facts.lost = clock_.lost();
  facts.clock_jumps = clock_.jumps();
  last_status_ = WallPacer::Clock::now();
  last_status_time_ = fleet_.time();
  diagnostic_msgs::DiagnosticArray message;
  message.header.stamp = now();
  for (const auto& vehicle : vehicles_) message.status.push_back(vehicle->status(facts));
  diagnostics_publisher_.publish(message);
}

void SimulatorNode::reportEvents() {
  for (const auto& vehicle : vehicles_) vehicle->reportEvents();
  if (clock_.lost() > reported_lost_ && behind_.due()) {
    ROS_WARN("behind the wall clock by %.2f s in all: real_time_factor %.3g cannot be held", clock_.lost(),
             clock_.factor());
    reported_lost_ = clock_.lost();
  }
}

int SimulatorNode::finish() {
  std::string all;
  for (const auto& vehicle : vehicles_) {
    std::string result = vehicle->result();
    if (!failure_.empty()) result = failure_;
    vehicle->finish(result);
    if (!vehicle->name().empty()) all += "vehicle: " + vehicle->name() + "\n";
    all += vehicle->statistics().report(fleet_.time(), secondsSince(wall_start_), result);
  }
  if (!options_.summary_file.empty()) std::ofstream(options_.summary_file) << all;
  ROS_INFO("%s", all.c_str());
  if (!failure_.empty()) return kExitNoCommand;
  return running() ? 0 : kExitDiverged;
}

}  // namespace ellipsoid_vehicle_sim
