#pragma once

#include <diagnostic_msgs/DiagnosticStatus.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/ros/command_input.h"
#include "ellipsoid_vehicle_sim/ros/contact_publisher.h"
#include "ellipsoid_vehicle_sim/ros/diagnostics.h"
#include "ellipsoid_vehicle_sim/ros/lidar_publisher.h"
#include "ellipsoid_vehicle_sim/ros/run_recorder.h"
#include "ellipsoid_vehicle_sim/ros/run_statistics.h"
#include "ellipsoid_vehicle_sim/ros/state_publisher.h"
#include "ellipsoid_vehicle_sim/ros/vehicle_services.h"
#include "ellipsoid_vehicle_sim/fleet/fleet.h"

namespace ellipsoid_vehicle_sim {

/// What a vehicle asks of the node that it is part of.
class VehicleHost {
 public:
  virtual ~VehicleHost() = default;
  virtual ros::Time now() const = 0;
  virtual double simulatedTime() const = 0;
  /// The vehicle was put somewhere by a service.
  virtual void wasPut(const std::string& name) = 0;
};

/// One vehicle for ROS: its commands in, its state out, its services. Time is the node's.
class VehicleNode : private VehicleControl {
 public:
  /// The vehicle is in the fleet already. nh and nh_priv: its own name spaces.
  VehicleNode(ros::NodeHandle nh, ros::NodeHandle nh_priv, VehicleSetup setup, std::optional<RunRecorder> recorder,
              Fleet& fleet, VehicleHost& host);

  const std::string& name() const { return name_; }  ///< "": the only one, without a name space.
  const std::string& baseFrame() const { return base_frame_; }
  const Simulator& simulator() const override { return simulator_; }
  Simulator& simulator() { return simulator_; }
  CommandInput& commands() { return commands_; }
  ContactPublisher& contacts() { return contacts_; }
  RunStatistics& statistics() { return statistics_; }

  bool carriesLidars() const { return !options_.lidars.empty(); }
  /// `nh`: the vehicle's name space; `caster`: of the world.
  void mountLidars(ros::NodeHandle nh, std::shared_ptr<const RayCaster> caster);
  std::optional<LidarPublisher>& lidars() { return lidars_; }  ///< none unless mounted.
  /// What others see of it, where it is now.
  void appendEllipsoids(std::vector<PosedEllipsoid>& out) { appendPosedEllipsoids(simulator_, link_poses_, out); }

  /// A tick of the node took so long.
  void addTick(std::chrono::nanoseconds duration);
  void addPosition() { statistics_.addPosition(simulator_.rootPose().p); }
  void publishImu(const ros::Time& stamp, std::int64_t sample) { state_.publishImu(stamp, sample); }
  /// Contacts, then what lockstep commanders answer.
  void publishState(const ros::Time& stamp);
  void publishReady(bool ready);
  bool announcedReady() const { return announced_ready_; }
  bool ready() const { return ready_; }
  diagnostic_msgs::DiagnosticStatus status(RunFacts facts) const;
  void reportEvents();

  /// Everything beside the simulator's state starts anew.
  void startAgain();
  void saveBeside(ByteWriter& out) const;
  /// Reads what saveBeside wrote; false, and nothing changed but by a later call to take: it did not.
  bool restoreBeside(ByteReader& in);
  void wasRestored();

  /// How the run ended for this vehicle: "ok", or what went wrong.
  std::string result() const;
  void finish(const std::string& result);
  /// Deletes its markers; what is returned has to live until that has gone out.
  std::vector<ros::Publisher> leave() { return contacts_.leave(); }

 private:
  // VehicleControl.
  Outcome put(const Placement& placement) override;
  Outcome resetVehicle() override;
  const Fleet& fleet() const override { return fleet_; }
  ros::Time now() const override { return host_.now(); }
  const std::string& worldFrame() const override { return state_.worldFrame(); }

  std::string name_;
  NodeOptions options_;
  Fleet& fleet_;
  Simulator& simulator_;
  VehicleHost& host_;
  std::string base_frame_;
  StatePublisher state_;
  ContactPublisher contacts_;
  LinkPoses link_poses_;
  std::optional<LidarPublisher> lidars_;
  CommandInput commands_;
  ros::Publisher ready_publisher_;
  RunStatistics statistics_;
  std::optional<RunRecorder> recorder_;
  bool announced_ready_ = false;
  bool ready_ = false;  ///< as last published.
  StepEvents reported_events_;
  WallThrottle effort_{5.0};
  // Last: from here on they may be called.
  VehicleServices services_;
};

}  // namespace ellipsoid_vehicle_sim
