#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/ros/command_input.h"
#include "ellipsoid_vehicle_sim/ros/contact_publisher.h"
#include "ellipsoid_vehicle_sim/ros/node_setup.h"
#include "ellipsoid_vehicle_sim/ros/run_recorder.h"
#include "ellipsoid_vehicle_sim/ros/run_statistics.h"
#include "ellipsoid_vehicle_sim/ros/running_parameters.h"
#include "ellipsoid_vehicle_sim/ros/sim_clock.h"
#include "ellipsoid_vehicle_sim/ros/simulator_services.h"
#include "ellipsoid_vehicle_sim/ros/state_publisher.h"

namespace ellipsoid_vehicle_sim {

/// Drives a Simulator for ROS: commands in, state out, time kept. Single-threaded; all physics is the simulator's.
///
/// Time. Stamps are simulated time and never go back, also over a reset. Nothing is published before the first tick, so
/// no stamp is 0. Events (clock, state, markers) fall on ticks counted from the last reset: what happens after a reset
/// does not depend on when it came.
///
/// Lockstep. After each publication of odom the simulation waits for one command on each lockstep topic. So the run is
/// a function of the sequence of commands alone, whatever the machine's load.
class SimulatorNode : private SimulationControl {
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
  void serveCallbacks(double longest_wait);
  bool finished() const;
  void reportEvents();
  int finish();

  void publishReady(bool ready);
  void publishDiagnostics();
  void startAgain();

  // SimulationControl.
  Outcome reset() override;
  Outcome pause() override;
  Outcome resume() override;
  Outcome advanceBy(std::int64_t ticks) override;
  Outcome put(const Placement& placement) override;
  std::vector<std::uint8_t> saveState() override;
  Outcome restoreState(const std::vector<std::uint8_t>& bytes, const std::string& where) override;
  const Simulator& simulator() const override { return simulator_; }
  ros::Time now() const override { return clock_.stamp(simulator_.stepCount()); }
  const std::string& worldFrame() const override { return state_.worldFrame(); }

  std::int64_t ticksSinceReset() const { return simulator_.stepCount() - reset_step_; }
  bool running() const { return simulator_.status() == StepStatus::kOk; }

  NodeOptions options_;
  Simulator simulator_;
  std::string base_frame_;
  SimClock clock_;
  StatePublisher state_;
  ContactPublisher contacts_;
  CommandInput commands_;
  ros::Publisher ready_publisher_, diagnostics_publisher_;
  Event clock_event_, state_event_, imu_event_, marker_event_, diagnostics_event_, distance_event_;
  RunStatistics statistics_;
  std::optional<RunRecorder> recorder_;

  std::int64_t reset_step_ = 0;  ///< ticks made when the vehicle last stood at its start.
  bool paused_ = false;
  bool waiting_ = false;       ///< for a command, in lockstep.
  bool release_wait_ = false;  ///< a reset came meanwhile: do not wait on.
  bool announced_ready_ = false;
  bool ready_ = false;   ///< as last published.
  std::string failure_;  ///< why the run cannot go on; "" while it can.
  StepEvents reported_events_;
  double reported_lost_ = 0.0;  ///< of the clock's lost time [s].
  WallThrottle behind_{5.0}, effort_{5.0};
  WallPacer::Clock::time_point wall_start_{}, last_status_{}, last_answer_{};
  double last_status_time_ = 0.0;  ///< simulated [s].

  // Last: from here on they may be called.
  RunningParameters running_parameters_;
  SimulatorServices services_;
};

}  // namespace ellipsoid_vehicle_sim
