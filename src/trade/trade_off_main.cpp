// trade_off: measures how exact and how fast every setting is, on the shipped scenes or given ones.

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <mutex>
#include <thread>

#include "ellipsoid_vehicle_sim/description/number_text.h"
#include "ellipsoid_vehicle_sim/description/shipped_files.h"
#include "ellipsoid_vehicle_sim/scene/progress_bar.h"
#include "ellipsoid_vehicle_sim/trade/cost_split.h"
#include "ellipsoid_vehicle_sim/trade/study.h"
#include "ellipsoid_vehicle_sim/trade/study_manifest.h"
#include "peers/peers.h"

namespace ellipsoid_vehicle_sim {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

// CPU time for the cost split of a scene and a method [s].
constexpr double kSplitBudget = 0.2;
constexpr int kBadInput = 2, kFailed = 1, kInterrupted = 130;

constexpr const char* kUsage =
    "usage: trade_off [--quick|--full] [--scene NAME|FILE]... [--held-back] --out DIR [--jobs N] [--no-plots]\n"
    "Runs scenes at many settings (integrators, steps from 10 us to 20 ms, contact rules, friction modes) and writes "
    "into\n"
    "DIR: trade_off.csv (a row each, failures included), manifest.yaml, knees.csv and knees.md (the cheapest setting "
    "for\n"
    "each error), dial.csv and dial.md (what the parameter accuracy chooses, and whether it holds), cost_split.csv (where a step's time goes), and for every scene a work-precision plot as PNG and SVG.\n"
    "  --quick        few steps, within a minute; --full: everything, all factors crossed, for hours\n"
    "  --scene S      a shipped scene (headless --list) or the path of a scene YAML; may be repeated; default: all "
    "shipped\n"
    "  --held-back    the scenes of launch/scenes/held_back, which the curves behind accuracy know nothing of\n"
    "  --jobs N       scenes measured side by side; default: one for each core\n"
    "  --no-plots     tables only\n"
    "exit code: 0 measured (rows of runs that failed are results, too), 1 results could not be written, 2 bad input\n";

std::atomic<bool> interrupted{false};
void onSignal(int) { interrupted = true; }

struct Arguments {
  StudyRecord record;
  std::vector<std::string> scenes;
  bool held_back = false;
  std::string out;
  bool plots = true, help = false;
};

Loaded<Arguments> parse(int argc, char** argv) {
  Loaded<Arguments> result;
  Arguments a;
  bool quick = false, full = false;
  a.record.jobs = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if ((word == "--scene" || word == "--out" || word == "--jobs") && i + 1 >= argc) {
      result.problems.push_back({word, "needs a value"});
    } else if (word == "--scene") {
      a.scenes.push_back(argv[++i]);
    } else if (word == "--out") {
      a.out = argv[++i];
    } else if (word == "--jobs") {
      const std::optional<double> n = parseNumber(argv[++i]);
      if (!n || *n < 1.0 || *n > 256.0 || *n != static_cast<int>(*n)) {
        result.problems.push_back({word, std::string("'") + argv[i] + "' is no whole number from 1 to 256"});
      } else {
        a.record.jobs = static_cast<int>(*n);
      }
    } else if (word == "--quick") {
      quick = true;
    } else if (word == "--full") {
      full = true;
    } else if (word == "--held-back") {
      a.held_back = true;
    } else if (word == "--no-plots") {
      a.plots = false;
    } else if (word == "--help" || word == "-h") {
      a.help = true;
    } else if (word.rfind("__", 0) == 0) {
      continue;  // roslaunch's own
    } else {
      result.problems.push_back(
          {word, "is no option; known are --quick, --full, --scene, --held-back, --out, --jobs, --no-plots, --help"});
    }
  }
  if (quick && full) result.problems.push_back({"--quick", "together with --full; give one of them"});
  if (a.out.empty() && !a.help) result.problems.push_back({"--out", "is missing: the folder for the results"});
  a.record.extent = quick ? "quick" : full ? "full" : "normal";
  a.record.budget = quick ? StudyBudget::quick() : full ? StudyBudget::full() : StudyBudget::normal();
  if (result.problems.empty()) result.value = std::move(a);
  return result;
}

int refuse(const Problems& problems) {
  std::cerr << problemText(problems) << problems.size() << (problems.size() == 1 ? " problem" : " problems")
            << ", nothing measured\n";
  return kBadInput;
}

Problems loadScenes(const std::vector<std::string>& names, bool held_back, std::vector<LoadedScene>& scenes) {
  Problems problems;
  const std::string share = shareFolderBesideProgram();
  const ShippedNames shipped = shippedScenes(share);
  std::vector<std::string> wanted = names;
  std::error_code none;
  if (held_back)
    for (const auto& entry : fs::directory_iterator(fs::path(share) / "launch" / "scenes" / "held_back", none))
      if (entry.path().extension() == ".yaml") wanted.push_back(entry.path().string());
  std::sort(wanted.begin() + static_cast<std::ptrdiff_t>(names.size()), wanted.end());
  if (wanted.empty() && !held_back)
    for (const auto& entry : shipped) wanted.push_back(entry.first);
  for (const std::string& name : wanted) {
    const Loaded<std::string> path = findShipped(shipped, "scene", name, "--scene");
    problems.insert(problems.end(), path.problems.begin(), path.problems.end());
    if (!path) continue;
    const Loaded<Scene> scene = loadScene(*path.value, share);
    problems.insert(problems.end(), scene.problems.begin(), scene.problems.end());
    if (!scene) continue;
    Loaded<LoadedScene> loaded = loadSceneFiles(*scene.value, share);
    problems.insert(problems.end(), loaded.problems.begin(), loaded.problems.end());
    if (!loaded) continue;
    for (const LoadedScene& other : scenes)
      if (other.scene.name == loaded.value->scene.name)
        problems.push_back({"--scene " + name, "is the second scene of this name, with " + other.scene.file});
    scenes.push_back(std::move(*loaded.value));
  }
  if (wanted.empty()) problems.push_back({"--scene", "no scene is shipped with this program; give a file"});
  return problems;
}

std::vector<StudyRow> measure(const StudyRecord& record, std::vector<DialRow>& dial) {
  const std::vector<LoadedScene>& scenes = record.scenes;
  std::vector<std::vector<StudyRow>> rows(scenes.size());
  std::vector<std::vector<DialRow>> dials(scenes.size());
  std::vector<double> done(scenes.size(), 0.0);
  std::mutex mutex;
  std::atomic<std::size_t> next{0};
  ProgressBar bar("trade_off");
  const auto work = [&] {
    for (std::size_t i; (i = next++) < scenes.size();) {
      const auto told = [&, i](const StudyRow& row, double share) {
        const std::lock_guard<std::mutex> lock(mutex);
        done[i] = share;
        double sum = 0.0;
        for (const double d : done) sum += d;
        bar.show(sum / static_cast<double>(done.size()),
                 row.scene + " " + row.setting.integrator + " " + numberText(row.setting.dt) + " s");
        return !interrupted;
      };
      if (interrupted) continue;
      rows[i] = studyScene(scenes[i], record.budget, told);
      if (interrupted) continue;
      dials[i] = studyDial(scenes[i], record.budget, rows[i]);
      const std::vector<StudyRow> peers = studyPeers(scenes[i], record.budget, told);
      rows[i].insert(rows[i].end(), peers.begin(), peers.end());
    }
  };
  std::vector<std::thread> threads;
  for (int j = 0; j < record.jobs; ++j) threads.emplace_back(work);
  for (std::thread& thread : threads) thread.join();
  bar.finish();
  std::vector<StudyRow> all;
  for (const auto& part : rows) all.insert(all.end(), part.begin(), part.end());
  for (const auto& part : dials) dial.insert(dial.end(), part.begin(), part.end());
  return all;
}

bool write(const fs::path& path, const std::string& text) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out << text;
  out.close();
  if (!out) std::cerr << path.string() << ": cannot be written\n";
  return static_cast<bool>(out);
}

/// The plots are drawn by a program of their own, from the table that was just written.
bool plot(const std::string& out) {
  const std::string program = shareFolderBesideProgram() + "/scripts/plot_trade_off";
  const pid_t child = fork();
  if (child == 0) {
    execl("/usr/bin/python3", "python3", "-B", program.c_str(), out.c_str(), static_cast<char*>(nullptr));
    _exit(127);
  }
  int status = 0;
  if (child < 0 || waitpid(child, &status, 0) != child || !WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    std::cerr << program << ": the plots could not be drawn; the tables are complete\n";
    return false;
  }
  return true;
}

int run(int argc, char** argv) {
  Loaded<Arguments> parsed = parse(argc, argv);
  if (!parsed) {
    const int code = refuse(parsed.problems);
    std::cerr << kUsage;
    return code;
  }
  if (parsed.value->help) {
    std::cout << kUsage;
    return 0;
  }
  StudyRecord& record = parsed.value->record;
  if (const Problems problems = loadScenes(parsed.value->scenes, parsed.value->held_back, record.scenes); !problems.empty())
    return refuse(problems);
  std::error_code error;
  const fs::path out = parsed.value->out;
  fs::create_directories(out, error);
  if (!fs::is_directory(out, error)) return refuse({{"--out " + out.string(), "is no folder and cannot be made"}});

  std::signal(SIGINT, onSignal);
  std::signal(SIGTERM, onSignal);
  record.peers = peerVersions();
  for (const std::string& peer : record.peers) std::cout << peer << "\n";
  if (getloadavg(&record.load_before, 1) != 1) record.load_before = 0.0;
  const Clock::time_point begun = Clock::now();
  std::vector<DialRow> dial;
  const std::vector<StudyRow> rows = measure(record, dial);
  record.wall_time = std::chrono::duration<double>(Clock::now() - begun).count();
  if (getloadavg(&record.load_after, 1) != 1) record.load_after = 0.0;
  if (interrupted) record.result = "interrupted: rows are missing";

  std::string table = studyHeader();
  for (const StudyRow& row : rows) table += studyLine(row);
  bool good = write(out / "trade_off.csv", table);
  good = write(out / "knees.csv", kneeCsv(rows)) && good;
  good = write(out / "knees.md", kneeTable(rows)) && good;
  good = write(out / "dial.csv", dialCsv(dial)) && good;
  good = write(out / "dial.md", dialSummary(dial)) && good;
  std::vector<CostSplit> splits;
  for (const LoadedScene& scene : record.scenes) {
    if (interrupted) break;
    for (const CostSplit& split : splitCost(scene, kSplitBudget)) splits.push_back(split);
  }
  good = write(out / "cost_split.csv", costSplitCsv(splits)) && good;
  for (const Problem& p : writeStudyManifest((out / "manifest.yaml").string(), record, rows)) {
    std::cerr << p.text() << "\n";
    good = false;
  }
  std::cout << kneeTable(rows) << dialSummary(dial) << rows.size() << " rows in " << numberText(record.wall_time) << " s: " << out.string()
            << "/trade_off.csv\n";
  if (good && parsed.value->plots) good = plot(out.string());
  if (interrupted) return kInterrupted;
  return good ? 0 : kFailed;
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim

int main(int argc, char** argv) { return ellipsoid_vehicle_sim::run(argc, argv); }
