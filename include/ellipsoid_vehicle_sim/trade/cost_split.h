#pragma once

#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/scene/scene.h"

namespace ellipsoid_vehicle_sim {

/// Where the time of a step goes: its parts repeated by themselves at states along a scene, as often as a step asks for
/// them. Shares of the whole step [-]; what the parts do not explain is integration (states moved, copied, remembered).
struct CostSplit {
  std::string scene, integrator;
  double dt = 0.0;
  double step = 0.0;  ///< CPU time of a step [s].
  double collision = 0.0, force = 0.0, dynamics = 0.0, integration = 0.0;
};

/// Of semi_implicit_euler and rk4 at 1 ms, whose evaluations per step are known beforehand; empty where the scene does not
/// start. `budget`: CPU time to spend, about [s].
std::vector<CostSplit> splitCost(const LoadedScene& scene, double budget);

/// cost_split.csv.
std::string costSplitCsv(const std::vector<CostSplit>& splits);

}  // namespace ellipsoid_vehicle_sim
