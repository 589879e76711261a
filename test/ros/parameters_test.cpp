#include "ellipsoid_vehicle_sim/ros/parameters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "ellipsoid_vehicle_sim/ros/running_parameters.h"

namespace ellipsoid_vehicle_sim {
namespace {

/// Text of all problems of one source of values.
std::string problemsOf(const ParameterValues& values) { return problemText(parametersFrom({{"~", values}}).problems); }

TEST(Parameters, DefaultsOfAnEmptyServerAreThoseOfTheStructs) {
  const auto loaded = parametersFrom({});
  ASSERT_TRUE(loaded) << problemText(loaded.problems);
  EXPECT_EQ(loaded.value->config.dt, SimConfig{}.dt);
  EXPECT_EQ(loaded.value->options.publish_rate, NodeOptions{}.publish_rate);
  EXPECT_FALSE(loaded.value->config.stiffness);
}

TEST(Parameters, EveryDefaultIsAcceptedByItsOwnRow) {
  for (const auto& row : simConfigParameters()) {
    const auto value = row.get(SimConfig{});
    EXPECT_FALSE(value && refusal(row.spec, *value)) << row.spec.key;
  }
  for (const auto& row : nodeParameters()) {
    const auto value = row.get(NodeOptions{});
    EXPECT_FALSE(value && refusal(row.spec, *value)) << row.spec.key;
  }
}

TEST(Parameters, EveryRowReadsBackWhatItWrote) {
  const auto check = [](const auto& table, auto options) {
    for (const auto& row : table) {
      ParameterValue value = 1.0;
      switch (row.spec.kind) {
        case ParameterKind::kFlag:
          value = true;
          break;
        case ParameterKind::kNumber:
          value = row.spec.minimum + 0.25 * (row.spec.maximum - row.spec.minimum);
          if (row.spec.whole) value = std::floor(std::get<double>(value));
          break;
        case ParameterKind::kChoice:
          value = row.spec.choices.back();
          break;
        case ParameterKind::kText:
          value = std::string("text");
          break;
        case ParameterKind::kNumberList:
          value = std::vector<double>(row.spec.length, 2.0);
          break;
        case ParameterKind::kTextList:
          value = std::vector<std::string>{"a", "b"};
          break;
      }
      ASSERT_FALSE(refusal(row.spec, value)) << row.spec.key;
      row.set(options, value);
      ASSERT_TRUE(row.get(options)) << row.spec.key;
      EXPECT_EQ(*row.get(options), value) << row.spec.key;
    }
  };
  check(simConfigParameters(), SimConfig{});
  check(nodeParameters(), NodeOptions{});
  check(lidarParameters(), LidarSpec{});
}

TEST(Parameters, LaterSourceWins) {
  const auto loaded =
      parametersFrom({{"car.yaml ", {{"mu_static", 1.5}, {"max_speed", 7.0}}}, {"~", {{"max_speed", 9.0}}}});
  ASSERT_TRUE(loaded) << problemText(loaded.problems);
  EXPECT_EQ(loaded.value->config.mu_static, 1.5);
  EXPECT_EQ(loaded.value->config.max_speed, 9.0);
}

TEST(Parameters, WholeNumberIsANumber) {
  const auto loaded = parametersFrom({{"~", {{"max_speed", std::int64_t{12}}}}});
  ASSERT_TRUE(loaded) << problemText(loaded.problems);
  EXPECT_EQ(loaded.value->config.max_speed, 12.0);
}

TEST(Parameters, MisspeltKeyIsRefusedWithTheRightOne) {
  EXPECT_EQ(problemsOf({{"stifness", 5e4}}),
            "~stifness: there is no such parameter (its value is '50000'); did you mean 'stiffness'?\n");
}

TEST(Parameters, MisspeltChoiceIsRefusedWithTheRightOne) {
  const std::string text = problemsOf({{"integrator", std::string("rk5")}});
  EXPECT_NE(text.find("'rk5' is unknown, allowed is rk4 | semi_implicit_euler | explicit_euler | rk4_events | "
                      "dormand_prince | linearly_implicit; did you mean 'rk4'?"),
            std::string::npos)
      << text;
}

TEST(Parameters, ValueOutOfRangeIsRefusedWithTheRangeAndUnit) {
  EXPECT_EQ(problemsOf({{"dt", -0.001}}), "~dt: '-0.001' is out of range, allowed is 1.0e-06 ... 0.1 [s]\n");
  EXPECT_NE(problemsOf({{"dt", std::nan("")}}).find("out of range"), std::string::npos);
  EXPECT_NE(problemsOf({{"publish_rate", std::int64_t{0}}}).find("out of range"), std::string::npos);
}

TEST(Parameters, WholeNumbersHaveNoFraction) {
  EXPECT_EQ(problemsOf({{"contact_substeps", 2.5}}),
            "~contact_substeps: '2.5' is no whole number, allowed is whole numbers 1 ... 64\n");
  EXPECT_NE(problemsOf({{"contact_substeps", std::int64_t{65}}}).find("whole numbers 1 ... 64"), std::string::npos);
  EXPECT_EQ(problemsOf({{"contact_substeps", std::int64_t{8}}}), "");
}

TEST(Parameters, WrongTypeIsRefusedAndTheYamlTrapExplained) {
  EXPECT_EQ(problemsOf({{"dt", std::string("1e-3")}}),
            "~dt: '1e-3' was read, expected a number (YAML reads 1e-3 as text: write 1.0e-3)\n");
  EXPECT_NE(problemsOf({{"lockstep", 1.0}}).find("expected true or false"), std::string::npos);
  EXPECT_NE(problemsOf({{"start", std::vector<double>{1.0, 2.0}}}).find("has 2 numbers, expected 3"),
            std::string::npos);
}

TEST(Parameters, AllProblemsAreToldAtOnce) {
  const auto loaded = parametersFrom({{"~", {{"dt", -1.0}, {"integrator", std::string("rk5")}, {"gravitty", 9.81}}}});
  EXPECT_FALSE(loaded);
  EXPECT_EQ(loaded.problems.size(), 3u) << problemText(loaded.problems);
}

TEST(Parameters, LockstepNeedsOurClock) {
  EXPECT_NE(problemsOf({{"lockstep", true}, {"clock", std::string("wall")}}).find("needs clock: publish"),
            std::string::npos);
}

TEST(Parameters, LockstepTopicsAreTopicsOfCommands) {
  const std::vector<std::string> misspelt = {"cmd_val"}, twice = {"cmd_vel", "cmd_vel"};
  EXPECT_NE(problemsOf({{"lockstep_topics", misspelt}}).find("allowed are cmd_vel, ackermann_cmd, joint_commands"),
            std::string::npos);
  EXPECT_NE(problemsOf({{"lockstep_topics", twice}}).find("stands there twice"), std::string::npos);
}

TEST(Parameters, OdometryDecidesWhetherWorldAndOdomAreOneFrame) {
  EXPECT_EQ(worldFrameOf(NodeOptions{}), "odom");
  const auto encoders = parametersFrom({{"~", {{"odometry", std::string("encoders")}}}});
  ASSERT_TRUE(encoders) << problemText(encoders.problems);
  EXPECT_EQ(worldFrameOf(encoders.value->options), "map");
  EXPECT_NE(problemsOf({{"world_frame", std::string("map")}}).find("they are one frame"), std::string::npos);
  EXPECT_NE(
      problemsOf({{"odometry", std::string("encoders")}, {"world_frame", std::string("odom")}}).find("they are two"),
      std::string::npos);
}

TEST(Parameters, WhatMayChangeWhileRunningHasOneRangeAndDefaultInTableAndCfg) {
  std::vector<std::string> keys;
  for (const auto& row : nodeParameters()) {
    if (!row.spec.running) continue;
    keys.push_back(row.spec.key);
    for (const auto& [key, member] : runningParameterKeys()) {
      if (key != row.spec.key) continue;
      EXPECT_EQ(RunningConfig::__getMin__().*member, row.spec.minimum) << key;
      EXPECT_EQ(RunningConfig::__getMax__().*member, row.spec.maximum) << key;
      EXPECT_EQ(RunningConfig::__getDefault__().*member, numberOf(*row.get(NodeOptions{}))) << key;
    }
  }
  std::vector<std::string> known;
  for (const auto& entry : runningParameterKeys()) known.push_back(entry.first);
  std::sort(keys.begin(), keys.end());
  std::sort(known.begin(), known.end());
  EXPECT_EQ(keys, known);
  for (const auto& row : simConfigParameters()) EXPECT_FALSE(row.spec.running) << row.spec.key;
}

TEST(Parameters, LidarsHaveTheirParametersBelowTheirNames) {
  const std::vector<std::string> names = {"front"}, taken = {"dt"};
  const auto loaded = parametersFrom({{"car.yaml ", {{"lidars", names}, {"front/samples", std::int64_t{31}}}},
                                      {"~", {{"front/rate", 10.0}}}});
  ASSERT_TRUE(loaded) << problemText(loaded.problems);
  ASSERT_EQ(loaded.value->options.lidars.size(), 1u);
  EXPECT_EQ(loaded.value->options.lidars[0].spec.samples, 31.0);
  EXPECT_EQ(loaded.value->options.lidars[0].spec.rate, 10.0);
  EXPECT_EQ(problemsOf({{"lidars", names}, {"front/rat", 10.0}}),
            "~front/rat: there is no such parameter (its value is '10'); did you mean 'rate'?\n");
  EXPECT_NE(problemsOf({{"rear/rate", 10.0}}).find("~rear/rate: there is no such parameter"), std::string::npos);
  EXPECT_EQ(problemsOf({{"lidars", taken}}), "~lidars: 'dt' is the name of a parameter: call the lidar otherwise\n");
}

/// The file of the package, written anew first where that is asked for.
std::string shipped(const std::string& file, const std::string& text) {
  const std::string path = std::string(PACKAGE_DIR) + file;
  if (std::getenv("ELLIPSOID_VEHICLE_SIM_UPDATE") != nullptr) std::ofstream(path) << text;
  std::ifstream in(path);
  std::ostringstream read;
  read << in.rdbuf();
  return read.str();
}

TEST(Parameters, ManualIsTheShippedFile) {
  EXPECT_EQ(shipped("/launch/simulator.yaml", parameterManual()), parameterManual())
      << "run this test with ELLIPSOID_VEHICLE_SIM_UPDATE=1 to write it";
}

TEST(Parameters, ReferenceIsTheShippedFile) {
  EXPECT_EQ(shipped("/docs/parameters.md", parameterReference()), parameterReference())
      << "run this test with ELLIPSOID_VEHICLE_SIM_UPDATE=1 to write it";
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
