#include "ellipsoid_vehicle_sim/trade/study.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "ellipsoid_vehicle_sim/description/number_text.h"
#include "ellipsoid_vehicle_sim/vehicle/parameter_table.h"
#include "reference.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

}  // namespace

bool Setting::sameModel(const Setting& other) const {
  return contact_rule == other.contact_rule && contacts_per_ellipsoid == other.contacts_per_ellipsoid &&
         friction == other.friction;
}

std::string Setting::modelText() const { return contact_rule + ", " + contacts_per_ellipsoid + ", " + friction; }

SimConfig configAt(const Scene& scene, const Setting& setting) {
  SimConfig config = scene.config;
  ParameterValues values = {{"integrator", setting.integrator},
                            {"dt", setting.dt},
                            {"contact_substeps", setting.substeps},
                            {"contact_rule", setting.contact_rule},
                            {"contacts_per_ellipsoid", setting.contacts_per_ellipsoid}};
  if (setting.friction != "default") {
    values["body_friction"] = setting.friction;
    values["wheel_friction"] = setting.friction;
  }
  // Words and steps are the study's own: a refusal is a slip of the program, and shows as a run that does not start.
  takeParameters(simConfigParameters(), "", values, config);
  return config;
}

std::vector<std::string> knownIntegrators() {
  for (const auto& row : simConfigParameters())
    if (row.spec.key == "integrator") return row.spec.choices;
  return {};
}

StudyBudget StudyBudget::quick() {
  StudyBudget budget;
  budget.steps = {1e-4, 5e-4, 1e-3, 5e-3};
  budget.reference = 0.2;
  budget.cells = 0.9;
  return budget;
}

StudyBudget StudyBudget::normal() {
  StudyBudget budget;
  budget.steps = {1e-5, 2e-5, 5e-5, 1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2};
  budget.reference = 3.0;
  budget.cells = 24.0;
  budget.repeats = 0.1;
  budget.substeps = {1.0, 16.0};
  return budget;
}

StudyBudget StudyBudget::full() {
  StudyBudget budget = normal();
  budget.reference = 60.0;
  budget.cells = std::numeric_limits<double>::infinity();
  budget.repeats = 1.0;
  budget.cross = true;
  return budget;
}

std::vector<std::pair<Setting, std::string>> settingsOf(const StudyBudget& budget) {
  const std::vector<std::string> integrators = knownIntegrators();
  std::vector<std::pair<Setting, std::string>> models = {{Setting{}, "step"}};
  const std::vector<std::pair<std::string, std::string>> rules = {{"minimum_translation", "one"},
                                                                  {"clamped_point", "one"}};
  const std::vector<std::string> frictions = {"viscous", "anchored", "brush"};
  for (const auto& [rule, contacts] : rules) {
    Setting model;
    model.contact_rule = rule;
    model.contacts_per_ellipsoid = contacts;
    models.emplace_back(model, "contact");
    if (!budget.cross) continue;
    for (const std::string& friction : frictions) {
      model.friction = friction;
      models.emplace_back(model, "all");
    }
  }
  for (const std::string& friction : frictions) {
    Setting model;
    model.friction = friction;
    models.emplace_back(model, "friction");
  }
  std::vector<std::pair<Setting, std::string>> settings;
  for (const auto& [model, factor] : models) {
    for (const std::string& integrator : integrators) {
      // One factor at a time: other models with the default integrator only.
      if (factor != "step" && !budget.cross && integrator != Setting{}.integrator) continue;
      for (const double dt : budget.steps) {
        Setting setting = model;
        setting.integrator = integrator;
        setting.dt = dt;
        settings.emplace_back(setting, factor);
      }
    }
  }
  for (const double substeps : budget.substeps)
    for (const double dt : budget.steps) {
      Setting setting;
      setting.integrator = toString(IntegratorKind::kRk4Events);
      setting.substeps = substeps;
      setting.dt = dt;
      settings.emplace_back(setting, "substeps");
    }
  return settings;
}

std::vector<StudyRow> studyScene(const LoadedScene& loaded, const StudyBudget& budget, const RowListener& told) {
  const Scene& scene = loaded.scene;
  std::vector<StudyRow> rows;
  const auto settings = settingsOf(budget);
  // Cheapest first: large steps; where the budget ends, the finest steps are left out.
  std::vector<std::size_t> order(settings.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&settings](std::size_t a, std::size_t b) { return settings[a].first.dt > settings[b].first.dt; });

  std::vector<Reference> references;
  double spent_on_references = 0.0;  // has a budget of its own [s]
  const auto referenceOf = [&](const Setting& setting) -> const Reference& {
    for (const Reference& r : references)
      if (r.model.sameModel(setting)) return r;
    const double before = threadTime();
    references.push_back(makeReference(loaded, setting, budget.reference));
    spent_on_references += threadTime() - before;
    return references.back();
  };
  references.reserve(settings.size());
  const Reference& standard = referenceOf(Setting{});

  spent_on_references = 0.0;
  const double begun = threadTime();
  // The latest known cost of a tick of a method.
  std::vector<std::pair<std::pair<std::string, double>, double>> per_tick;
  for (std::size_t n = 0; n < order.size(); ++n) {
    const auto& [setting, factor] = settings[order[n]];
    StudyRow row;
    row.scene = scene.name;
    row.factor = factor;
    row.setting = setting;
    const std::pair<std::string, double> method{setting.integrator, setting.substeps};
    const auto known =
        std::find_if(per_tick.begin(), per_tick.end(), [&method](const auto& entry) { return entry.first == method; });
    const double ticks = scene.duration / setting.dt;
    const double tick = known == per_tick.end() ? tickCost(loaded, setting) : known->second;
    // A run for the cost and one to look at it; with headings, one for each.
    const double expected = tick * ticks * (1.0 + (1.0 + scene.measures.energy) * scene.headings);
    if (threadTime() - begun - spent_on_references + expected > budget.cells) {
      row.status = RowStatus::kLeftOut;
      row.reason = "takes " + numberText(expected) + " s of CPU, more than is left for this scene; --full runs it";
    } else {
      const Reference& reference = referenceOf(setting);
      MeasureOptions options;
      options.repeat_budget = budget.repeats;
      row.run = measureRun(loaded, configAt(scene, setting), options);
      row.reason = row.run.reason;
      row.status = row.run.finished ? RowStatus::kOk : row.run.started ? RowStatus::kFailed : RowStatus::kRefused;
      row.error.largest = row.error.at_end = row.error.angle = row.model_error = row.relative_error = kNaN;
      row.reference_error = reference.error;
      if (row.status == RowStatus::kOk) {
        const double cost = row.run.cost.least * setting.dt;
        if (known == per_tick.end()) {
          per_tick.emplace_back(method, cost);
        } else {
          known->second = cost;
        }
        if (reference.usable) {
          row.error = pathError(row.run.path, reference.path, scene.horizon);
          row.distance = reference.path.distance(scene.horizon);
          row.relative_error = row.error.largest / std::max(row.distance, row.run.length);
        } else {
          row.reason = "no reference: " + reference.reason;
        }
        if (standard.usable) row.model_error = pathError(row.run.path, standard.path, scene.horizon).largest;
      }
      row.run.path = MeasuredPath{};
    }
    rows.push_back(row);
    if (!told(rows.back(), static_cast<double>(n + 1) / static_cast<double>(order.size()))) break;
  }
  return rows;
}

}  // namespace ellipsoid_vehicle_sim
