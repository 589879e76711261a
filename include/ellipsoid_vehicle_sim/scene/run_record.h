#pragma once

#include <cstdint>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/geometry/problem.h"
#include "ellipsoid_vehicle_sim/vehicle/simulator.h"

// What a run leaves behind: a table of the run, and a manifest that says what it was a run of.

namespace ellipsoid_vehicle_sim {

/// Writes a run as CSV, a line per tick (or per `every` ticks), comma separated, one header line, SI units:
///
///     step               ticks since the simulator was made
///     time               step times dt [s]
///     x, y, z            of the root link in the world [m]
///     qx, qy, qz, qw     its rotation
///     vx, vy, vz         velocity of its origin, in the root link's own axes, as in nav_msgs/Odometry [m/s]
///     wx, wy, wz         angular velocity, likewise [rad/s]
///     wheel_speed:NAME   of every wheel, forward positive [rad/s]
///     command            none, coast, twist, ackermann; "expired" once it is older than command_timeout
///     command_speed      [m/s], command_yaw_rate [rad/s], command_steering_angle [rad]
///     penetration        of the deepest contact [m]
///     contacts           how many push
///     normal_force       their normal forces added up [N]
///     energy             kinetic, gravity and springs [J]
///     energy_lost, energy_supplied, energy_unaccounted
///                        EnergyBalance: lost, supplied, error() [J]; only with energy_balance
///     events             what happened since the line before, NAME or NAME=COUNT, separated by blanks: passed_through,
///                        effort_exceeded, command_timeouts, rejected_commands, diverged
///     step_time          wall time of this step [s]; the only column that differs between two runs of the same
///
/// Numbers are written so that reading them gives the same bits.
class RunTable {
 public:
  /// Opens the file and writes the header. Problem: it cannot be written.
  static Loaded<RunTable> create(const std::string& path, const Simulator& simulator, std::int64_t every = 1);

  /// Call after every step (and once before the first, with step_time 0). Lines are written every so many calls; events
  /// of calls in between are kept for the next line.
  void add(const Simulator& simulator, double step_time);
  /// Writes the rest. Problem: the disk took not all of it.
  Problems close();

 private:
  std::string path_;
  std::ofstream out_;
  std::int64_t every_ = 1, calls_ = 0;
  StepEvents told_;
  StepStatus status_told_ = StepStatus::kOk;
  std::vector<ContactReport> contacts_;
  std::string line_;
};

/// What program and machine did it.
struct BuildInfo {
  std::string version;  ///< of the package.
  std::string commit;   ///< of the checkout it was built from, with "-dirty" if it was changed; "unknown" without.
  std::string compiler;
  std::string flags;  ///< build type and optimisation.
};

BuildInfo buildInfo();
/// The processor's name, as /proc/cpuinfo has it; "unknown" without.
std::string machineName();

/// SHA-256 of a file's bytes, in hexadecimal as sha256sum prints it; nullopt where it cannot be read.
std::optional<std::string> fileHash(const std::string& path);

/// What a run was a run of, written as YAML.
struct RunManifest {
  std::string program;                      ///< that ran.
  std::string result;                       ///< "finished", or what ended it.
  std::optional<std::uint64_t> seed;        ///< of the noise, where there is any.
  std::vector<std::string> files;           ///< that were read; written with their hashes.
  std::map<std::string, std::string> more;  ///< anything else, as text.
};

/// Build, machine, integrator, step, every parameter with the value in force, files with hashes, load report. Problem:
/// the file cannot be written.
Problems writeManifest(const std::string& path, const RunManifest& manifest, const Simulator& simulator);

}  // namespace ellipsoid_vehicle_sim
