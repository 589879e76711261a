// The study of speed against accuracy: what it runs, what it takes for an error, what it writes down.
#include "ellipsoid_vehicle_sim/trade/study.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "ellipsoid_vehicle_sim/trade/closed_forms.h"
#include "ellipsoid_vehicle_sim/trade/cost_split.h"
#include "ellipsoid_vehicle_sim/trade/study_manifest.h"
#include "support/slowdown.h"
#include "support/temporary_files.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

const std::string kShare = SHARE_DIR;

LoadedScene shipped(const std::string& name) {
  const Loaded<Scene> scene = loadScene(kShare + "/launch/scenes/" + name + ".yaml", kShare);
  if (!scene) throw std::runtime_error(problemText(scene.problems));
  Loaded<LoadedScene> loaded = loadSceneFiles(*scene.value, kShare);
  if (!loaded) throw std::runtime_error(problemText(loaded.problems));
  return std::move(*loaded.value);
}

MeasuredPath straight(double speed, int samples) {
  MeasuredPath path;
  for (int i = 0; i < samples; ++i) {
    path.p_WR.emplace_back(speed * kPathInterval * i, 0.0, 0.0);
    path.q_WR.push_back(Quaterniond::Identity());
  }
  return path;
}

TEST(PathError, IsTheLargestDistanceUpToTheTime) {
  const MeasuredPath reference = straight(1.0, 51), path = straight(1.1, 51);
  const PathError half = pathError(path, reference, 0.5), whole = pathError(path, reference, 1.0);
  EXPECT_NEAR(half.largest, 0.05, 1e-12);
  EXPECT_NEAR(whole.largest, 0.1, 1e-12);
  EXPECT_NEAR(whole.at_end, 0.1, 1e-12);
  EXPECT_EQ(whole.angle, 0.0);
  EXPECT_NEAR(reference.distance(0.5), 0.5, 1e-12);
}

TEST(PathError, KnowsTheDistanceThatGoesAwayAgainAndSmallAngles) {
  MeasuredPath reference = straight(1.0, 11), path = reference;
  path.p_WR[5].y() += 0.3;
  path.q_WR[7] = Quaterniond(Eigen::AngleAxisd(1e-9, Vector3d::UnitZ()));
  const PathError error = pathError(path, reference, 0.2);
  EXPECT_NEAR(error.largest, 0.3, 1e-12);
  EXPECT_EQ(error.at_end, 0.0);
  EXPECT_NEAR(error.angle, 1e-9, 1e-15);
}

TEST(PathError, IsInfiniteWhereAPathBreaksOff) {
  EXPECT_TRUE(std::isinf(pathError(straight(1.0, 10), straight(1.0, 51), 1.0).largest));
}

TEST(Study, EveryIntegratorAndStepOnceAndOtherModelsOneFactorAtATime) {
  StudyBudget budget = StudyBudget::normal();
  EXPECT_EQ(budget.steps.front(), 1e-5);
  EXPECT_EQ(budget.steps.back(), 2e-2);
  for (const double dt : budget.steps) {
    const double per_sample = kPathInterval / dt;
    EXPECT_NEAR(per_sample, std::round(per_sample), 1e-9) << dt;
  }
  std::set<std::string> seen, integrators;
  std::size_t defaults = 0;
  for (const auto& [setting, factor] : settingsOf(budget)) {
    std::ostringstream key;
    key << setting.integrator << setting.dt << ' ' << setting.substeps << setting.modelText();
    EXPECT_TRUE(seen.insert(key.str()).second) << key.str();
    integrators.insert(setting.integrator);
    const int changed = (setting.contact_rule != "minimum_translation") + (setting.friction != "default") +
                        (setting.contacts_per_ellipsoid != "valley" && setting.contact_rule == "minimum_translation") +
                        (setting.substeps != Setting{}.substeps);
    EXPECT_EQ(changed == 0, factor == "step");
    EXPECT_LE(changed, 1) << key.str();
    EXPECT_EQ(setting.substeps != Setting{}.substeps, factor == "substeps");
    if (factor == "substeps") {
      EXPECT_EQ(setting.integrator, "rk4_events");
    }
    defaults += factor == "step" ? 1 : 0;
  }
  EXPECT_EQ(integrators.size(), knownIntegrators().size());
  EXPECT_EQ(defaults, budget.steps.size() * integrators.size());
  EXPECT_GT(settingsOf(StudyBudget::full()).size(), settingsOf(budget).size());
}

TEST(Study, ErrorsOfTheMethodAreThoseOfItsOrder) {
  // A tumbling body has a closed form and no contact: RK4 gains 16 with every halving, Euler 2.
  const LoadedScene scene = shipped("tossed_body");
  StudyBudget budget = StudyBudget::quick();
  budget.steps = {2.5e-3, 5e-3};
  budget.cells *= slowdown();
  const std::vector<StudyRow> rows = studyScene(scene, budget, [](const StudyRow&, double) { return true; });
  const auto errorOf = [&](const std::string& integrator, double dt) {
    for (const StudyRow& row : rows)
      if (row.factor == "step" && row.setting.integrator == integrator && row.setting.dt == dt) {
        EXPECT_EQ(row.status, RowStatus::kOk) << row.reason;
        EXPECT_LT(row.reference_error, 1e-9);
        return row.run.errors.closed_form.value_or(NAN);
      }
    ADD_FAILURE() << "no row of " << integrator;
    return 0.0;
  };
  EXPECT_NEAR(std::log2(errorOf("rk4", 5e-3) / errorOf("rk4", 2.5e-3)), 4.0, 0.3);
  EXPECT_NEAR(std::log2(errorOf("semi_implicit_euler", 5e-3) / errorOf("semi_implicit_euler", 2.5e-3)), 1.0, 0.2);
}

TEST(Study, ARowThatFailsIsARowWithItsReason) {
  // An undamped ball and explicit Euler at 5 ms: it gains energy until it is stopped, or is far off; a step beyond the
  // certificate is marked in any case.
  StudyBudget budget = StudyBudget::quick();
  budget.steps = {1e-3, 2e-2};
  const std::vector<StudyRow> rows = studyScene(shipped("bouncing_ball"), budget, [](const StudyRow&, double) { return true; });
  bool found = false;
  for (const StudyRow& row : rows) {
    if (row.factor != "step" || row.setting.integrator != "explicit_euler" || row.setting.dt != 2e-2) continue;
    found = true;
    EXPECT_TRUE(row.run.beyond_limit);
    EXPECT_TRUE(row.status == RowStatus::kFailed || row.run.errors.energy.value_or(0.0) > 0.1);
    if (row.status == RowStatus::kFailed) {
      EXPECT_FALSE(row.reason.empty());
    }
  }
  EXPECT_TRUE(found);
}

TEST(Study, ListenersCanStopIt) {
  int told = 0;
  const std::vector<StudyRow> rows =
      studyScene(shipped("rugby_ball"), StudyBudget::quick(), [&told](const StudyRow&, double) { return ++told < 3; });
  EXPECT_EQ(rows.size(), 3u);
}

std::size_t columnsOf(const std::string& line) {
  // Commas outside of quotes.
  std::size_t count = 1;
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') quoted = !quoted;
    if (c == ',' && !quoted) ++count;
  }
  return count;
}

StudyRow rowOf(const std::string& integrator, double dt, double cost, double error, bool beyond = false) {
  StudyRow row;
  row.scene = "scene";
  row.factor = "step";
  row.setting.integrator = integrator;
  row.setting.dt = dt;
  row.run.started = row.run.finished = true;
  row.run.cost = {cost, cost, cost, 1};
  row.run.beyond_limit = beyond;
  row.relative_error = error;
  return row;
}

TEST(StudyTable, LinesHaveTheColumnsOfTheHeader) {
  StudyRow failed = rowOf("rk4", 1e-3, 1e-3, 1e-4);
  failed.status = RowStatus::kFailed;
  failed.reason = "a \"quoted\", reason";
  for (const StudyRow& row : {rowOf("rk4", 1e-3, 1e-3, 1e-4), failed})
    EXPECT_EQ(columnsOf(studyLine(row)), columnsOf(studyHeader()));
  EXPECT_NE(studyLine(failed).find("\"a \"\"quoted\"\", reason\""), std::string::npos);
}

TEST(StudyTable, TheKneeIsTheCheapestThatHoldsTheErrorAndItsCertificate) {
  const std::vector<StudyRow> rows = {rowOf("a", 1e-2, 1e-4, 5e-3, true), rowOf("b", 1e-3, 3e-4, 5e-3),
                                      rowOf("c", 1e-3, 2e-4, 8e-3), rowOf("d", 1e-4, 9e-4, 5e-7)};
  const std::string csv = kneeCsv(rows);
  EXPECT_NE(csv.find("scene,0.01,c,"), std::string::npos) << csv;
  EXPECT_NE(csv.find("scene,0.001,d,"), std::string::npos) << csv;
  EXPECT_NE(csv.find("scene,1e-06,d,"), std::string::npos) << csv;
  // Nothing holds what nothing holds.
  EXPECT_NE(kneeCsv({rowOf("b", 1e-3, 3e-4, 0.5)}).find("scene,0.1,,"), std::string::npos);
}

TEST(StudyManifest, SaysWhatWasMeasuredWithWhat) {
  const TemporaryFiles files;
  StudyRecord record;
  record.extent = "quick";
  record.budget = StudyBudget::quick();
  record.scenes.push_back(shipped("rugby_ball"));
  const std::string path = files.folder("study") + "/manifest.yaml";
  StudyRow repeated = rowOf("rk4", 1e-3, 1e-3, 1e-4);
  repeated.run.cost = {1.0, 1.1, 1.5, 5};
  ASSERT_TRUE(writeStudyManifest(path, record, {repeated}).empty());
  std::ifstream in(path);
  std::ostringstream text;
  text << in.rdbuf();
  for (const char* line : {"commit: ", "flags: ", "machine: ", "compiler: ", "load_before: ", "load_after: ",
                           "largest_spread_of_repeats: 0.5", "name: \"rugby_ball\"", "horizon_s: 0.5", "sha256: \""})
    EXPECT_NE(text.str().find(line), std::string::npos) << line << "\n" << text.str();
  EXPECT_FALSE(writeStudyManifest(files.folder("study") + "/no/such/folder/m.yaml", record, {}).empty());
}

/// Error against the closed form at a fine step of the most exact method.
double closedFormError(const std::string& name, double dt) {
  const LoadedScene scene = shipped(name);
  Setting setting;
  setting.integrator = "rk4_events";
  setting.dt = dt;
  MeasureOptions options;
  options.repeat_budget = 0.0;
  const MeasuredRun run = measureRun(scene, configAt(scene.scene, setting), options);
  EXPECT_TRUE(run.finished) << run.reason;
  EXPECT_TRUE(run.errors.closed_form) << name << " has no closed form";
  return run.errors.closed_form.value_or(1e300);
}

TEST(ClosedForms, FineRunsAgreeWithTheFormulas) {
  // What is left is the idealisation: springs that give, tyres that slip.
  EXPECT_LT(closedFormError("bouncing_ball", 1e-3), 1e-5);
  EXPECT_LT(closedFormError("tossed_body", 1e-3), 1e-6);
  EXPECT_LT(closedFormError("seam", 1e-3), 1e-6);
  EXPECT_LT(closedFormError("roll_down", 1e-3), 1e-2);
  EXPECT_LT(closedFormError("block_threshold", 1e-3), 1e-4);
  EXPECT_LT(closedFormError("brake", 1e-3), 0.5);
}

TEST(CostSplit, PartsAddUpToTheStep) {
  const std::vector<CostSplit> splits = splitCost(shipped("cornering"), 0.2);
  ASSERT_EQ(splits.size(), 2u);
  for (const CostSplit& split : splits) {
    EXPECT_GT(split.step, 1e-8);
    EXPECT_LT(split.step, 1e-3);
    for (const double share : {split.collision, split.force, split.dynamics}) {
      EXPECT_GT(share, 0.0);
      EXPECT_LT(share, 1.0);
    }
    EXPECT_GE(split.integration, 0.0);
  }
  const std::string csv = costSplitCsv(splits);
  EXPECT_NE(csv.find("cornering,rk4,0.001,"), std::string::npos) << csv;
}

TEST(Dial, RunsWhatItChoseAndSaysWhetherItHeld) {
  StudyRow cheap = rowOf("semi_implicit_euler", 1e-3, 1e-9, 1e-9);
  const std::vector<DialRow> rows = studyDial(shipped("tossed_body"), StudyBudget::quick(), {cheap});
  ASSERT_EQ(rows.size(), 4u);
  for (const DialRow& row : rows) {
    EXPECT_TRUE(row.finished) << row.reason;
    EXPECT_GT(row.chosen.dt, 0.0);
    EXPECT_EQ(row.cheapest_cost, 1e-9);
    EXPECT_FALSE(row.affordable());  // no run costs a nanosecond
  }
  const std::string csv = dialCsv(rows), summary = dialSummary(rows);
  EXPECT_NE(csv.find("tossed_body,fast,0.01,"), std::string::npos) << csv;
  EXPECT_NE(summary.find(" of 4 cases"), std::string::npos) << summary;
  EXPECT_NE(summary.find("- tossed_body, fast: "), std::string::npos) << summary;
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
