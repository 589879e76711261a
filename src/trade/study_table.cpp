#include <cmath>
#include <cstdio>
#include <sstream>

#include "ellipsoid_vehicle_sim/trade/study.h"

namespace ellipsoid_vehicle_sim {
namespace {

const char* toString(RowStatus status) {
  switch (status) {
    case RowStatus::kOk:
      return "ok";
    case RowStatus::kFailed:
      return "failed";
    case RowStatus::kRefused:
      return "refused";
    case RowStatus::kLeftOut:
      return "left_out";
  }
  return "unknown";
}

/// Empty where there is no number.
std::string number(double value) {
  if (!std::isfinite(value)) return "";
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

std::string number(const std::optional<double>& value) { return value ? number(*value) : ""; }

/// A reason may hold commas and quotes.
std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) result += c == '"' ? std::string("\"\"") : c == '\n' ? std::string(" ") : std::string(1, c);
  return result + "\"";
}

constexpr double kTargets[] = {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6};

/// Cheapest row of our own default model that holds the error and is not beyond its certificate; nullptr without.
const StudyRow* cheapest(const std::vector<StudyRow>& rows, const std::string& scene, double error) {
  const StudyRow* best = nullptr;
  for (const StudyRow& row : rows) {
    if (row.scene != scene || row.status != RowStatus::kOk || !row.ownModel()) continue;
    if (row.run.beyond_limit || !(row.relative_error <= error)) continue;
    if (!best || row.run.cost.least < best->run.cost.least) best = &row;
  }
  return best;
}

// Empty where the integrator has none.
std::string substepsOf(const Setting& setting) {
  return setting.integrator == toString(IntegratorKind::kRk4Events) ? number(setting.substeps) : "";
}

std::vector<std::string> scenesOf(const std::vector<StudyRow>& rows) {
  std::vector<std::string> scenes;
  for (const StudyRow& row : rows)
    if (scenes.empty() || scenes.back() != row.scene) scenes.push_back(row.scene);
  return scenes;
}

}  // namespace

std::string studyHeader() {
  return "scene,program,factor,integrator,dt,contact_substeps,contact_rule,contacts_per_ellipsoid,friction,status,cpu_ms_per_s,"
         "cpu_ms_per_s_median,cpu_ms_per_s_most,repeats,error_m,end_error_m,angle_error_rad,relative_error,"
         "reference_error_m,model_error_m,closed_form_error_m,energy_error,momentum_error,penetration_m,force_ripple,"
         "creep_m_per_s,cone_violation,passed_through,distance_m,step_limit_s,beyond_limit,fastest_mode_rad_per_s,"
         "reason\n";
}

std::string studyLine(const StudyRow& row) {
  const MeasuredRun& run = row.run;
  const bool ran = row.status == RowStatus::kOk || row.status == RowStatus::kFailed;
  const auto when = [](bool condition, double value) { return condition ? number(value) : std::string(); };
  const bool ok = row.status == RowStatus::kOk;
  std::ostringstream line;
  line << row.scene << ',' << row.program << ',' << row.factor << ',' << row.setting.integrator << ','
       << number(row.setting.dt) << ',' << substepsOf(row.setting)
       << ',' << row.setting.contact_rule << ',' << row.setting.contacts_per_ellipsoid << ','
       << row.setting.friction << ',' << toString(row.status) << ',' << when(ok, 1e3 * run.cost.least) << ','
       << when(ok, 1e3 * run.cost.median) << ',' << when(ok, 1e3 * run.cost.most) << ',' << run.cost.repeats << ','
       << when(ok, row.error.largest) << ',' << when(ok, row.error.at_end) << ',' << when(ok, row.error.angle) << ','
       << when(ok, row.relative_error) << ',' << when(ok, row.reference_error) << ',' << when(ok, row.model_error)
       << ',' << number(run.errors.closed_form) << ',' << number(run.errors.energy) << ','
       << number(run.errors.momentum) << ',' << number(run.errors.penetration) << ',' << number(run.errors.ripple)
       << ',' << number(run.errors.creep) << ',' << number(run.errors.cone) << ',' << run.events.passed_through << ','
       << when(ok, row.distance) << ',' << when(ran && run.step_limit > 0.0, run.step_limit) << ','
       << (run.beyond_limit ? 1 : 0) << ',' << when(ran && run.fastest > 0.0, run.fastest) << ',' << quoted(row.reason)
       << '\n';
  return line.str();
}

std::string kneeTable(const std::vector<StudyRow>& rows) {
  std::ostringstream table;
  table << "| scene |";
  for (const double target : kTargets) table << ' ' << number(target) << " |";
  table << "\n|---|";
  for (std::size_t i = 0; i < std::size(kTargets); ++i) table << "---|";
  table << '\n';
  for (const std::string& scene : scenesOf(rows)) {
    table << "| " << scene << " |";
    for (const double target : kTargets) {
      const StudyRow* row = cheapest(rows, scene, target);
      if (row) {
        const std::string substeps = substepsOf(row->setting);
        table << ' ' << row->setting.integrator << ' ' << number(1e3 * row->setting.dt)
              << (substeps.empty() || row->factor == "step" ? "" : " / " + substeps) << " ms: " << number(1e3 * row->run.cost.least) << " |";
      } else {
        table << " – |";
      }
    }
    table << '\n';
  }
  return table.str();
}

std::string kneeCsv(const std::vector<StudyRow>& rows) {
  std::ostringstream table;
  table << "scene,error,integrator,dt,contact_substeps,cpu_ms_per_s,relative_error\n";
  for (const std::string& scene : scenesOf(rows))
    for (const double target : kTargets) {
      const StudyRow* row = cheapest(rows, scene, target);
      table << scene << ',' << number(target) << ',';
      if (row) {
        table << row->setting.integrator << ',' << number(row->setting.dt) << ',' << substepsOf(row->setting) << ',' << number(1e3 * row->run.cost.least)
              << ',' << number(row->relative_error) << '\n';
      } else {
        table << ",,,,\n";
      }
    }
  return table.str();
}

}  // namespace ellipsoid_vehicle_sim
