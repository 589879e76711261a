#pragma once

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <ros/node_handle.h>
#include <ros/service_server.h>
#include <ros/subscriber.h>
#include <std_srvs/Trigger.h>

#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/ExplainContact.h"
#include "ellipsoid_vehicle_sim/SetPose.h"
#include "ellipsoid_vehicle_sim/ros/simulator_services.h"
#include "ellipsoid_vehicle_sim/fleet/fleet.h"

namespace ellipsoid_vehicle_sim {

/// Where the vehicle is to be put.
struct Placement {
  std::string frame;         ///< of pose; empty: the world's.
  Pose pose;                 ///< of the root link.
  Eigen::Vector3d v_R, w_R;  ///< its velocities in its own axes [m/s], [rad/s].
  bool settle = true;        ///< at rest on the ground below, only heading and x, y count.
};

/// What the services of one vehicle ask of it. All are called between ticks.
class VehicleControl {
 public:
  virtual ~VehicleControl() = default;
  virtual Outcome put(const Placement& placement) = 0;
  virtual Outcome resetVehicle() = 0;
  virtual const Simulator& simulator() const = 0;
  virtual const Fleet& fleet() const = 0;
  virtual ros::Time now() const = 0;
  virtual const std::string& worldFrame() const = 0;
};

/// The services of one vehicle, and initialpose, which is one without a reply. `named`: its own reset besides the node's.
class VehicleServices {
 public:
  VehicleServices(ros::NodeHandle& nh, ros::NodeHandle& nh_priv, bool named, VehicleControl& control);

 private:
  using Trigger = std_srvs::Trigger;

  bool onReset(Trigger::Request& request, Trigger::Response& response);
  bool onStateHash(Trigger::Request& request, Trigger::Response& response);
  bool onSetPose(SetPose::Request& request, SetPose::Response& response);
  bool onExplainContact(ExplainContact::Request& request, ExplainContact::Response& response);
  void onInitialPose(const geometry_msgs::PoseWithCovarianceStamped& message);

  VehicleControl& control_;
  std::vector<ros::ServiceServer> servers_;
  ros::Subscriber initial_pose_;
};

}  // namespace ellipsoid_vehicle_sim
