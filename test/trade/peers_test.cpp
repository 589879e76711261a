// Other engines on our drive scenes: what they are told drives, and what they cannot be told is said.
#include "peers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "corners.h"
#include "wheel_torques.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

const std::string kShare = SHARE_DIR;

LoadedScene load(const Scene& scene) {
  Loaded<LoadedScene> loaded = loadSceneFiles(scene, kShare);
  if (!loaded) throw std::runtime_error(problemText(loaded.problems));
  return std::move(*loaded.value);
}

Scene shippedScene(const std::string& name) {
  const Loaded<Scene> scene = loadScene(kShare + "/launch/scenes/" + name + ".yaml", kShare);
  if (!scene) throw std::runtime_error(problemText(scene.problems));
  return *scene.value;
}

LoadedScene shipped(const std::string& name) { return load(shippedScene(name)); }

DriveScene driveScene(const LoadedScene& loaded) {
  Loaded<DriveScene> scene = makeDriveScene(loaded);
  if (!scene) throw std::runtime_error(problemText(scene.problems));
  return std::move(*scene.value);
}

std::vector<Peer> found() {
  std::vector<Peer> peers;
  for (const auto& some : {mujocoPeers(), bulletPeers(), odePeers()})
    peers.insert(peers.end(), some.begin(), some.end());
  return peers;
}

#define NEEDS_ENGINES() \
  if (found().empty()) GTEST_SKIP() << "no other engine was found when this was built"

/// Runs a scene in every engine that was found; `look` sees its path and ours, both at 1 ms.
template <typename Look>
void driveAll(const std::string& name, Look&& look) {
  const LoadedScene loaded = shipped(name);
  const DriveScene scene = driveScene(loaded);
  MeasureOptions options;
  options.errors = false;
  options.repeat_budget = 0.0;
  const MeasuredRun ours = measureRun(loaded, configAt(loaded.scene, Setting{}), options);
  ASSERT_TRUE(ours.finished) << ours.reason;
  for (const Peer& peer : found()) {
    SCOPED_TRACE(peer.program + " " + peer.method);
    const PeerRun run = peer.drive(scene, 1e-3);
    ASSERT_EQ(run.cannot, "");
    ASSERT_EQ(run.path.p_WR.size(), ours.path.p_WR.size());
    for (std::size_t i = 0; i < run.path.p_WR.size(); ++i) {
      ASSERT_LT(std::abs(run.path.p_WR[i].z() - ours.path.p_WR[i].z()), 0.1) << i;
      ASSERT_GT((run.path.q_WR[i] * Vector3d::UnitZ()).z(), 0.98) << i;
    }
    look(run.path, ours.path);
  }
}

TEST(DrivePeers, GoRoundTheSteadyCircle) {
  NEEDS_ENGINES();
  driveAll("cornering", [](const MeasuredPath& path, const MeasuredPath& ours) {
    EXPECT_GT(path.distance(5.0), 10.0);
    // Their tyres slip otherwise than ours; what they are told is the same circle.
    EXPECT_LT((path.p_WR.back() - ours.p_WR.back()).norm(), 1.0);
  });
}

TEST(DrivePeers, BrakeToAStandstill) {
  NEEDS_ENGINES();
  driveAll("brake", [](const MeasuredPath& path, const MeasuredPath& ours) {
    EXPECT_LT((path.p_WR.back() - ours.p_WR.back()).norm(), 1.0);
    EXPECT_LT((path.p_WR.back() - path.p_WR[path.p_WR.size() - 25]).norm(), 0.02);
  });
}

TEST(DriveSeries, IsWhatOurDriveAskedFor) {
  const DriveScene scene = driveScene(shipped("brake"));
  // 6 m/s^2 up to 10 m/s, wheels of 0.35 m.
  EXPECT_NEAR(scene.series.wheelSpeed(2, 1.0), 6.0 / 0.35, 0.05);
  EXPECT_NEAR(scene.series.wheelSpeed(2, 2.0), 10.0 / 0.35, 1e-9);
  EXPECT_NEAR(scene.series.wheelAngle(2, 2.0), (0.5 * 100.0 / 6.0 + 10.0 * (2.0 - 10.0 / 6.0)) / 0.35, 0.1);
  EXPECT_EQ(scene.series.mode(2.3995), DriveState::Mode::kDrive);
  EXPECT_EQ(scene.series.mode(2.4015), DriveState::Mode::kBrake);
  // Between two moments linearly, and its sum to match.
  const double a = scene.series.wheelSpeed(2, 0.5), b = scene.series.wheelSpeed(2, 0.501);
  EXPECT_NEAR(scene.series.wheelSpeed(2, 0.50025), 0.75 * a + 0.25 * b, 1e-9);
  EXPECT_NEAR(scene.series.wheelAngle(2, 0.501) - scene.series.wheelAngle(2, 0.5), 0.5e-3 * (a + b), 1e-12);
}

TEST(DriveSeries, SteersAsOurCarDoes) {
  const DriveScene scene = driveScene(shipped("cornering"));
  const DriveSeries::Path left = scene.series.path(0, 3.0), right = scene.series.path(1, 3.0);
  // Both wheels about the point amidships the rear axle, wheelbase 2.6 m, track 1.5 m.
  const double radius = 2.6 / std::tan(0.1);
  EXPECT_NEAR(left.position, std::atan(2.6 / (radius - 0.75)), 1e-6);
  EXPECT_NEAR(right.position, std::atan(2.6 / (radius + 0.75)), 1e-6);
  EXPECT_NEAR(left.velocity, 0.0, 1e-9);
}

TEST(WheelTorques, ABrakeHoldsUpToItsTorqueAndASlidingWheelFeelsAllOfIt) {
  const DriveScene scene = driveScene(shipped("parked_car"));
  const std::size_t n = scene.model.drive.wheels.size();
  std::vector<double> angle, speed(n, 0.0);
  for (const WheelUnit& wheel : scene.model.drive.wheels) angle.push_back(scene.start.q[static_cast<std::size_t>(wheel.joint)]);
  WheelTorques torques(scene, 1e-3);
  // What holds the car at the start: its weight down the slope, all wheels together.
  double sum = 0.0;
  for (const double t : torques.at(0.0, angle, speed)) sum += t;
  const double slope = std::acos(scene.nhat_W.z());
  EXPECT_NEAR(std::abs(sum), scene.model.mass * scene.gravity * std::sin(slope) * 0.35, 0.01 * std::abs(sum));
  // One turn on, at rest: the limit; and it pulls back from there, not from the start.
  for (double& a : angle) a += 6.0;
  const WheelUnit& wheel = scene.model.drive.wheels[0];
  EXPECT_NEAR(torques.at(1e-3, angle, speed)[0], -wheel.brake_torque, 1e-9);
  torques.endStep(1e-3, angle, speed);
  EXPECT_NEAR(torques.at(1e-3, angle, speed)[0], -wheel.brake_torque, 1e-6);
  speed[0] = -100.0;
  EXPECT_NEAR(torques.at(1e-3, angle, speed)[0], wheel.brake_torque, 1e-9);
}

TEST(Corners, WeighWhatTheVehicleWeighs) {
  const DriveScene scene = driveScene(shipped("cornering"));
  const Loaded<CornerVehicle> vehicle = makeCornerVehicle(scene);
  ASSERT_TRUE(vehicle) << problemText(vehicle.problems);
  double mass = vehicle.value->mass;
  for (const Corner& corner : vehicle.value->corners) {
    mass += corner.mass;
    EXPECT_NEAR(corner.spin, 1.1025, 1e-12);
    EXPECT_NEAR(corner.stiffness * corner.pressed, 0.25 * 1100.0 * scene.gravity, 0.02 * 2700.0);
  }
  EXPECT_NEAR(mass, scene.model.mass, 1e-9);
  EXPECT_EQ(vehicle.value->ellipsoids.size(), scene.model.ellipsoids.size());
}

/// Rows of all engines on a scene, with hardly any budget.
std::vector<StudyRow> rowsOf(const LoadedScene& scene) {
  StudyBudget budget = StudyBudget::quick();
  budget.steps = {1e-3, 5e-3};
  budget.reference = 0.02;
  budget.cells = 1.0;
  return studyPeers(scene, budget, [](const StudyRow&, double) { return true; });
}

TEST(StudyPeers, EveryEngineHasRowsWithErrorsOnADriveScene) {
  NEEDS_ENGINES();
  Scene scene = shippedScene("cornering");
  scene.duration = scene.horizon = 0.4;
  const std::vector<StudyRow> rows = rowsOf(load(scene));
  ASSERT_EQ(rows.size(), 2 * found().size());
  for (const StudyRow& row : rows) {
    SCOPED_TRACE(row.program + " " + row.setting.integrator);
    if (row.setting.dt != 1e-3) continue;
    ASSERT_EQ(row.status, RowStatus::kOk) << row.reason;
    EXPECT_GT(row.run.cost.least, 0.0);
    EXPECT_GT(row.error.largest, 0.0);
    EXPECT_LT(row.error.largest, 0.5);
    EXPECT_GT(row.model_error, 0.0);
    EXPECT_LT(row.model_error, 0.5);
    EXPECT_EQ(row.factor, "peer");
  }
}

TEST(StudyPeers, WhatTheyCannotBeToldIsARowWithTheReason) {
  NEEDS_ENGINES();
  const auto reasons = [](const LoadedScene& scene) {
    std::string text;
    const std::vector<StudyRow> rows = rowsOf(scene);
    EXPECT_EQ(rows.size(), found().size());
    for (const StudyRow& row : rows) {
      EXPECT_EQ(row.status, RowStatus::kLeftOut);
      EXPECT_FALSE(row.reason.empty());
      text += row.reason + "\n";
    }
    return text;
  };
  EXPECT_NE(reasons(shipped("kerb")).find("not one plane"), std::string::npos);
  Scene compound = shippedScene("cornering");
  compound.config.solid_compound = true;
  EXPECT_NE(reasons(load(compound)).find("treads"), std::string::npos);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
