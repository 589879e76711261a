#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ellipsoid_vehicle_sim/ros/node_setup.h"
#include "ellipsoid_vehicle_sim/ros/running_parameters.h"
#include "ellipsoid_vehicle_sim/ros/sim_clock.h"
#include "ellipsoid_vehicle_sim/ros/simulator_services.h"
#include "ellipsoid_vehicle_sim/ros/vehicle_node.h"
#include "ellipsoid_vehicle_sim/ros/world_publisher.h"

namespace ellipsoid_vehicle_sim {

/// Drives a Fleet for ROS: keeps its time, and what belongs to the node as a whole. Single-threaded; all physics is the
/// fleet's, all that belongs to one vehicle is a VehicleNode's.
///
/// Time. Stamps are simulated time and never go back, also over a reset. Nothing is published before the first tick, so
/// no stamp is 0. Events (clock, state, markers) fall on ticks counted from the last reset: what happens after a reset
/// does not depend on when it came.
///
/// Lockstep. After each publication of odom the simulation waits for one command on each lockstep topic of each vehicle.
/// So the run is a function of the sequence of commands alone, whatever the machine's load.
class SimulatorNode : private SimulationControl, private VehicleHost {
 public:
  SimulatorNode(ros::NodeHandle nh, ros::NodeHandle nh_priv, NodeSetup setup);

  /// Until shut down, or the parameter `duration` is over. The process's exit code.
  int run();

 private:
  /// Something to do every `period` ticks.
  struct Event {
    double rate = 0.0;  ///< as asked for [Hz].
    std::int64_t period = 1;
    bool dueAt(std::int64_t ticks_since_reset) const { return ticks_since_reset % period == 0; }
  };

  void setEvent(Event& event, const char* key, double rate) const;
  void setEvents();
  void applyRunningParameters();

  // The loop.
  void runOnce();
  std::int64_t ticksPerWakeUp() const;
  std::int64_t ticksToNextEvent() const;
  void advance(std::int64_t ticks);
  void publishDue();
  void awaitCommand();
  bool allCommandsAreThere() const;
  std::string missingCommands() const;
  void serveCallbacks(double longest_wait);
  void returnMemory();
  bool finished() const;
  void reportEvents();
  int finish();

  void publishReady(bool ready);
  void publishDiagnostics();
  /// Ticks are counted anew, nobody waits on, the clock does not catch up.
  void timeStartsAgain();
  void addVehicle(VehicleSetup setup, std::optional<RunRecorder> recorder);
  /// Of the last vehicle that came.
  void mountLidars(ros::NodeHandle nh);
  void publishLidars(std::int64_t ticks, const ros::Time& stamp);

  // SimulationControl.
  Outcome reset() override;
  Outcome pause() override;
  Outcome resume() override;
  Outcome advanceBy(std::int64_t ticks) override;
  std::vector<std::uint8_t> saveState() override;
  Outcome restoreState(const std::vector<std::uint8_t>& bytes, const std::string& where) override;
  Outcome spawn(const SpawnOrder& request) override;
  Outcome remove(const std::string& name) override;
  std::uint64_t stateHash() const override { return fleet_.stateHash(); }
  ros::Time now() const override { return clock_.stamp(fleet_.stepCount()); }
  // VehicleHost.
  double simulatedTime() const override { return fleet_.time(); }
  void wasPut(const std::string& name) override;

  /// One vehicle without a name: all is as it is without fleets.
  bool isPlain() const { return vehicles_.size() == 1 && vehicles_.front()->name().empty(); }
  std::int64_t ticksSinceReset() const { return fleet_.stepCount() - reset_step_; }
  bool running() const { return fleet_.status() == StepStatus::kOk; }

  ros::NodeHandle nh_, nh_priv_;
  NodeOptions options_;
  double dt_;
  std::shared_ptr<const Terrain> terrain_;
  WorldStart world_start_;
  std::vector<std::string> world_files_;
  ParameterValues common_;
  Fleet fleet_;
  SimClock clock_;
  std::vector<std::unique_ptr<VehicleNode>> vehicles_;
  WorldPublisher world_;
  std::shared_ptr<const RayCaster> caster_;  ///< of all lidars; null until the first.
  ros::Publisher static_tf_publisher_;       ///< frames of lidars.
  ros::Publisher ready_publisher_;  ///< of all; where vehicles have names.
  ros::Publisher diagnostics_publisher_;
  Event clock_event_, state_event_, imu_event_, marker_event_, diagnostics_event_, distance_event_;
  std::deque<std::pair<ros::WallTime, ros::Publisher>> leaving_;  ///< of removed vehicles, until their last word is out.

  std::int64_t reset_step_ = 0;  ///< ticks made when the vehicles last stood at their start.
  bool paused_ = false;
  bool waiting_ = false;       ///< for a command, in lockstep.
  bool release_wait_ = false;  ///< a reset came meanwhile: do not wait on.
  bool announced_ready_ = false;
  std::string failure_;  ///< why the run cannot go on; "" while it can.
  double reported_lost_ = 0.0;  ///< of the clock's lost time [s].
  WallThrottle behind_{5.0}, memory_{2.0};
  WallPacer::Clock::time_point wall_start_{}, last_status_{}, last_answer_{};
  double last_status_time_ = 0.0;  ///< simulated [s].

  // Last: from here on they may be called.
  RunningParameters running_parameters_;
  SimulatorServices services_;
};

}  // namespace ellipsoid_vehicle_sim
