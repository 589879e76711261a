#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <sstream>

#include "ellipsoid_vehicle_sim/vehicle/accuracy.h"
#include "reference.h"

namespace ellipsoid_vehicle_sim {
namespace {

// The dial promises no more than this much of a run [s].
constexpr double kPromised = 10.0;
const char* const kAsked[] = {"0.1", "fast", "balanced", "0.0001"};

/// Cheapest measured row of the default model that holds the target within its certificate [s/s]; NaN without.
double cheapestCost(const std::vector<StudyRow>& rows, double target) {
  double cheapest = std::numeric_limits<double>::quiet_NaN();
  for (const StudyRow& row : rows) {
    if (row.status != RowStatus::kOk || !row.ownModel() || row.run.beyond_limit) continue;
    if (row.relative_error <= target && !(row.run.cost.least >= cheapest)) cheapest = row.run.cost.least;
  }
  return cheapest;
}

}  // namespace

std::vector<DialRow> studyDial(const LoadedScene& loaded, const StudyBudget& budget, const std::vector<StudyRow>& rows) {
  std::vector<DialRow> dial;
  const Reference reference = makeReference(loaded, Setting{}, budget.reference);
  const double horizon = std::min(loaded.scene.horizon, kPromised);
  for (const char* asked : kAsked) {
    DialRow row;
    row.scene = loaded.scene.name;
    row.accuracy = asked;
    row.target = accuracyTarget(asked).value_or(0.0);
    row.cheapest_cost = cheapestCost(rows, row.target);
    SimConfig config = loaded.scene.config;
    const SimConfig defaults;
    config.integrator = defaults.integrator;
    config.dt = defaults.dt;
    config.contact_substeps = defaults.contact_substeps;
    config.integrator_given = config.dt_given = config.substeps_given = config.allow_unstable = false;
    config.accuracy = asked;
    const Loaded<Simulator> started = startScene(loaded, config);
    if (!started || !reference.usable) {
      row.reason = started ? "no reference: " + reference.reason : problemText(started.problems);
      dial.push_back(row);
      continue;
    }
    row.chosen.integrator = toString(started.value->config().integrator);
    row.chosen.dt = started.value->config().dt;
    row.chosen.substeps = started.value->config().contact_substeps;
    config.accuracy.clear();
    config.integrator = started.value->config().integrator;
    config.dt = started.value->config().dt;
    config.contact_substeps = started.value->config().contact_substeps;
    MeasureOptions options;
    options.errors = false;
    options.repeat_budget = budget.repeats;
    const MeasuredRun run = measureRun(loaded, config, options);
    row.finished = run.finished;
    row.reason = run.reason;
    row.cost = run.cost.least;
    row.error = pathError(run.path, reference.path, horizon).largest / std::max(reference.path.distance(horizon), run.length);
    dial.push_back(row);
  }
  return dial;
}

std::string dialCsv(const std::vector<DialRow>& rows) {
  std::string table = "scene,accuracy,target,integrator,dt,contact_substeps,relative_error,met,cpu_ms_per_s,cheapest_cpu_ms_per_s,affordable\n";
  for (const DialRow& row : rows) {
    char line[320];
    std::snprintf(line, sizeof line, "%s,%s,%g,%s,%g,%g,%.3g,%d,%.4g,", row.scene.c_str(), row.accuracy.c_str(), row.target,
                  row.chosen.integrator.c_str(), row.chosen.dt, row.chosen.substeps, row.error, row.met() ? 1 : 0, 1e3 * row.cost);
    table += line;
    char cheapest[32] = "";
    if (std::isfinite(row.cheapest_cost)) std::snprintf(cheapest, sizeof cheapest, "%.4g", 1e3 * row.cheapest_cost);
    table += std::string(cheapest) + "," + (row.affordable() ? "1" : "0") + "\n";
  }
  return table;
}

std::string dialSummary(const std::vector<DialRow>& rows) {
  std::ostringstream text;
  std::size_t met = 0, affordable = 0;
  for (const DialRow& row : rows) {
    met += row.met() ? 1 : 0;
    affordable += row.affordable() ? 1 : 0;
  }
  text << "accuracy held in " << met << " of " << rows.size() << " cases, at most three times the cheapest measured cost in "
       << affordable << "\n";
  for (const DialRow& row : rows) {
    if (row.met() && row.affordable()) continue;
    text << "- " << row.scene << ", " << row.accuracy << ": " << row.chosen.integrator << " at " << 1e3 * row.chosen.dt << " ms, ";
    if (!row.finished) {
      text << "no run: " << row.reason << "\n";
      continue;
    }
    text << "error " << row.error << " for " << row.target << ", " << 1e3 * row.cost << " ms/s";
    if (std::isfinite(row.cheapest_cost)) text << " where " << 1e3 * row.cheapest_cost << " would do";
    text << "\n";
  }
  return text.str();
}

}  // namespace ellipsoid_vehicle_sim
