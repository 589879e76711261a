#include <gtest/gtest.h>

#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "ellipsoid_vehicle_sim/description/shipped_files.h"
#include "ellipsoid_vehicle_sim/scene/run_record.h"
#include "ellipsoid_vehicle_sim/scene/scene.h"
#include "support/temporary_files.h"

namespace ellipsoid_vehicle_sim {
namespace {

const std::string kPackage = PACKAGE_DIR;
const std::string kShare = SHARE_DIR;
const std::string kHeadless = PROGRAM_DIR "/headless";

std::string textOf(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::vector<std::string> linesOf(const std::string& path) {
  std::vector<std::string> lines;
  std::ifstream in(path);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::vector<std::string> cellsOf(const std::string& line) {
  std::vector<std::string> cells;
  std::string cell;
  for (const char c : line + ",") {
    if (c != ',') {
      cell += c;
      continue;
    }
    cells.push_back(cell);
    cell.clear();
  }
  return cells;
}

/// A line without its last cell, the step time.
std::string withoutTime(const std::string& line) { return line.substr(0, line.rfind(',')); }

double cell(const std::string& header, const std::string& line, const std::string& column) {
  const std::vector<std::string> names = cellsOf(header), cells = cellsOf(line);
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i] == column) return std::stod(cells.at(i));
  ADD_FAILURE() << "no column " << column;
  return 0.0;
}

class SceneFile : public ::testing::Test {
 protected:
  std::string write(const std::string& text) { return folder_.write("scene.yaml", text); }
  Loaded<Scene> load(const std::string& text) { return loadScene(write(text), kShare); }

  /// Exit code; what it printed is in out_.
  int headless(const std::string& arguments) {
    const std::string log = folder_.folder("") + "/out.txt";
    const int status = std::system(("'" + kHeadless + "' " + arguments + " > '" + log + "' 2>&1").c_str());
    out_ = textOf(log);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  TemporaryFiles folder_;
  std::string out_;
};

const char* kFall = R"(
vehicle: rugby_ball
world: flat
parameters: {gravity: 10, dt: 0.002}
start: {position: [1, 2, 100], velocity: [3, 0, 0]}
duration: 2
)";

TEST_F(SceneFile, TakesTheVehiclesOwnParametersBelowTheScenes) {
  const Loaded<Scene> scene = load(kFall);
  ASSERT_TRUE(scene) << problemText(scene.problems);
  EXPECT_TRUE(scene.value->config.allow_no_wheels) << "rugby_ball.yaml says so";
  EXPECT_EQ(scene.value->config.gravity, 10.0);
  EXPECT_EQ(scene.value->horizon, 2.0) << "the duration, unless said otherwise";
}

TEST_F(SceneFile, TellsEveryProblemAtOnceWithItsLine) {
  const Loaded<Scene> scene = load(R"(vehicle: no_such_car
world: flat
parameters:
  gravty: 9.81
  dt: 3
start: {set_down: [0, 0, 0], velocity: [1, 0, 0]}
commands:
  - {at: 1, speed: 2}
  - {at: 1, speed: nan}
  - {speed: 1, yaw_rate: 1, steering_angle: 1}
duration: -1
measure: [energie]
closed_form: tea
colour: red
)");
  ASSERT_FALSE(scene);
  const std::string problems = problemText(scene.problems);
  for (const char* expected :
       {"scene.yaml:1: 'no_such_car' is no known vehicle; known vehicles: ", "scene.yaml:4: unknown key 'gravty'",
        "scene.yaml:5 dt: ", "scene.yaml:6: 'set_down' together with a position or velocity",
        "scene.yaml:6: a start that is not set down needs a 'position'", "scene.yaml:9: 'speed' is no number: nan",
        "scene.yaml:9: 'at' is 1, not after the command before it at 1", "scene.yaml:10: a command without 'at'",
        "scene.yaml:10: 'yaw_rate' together with 'steering_angle'",
        "scene.yaml:11: 'duration' is -1; allowed is between 1e-6 and 1e6", "scene.yaml:12: unknown measure 'energie'",
        "scene.yaml:13: unknown closed form 'tea'", "scene.yaml:14: unknown key 'colour'"})
    EXPECT_NE(problems.find(expected), std::string::npos) << expected << "\nin\n" << problems;
}

TEST_F(SceneFile, RefusesAHorizonAndCommandsBeyondTheEnd) {
  const Loaded<Scene> scene = load(std::string(kFall) + "horizon: 3\ncommands: [{at: 2, speed: 1}]\n");
  ASSERT_FALSE(scene);
  const std::string problems = problemText(scene.problems);
  EXPECT_NE(problems.find("'horizon' is 3, after the end; allowed is up to duration = 2"), std::string::npos)
      << problems;
  EXPECT_NE(problems.find("'at' is 2, after the end"), std::string::npos) << problems;
}

TEST_F(SceneFile, EveryShippedSceneLoadsAndStarts) {
  const ShippedNames scenes = shippedScenes(kShare);
  EXPECT_GE(scenes.size(), 1u);
  for (const auto& [name, path] : scenes) {
    const Loaded<Scene> scene = loadScene(path, kShare);
    ASSERT_TRUE(scene) << problemText(scene.problems);
    const Loaded<LoadedScene> loaded = loadSceneFiles(*scene.value, kShare);
    ASSERT_TRUE(loaded) << problemText(loaded.problems);
    const Loaded<Simulator> simulator = startScene(*loaded.value, scene.value->config);
    EXPECT_TRUE(simulator) << name << "\n" << problemText(simulator.problems);
    EXPECT_FALSE(scene.value->description.empty()) << name;
  }
}

TEST_F(SceneFile, CommandsBeginAtTheTickNearestToTheirTime) {
  Loaded<Scene> scene = load(R"(
vehicle: car
world: flat
commands: [{at: 0, speed: 1}, {at: 0.1, coast: true}]
duration: 1
)");
  ASSERT_TRUE(scene) << problemText(scene.problems);
  const Loaded<LoadedScene> loaded = loadSceneFiles(*scene.value, kShare);
  ASSERT_TRUE(loaded) << problemText(loaded.problems);
  Loaded<Simulator> simulator = startScene(*loaded.value, scene.value->config);
  ASSERT_TRUE(simulator) << problemText(simulator.problems);
  const auto kindAt = [&](double time) {
    commandScene(*scene.value, time, 1e-3, *simulator.value);
    return simulator.value->state().drive.command.kind;
  };
  EXPECT_EQ(kindAt(0.0), DriveCommand::Kind::kTwist);
  EXPECT_EQ(kindAt(0.099), DriveCommand::Kind::kTwist);
  EXPECT_EQ(kindAt(100 * 1e-3), DriveCommand::Kind::kCoast) << "100 times 0.001 is not 0.1 to the last bit";
}

// Semi-implicit Euler in a fall: z_n = z_0 - g dt^2 n (n + 1) / 2; tolerance: rounding of 1000 sums of about 100.
TEST_F(SceneFile, HeadlessWritesTheFallOfABall) {
  const std::string scene = write(std::string(kFall) + "description: a fall\n");
  ASSERT_EQ(headless("'" + scene + "' --out '" + folder_.folder("") + "/run' --set integrator=semi_implicit_euler"), 0)
      << out_;
  const std::vector<std::string> lines = linesOf(folder_.folder("") + "/run/scene.csv");
  ASSERT_EQ(lines.size(), 1u + 1u + 1000u) << "header, start, and one for every tick";
  const std::string& header = lines.front();
  const std::string& last = lines.back();
  EXPECT_NEAR(cell(header, last, "z"), 100.0 - 10.0 * 4e-6 * 1000.0 * 1001.0 / 2.0, 1e-11);
  EXPECT_NEAR(cell(header, last, "x"), 1.0 + 3.0 * 2.0, 1e-12);
  EXPECT_NEAR(cell(header, last, "vz"), -20.0, 1e-12);
  EXPECT_EQ(cell(header, last, "step"), 1000.0);
  EXPECT_NEAR(cell(header, last, "time"), 2.0, 1e-15);
  EXPECT_EQ(cell(header, last, "contacts"), 0.0);
  const double energy = 5.0 * 10.0 * cell(header, last, "z") + 0.5 * 5.0 * (9.0 + 400.0);
  EXPECT_NEAR(cell(header, last, "energy"), energy, 1e-9);
  EXPECT_EQ(cellsOf(header).back(), "step_time");
}

TEST_F(SceneFile, TwoRunsDifferInTheLastColumnOnly) {
  const std::string scene =
      write("vehicle: car\nworld: flat\ncommands: [{at: 0, speed: 2, yaw_rate: 0.3}]\nduration: 0.5\n");
  for (const char* run : {"one", "two"})
    ASSERT_EQ(headless("'" + scene + "' --quiet --out '" + folder_.folder("") + "/" + run + "'"), 0) << out_;
  const auto one = linesOf(folder_.folder("") + "/one/scene.csv"), two = linesOf(folder_.folder("") + "/two/scene.csv");
  ASSERT_EQ(one.size(), 502u);
  ASSERT_EQ(one.size(), two.size());
  for (std::size_t i = 0; i < one.size(); ++i) ASSERT_EQ(withoutTime(one[i]), withoutTime(two[i]));
  EXPECT_GT(cell(one[0], one[501], "wheel_speed:rear_left_axle"), 1.0) << "it drives";
}

TEST_F(SceneFile, ManifestNamesParametersAndHashesOfVehicleAndWorld) {
  const std::string scene = write(kFall);
  ASSERT_EQ(headless("'" + scene + "' --quiet --out '" + folder_.folder("") + "'"), 0) << out_;
  const std::string manifest = textOf(folder_.folder("") + "/scene.manifest.yaml");
  for (const char* expected : {"integrator: rk4", "dt: 0.002", "gravity: 10", "result: \"finished\"", "seed: ~",
                               "commit: \"", "rugby_ball.urdf", "flat.yaml", "flat.stl"})
    EXPECT_NE(manifest.find(expected), std::string::npos) << expected << "\nin\n" << manifest;
}

// "abc" is the first example of FIPS 180-2, appendix B; the empty message is in NIST's list of short messages.
TEST_F(SceneFile, FileHashIsSha256) {
  EXPECT_EQ(fileHash(folder_.write("abc", "abc")).value_or(""),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(fileHash(folder_.write("empty", "")).value_or(""),
            "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_FALSE(fileHash(folder_.folder("") + "/none"));
}

TEST_F(SceneFile, HeadlessRefusesBadInputWithCodeTwo) {
  EXPECT_EQ(headless("no_such_scene"), 2);
  EXPECT_NE(out_.find("'no_such_scene' is no known scene; known scenes: "), std::string::npos) << out_;
  const std::string scene = write(kFall);
  EXPECT_EQ(headless("'" + scene + "' --set dt=0.5 --set colour=red --every 0"), 2);
  EXPECT_NE(out_.find("--every: '0' is no whole number"), std::string::npos) << out_;
  EXPECT_EQ(headless("'" + scene + "' --set dt=0.5 --set colour=red"), 2);
  EXPECT_NE(out_.find("--set dt: "), std::string::npos) << out_;
  EXPECT_NE(out_.find("--set colour: "), std::string::npos) << out_;
  EXPECT_EQ(headless("'" + scene + "' --out /proc/nothing_can_be_made_here"), 2) << out_;
}

// Explicit Euler at twenty times the default step is far outside of what a car's contacts allow.
TEST_F(SceneFile, HeadlessSaysWhenARunBreaksDown) {
  const std::string scene = write(R"(
vehicle: car
world: flat
parameters: {dt: 0.02, integrator: explicit_euler, allow_unstable: true}
commands: [{at: 0, speed: 5}]
duration: 60
)");
  EXPECT_EQ(headless("'" + scene + "' --quiet --out '" + folder_.folder("") + "'"), 1) << out_;
  EXPECT_NE(out_.find("diverged after "), std::string::npos) << out_;
  const auto lines = linesOf(folder_.folder("") + "/scene.csv");
  EXPECT_NE(lines.back().find("diverged"), std::string::npos) << lines.back();
  EXPECT_EQ(lines.back().find("nan"), std::string::npos);
  EXPECT_NE(textOf(folder_.folder("") + "/scene.manifest.yaml").find("result: \"diverged after"), std::string::npos);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
