// vehicle_trial VEHICLE WORLD: puts a vehicle through its paces in a world, without a ROS master; one line of JSON.

#include <filesystem>
#include <iostream>

#include "ellipsoid_vehicle_sim/description/shipped_files.h"
#include "ellipsoid_vehicle_sim/scene/vehicle_trial.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr int kFailed = 1, kBadInput = 2;

constexpr const char* kUsage =
    "usage: vehicle_trial VEHICLE WORLD [--set KEY=VALUE]... [--package-dir DIR]...\n"
    "Stands, drives, turns, stops and climbs VEHICLE (a shipped name or the path of a URDF) in WORLD (a shipped name or\n"
    "the path of a mesh or world YAML), as far as its ground allows, and prints one line of JSON.\n"
    "  --set KEY=VALUE     a parameter of the physics (launch/simulator.yaml), over VEHICLE.yaml beside the vehicle\n"
    "  --package-dir DIR   a folder searched for package://NAME/... too, after the vehicle's own\n"
    "exit code: 0 all trials passed, 1 one failed or the vehicle was refused, 2 bad usage\n";

int refuse(const Problems& problems) {
  std::cerr << problemText(problems) << kUsage;
  return kBadInput;
}

int run(int argc, char** argv) {
  std::vector<std::string> names, overrides, package_dirs;
  Problems problems;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--help" || word == "-h") {
      std::cout << kUsage;
      return 0;
    }
    if (word == "--set" || word == "--package-dir") {
      if (i + 1 >= argc) {
        problems.push_back({word, "needs a value"});
      } else {
        (word == "--set" ? overrides : package_dirs).push_back(argv[++i]);
      }
    } else if (word.rfind("-", 0) == 0) {
      problems.push_back({word, "is no option; known are --set, --package-dir, --help"});
    } else {
      names.push_back(word);
    }
  }
  if (names.size() != 2)
    problems.push_back({"arguments", "allowed are one VEHICLE and one WORLD, given are " + std::to_string(names.size())});
  if (!problems.empty()) return refuse(problems);

  const std::string share = shareFolderBesideProgram();
  const auto vehicle = findShipped(shippedVehicles(share), "vehicle", names[0], "VEHICLE");
  const auto world = findShipped(shippedWorlds(share), "world", names[1], "WORLD");
  for (const auto* found : {&vehicle, &world})
    problems.insert(problems.end(), found->problems.begin(), found->problems.end());
  if (!problems.empty()) return refuse(problems);

  Loaded<Scene> scene = sceneOf(*vehicle.value, *world.value, share);
  if (scene && !package_dirs.empty()) {
    // Besides what VEHICLE.yaml says, or the vehicle's own.
    std::vector<std::string>& dirs = scene.value->package_dirs;
    if (dirs.empty()) dirs = packageDirsOf(*vehicle.value);
    dirs.insert(dirs.end(), package_dirs.begin(), package_dirs.end());
  }
  problems = scene.problems;
  for (const std::string& word : overrides) {
    const std::size_t equals = word.find('=');
    Scene unread;
    const Problems refused =
        equals == std::string::npos
            ? Problems{{"--set", "'" + word + "' is not KEY=VALUE"}}
            : overrideParameter(scene ? *scene.value : unread, word.substr(0, equals), word.substr(equals + 1), "--set ");
    problems.insert(problems.end(), refused.begin(), refused.end());
  }
  if (!problems.empty()) return refuse(problems);
  if (const Problems refused = scene.value->config.validate(); !refused.empty()) return refuse(refused);

  const TrialResult result = tryVehicle(*scene.value, share);
  std::cout << trialJson(result) << "\n";
  return result.passed() ? 0 : kFailed;
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim

int main(int argc, char** argv) { return ellipsoid_vehicle_sim::run(argc, argv); }
