// The dial: how exact, to which integrator and step.
#include "ellipsoid_vehicle_sim/vehicle/accuracy.h"

#include <gtest/gtest.h>

#include "ellipsoid_vehicle_sim/vehicle/parameter_table.h"
#include "support/motions.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

const std::vector<AccuracyPoint> kCurves = {{true, "semi_implicit_euler", 0.1, 1e-3, 1.0},
                                            {true, "semi_implicit_euler", 0.5, 1e-2, 1.0},
                                            {true, "rk4", 0.5, 1e-4, 3.0},
                                            {true, "rk4", 2.0, 5e-3, 3.0},
                                            {false, "rk4_events", 1.0, 1e-6, 10.0}};

StabilityCertificate certificateOf(double fastest, double limit) {
  StabilityCertificate certificate;
  StabilityMode mode;
  mode.frequency = fastest;
  certificate.modes.push_back(mode);
  certificate.largest_step.fill(limit);
  return certificate;
}

TEST(Accuracy, TakesTheCheapestThatHoldsTheTarget) {
  const StabilityCertificate certificate = certificateOf(100.0, 0.1);
  // 1e-2: Euler at 5 ms costs 1 / 5 ms, RK4 at 20 ms 3 / 20 ms.
  AccuracyChoice choice = chooseAccuracy(1e-2, true, certificate, kCurves);
  EXPECT_EQ(choice.integrator, IntegratorKind::kRk4);
  EXPECT_EQ(choice.dt, 0.02);
  EXPECT_TRUE(choice.reached);
  // 1e-3: Euler at 1 ms against RK4 at 5 ms.
  choice = chooseAccuracy(1e-3, true, certificate, kCurves);
  EXPECT_EQ(choice.integrator, IntegratorKind::kRk4);
  EXPECT_EQ(choice.dt, 5e-3);
  EXPECT_EQ(chooseAccuracy(1e-3, false, certificate, kCurves).integrator, IntegratorKind::kRk4Events);
}

TEST(Accuracy, KeepsATenthOfTheCertificateInHand) {
  const AccuracyChoice choice = chooseAccuracy(1e-2, true, certificateOf(100.0, 3e-3), kCurves);
  EXPECT_LE(choice.dt, 0.9 * 3e-3);
  EXPECT_GE(choice.dt, 2e-3);
  EXPECT_NE(choice.reason.find("stability certificate"), std::string::npos) << choice.reason;
}

TEST(Accuracy, SaysWhenNothingIsSoExact) {
  const AccuracyChoice choice = chooseAccuracy(1e-8, true, certificateOf(100.0, 0.1), kCurves);
  EXPECT_FALSE(choice.reached);
  EXPECT_EQ(choice.integrator, IntegratorKind::kRk4);
  EXPECT_NE(choice.reason.find("most exact"), std::string::npos) << choice.reason;
}

TEST(Accuracy, WordsAndNumbers) {
  EXPECT_EQ(accuracyTarget("fast"), 1e-2);
  EXPECT_EQ(accuracyTarget("balanced"), 1e-3);
  EXPECT_EQ(accuracyTarget("exact"), 1e-5);
  EXPECT_EQ(accuracyTarget("0.003"), 0.003);
  for (const char* bad : {"", "quick", "0", "-1", "2", "1e-3x", "nan", "1e-10"}) EXPECT_FALSE(accuracyTarget(bad)) << bad;
}

TEST(Accuracy, TheMeasuredCurvesAreThere) {
  ASSERT_FALSE(accuracyCurves().empty());
  bool driven = false, ballistic = false;
  for (const AccuracyPoint& point : accuracyCurves()) {
    (point.driven ? driven : ballistic) = true;
    EXPECT_GT(point.omega_dt, 0.0);
    EXPECT_GT(point.error, 0.0);
    EXPECT_GT(point.tick_cost, 0.0);
  }
  EXPECT_TRUE(driven && ballistic);
}

TEST(Accuracy, ASimulatorMadeWithItHasTheChosenStepAndSaysWhy) {
  double fast = 0.0;
  for (const char* asked : {"fast", "balanced", "0.02"}) {
    SimConfig config;
    config.accuracy = asked;
    Simulator simulator = make(car(), flatFloor(), config);
    EXPECT_LE(simulator.config().dt, simulator.certificate().largestStep(simulator.config().integrator));
    if (std::string(asked) == "fast") fast = simulator.config().dt;
    bool said = false;
    for (const std::string& line : simulator.loadReport())
      said = said || (line.rfind(std::string("accuracy: ") + asked + ": ", 0) == 0 &&
                      line.find(toString(simulator.config().integrator)) != std::string::npos);
    EXPECT_TRUE(said) << asked;
    standAt(simulator, 0.0, 0.0, 0.0);
    drive(simulator, twist(2.0), 1.0);
    EXPECT_GT(simulator.rootPose().p.x(), 0.5);
  }
  EXPECT_GT(fast, 0.0);
}

TEST(Accuracy, TogetherWithStepOrIntegratorItIsRefused) {
  SimConfig config;
  config.accuracy = "fast";
  EXPECT_TRUE(config.validate().empty()) << problemText(config.validate());
  for (const char* key : {"dt", "integrator"}) {
    // Even where what is given is the default.
    SimConfig both = config;
    ParameterValues values;
    if (std::string(key) == "dt") {
      values = {{"dt", 1e-3}};
    } else {
      values = {{"integrator", std::string("rk4")}};
    }
    EXPECT_TRUE(takeParameters(simConfigParameters(), "", values, both).empty());
    const std::string text = problemText(both.validate());
    EXPECT_NE(text.find("parameter 'accuracy'"), std::string::npos) << text;
    EXPECT_NE(text.find(std::string("together with ") + key), std::string::npos) << text;
  }
}

TEST(Accuracy, ParameterTakesWordsAndNumbersInRange) {
  const auto problemsOf = [](const ParameterValue& value) {
    SimConfig config;
    ParameterValues values = {{"accuracy", value}};
    Problems problems = takeParameters(simConfigParameters(), "", values, config);
    for (const Problem& p : config.validate()) problems.push_back(p);
    return problemText(problems);
  };
  EXPECT_EQ(problemsOf(std::string("exact")), "");
  EXPECT_EQ(problemsOf(0.002), "");
  EXPECT_NE(problemsOf(2.0).find("fast | balanced | exact | 1.0e-09 ... 1"), std::string::npos) << problemsOf(2.0);
  EXPECT_NE(problemsOf(std::string("exakt")).find("did you mean 'exact'?"), std::string::npos);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
