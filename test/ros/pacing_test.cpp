#include "ellipsoid_vehicle_sim/ros/pacing.h"

#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/ros/run_statistics.h"

namespace ellipsoid_vehicle_sim {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;

const WallPacer::Clock::time_point kStart{};

TEST(WallPacer, MakesATickAMillisecondAtFactorOne) {
  WallPacer pacer(1.0, 1e-3);
  pacer.start(kStart, 100);
  EXPECT_EQ(pacer.due(kStart + microseconds(900), 100), 0);
  EXPECT_EQ(pacer.due(kStart + microseconds(20100), 100), 20);
  EXPECT_EQ(pacer.due(kStart + microseconds(20100), 120), 0);
}

TEST(WallPacer, FactorScalesTheTicks) {
  WallPacer pacer(4.0, 1e-3);
  pacer.start(kStart, 0);
  EXPECT_EQ(pacer.due(kStart + microseconds(10100), 0), 40);
}

TEST(WallPacer, FactorZeroIsAlwaysDue) {
  WallPacer pacer(0.0, 1e-3);
  pacer.start(kStart, 0);
  EXPECT_GT(pacer.due(kStart, 1000000), 0);
  EXPECT_EQ(pacer.wait(kStart, 5), 0.0);
}

TEST(WallPacer, WaitsUntilTheTickIsDue) {
  WallPacer pacer(1.0, 1e-3);
  pacer.start(kStart, 0);
  EXPECT_NEAR(pacer.wait(kStart + milliseconds(2), 5), 0.003, 1e-9);
  EXPECT_EQ(pacer.wait(kStart + milliseconds(9), 5), 0.0);
}

TEST(WallPacer, WhatIsFarBehindIsGivenUpAndCounted) {
  WallPacer pacer(1.0, 1e-3);
  pacer.start(kStart, 0);
  const auto late = kStart + milliseconds(500);
  EXPECT_LE(pacer.due(late, 0), 1);
  EXPECT_NEAR(pacer.lost(), 0.5, 1e-3);
  EXPECT_EQ(pacer.due(late + microseconds(10100), 0), 10);
}

TEST(RunStatistics, QuantileIsTheSlowStepOfAHundred) {
  RunStatistics statistics;
  for (int i = 0; i < 980; ++i) statistics.addStep(microseconds(5), 1e-3, 4);
  for (int i = 0; i < 20; ++i) statistics.addStep(microseconds(50), 2e-3, 6);
  EXPECT_NEAR(statistics.meanStepTime(), 5.9e-6, 1e-12);
  EXPECT_NEAR(statistics.stepTimeQuantile(0.5), 5e-6, 0.01 * 5e-6);  // a bin is one per cent wide
  EXPECT_NEAR(statistics.stepTimeQuantile(0.99), 5e-5, 0.01 * 5e-5);
  EXPECT_EQ(statistics.largestPenetration(), 2e-3);
  EXPECT_EQ(statistics.mostContacts(), 6);
}

TEST(RunStatistics, StepTimesBeyondTheBinsAreStillCounted) {
  RunStatistics statistics;
  statistics.addStep(nanoseconds(0), 0.0, 0);
  statistics.addStep(std::chrono::hours(1), 0.0, 0);
  EXPECT_EQ(statistics.steps(), 2);
}

TEST(RunStatistics, DistanceIsHorizontalAndSkipsAJump) {
  RunStatistics statistics;
  statistics.addPosition({0.0, 0.0, 0.0});
  statistics.addPosition({3.0, 4.0, 12.0});
  statistics.jump();
  statistics.addPosition({100.0, 0.0, 0.0});
  statistics.addPosition({101.0, 0.0, 0.0});
  EXPECT_DOUBLE_EQ(statistics.distance(), 6.0);
}

TEST(RunStatistics, ReportHasItsKeysInOrder) {
  RunStatistics statistics;
  statistics.addStep(microseconds(5), 1.5e-3, 4);
  std::istringstream report(statistics.report(20.0, 4.0, "ok"));
  std::vector<std::string> keys;
  for (std::string line; std::getline(report, line);) keys.push_back(line.substr(0, line.find(':')));
  const std::vector<std::string> expected = {"simulated time", "distance",      "real-time factor",
                                             "step time mean", "step time p99", "largest penetration",
                                             "most contacts",  "result"};
  EXPECT_EQ(keys, expected);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
