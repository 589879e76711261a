#pragma once

#include <geometry_msgs/Twist.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/service_server.h>
#include <ros/subscriber.h>
#include <sensor_msgs/JointState.h>
#include <std_srvs/Trigger.h>

#include <chrono>
#include <cstdint>
#include <deque>
#include <set>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/ros/contact_markers.h"
#include "ellipsoid_vehicle_sim/ros/node_setup.h"
#include "ellipsoid_vehicle_sim/ros/pacing.h"
#include "ellipsoid_vehicle_sim/ros/run_statistics.h"
#include "ellipsoid_vehicle_sim/ros/world_markers.h"

namespace ellipsoid_vehicle_sim {

/// Drives a Simulator for ROS: commands in, state out, time kept. Single-threaded; all physics is the simulator's.
///
/// Time. Stamps are simulated time and never go back, also over a reset. Nothing is published before the first tick, so
/// no stamp is 0. Events (clock, state, markers) fall on ticks counted from the last reset: what happens after a reset
/// does not depend on when it came.
///
/// Lockstep. After each publication of odom the simulation waits for one command; commands are taken in the order they
/// came, one a period. So the run is a function of the sequence of commands alone, whatever the machine's load.
/// odom is latched then: a commander that comes late still gets the message it has to answer.
class SimulatorNode {
 public:
  SimulatorNode(ros::NodeHandle nh, ros::NodeHandle nh_priv, NodeSetup setup);

  /// Until shut down, or the parameter `duration` is over. The process's exit code.
  int run();

 private:
  /// Something to do every `period` ticks.
  struct Event {
    std::int64_t period = 1;
    bool dueAt(std::int64_t ticks_since_reset) const { return ticks_since_reset % period == 0; }
  };

  /// Says so if the rate has to be rounded to whole ticks.
  Event eventAt(const char* key, double rate) const;
  void advertise();

  // The loop.
  void runOnce();
  std::int64_t ticksDue();
  std::int64_t ticksPerWakeUp() const;
  std::int64_t ticksToNextEvent() const;
  void advance(std::int64_t ticks);
  void publishDue();
  void awaitCommand();
  void serveCallbacks(double longest_wait);
  bool finished() const;
  void reportEvents();
  int finish();

  // Messages.
  ros::Time stamp() const;
  void publishClock();
  void publishState();
  void publishMarkers();
  void publishReady(bool ready);
  void publishDiagnostics();

  // Callbacks.
  void onCommand(const geometry_msgs::Twist& twist);
  bool onReset(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);

  std::int64_t ticksSinceReset() const { return simulator_.stepCount() - reset_step_; }
  bool running() const { return simulator_.status() == StepStatus::kOk; }

  ros::NodeHandle nh_, nh_priv_;
  NodeOptions options_;
  ContactMarkers contact_markers_;
  WorldMarkers world_markers_;
  Simulator simulator_;
  std::string base_frame_;
  std::set<std::string> drawn_links_;

  ros::Publisher clock_publisher_, tf_publisher_, odom_publisher_, joint_publisher_, contact_publisher_,
      shape_publisher_, world_publisher_, ready_publisher_, diagnostics_publisher_;
  ros::Subscriber command_subscriber_;
  ros::ServiceServer reset_server_;

  Event clock_event_, state_event_, marker_event_, diagnostics_event_, distance_event_;
  WallPacer pacer_;
  RunStatistics statistics_;

  ros::Time time_origin_;        ///< stamp of simulated time zero.
  std::int64_t reset_step_ = 0;  ///< ticks made when the vehicle last stood at its start.
  bool announced_ready_ = false;
  bool ready_ = false;  ///< as last published.
  std::int64_t dropped_commands_ = 0;
  WallPacer::Clock::time_point last_drop_warning_{};
  double reported_lost_ = 0.0;  ///< of the pacer's lost time [s].
  std::string failure_;         ///< why the run cannot go on; "" while it can.
  StepEvents reported_events_;
  std::deque<DriveCommand> waiting_commands_;  ///< lockstep only.
  bool release_wait_ = false;                  ///< a reset came while a command was awaited.
  WallPacer::Clock::time_point wall_start_{};

  // Kept to save their memory from step to step.
  std::vector<ContactReport> contacts_;
  std::vector<JointReading> readings_;
  sensor_msgs::JointState joint_message_;
};

}  // namespace ellipsoid_vehicle_sim
