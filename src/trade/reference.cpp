#include "reference.h"

#include <algorithm>
#include <limits>

namespace ellipsoid_vehicle_sim {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// Steps a reference may have, finest first [s]; each divides kPathInterval.
constexpr double kReferenceSteps[] = {1e-6, 2e-6, 5e-6, 1e-5, 2e-5, 5e-5, 1e-4, 2e-4, 5e-4, 1e-3};

/// The most exact of the integrators at small steps: contact events located where that exists.
std::string referenceIntegrator() {
  const std::vector<std::string> known = knownIntegrators();
  for (const char* name : {"rk4_events", "rk4"})
    if (std::find(known.begin(), known.end(), name) != known.end()) return name;
  return "semi_implicit_euler";
}

}  // namespace

double tickCost(const LoadedScene& loaded, const Setting& setting) {
  LoadedScene shorter = loaded;
  shorter.scene.duration = std::min(loaded.scene.duration, 200.0 * setting.dt);
  MeasureOptions options;
  options.errors = false;
  options.repeat_budget = 0.0;
  const MeasuredRun run = measureRun(shorter, configAt(loaded.scene, setting), options);
  return run.finished ? run.cost.least * setting.dt : 0.0;
}

Reference makeReference(const LoadedScene& loaded, Setting model, double budget) {
  Reference reference;
  reference.error = kNaN;
  model.integrator = referenceIntegrator();
  model.dt = 1e-3;
  reference.model = model;
  const double cost = tickCost(loaded, model);
  if (!(cost > 0.0)) {
    reference.reason = "the model does not start";
    return reference;
  }
  std::size_t step = 0;
  while (step + 2 < std::size(kReferenceSteps) && loaded.scene.horizon / kReferenceSteps[step] * cost > budget) ++step;
  LoadedScene to_horizon = loaded;
  to_horizon.scene.duration = loaded.scene.horizon;
  MeasureOptions options;
  options.errors = false;
  options.repeat_budget = 0.0;
  model.dt = kReferenceSteps[step];
  MeasuredRun finest = measureRun(to_horizon, configAt(loaded.scene, model), options);
  model.dt = kReferenceSteps[step + 1];
  const MeasuredRun coarser = measureRun(to_horizon, configAt(loaded.scene, model), options);
  if (!finest.finished || !coarser.finished) {
    reference.reason = finest.finished ? coarser.reason : finest.reason;
    return reference;
  }
  reference.model.dt = kReferenceSteps[step];
  reference.error = pathError(coarser.path, finest.path, loaded.scene.horizon).largest;
  reference.path = std::move(finest.path);
  reference.usable = true;
  return reference;
}

}  // namespace ellipsoid_vehicle_sim
