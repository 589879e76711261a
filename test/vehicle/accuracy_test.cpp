// The dial: how exact, to which integrator and step.
#include "ellipsoid_vehicle_sim/vehicle/accuracy.h"

#include <gtest/gtest.h>

#include <set>

#include "ellipsoid_vehicle_sim/vehicle/parameter_table.h"
#include "support/meshes.h"
#include "support/motions.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

const std::vector<AccuracyPoint> kCurves = {{SceneKind::kDrive, "semi_implicit_euler", 0.1, 1e-3, 1.0},
                                            {SceneKind::kDrive, "semi_implicit_euler", 0.5, 1e-2, 1.0},
                                            {SceneKind::kDrive, "rk4", 0.5, 1e-4, 3.0},
                                            {SceneKind::kDrive, "rk4", 2.0, 5e-3, 3.0},
                                            {SceneKind::kElastic, "rk4_events", 1.0, 1e-6, 10.0, 4.0},
                                            {SceneKind::kElastic, "rk4_events", 1.0, 1e-4, 3.0, 1.0},
                                            {SceneKind::kElastic, "rk4_events", 4.0, 1e-6, 12.0, 16.0}};

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
  AccuracyChoice choice = chooseAccuracy(1e-2, SceneKind::kDrive, certificate, kCurves);
  EXPECT_EQ(choice.integrator, IntegratorKind::kRk4);
  EXPECT_EQ(choice.dt, 0.02);
  EXPECT_TRUE(choice.reached);
  // 1e-3: Euler at 1 ms against RK4 at 5 ms.
  choice = chooseAccuracy(1e-3, SceneKind::kDrive, certificate, kCurves);
  EXPECT_EQ(choice.integrator, IntegratorKind::kRk4);
  EXPECT_EQ(choice.dt, 5e-3);
  EXPECT_EQ(chooseAccuracy(1e-3, SceneKind::kElastic, certificate, kCurves).integrator, IntegratorKind::kRk4Events);
}

TEST(Accuracy, ChoosesContactSubStepsWithinWhatEachOfThemHolds) {
  // 1e-4: one sub-step at 10 ms is the cheapest; 1e-6: sixteen at 20 ms (40 ms are more than is published) against four at 10 ms.
  const StabilityCertificate easy = certificateOf(100.0, 0.1);
  AccuracyChoice choice = chooseAccuracy(1e-4, SceneKind::kElastic, easy, kCurves);
  EXPECT_EQ(choice.substeps, 1.0);
  EXPECT_EQ(choice.dt, 0.01);
  EXPECT_NE(choice.reason.find("with 1 contact sub-steps"), std::string::npos) << choice.reason;
  EXPECT_EQ(chooseAccuracy(1e-6, SceneKind::kElastic, easy, kCurves).substeps, 16.0);
  EXPECT_EQ(chooseAccuracy(1e-6, SceneKind::kElastic, easy, kCurves).dt, 0.02);
  // RK4 holds 2 ms here: one sub-step may have 1.8 ms, four 7.2 ms, sixteen 28.8 ms.
  choice = chooseAccuracy(1e-4, SceneKind::kElastic, certificateOf(100.0, 2e-3), kCurves);
  EXPECT_LE(choice.dt, 0.9 * 2e-3 * choice.substeps);
  EXPECT_EQ(choice.substeps, 16.0);
  // Methods without sub-steps leave them alone.
  EXPECT_EQ(chooseAccuracy(1e-3, SceneKind::kDrive, easy, kCurves).substeps, 0.0);
}

TEST(Accuracy, IsRefusedTogetherWithSubStepsOfOnesOwn) {
  SimConfig config;
  config.accuracy = "fast";
  EXPECT_TRUE(config.validate().empty());
  config.contact_substeps = 8.0;
  ASSERT_EQ(config.validate().size(), 1u);
  EXPECT_NE(config.validate()[0].text().find("contact_substeps"), std::string::npos);
}

TEST(Accuracy, KeepsATenthOfTheCertificateInHand) {
  const AccuracyChoice choice = chooseAccuracy(1e-2, SceneKind::kDrive, certificateOf(100.0, 3e-3), kCurves);
  EXPECT_LE(choice.dt, 0.9 * 3e-3);
  EXPECT_GE(choice.dt, 2e-3);
  EXPECT_NE(choice.reason.find("stability certificate"), std::string::npos) << choice.reason;
}

TEST(SceneKind, IsToldByWheelsEdgesAndDamping) {
  const auto kindOf = [](const VehicleDescription& vehicle, std::shared_ptr<const Terrain> terrain, double damping) {
    const Simulator simulator = make(vehicle, terrain, springConfig(IntegratorKind::kRk4, 1e-3, 1e5, damping));
    return sceneKindOf(simulator.model(), simulator.terrain());
  };
  const VehicleDescription ball = solidBody(Eigen::Vector3d::Constant(0.3), 10.0);  // critical: 2000 N s/m
  EXPECT_EQ(kindOf(ball, flatFloor(), 0.0), SceneKind::kElastic);
  EXPECT_EQ(kindOf(ball, flatFloor(), 300.0), SceneKind::kElastic);
  EXPECT_EQ(kindOf(ball, flatFloor(), 600.0), SceneKind::kDamped);
  const Simulator on_floor = make(car(), flatFloor(), SimConfig{});
  EXPECT_EQ(sceneKindOf(on_floor.model(), on_floor.terrain()), SceneKind::kDrive);
  TriangleSoup kerb = floorSoup(50.0, 2);
  addQuad(kerb, {5, -1, 0.0}, {5, 1, 0.0}, {5, 1, 0.1}, {5, -1, 0.1});
  addQuad(kerb, {5, -1, 0.1}, {5, 1, 0.1}, {6, 1, 0.1}, {6, -1, 0.1});
  const Simulator at_kerb = make(car(), terrainOf(std::move(kerb)), SimConfig{});
  EXPECT_EQ(sceneKindOf(at_kerb.model(), at_kerb.terrain()), SceneKind::kRoughDrive);
}

TEST(SceneKind, SharpestBendIsTheAngleBetweenNeighbours) {
  EXPECT_NEAR(sharpestBend(*terrainOf(cubeSoup())), M_PI / 2.0, 1e-9);
  EXPECT_EQ(sharpestBend(*terrainOf(flatSoup(4, 1.0))), 0.0);
  // A roof of 30 degrees on each side.
  const auto roof = gridSoup(4, 1.0, [](double x, double) { return -std::tan(M_PI / 6.0) * std::abs(x - 2.0); });
  EXPECT_NEAR(sharpestBend(*terrainOf(roof)), M_PI / 3.0, 1e-9);
}

TEST(Accuracy, SaysWhenNothingIsSoExact) {
  const AccuracyChoice choice = chooseAccuracy(1e-8, SceneKind::kDrive, certificateOf(100.0, 0.1), kCurves);
  EXPECT_FALSE(choice.reached);
  EXPECT_EQ(choice.integrator, IntegratorKind::kRk4);
  EXPECT_NE(choice.reason.find("nearly the most exact"), std::string::npos) << choice.reason;
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
  std::set<SceneKind> kinds;
  for (const AccuracyPoint& point : accuracyCurves()) {
    kinds.insert(point.kind);
    EXPECT_GT(point.omega_dt, 0.0);
    EXPECT_GT(point.error, 0.0);
    EXPECT_GT(point.tick_cost, 0.0);
  }
  EXPECT_EQ(kinds.size(), static_cast<std::size_t>(kSceneKindCount));
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
