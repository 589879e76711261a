#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/geometry/problem.h"
#include "ellipsoid_vehicle_sim/scene/run_record.h"
#include "ellipsoid_vehicle_sim/vehicle/simulator.h"

namespace ellipsoid_vehicle_sim {

/// What a run of the node leaves behind in a folder: run.csv (see RunTable) and manifest.yaml (see RunManifest). The
/// manifest is there from the start, so that a run that is killed has one too; its result is then "running".
class RunRecorder {
 public:
  /// Makes the folder if it is not there and opens the files. `every` ticks a line is written. Problems: the path is
  /// not absolute (a node runs in a folder that nobody thinks of), holds a run already, or cannot be written.
  static Loaded<RunRecorder> create(const std::string& folder, std::int64_t every, RunManifest manifest,
                                    const Simulator& simulator);

  /// Call after every step, with the wall time it took [s].
  void add(const Simulator& simulator, double step_time);
  /// Writes the rest. Problems: the disk took not all of it.
  Problems finish(const Simulator& simulator, const std::string& result);

 private:
  RunRecorder(std::string folder, RunTable table, RunManifest manifest);
  Problems writeManifestFile(const Simulator& simulator) const;

  std::string folder_;
  RunTable table_;
  RunManifest manifest_;
};

}  // namespace ellipsoid_vehicle_sim
