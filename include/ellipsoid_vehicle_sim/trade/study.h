#pragma once

#include <functional>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/trade/measured_run.h"

// The trade between speed and accuracy, measured: scenes times settings, each a row.

namespace ellipsoid_vehicle_sim {

/// What is varied. Words as in launch/simulator.yaml; friction "default" is what the scene has, else both body_friction
/// and wheel_friction.
struct Setting {
  std::string integrator = "rk4";
  double dt = 1e-3;
  double substeps = 4.0;  ///< contact_substeps; means something to rk4_events only.
  std::string contact_rule = "minimum_translation";
  std::string contacts_per_ellipsoid = "valley";
  std::string friction = "default";

  /// Same equations, whatever the method and step.
  bool sameModel(const Setting& other) const;
  std::string modelText() const;
};

/// The scene's configuration at this setting. A friction that is "default" keeps the scene's.
SimConfig configAt(const Scene& scene, const Setting& setting);

/// Every integrator the parameter table knows, in its order.
std::vector<std::string> knownIntegrators();

enum class RowStatus { kOk, kFailed, kRefused, kLeftOut };

/// One setting of one scene. Errors that could not be taken are NaN, and empty in the table.
struct StudyRow {
  std::string scene, program = "ellipsoid_vehicle_sim", factor;  ///< factor: step, substeps, contact, friction, all, peer.
  Setting setting;
  RowStatus status = RowStatus::kOk;
  std::string reason;
  MeasuredRun run;               ///< without its path.
  PathError error;               ///< against the finest run of the same model.
  double reference_error = 0.0;  ///< how well that one is known: its distance from a run at a coarser step [m].
  double model_error = 0.0;      ///< against the finest run of the default model [m].
  double distance = 0.0;         ///< way up to the horizon, by the reference [m].
  double relative_error = 0.0;   ///< error.largest over the way, or over the characteristic length if that is more [-].

  /// A row of our own whose equations are the default model's, whatever the method.
  bool ownModel() const { return factor == "step" || factor == "substeps"; }
};

/// How much of everything.
struct StudyBudget {
  std::vector<double> steps;  ///< [s], each divides kPathInterval.
  double reference = 0.0;     ///< CPU time for a reference run [s], about.
  double cells = 0.0;         ///< CPU time for all rows of a scene together [s]; the costliest are left out, as rows.
  double repeats = 0.0;       ///< CPU time for the repeats of a row [s].
  std::vector<double> substeps;  ///< that rk4_events is tried with besides the default.
  bool cross = false;         ///< all combinations, not one factor at a time.

  static StudyBudget quick();
  static StudyBudget normal();
  static StudyBudget full();
};

/// All settings of the study, the factor each belongs to beside it.
std::vector<std::pair<Setting, std::string>> settingsOf(const StudyBudget& budget);

/// Called with every row as it comes, and the share done; false: stop here.
using RowListener = std::function<bool(const StudyRow&, double)>;

/// One scene. Not for several threads at once on one scene; different scenes may run side by side.
std::vector<StudyRow> studyScene(const LoadedScene& scene, const StudyBudget& budget, const RowListener& told);

/// The header and lines of trade_off.csv.
std::string studyHeader();
std::string studyLine(const StudyRow& row);

/// For each scene and error 1e-1 ... 1e-6 the cheapest row that stays below it, as a table in Markdown.
std::string kneeTable(const std::vector<StudyRow>& rows);
/// The same as CSV.
std::string kneeCsv(const std::vector<StudyRow>& rows);

/// The dial `accuracy` on a scene: what it chose, and whether that held what was asked.
struct DialRow {
  std::string scene, accuracy;
  double target = 0.0;          ///< [m/m].
  Setting chosen;
  std::string reason;           ///< why there is no run.
  bool finished = false;
  double error = 0.0;           ///< over the way or the characteristic length, within 10 s of the horizon [m/m].
  double cost = 0.0;            ///< CPU time per simulated second [s/s].
  double cheapest_cost = 0.0;   ///< of the rows measured on this scene that hold the target; NaN without any.

  bool met() const { return finished && error <= target; }
  bool affordable() const { return !(cost > 3.0 * cheapest_cost); }
};

/// Runs the scene at accuracy 1e-1, fast, balanced and 1e-4; `rows`: what studyScene measured on it. The reference is made
/// anew.
std::vector<DialRow> studyDial(const LoadedScene& scene, const StudyBudget& budget, const std::vector<StudyRow>& rows);

/// dial.csv, and the misses in words with their share, as Markdown.
std::string dialCsv(const std::vector<DialRow>& rows);
std::string dialSummary(const std::vector<DialRow>& rows);

}  // namespace ellipsoid_vehicle_sim
