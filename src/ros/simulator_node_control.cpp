// What SimulatorNode does when a service asks for it. Everything happens between two ticks.

#include <ros/ros.h>

#include <std_msgs/Bool.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "ellipsoid_vehicle_sim/description/parameter_file.h"
#include "ellipsoid_vehicle_sim/ros/interrupt.h"
#include "ellipsoid_vehicle_sim/ros/master_call.h"
#include "ellipsoid_vehicle_sim/ros/simulator_node.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr std::uint64_t kStateVersion = 1;  // of what is saved beside the simulator's own state
constexpr std::int64_t kMostTicks = 1000000000000000;  // thirty thousand years of milliseconds

// Topics come and go by the master's leave, and roscpp waits for that for ever: the simulation would stand still meanwhile.
constexpr std::chrono::milliseconds kPatience(500);

Outcome noMaster() {
  return {false, "the ROS master does not answer: topics can neither be offered nor taken back"};
}

std::string atTime(double time) {
  char text[40];
  std::snprintf(text, sizeof text, " at simulated time %.6g s", time);
  return text;
}

Outcome refused(const Problems& problems) {
  std::string text = problemText(problems);
  if (!text.empty()) text.pop_back();
  return {false, text};
}

}  // namespace

void SimulatorNode::timeStartsAgain() {
  reset_step_ = fleet_.stepCount();
  release_wait_ = true;
  clock_.skip(fleet_.stepCount());
  if (ready_publisher_ && announced_ready_ && running()) publishReady(true);
}

// With several vehicles the events go on as they were: the others have nothing to do with it.
void SimulatorNode::wasPut(const std::string&) {
  if (isPlain()) {
    timeStartsAgain();
    return;
  }
  clock_.skip(fleet_.stepCount());
  if (announced_ready_ && running()) publishReady(true);
}

Outcome SimulatorNode::reset() {
  fleet_.reset();
  for (const auto& vehicle : vehicles_) vehicle->startAgain();
  timeStartsAgain();
  const std::string message = "back at the start" + atTime(fleet_.time());
  ROS_INFO("reset: %s", message.c_str());
  return {true, message};
}

Outcome SimulatorNode::pause() {
  const std::string message = (paused_ ? "paused already" : "paused") + atTime(fleet_.time());
  paused_ = true;
  return {true, message};
}

Outcome SimulatorNode::resume() {
  const std::string message = (paused_ ? "going on" : "was going on already") + atTime(fleet_.time());
  if (paused_) clock_.skip(fleet_.stepCount());
  paused_ = false;
  if (!running()) return {false, "the simulation has diverged and is frozen: ~reset starts again"};
  return {true, message};
}

Outcome SimulatorNode::advanceBy(std::int64_t ticks) {
  if (!paused_ && !options_.lockstep) return {false, "the simulation is running by itself: call ~pause first"};
  if (!running()) return {false, "the simulation has diverged and is frozen: ~reset starts again"};
  for (const auto& vehicle : vehicles_) vehicle->commands().takeAll();
  const std::int64_t last = fleet_.stepCount() + ticks;
  while (fleet_.stepCount() < last && running() && ros::ok() && !interrupted()) {
    advance(std::min(last - fleet_.stepCount(), ticksToNextEvent()));
    if (running()) publishDue();
  }
  // Somebody is there: a lockstep command is awaited anew.
  last_answer_ = WallPacer::Clock::now();
  clock_.skip(fleet_.stepCount());
  // Who steps by hand reads the clock, whatever its rate.
  clock_.publish(fleet_.stepCount());
  if (!running()) return {false, "the simulation diverged" + atTime(fleet_.time())};
  if (fleet_.stepCount() < last) return {false, "shut down" + atTime(fleet_.time())};
  return {true, ""};
}

std::vector<std::uint8_t> SimulatorNode::saveState() {
  ByteWriter extra;
  extra.add(kStateVersion);
  // Of the events' phase and of the noise: both are functions of it.
  extra.add(ticksSinceReset());
  if (isPlain()) {
    vehicles_.front()->saveBeside(extra);
    Snapshot snapshot = fleet_.vehicle(0).save();
    snapshot.extra = extra.bytes();
    return toBytes(snapshot, fleet_.vehicle(0));
  }
  FleetSnapshot snapshot = fleet_.save();
  snapshot.extra = extra.bytes();
  for (std::size_t i = 0; i < vehicles_.size(); ++i) {
    ByteWriter own;
    vehicles_[i]->saveBeside(own);
    snapshot.vehicles[i].extra = own.bytes();
  }
  return toBytes(snapshot, fleet_);
}

Outcome SimulatorNode::restoreState(const std::vector<std::uint8_t>& bytes, const std::string& where) {
  const Outcome foreign{false, where + ": was not saved by this node, or by another version of it"};
  FleetSnapshot snapshot;
  if (isPlain()) {
    Loaded<Snapshot> one = fromBytes(bytes, fleet_.vehicle(0), where);
    if (!one) return refused(one.problems);
    snapshot.names = {fleet_.name(0)};
    snapshot.extra = one.value->extra;
    snapshot.vehicles.push_back(std::move(*one.value));
  } else {
    Loaded<FleetSnapshot> all = fromBytes(bytes, fleet_, where);
    if (!all) return refused(all.problems);
    snapshot = std::move(*all.value);
  }
  ByteReader in(snapshot.extra.data(), snapshot.extra.data() + snapshot.extra.size());
  const bool known = in.whole() == kStateVersion;
  const auto ticks = static_cast<std::int64_t>(in.whole());
  if (!known || !in.ok() || ticks < 0 || ticks > kMostTicks) return foreign;
  for (std::size_t i = 0; i < vehicles_.size(); ++i) {
    const std::vector<std::uint8_t>& own = snapshot.vehicles[i].extra;
    ByteReader beside(own.data(), own.data() + own.size());
    if (!vehicles_[i]->restoreBeside(isPlain() ? in : beside)) return foreign;
  }
  if (const Problems problems = fleet_.restore(snapshot); !problems.empty()) return refused(problems);
  reset_step_ = fleet_.stepCount() - ticks;
  for (const auto& vehicle : vehicles_) vehicle->wasRestored();
  clock_.skip(fleet_.stepCount());
  // A lockstep state that was saved between two commands goes on to the next; one that waited for a command waits on.
  if (!state_event_.dueAt(ticks)) release_wait_ = true;
  if (ready_publisher_ && announced_ready_) publishReady(true);
  if (fleet_.size() > 0) options_.friction_scale = fleet_.vehicle(0).frictionScale();
  running_parameters_.refresh();
  const std::string message = "restored" + atTime(fleet_.time());
  ROS_INFO("restore_state: %s", message.c_str());
  return {true, message};
}

Outcome SimulatorNode::spawn(const SpawnOrder& wanted) {
  std::vector<std::string> taken;
  for (const auto& vehicle : vehicles_) taken.push_back(vehicle->name());
  if (const std::string refusal = nameRefusal(wanted.name, taken); !refusal.empty())
    return {false, "name: '" + wanted.name + "' " + refusal};
  if (!std::isfinite(wanted.x + wanted.y + wanted.yaw)) return {false, "x, y and yaw must be finite"};
  if (askMaster(kPatience) != Answer::kCame) return noMaster();

  Problems problems;
  std::vector<std::string> notes;
  VehicleRequest request;
  request.name = wanted.name;
  request.urdf = wanted.urdf;
  request.start = WorldStart{wanted.x, wanted.y, wanted.yaw};
  request.sources = {{"~", common_}};
  Loaded<ParameterValues> own = readParameterText(wanted.parameters, "parameters");
  append(own.problems, problems);
  if (own) request.sources.push_back({"parameters: ", std::move(*own.value)});
  if (!wanted.vehicle.empty()) request.sources.push_back({"vehicle: ", {{"vehicle_file", ParameterValue(wanted.vehicle)}}});
  // A URDF of its own does not belong to the common file.
  if (!wanted.urdf.empty() && wanted.vehicle.empty()) request.sources.front().values.erase("vehicle_file");

  const ros::NodeHandle nh(nh_, wanted.name);
  DescribedVehicle described = describeVehicle(nh, request, problems, notes);
  std::optional<VehicleSetup> setup;
  if (described.complete && problems.empty())
    setup = setUpVehicle(request, std::move(described), terrain_, world_start_, problems, notes);
  if (setup && fleet_.size() == 0 && setup->simulator.config().dt != dt_)
    problems.push_back({"dt", "is " + std::to_string(setup->simulator.config().dt) + " s; the node was started with " +
                                  std::to_string(dt_) + " s, which its clock keeps"});
  if (setup && problems.empty()) append(addToFleet(*setup, fleet_), problems);
  clock_.skip(fleet_.stepCount());
  if (!problems.empty() || !setup) {
    nh_.deleteParam(wanted.name + "/robot_description");
    return refused(problems);
  }
  for (const std::string& note : notes) ROS_INFO("%s: %s", wanted.name.c_str(), note.c_str());
  setup->options.friction_scale = options_.friction_scale;
  std::optional<RunRecorder> recorder =
      openRecord(*setup, fleet_.vehicle(fleet_.size() - 1), world_files_, problems);
  for (const Problem& problem : problems) ROS_WARN("no record: %s", problem.text().c_str());
  addVehicle(std::move(*setup), std::move(recorder));
  if (!ready_publisher_ && !isPlain() && vehicles_.front()->name() != "")
    ready_publisher_ = nh_.advertise<std_msgs::Bool>("ready", 1, true);
  const std::string message = "'" + wanted.name + "' is there" + atTime(fleet_.time());
  ROS_INFO("spawn: %s", message.c_str());
  return {true, message};
}

Outcome SimulatorNode::remove(const std::string& name) {
  const auto found = std::find_if(vehicles_.begin(), vehicles_.end(), [&name](const auto& v) { return v->name() == name; });
  if (found == vehicles_.end() || name.empty()) {
    std::string known;
    for (const auto& vehicle : vehicles_)
      if (!vehicle->name().empty()) known += (known.empty() ? "" : ", ") + vehicle->name();
    return {false, "there is no vehicle '" + name + "'; there are: " + (known.empty() ? "none with a name" : known)};
  }
  if (askMaster(kPatience) != Answer::kCame) return noMaster();
  // Its last word, deleting its markers, goes out yet.
  for (const ros::Publisher& publisher : (*found)->leave())
    leaving_.emplace_back(ros::WallTime::now() + ros::WallDuration(1.0), publisher);
  (*found)->finish("removed" + atTime(fleet_.time()));
  vehicles_.erase(found);
  fleet_.remove(name);
  nh_.deleteParam(name + "/robot_description");
  const std::string message = "'" + name + "' is gone" + atTime(fleet_.time());
  ROS_INFO("remove: %s", message.c_str());
  return {true, message};
}

}  // namespace ellipsoid_vehicle_sim
