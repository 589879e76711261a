#pragma once

#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/trade/study.h"

namespace ellipsoid_vehicle_sim {

/// What a study was made with, for whoever reads its numbers later.
struct StudyRecord {
  std::string result = "finished";  ///< or what ended it.
  std::string extent;               ///< quick, normal or full.
  StudyBudget budget;
  int jobs = 1;
  double wall_time = 0.0;                      ///< [s].
  double load_before = 0.0, load_after = 0.0;  ///< runnable processes, mean of a minute.
  std::vector<LoadedScene> scenes;
  std::vector<std::string> peers;  ///< "MuJoCo 2.2.2", "Bullet: not found when this was built".
};

/// Build, machine, extent, and the scenes with their horizons and the hashes of their files; the spread of the repeats
/// from the rows. Problem: the file cannot be written.
Problems writeStudyManifest(const std::string& path, const StudyRecord& record, const std::vector<StudyRow>& rows);

}  // namespace ellipsoid_vehicle_sim
