#include "ellipsoid_vehicle_sim/ros/simulator_services.h"

#include <ros/console.h>

#include <cerrno>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "ellipsoid_vehicle_sim/ros/conversions.h"
#include "ellipsoid_vehicle_sim/world/file_bytes.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr std::uint32_t kMostSteps = 10000000;  // a client that asks for more has made a mistake

const char* featureName(Feature feature) {
  if (feature == Feature::kNone) return "none";
  if (feature == Feature::kFace) return "face";
  return feature >= Feature::kVertex0 ? "corner" : "edge";
}

/// Writes a file whole or not at all; "" or the reason.
std::string writeFile(const std::string& path, const std::vector<std::uint8_t>& bytes) {
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

ContactCandidate toCandidate(const CandidateReport& report, const Terrain& terrain) {
  ContactCandidate message;
  message.triangle = report.triangle;
  message.surface = terrain.surface(report.triangle).name;
  const Triangle triangle = terrain.triangle(report.triangle);
  for (std::size_t i = 0; i < 3; ++i) message.corners[i] = toPoint(triangle.v[i]);
  message.rank = report.rank;
  message.touches = static_cast<bool>(report.alone);
  message.admitted = report.admitted;
  message.feature = featureName(report.alone.feature);
  message.plane_depth = report.plane_depth;
  message.depth = report.alone.depth;
  message.normal = toVector(report.alone.nhat_W);
  message.reason = report.reason;
  return message;
}

std::string summaryOf(const ContactExplanation& explanation, const std::string& name) {
  char text[300];
  if (explanation.contacts.empty()) {
    std::snprintf(text, sizeof text, "'%s' touches nothing; %zu triangles are near", name.c_str(),
                  explanation.candidates.size());
    return text;
  }
  const ContactReport& first = explanation.contacts.front();
  std::snprintf(text, sizeof text,
                "'%s' is pushed by triangle %d: %.4g mm deep, normal force %.4g N, friction %.4g N, %s", name.c_str(),
                first.triangle, 1e3 * first.depth, first.normal_force, first.friction_W.norm(),
                first.sliding ? "slipping" : "sticking");
  return text;
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
  servers_.push_back(nh_priv.advertiseService("set_pose", &SimulatorServices::onSetPose, this));
  servers_.push_back(nh_priv.advertiseService("save_state", &SimulatorServices::onSaveState, this));
  servers_.push_back(nh_priv.advertiseService("restore_state", &SimulatorServices::onRestoreState, this));
  servers_.push_back(nh_priv.advertiseService("explain_contact", &SimulatorServices::onExplainContact, this));
  servers_.push_back(nh_priv.advertiseService("state_hash", &SimulatorServices::onStateHash, this));
  if (options.gazebo_services) {
    serveEmpty(nh, "/gazebo/reset_simulation", &SimulationControl::reset);
    serveEmpty(nh, "/gazebo/reset_world", &SimulationControl::reset);
    serveEmpty(nh, "/gazebo/pause_physics", &SimulationControl::pause);
    serveEmpty(nh, "/gazebo/unpause_physics", &SimulationControl::resume);
  }
  initial_pose_ = nh.subscribe("initialpose", 1, &SimulatorServices::onInitialPose, this);
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

bool SimulatorServices::onSetPose(SetPose::Request& request, SetPose::Response& response) {
  const Placement placement{request.pose.header.frame_id, fromPose(request.pose.pose), fromVector(request.twist.linear),
                            fromVector(request.twist.angular), request.settle != 0};
  const Outcome outcome = control_.put(placement);
  response.success = outcome.success;
  response.message = outcome.message;
  response.pose.header.stamp = control_.now();
  response.pose.header.frame_id = control_.worldFrame();
  response.pose.pose = toPose(control_.simulator().rootPose());
  return true;
}

void SimulatorServices::onInitialPose(const geometry_msgs::PoseWithCovarianceStamped& message) {
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  const Outcome outcome = control_.put({message.header.frame_id, fromPose(message.pose.pose), zero, zero, true});
  if (outcome.success) {
    ROS_INFO("initialpose: %s", outcome.message.c_str());
  } else {
    ROS_WARN("initialpose refused: %s", outcome.message.c_str());
  }
}

bool SimulatorServices::onSaveState(SaveState::Request& request, SaveState::Response& response) {
  response.state = control_.saveState();
  response.hash = hashText(control_.simulator().stateHash());
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
  response.hash = hashText(control_.simulator().stateHash());
  return true;
}

bool SimulatorServices::onStateHash(Trigger::Request&, Trigger::Response& response) {
  response.success = true;
  response.message = hashText(control_.simulator().stateHash());
  return true;
}

bool SimulatorServices::onExplainContact(ExplainContact::Request& request, ExplainContact::Response& response) {
  const Simulator& simulator = control_.simulator();
  std::string known;
  for (std::size_t i = 0; i < simulator.ellipsoids().size(); ++i) {
    const EllipsoidPlacement& ellipsoid = simulator.ellipsoids()[i];
    if (ellipsoid.name == request.ellipsoid) {
      const ContactExplanation explanation = simulator.explainContact(static_cast<int>(i));
      for (const CandidateReport& candidate : explanation.candidates) {
        response.candidates.push_back(toCandidate(candidate, simulator.terrain()));
      }
      for (const ContactReport& contact : explanation.contacts) {
        response.contacts.push_back(
            toContactState(contact, ellipsoid, simulator.terrain().surface(contact.triangle).name));
      }
      response.margin = explanation.margin;
      response.slack = explanation.slack;
      response.message = summaryOf(explanation, ellipsoid.name);
      response.success = true;
      return true;
    }
    known += (known.empty() ? "" : ", ") + ellipsoid.name;
  }
  response.message = "there is no ellipsoid '" + request.ellipsoid + "'; there are: " + known;
  return true;
}

}  // namespace ellipsoid_vehicle_sim
