#include "ellipsoid_vehicle_sim/trade/study_manifest.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <thread>

#include "ellipsoid_vehicle_sim/scene/run_record.h"
#include "ellipsoid_vehicle_sim/vehicle/scene_kind.h"

namespace ellipsoid_vehicle_sim {
namespace {

/// What the dial takes the scene for.
std::string kindText(const LoadedScene& loaded) {
  SimConfig config = loaded.scene.config;
  config.allow_unstable = true;
  const Loaded<Simulator> simulator = startScene(loaded, config);
  return simulator ? toString(sceneKindOf(simulator.value->model(), simulator.value->terrain())) : "cannot be started";
}

}  // namespace

Problems writeStudyManifest(const std::string& path, const StudyRecord& record, const std::vector<StudyRow>& rows) {
  const BuildInfo build = buildInfo();
  YAML::Emitter yaml;
  const auto text = [&yaml](const std::string& key, const std::string& value) {
    yaml << YAML::Key << key << YAML::Value << YAML::DoubleQuoted << value;
  };
  const auto number = [&yaml](const std::string& key, double value) {
    yaml << YAML::Key << key << YAML::Value;
    if (std::isfinite(value)) {
      yaml << value;
    } else {
      yaml << "no limit";
    }
  };
  yaml << YAML::BeginMap;
  text("program", "trade_off");
  text("result", record.result);
  text("extent", record.extent);
  text("version", build.version);
  text("commit", build.commit);
  text("compiler", build.compiler);
  text("flags", build.flags);
  text("machine", machineName());
  number("cores", std::thread::hardware_concurrency());
  number("jobs", record.jobs);
  number("wall_time_s", record.wall_time);
  number("load_before", record.load_before);
  number("load_after", record.load_after);
  text("cost",
       "CPU time of the thread that runs the simulation, least of the repeats; set-down and load are not in it");
  number("cpu_budget_of_a_reference_s", record.budget.reference);
  number("cpu_budget_of_a_scene_s", record.budget.cells);
  number("cpu_budget_of_repeats_s", record.budget.repeats);

  // How far repeats lie apart says how much the machine was disturbed.
  std::vector<double> spreads;
  int failed = 0, left_out = 0;
  for (const StudyRow& row : rows) {
    if (row.run.cost.repeats > 1) spreads.push_back(row.run.cost.most / row.run.cost.least - 1.0);
    failed += row.status == RowStatus::kFailed || row.status == RowStatus::kRefused ? 1 : 0;
    left_out += row.status == RowStatus::kLeftOut ? 1 : 0;
  }
  std::sort(spreads.begin(), spreads.end());
  number("rows", static_cast<double>(rows.size()));
  number("rows_failed", failed);
  number("rows_left_out", left_out);
  number("rows_repeated", static_cast<double>(spreads.size()));
  number("median_spread_of_repeats", spreads.empty() ? 0.0 : spreads[spreads.size() / 2]);
  number("largest_spread_of_repeats", spreads.empty() ? 0.0 : spreads.back());

  yaml << YAML::Key << "peers" << YAML::Value << YAML::BeginSeq;
  for (const std::string& peer : record.peers) yaml << YAML::DoubleQuoted << peer;
  yaml << YAML::EndSeq << YAML::Key << "scenes" << YAML::Value << YAML::BeginSeq;
  for (const LoadedScene& loaded : record.scenes) {
    yaml << YAML::BeginMap;
    text("name", loaded.scene.name);
    text("description", loaded.scene.description);
    number("duration_s", loaded.scene.duration);
    number("horizon_s", loaded.scene.horizon);
    text("kind", kindText(loaded));
    yaml << YAML::Key << "files" << YAML::Value << YAML::BeginSeq;
    for (const std::string& file : loaded.files) {
      yaml << YAML::BeginMap;
      text("path", file);
      text("sha256", fileHash(file).value_or("cannot be read"));
      yaml << YAML::EndMap;
    }
    yaml << YAML::EndSeq << YAML::EndMap;
  }
  yaml << YAML::EndSeq << YAML::EndMap;
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out << yaml.c_str() << "\n";
  out.close();
  if (out) return {};
  return {{path, "cannot be written"}};
}

}  // namespace ellipsoid_vehicle_sim
