#include "ellipsoid_vehicle_sim/ros/simulator_services.h"

#include <cerrno>
#include <cinttypes>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "ellipsoid_vehicle_sim/world/file_bytes.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr std::uint32_t kMostSteps = 10000000;  // a client that asks for more has made a mistake

/// Writes a file whole or not at all; "" or the reason.
std::string writeFile(const std::string& path, const std::vector<std::uint8_t>& bytes) {
  // The file is put in place of what is there, which must not be a device or a folder.
  std::error_code unknown;
  if (std::filesystem::exists(path, unknown) && !std::filesystem::is_regular_file(path, unknown))
    return "'" + path + "' cannot be written: it is no file";
  const std::string unfinished = path + ".part";
  std::ofstream out(unfinished, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  out.close();
  std::error_code error;
  if (out) std::filesystem::rename(unfinished, path, error);
  if (out && !error) return "";
  return "'" + path + "' cannot be written: " + (error ? error.message() : std::strerror(errno));
}

std::string readFile(const std::string& path, std::vector<std::uint8_t>& bytes) {
  const Loaded<std::string> read = readFileBytes(path, "state", kLargestXmlFile);
  if (read) bytes.assign(read.value->begin(), read.value->end());
  return read ? "" : "'" + path + "' " + read.problems.front().message;
}

}  // namespace

std::string hashText(std::uint64_t hash) {
  char text[24];
  std::snprintf(text, sizeof text, "0x%016" PRIx64, hash);
  return text;
}

SimulatorServices::SimulatorServices(ros::NodeHandle& nh, ros::NodeHandle& nh_priv, const NodeOptions& options,
                                     SimulationControl& control)
    : control_(control) {
  serveTrigger(nh_priv, "reset", &SimulationControl::reset);
  serveTrigger(nh_priv, "pause", &SimulationControl::pause);
  serveTrigger(nh_priv, "resume", &SimulationControl::resume);
  servers_.push_back(nh_priv.advertiseService("step", &SimulatorServices::onStep, this));
  servers_.push_back(nh_priv.advertiseService("save_state", &SimulatorServices::onSaveState, this));
  servers_.push_back(nh_priv.advertiseService("restore_state", &SimulatorServices::onRestoreState, this));
  servers_.push_back(nh_priv.advertiseService("spawn", &SimulatorServices::onSpawn, this));
  servers_.push_back(nh_priv.advertiseService("remove", &SimulatorServices::onRemove, this));
  servers_.push_back(nh_priv.advertiseService("state_hash", &SimulatorServices::onStateHash, this));
  if (options.gazebo_services) {
    serveEmpty(nh, "/gazebo/reset_simulation", &SimulationControl::reset);
    serveEmpty(nh, "/gazebo/reset_world", &SimulationControl::reset);
    serveEmpty(nh, "/gazebo/pause_physics", &SimulationControl::pause);
    serveEmpty(nh, "/gazebo/unpause_physics", &SimulationControl::resume);
  }
}

void SimulatorServices::serveTrigger(ros::NodeHandle& nh, const std::string& name,
                                     Outcome (SimulationControl::*action)()) {
  const boost::function<bool(Trigger::Request&, Trigger::Response&)> callback =
      [this, action](Trigger::Request&, Trigger::Response& response) {
        const Outcome outcome = (control_.*action)();
        response.success = outcome.success;
        response.message = outcome.message;
        return true;
      };
  servers_.push_back(nh.advertiseService(name, callback));
}

void SimulatorServices::serveEmpty(ros::NodeHandle& nh, const std::string& name,
                                   Outcome (SimulationControl::*action)()) {
  const boost::function<bool(Empty::Request&, Empty::Response&)> callback =
      [this, action](Empty::Request&, Empty::Response&) { return (control_.*action)().success; };
  servers_.push_back(nh.advertiseService(name, callback));
}

bool SimulatorServices::onStep(Step::Request& request, Step::Response& response) {
  Outcome outcome;
  if (request.steps == 0 || request.steps > kMostSteps) {
    outcome.message = "steps: '" + std::to_string(request.steps) + "' is out of range, allowed is 1 ... " +
                      std::to_string(kMostSteps);
  } else {
    outcome = control_.advanceBy(request.steps);
  }
  response.success = outcome.success;
  response.message = outcome.message;
  response.stamp = control_.now();
  return true;
}

bool SimulatorServices::onSaveState(SaveState::Request& request, SaveState::Response& response) {
  response.state = control_.saveState();
  response.hash = hashText(control_.stateHash());
  if (!request.file.empty()) response.message = writeFile(request.file, response.state);
  response.success = response.message.empty();
  return true;
}

bool SimulatorServices::onRestoreState(RestoreState::Request& request, RestoreState::Response& response) {
  std::vector<std::uint8_t> bytes = request.state;
  if (request.file.empty() == request.state.empty()) {
    response.message = "give either a state or a file";
  } else if (!request.file.empty()) {
    response.message = readFile(request.file, bytes);
  }
  if (response.message.empty()) {
    const Outcome outcome = control_.restoreState(bytes, request.file.empty() ? "the state" : "'" + request.file + "'");
    response.success = outcome.success;
    response.message = outcome.message;
  }
  response.hash = hashText(control_.stateHash());
  return true;
}

bool SimulatorServices::onStateHash(Trigger::Request&, Trigger::Response& response) {
  response.success = true;
  response.message = hashText(control_.stateHash());
  return true;
}

bool SimulatorServices::onSpawn(Spawn::Request& request, Spawn::Response& response) {
  const Outcome outcome = control_.spawn({request.name, request.vehicle, request.urdf, request.parameters, request.x, request.y, request.yaw});
  response.success = outcome.success;
  response.message = outcome.message;
  return true;
}

bool SimulatorServices::onRemove(Remove::Request& request, Remove::Response& response) {
  const Outcome outcome = control_.remove(request.name);
  response.success = outcome.success;
  response.message = outcome.message;
  return true;
}

}  // namespace ellipsoid_vehicle_sim
