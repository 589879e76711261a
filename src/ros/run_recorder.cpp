#include "ellipsoid_vehicle_sim/ros/run_recorder.h"

#include <filesystem>
#include <system_error>
#include <utility>

namespace ellipsoid_vehicle_sim {

namespace fs = std::filesystem;

namespace {

void append(const Problems& more, Problems& problems) { problems.insert(problems.end(), more.begin(), more.end()); }

}  // namespace

RunRecorder::RunRecorder(std::string folder, RunTable table, RunManifest manifest)
    : folder_(std::move(folder)), table_(std::move(table)), manifest_(std::move(manifest)) {}

Loaded<RunRecorder> RunRecorder::create(const std::string& folder, std::int64_t every, RunManifest manifest,
                                        const Simulator& simulator) {
  Loaded<RunRecorder> result;
  const auto refuse = [&result, &folder](const std::string& why) {
    result.problems.push_back({"~record_folder", "'" + folder + "' " + why});
  };
  const fs::path table_path = fs::path(folder) / "run.csv";
  std::error_code error;
  if (!fs::path(folder).is_absolute()) {
    refuse("is no absolute path");
  } else if (fs::create_directories(folder, error); error) {
    refuse("cannot be made: " + error.message());
  } else if (fs::exists(table_path, error)) {
    refuse("holds a run already: take another folder, or remove it");
  }
  if (!result.problems.empty()) return result;

  Loaded<RunTable> table = RunTable::create(table_path.string(), simulator, every);
  append(table.problems, result.problems);
  if (!table) return result;
  manifest.result = "running";
  RunRecorder recorder(folder, std::move(*table.value), std::move(manifest));
  append(recorder.writeManifestFile(simulator), result.problems);
  if (!result.problems.empty()) return result;
  recorder.add(simulator, 0.0);
  result.value.emplace(std::move(recorder));
  return result;
}

void RunRecorder::add(const Simulator& simulator, double step_time) { table_.add(simulator, step_time); }

Problems RunRecorder::finish(const Simulator& simulator, const std::string& result) {
  Problems problems = table_.close();
  manifest_.result = result;
  append(writeManifestFile(simulator), problems);
  return problems;
}

Problems RunRecorder::writeManifestFile(const Simulator& simulator) const {
  return writeManifest((fs::path(folder_) / "manifest.yaml").string(), manifest_, simulator);
}

}  // namespace ellipsoid_vehicle_sim
