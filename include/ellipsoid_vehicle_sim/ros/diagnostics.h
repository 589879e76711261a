#pragma once

#include <diagnostic_msgs/DiagnosticStatus.h>

#include <cstdint>
#include <string>

#include "ellipsoid_vehicle_sim/ros/run_statistics.h"
#include "ellipsoid_vehicle_sim/vehicle/simulator.h"

namespace ellipsoid_vehicle_sim {

/// What the node knows beside the simulator and its statistics.
struct RunFacts {
  std::string node;      ///< its name.
  std::string hardware;  ///< what the status is about: the root link.
  bool paused = false;
  bool waiting = false;          ///< for a command, in lockstep.
  double recent_factor = 0.0;    ///< simulated over wall time since the last status.
  double mean_factor = 0.0;      ///< since the start.
  double lost = 0.0;             ///< wall time given up by falling behind [s].
  std::int64_t clock_jumps = 0;  ///< of a followed clock.
  std::int64_t dropped_commands = 0;
  std::string last_refusal;  ///< of a command; "" without.
};

/// One status: level and one sentence, then the numbers.
diagnostic_msgs::DiagnosticStatus diagnosticStatus(const Simulator& simulator, const RunStatistics& statistics,
                                                   const RunFacts& facts);

}  // namespace ellipsoid_vehicle_sim
