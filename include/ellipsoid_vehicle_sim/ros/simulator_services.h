#pragma once

#include <ros/node_handle.h>
#include <ros/service_server.h>
#include <std_srvs/Empty.h>
#include <std_srvs/Trigger.h>

#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/Remove.h"
#include "ellipsoid_vehicle_sim/RestoreState.h"
#include "ellipsoid_vehicle_sim/SaveState.h"
#include "ellipsoid_vehicle_sim/Spawn.h"
#include "ellipsoid_vehicle_sim/Step.h"
#include "ellipsoid_vehicle_sim/ros/parameters.h"

namespace ellipsoid_vehicle_sim {

/// Whether something was done, and what is to be said about it.
struct Outcome {
  bool success = false;
  std::string message;
};

/// A vehicle that is asked for.
struct SpawnOrder {
  std::string name, vehicle, urdf, parameters;
  double x = 0.0, y = 0.0, yaw = 0.0;
};

/// What the services ask of whoever runs the simulation. All are called between ticks.
class SimulationControl {
 public:
  virtual ~SimulationControl() = default;
  virtual Outcome reset() = 0;
  virtual Outcome pause() = 0;
  virtual Outcome resume() = 0;
  virtual Outcome advanceBy(std::int64_t ticks) = 0;
  virtual std::vector<std::uint8_t> saveState() = 0;
  virtual Outcome restoreState(const std::vector<std::uint8_t>& bytes, const std::string& where) = 0;
  virtual Outcome spawn(const SpawnOrder& request) = 0;
  virtual Outcome remove(const std::string& name) = 0;
  virtual std::uint64_t stateHash() const = 0;
  virtual ros::Time now() const = 0;
};

/// The services of the node as a whole.
class SimulatorServices {
 public:
  SimulatorServices(ros::NodeHandle& nh, ros::NodeHandle& nh_priv, const NodeOptions& options,
                    SimulationControl& control);

 private:
  using Trigger = std_srvs::Trigger;
  using Empty = std_srvs::Empty;

  void serveTrigger(ros::NodeHandle& nh, const std::string& name, Outcome (SimulationControl::*action)());
  void serveEmpty(ros::NodeHandle& nh, const std::string& name, Outcome (SimulationControl::*action)());
  bool onStep(Step::Request& request, Step::Response& response);
  bool onSaveState(SaveState::Request& request, SaveState::Response& response);
  bool onRestoreState(RestoreState::Request& request, RestoreState::Response& response);
  bool onStateHash(Trigger::Request& request, Trigger::Response& response);
  bool onSpawn(Spawn::Request& request, Spawn::Response& response);
  bool onRemove(Remove::Request& request, Remove::Response& response);

  SimulationControl& control_;
  std::vector<ros::ServiceServer> servers_;
};

/// "0x" and 16 digits.
std::string hashText(std::uint64_t hash);

}  // namespace ellipsoid_vehicle_sim
