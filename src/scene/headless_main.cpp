// headless SCENE: runs a scene as fast as possible, without a ROS master, and leaves a CSV and a manifest.

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <utility>

#include "ellipsoid_vehicle_sim/description/number_text.h"
#include "ellipsoid_vehicle_sim/description/shipped_files.h"
#include "ellipsoid_vehicle_sim/scene/progress_bar.h"
#include "ellipsoid_vehicle_sim/scene/run_record.h"
#include "ellipsoid_vehicle_sim/scene/scene.h"

namespace ellipsoid_vehicle_sim {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr int kBadInput = 2, kBrokeDown = 1, kInterrupted = 130;

constexpr const char* kUsage =
    "usage: headless SCENE [--out DIR] [--every N] [--set KEY=VALUE]... [--quiet]\n"
    "       headless --list\n"
    "Runs SCENE (a shipped name, or the path of a scene YAML) as fast as possible, without a ROS master, and writes\n"
    "DIR/NAME.csv and DIR/NAME.manifest.yaml.\n"
    "  --out DIR        folder for the results, made if need be; default: here\n"
    "  --every N        a line in the CSV for every N-th tick; default 1\n"
    "  --set KEY=VALUE  a parameter of the physics (launch/simulator.yaml), over everything the files say\n"
    "  --quiet          neither the load report nor the summary\n"
    "  --list           the shipped scenes\n"
    "exit code: 0 the scene was run to its end, 1 it broke down on the way, 2 bad input, 130 interrupted\n";

volatile std::sig_atomic_t interrupted = 0;
void onSignal(int) { interrupted = 1; }

struct Arguments {
  std::string scene, out = ".";
  std::int64_t every = 1;
  std::vector<std::string> overrides;
  bool quiet = false, list = false, help = false;
};

Loaded<Arguments> parse(int argc, char** argv) {
  Loaded<Arguments> result;
  Arguments arguments;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const bool takes_value = word == "--out" || word == "--every" || word == "--set";
    if (takes_value && i + 1 >= argc) {
      result.problems.push_back({word, "needs a value"});
    } else if (word == "--out") {
      arguments.out = argv[++i];
    } else if (word == "--set") {
      arguments.overrides.push_back(argv[++i]);
    } else if (word == "--every") {
      const std::optional<double> n = parseNumber(argv[++i]);
      if (!n || *n < 1.0 || *n > 1e9 || *n != std::floor(*n)) {
        result.problems.push_back({word, std::string("'") + argv[i] + "' is no whole number from 1 to 1e9"});
      } else {
        arguments.every = static_cast<std::int64_t>(*n);
      }
    } else if (word == "--quiet") {
      arguments.quiet = true;
    } else if (word == "--list") {
      arguments.list = true;
    } else if (word == "--help" || word == "-h") {
      arguments.help = true;
    } else if (word.rfind("__", 0) == 0) {
      continue;  // roslaunch adds its remappings (__name:=, __log:=)
    } else if (word.rfind("-", 0) == 0) {
      result.problems.push_back({word, "is no option; known are --out, --every, --set, --quiet, --list, --help"});
    } else if (!arguments.scene.empty()) {
      result.problems.push_back({word, "is a second scene; one at a time"});
    } else {
      arguments.scene = word;
    }
  }
  if (arguments.scene.empty() && !arguments.list && !arguments.help)
    result.problems.push_back({"SCENE", "is missing: a shipped name (--list) or the path of a scene YAML"});
  if (result.problems.empty()) result.value = arguments;
  return result;
}

int refuse(const Problems& problems) {
  std::cerr << problemText(problems) << problems.size() << (problems.size() == 1 ? " problem" : " problems")
            << ", not started\n";
  return kBadInput;
}

struct Run {
  std::string result = "finished";
  double wall = 0.0;  ///< [s], writing included.
  Problems problems;
};

Run runScene(const Scene& scene, std::int64_t every, const std::string& csv, Simulator& simulator) {
  Run run;
  Loaded<RunTable> table = RunTable::create(csv, simulator, every);
  if (!table) {
    run.problems = table.problems;
    return run;
  }
  const double dt = simulator.config().dt;
  const std::int64_t ticks = sceneTicks(scene, dt);
  ProgressBar bar(scene.name);
  const Clock::time_point begun = Clock::now();
  table.value->add(simulator, 0.0);
  for (std::int64_t tick = 0; tick < ticks; ++tick) {
    commandScene(scene, static_cast<double>(tick) * dt, dt, simulator);
    const Clock::time_point before = Clock::now();
    const StepStatus status = simulator.step();
    table.value->add(simulator, std::chrono::duration<double>(Clock::now() - before).count());
    if (status != StepStatus::kOk) {
      run.result = "diverged after " + numberText(static_cast<double>(tick) * dt) +
                   " s: the next state would not have been "
                   "finite; the last good one is the last line";
      break;
    }
    if (interrupted) {
      run.result = "interrupted";
      break;
    }
    // The clock is asked now and then only.
    if (tick % 64 == 0) bar.show(static_cast<double>(tick) / static_cast<double>(ticks));
  }
  bar.finish();
  run.problems = table.value->close();
  run.wall = std::chrono::duration<double>(Clock::now() - begun).count();
  return run;
}

int run(int argc, char** argv) {
  const Loaded<Arguments> parsed = parse(argc, argv);
  if (!parsed) {
    const int code = refuse(parsed.problems);
    std::cerr << kUsage;
    return code;
  }
  const Arguments& arguments = *parsed.value;
  const std::string share = shareFolderBesideProgram();
  if (arguments.help) {
    std::cout << kUsage;
    return 0;
  }
  if (arguments.list) {
    for (const auto& [name, path] : shippedScenes(share)) std::cout << name << "\n";
    return 0;
  }

  const Loaded<std::string> file = findShipped(shippedScenes(share), "scene", arguments.scene, "SCENE");
  if (!file) return refuse(file.problems);
  Loaded<Scene> scene = loadScene(*file.value, share);
  Problems problems = scene.problems;
  Scene unread;  // parameters are checked even where the scene is refused
  for (const std::string& word : arguments.overrides) {
    const std::size_t equals = word.find('=');
    if (equals == std::string::npos) {
      problems.push_back({"--set", "'" + word + "' is not KEY=VALUE"});
      continue;
    }
    const Problems refused =
        overrideParameter(scene ? *scene.value : unread, word.substr(0, equals), word.substr(equals + 1), "--set ");
    problems.insert(problems.end(), refused.begin(), refused.end());
  }
  if (!problems.empty()) return refuse(problems);
  if (const Problems refused = scene.value->config.validate(); !refused.empty()) return refuse(refused);
  const Loaded<LoadedScene> loaded = loadSceneFiles(*scene.value, share);
  if (!loaded) return refuse(loaded.problems);
  Loaded<Simulator> simulator = startScene(*loaded.value, scene.value->config);
  if (!simulator) return refuse(simulator.problems);

  std::error_code error;
  fs::create_directories(arguments.out, error);
  if (!fs::is_directory(arguments.out, error))
    return refuse({{"--out " + arguments.out, "is no folder and cannot be made"}});
  const std::string stem = (fs::path(arguments.out) / scene.value->name).string();
  if (!arguments.quiet) {
    for (const std::vector<std::string>* notes :
         {&std::as_const(scene).notes, &loaded.value->notes, &std::as_const(simulator).notes})
      for (const std::string& note : *notes) std::cout << note << "\n";
    for (const std::string& line : simulator.value->loadReport()) std::cout << line << "\n";
  }

  std::signal(SIGINT, onSignal);
  std::signal(SIGTERM, onSignal);
  const Run result = runScene(loaded.value->scene, arguments.every, stem + ".csv", *simulator.value);
  problems = result.problems;
  RunManifest manifest;
  manifest.program = "headless";
  manifest.result = result.result;
  manifest.files = loaded.value->files;
  manifest.more["scene"] = scene.value->name;
  manifest.more["description"] = scene.value->description;
  for (const Problem& p : writeManifest(stem + ".manifest.yaml", manifest, *simulator.value)) problems.push_back(p);

  if (!arguments.quiet || result.result != "finished") {
    const double simulated = static_cast<double>(simulator.value->stepCount()) * simulator.value->config().dt;
    const StepEvents& events = simulator.value->events();
    std::cout << (simulator.value->isBeyondCertificate() ? "UNSTABLE " : "") << scene.value->name << ": " << result.result << "; " << numberText(simulated) << " s simulated in "
              << numberText(result.wall) << " s, real-time factor "
              << numberText(simulated / std::max(1e-9, result.wall)) << "; passed through " << events.passed_through
              << ", commands timed out " << events.command_timeouts << "; " << stem << ".csv, " << stem
              << ".manifest.yaml\n";
  }
  if (!problems.empty()) {
    std::cerr << problemText(problems);
    return kBrokeDown;
  }
  if (result.result == "interrupted") return kInterrupted;
  return result.result == "finished" ? 0 : kBrokeDown;
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim

int main(int argc, char** argv) { return ellipsoid_vehicle_sim::run(argc, argv); }
