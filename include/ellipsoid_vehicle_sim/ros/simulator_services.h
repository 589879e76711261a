#pragma once

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <ros/node_handle.h>
#include <ros/service_server.h>
#include <ros/subscriber.h>
#include <std_srvs/Empty.h>
#include <std_srvs/Trigger.h>

#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/ExplainContact.h"
#include "ellipsoid_vehicle_sim/RestoreState.h"
#include "ellipsoid_vehicle_sim/SaveState.h"
#include "ellipsoid_vehicle_sim/SetPose.h"
#include "ellipsoid_vehicle_sim/Step.h"
#include "ellipsoid_vehicle_sim/ros/parameters.h"
#include "ellipsoid_vehicle_sim/vehicle/simulator.h"

namespace ellipsoid_vehicle_sim {

/// Whether something was done, and what is to be said about it.
struct Outcome {
  bool success = false;
  std::string message;
};

/// Where the vehicle is to be put.
struct Placement {
  std::string frame;         ///< of pose; empty: the world's.
  Pose pose;                 ///< of the root link.
  Eigen::Vector3d v_R, w_R;  ///< its velocities in its own axes [m/s], [rad/s].
  bool settle = true;        ///< at rest on the ground below, only heading and x, y count.
};

/// What the services ask of whoever runs the simulation. All are called between ticks.
class SimulationControl {
 public:
  virtual ~SimulationControl() = default;
  virtual Outcome reset() = 0;
  virtual Outcome pause() = 0;
  virtual Outcome resume() = 0;
  virtual Outcome advanceBy(std::int64_t ticks) = 0;
  virtual Outcome put(const Placement& placement) = 0;
  virtual std::vector<std::uint8_t> saveState() = 0;
  virtual Outcome restoreState(const std::vector<std::uint8_t>& bytes, const std::string& where) = 0;
  virtual const Simulator& simulator() const = 0;
  virtual ros::Time now() const = 0;
  virtual const std::string& worldFrame() const = 0;
};

/// The services, and initialpose, which is one without a reply.
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
  bool onSetPose(SetPose::Request& request, SetPose::Response& response);
  bool onSaveState(SaveState::Request& request, SaveState::Response& response);
  bool onRestoreState(RestoreState::Request& request, RestoreState::Response& response);
  bool onExplainContact(ExplainContact::Request& request, ExplainContact::Response& response);
  bool onStateHash(Trigger::Request& request, Trigger::Response& response);
  void onInitialPose(const geometry_msgs::PoseWithCovarianceStamped& message);

  SimulationControl& control_;
  std::vector<ros::ServiceServer> servers_;
  ros::Subscriber initial_pose_;
};

/// "0x" and 16 digits.
std::string hashText(std::uint64_t hash);

}  // namespace ellipsoid_vehicle_sim
