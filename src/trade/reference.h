#pragma once

#include <string>

#include "ellipsoid_vehicle_sim/trade/study.h"

namespace ellipsoid_vehicle_sim {

/// The finest run of a model that a budget pays for, which others are compared with.
struct Reference {
  Setting model;
  MeasuredPath path;
  double error = 0.0;   ///< distance from the next coarser one, within the horizon [m]; NaN where there is none.
  std::string reason;   ///< why there is none.
  bool usable = false;
};

/// `budget`: CPU time, about [s]. Integrator and step of `model` are replaced by those of the reference.
Reference makeReference(const LoadedScene& scene, Setting model, double budget);

/// CPU time of a tick, from a short run [s]; 0 where it does not start.
double tickCost(const LoadedScene& scene, const Setting& setting);

}  // namespace ellipsoid_vehicle_sim
