#include "ellipsoid_vehicle_sim/fleet/fleet.h"

#include <gtest/gtest.h>

#include <random>

#include "support/fleet_sums.h"
#include "support/meshes.h"
#include "support/motions.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Vector3d;

SimConfig floating(IntegratorKind kind, double dt = 1e-3) {
  SimConfig config;
  config.integrator = kind;
  config.dt = dt;
  config.gravity = 0.0;
  config.allow_unstable = kind == IntegratorKind::kExplicitEuler;
  return config;
}

void place(Fleet& fleet, std::size_t i, const Vector3d& p, const Vector3d& v, const Vector3d& w = Vector3d::Zero(),
           const Eigen::Quaterniond& q = Eigen::Quaterniond::Identity()) {
  ASSERT_TRUE(fleet.vehicle(i).place({p, q.normalized()}, v, w).empty());
}

void run(Fleet& fleet, int steps) {
  for (int i = 0; i < steps; ++i) ASSERT_EQ(fleet.step(), StepStatus::kOk);
}

Vector3d angularMomentumOf(const Fleet& fleet) {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 0; i < fleet.size(); ++i) sum += fleet.vehicle(i).angularMomentum_W();
  return sum;
}

TEST(Fleet, OneVehicleIsASimulatorToTheLastBit) {
  const auto floor = flatFloor();
  for (const IntegratorKind kind : allIntegrators()) {
    SimConfig config;
    config.integrator = kind;
    config.allow_unstable = true;
    Simulator alone = make(car(), floor, config);
    Fleet fleet;
    ASSERT_TRUE(fleet.add("one", make(car(), floor, config)).empty());
    standAt(alone, 0, 0, 0);
    standAt(fleet.vehicle(0), 0, 0, 0);
    for (int i = 0; i < 1000; ++i) {
      alone.command(twist(4.0, 0.3));
      fleet.vehicle(0).command(twist(4.0, 0.3));
      alone.step();
      fleet.step();
    }
    EXPECT_EQ(fleet.stateHash(), alone.stateHash()) << toString(kind);
    EXPECT_EQ(fleet.time(), alone.time());
  }
}

TEST(Fleet, VehiclesThatTouchNobodyRunAsAloneToTheLastBit) {
  const auto floor = flatFloor();
  Fleet fleet;
  std::vector<Simulator> alone;
  for (int i = 0; i < 3; ++i) {
    alone.push_back(make(car(), floor, {}));
    ASSERT_TRUE(fleet.add("car" + std::to_string(i), make(car(), floor, {})).empty());
    // Two of them side by side, so close that they are looked at together.
    const double y = i == 1 ? 1.75 : 20.0 * i;
    standAt(alone.back(), 0, y, 0);
    standAt(fleet.vehicle(i), 0, y, 0);
  }
  for (int step = 0; step < 1500; ++step) {
    for (int i = 0; i < 3; ++i) {
      alone[i].command(twist(3.0 + i));
      fleet.vehicle(i).command(twist(3.0 + i));
      alone[i].step();
    }
    ASSERT_EQ(fleet.step(), StepStatus::kOk);
  }
  for (int i = 0; i < 3; ++i) EXPECT_EQ(fleet.vehicle(i).stateHash(), alone[i].stateHash()) << i;
  EXPECT_TRUE(fleet.touching().empty());
}

// Two bodies, off-centre and spinning, in empty space.
void collide(IntegratorKind kind, const Vector3d& r1, const Vector3d& r2, double dt, double& linear, double& angular,
             double& gained, bool& touched) {
  const auto space = emptySpace();
  Fleet fleet;
  ASSERT_TRUE(fleet.add("one", make(solidBody(r1, 30.0), space, floating(kind, dt))).empty());
  ASSERT_TRUE(fleet.add("other", make(solidBody(r2, 70.0), space, floating(kind, dt))).empty());
  place(fleet, 0, {-1.2, 0.1, 0.05}, {2.0, 0.0, 0.1}, {0.5, -0.4, 0.8}, {0.9, 0.1, 0.2, -0.1});
  place(fleet, 1, {1.0, -0.05, 0.0}, {-1.0, 0.1, 0.0}, {0.0, 0.6, -0.3}, {0.7, -0.3, 0.1, 0.2});
  const Vector3d p = momentumOf(fleet), l = angularMomentumOf(fleet);
  const double energy = energyOf(fleet);
  linear = angular = gained = 0.0;
  touched = false;
  for (int i = 0; i < static_cast<int>(1.5 / dt); ++i) {
    ASSERT_EQ(fleet.step(), StepStatus::kOk);
    linear = std::max(linear, (momentumOf(fleet) - p).norm());
    angular = std::max(angular, (angularMomentumOf(fleet) - l).norm());
    gained = std::max(gained, (energyOf(fleet) - energy) / energy);
    touched = touched || !fleet.touching().empty();
  }
}

TEST(Fleet, CollidingBodiesKeepTheirMomentum) {
  const Vector3d shapes[][2] = {{Vector3d::Constant(0.4), Vector3d::Constant(0.5)},
                                {{0.35, 0.12, 0.35}, {0.5, 0.3, 0.2}},
                                {{0.8, 0.2, 0.3}, {0.35, 0.12, 0.35}}};
  for (const IntegratorKind kind : oneStepIntegrators())
    for (const auto& shape : shapes) {
      double linear = 0.0, angular = 0.0, gained = 0.0;
      bool touched = false;
      collide(kind, shape[0], shape[1], 1e-3, linear, angular, gained, touched);
      EXPECT_TRUE(touched);
      // Linear: sums of 1500 forces of up to 1e4 N times 1 ms, each rounded to 1e-16 of itself.
      EXPECT_LT(linear, 1e-11) << toString(kind);
      // Angular: what a step of order p makes of spinning bodies; rounding is far below. I w of the one is 3 N m s.
      EXPECT_LT(angular, kind == IntegratorKind::kRk4 ? 2e-5 : 1e-1) << toString(kind);
      if (kind == IntegratorKind::kRk4) {
        EXPECT_LT(gained, 1e-4) << "a collision made energy";
      }
    }
}

TEST(Fleet, AngularMomentumIsLostToTheStepAlone) {
  double linear = 0.0, coarse = 0.0, fine = 0.0, gained = 0.0;
  bool touched = false;
  collide(IntegratorKind::kRk4, {0.8, 0.2, 0.3}, {0.35, 0.12, 0.35}, 2e-3, linear, coarse, gained, touched);
  collide(IntegratorKind::kRk4, {0.8, 0.2, 0.3}, {0.35, 0.12, 0.35}, 2.5e-4, linear, fine, gained, touched);
  EXPECT_LT(fine, 0.05 * coarse);
  EXPECT_LT(fine, 1e-7);
}

// Of spheres, semi-implicit Euler keeps r x m v + I w exactly, as long as the forces act along one line.
TEST(Fleet, SpheresKeepTheirAngularMomentumToRounding) {
  double linear = 0.0, angular = 0.0, gained = 0.0;
  bool touched = false;
  collide(IntegratorKind::kSemiImplicitEuler, Vector3d::Constant(0.4), Vector3d::Constant(0.5), 1e-3, linear, angular, gained,
          touched);
  EXPECT_TRUE(touched);
  EXPECT_LT(linear, 1e-11);
  EXPECT_LT(angular, 1e-11);
}

TEST(Fleet, ForcesOnBothAreEqualAndOppositeAtOnePoint) {
  const auto space = emptySpace();
  Fleet fleet;
  SimConfig config = floating(IntegratorKind::kRk4);
  ASSERT_TRUE(fleet.add("one", make(car(), space, config)).empty());
  ASSERT_TRUE(fleet.add("other", make(car(), space, config)).empty());
  place(fleet, 0, {0, 0, 0}, {3, 0, 0});
  place(fleet, 1, {4.4, 0.3, 0.1}, {-3, 0, 0}, {0, 0, 0.2});
  const Vector3d p = momentumOf(fleet);
  int seen = 0;
  for (int i = 0; i < 600; ++i) {
    ASSERT_EQ(fleet.step(), StepStatus::kOk);
    std::vector<ContactReport> a, b;
    fleet.vehicle(0).contacts(a);
    fleet.vehicle(1).contacts(b);
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t k = 0; k < a.size(); ++k) {
      EXPECT_EQ(a[k].triangle, -1);
      EXPECT_EQ(a[k].other, fleet.id(1));
      EXPECT_EQ(a[k].other_ellipsoid, b[k].ellipsoid);
      EXPECT_EQ(a[k].nhat_W, -b[k].nhat_W);
      EXPECT_EQ(a[k].normal_force, b[k].normal_force);
      EXPECT_EQ(a[k].friction_W, -b[k].friction_W);
      ++seen;
    }
  }
  EXPECT_GT(seen, 10);
  // Jointed bodies: what RK4 makes of the swinging suspensions, of 7200 N s that change hands.
  EXPECT_LT((momentumOf(fleet) - p).norm(), 1e-4);
  EXPECT_LT(fleet.vehicle(0).rootVelocity_W().x(), 2.0);
}

// Two cars with all their joints, off-centre. What they lose of both momenta is the step's doing: of fourth order, but for
// the moment at which they touch.
void crash(double dt, double& linear, double& angular) {
  const auto space = emptySpace();
  Fleet fleet;
  for (const char* name : {"one", "other"})
    ASSERT_TRUE(fleet.add(name, make(car(), space, floating(IntegratorKind::kRk4, dt))).empty());
  place(fleet, 0, {0, 0, 0}, {3, 0, 0});
  place(fleet, 1, {4.4, 0.3, 0.1}, {-3, 0, 0}, {0, 0, 0.2});
  const Vector3d p = momentumOf(fleet), l = angularMomentumOf(fleet);
  bool touched = false;
  for (int i = 0; i < static_cast<int>(0.4 / dt); ++i) {
    ASSERT_EQ(fleet.step(), StepStatus::kOk);
    touched = touched || !fleet.touching().empty();
  }
  EXPECT_TRUE(touched);
  linear = (momentumOf(fleet) - p).norm();
  angular = (angularMomentumOf(fleet) - l).norm();
}

TEST(Fleet, CarsWithJointsLoseMomentumToTheStepAlone) {
  double coarse_linear = 0.0, coarse_angular = 0.0, linear = 0.0, angular = 0.0;
  crash(1e-3, coarse_linear, coarse_angular);
  crash(1e-4, linear, angular);
  // Of 7200 N s and 5000 N m s.
  EXPECT_LT(linear, 1e-6);
  EXPECT_LT(angular, 1e-6);
  EXPECT_LT(linear, 0.05 * coarse_linear + 1e-9);
  EXPECT_LT(angular, 0.05 * coarse_angular + 1e-9);
}

TEST(Fleet, EqualSpheresHeadOnReboundAsTheRestitutionSays) {
  const auto space = emptySpace();
  SimConfig config = floating(IntegratorKind::kRk4, 1e-4);
  config.restitution = 0.6;
  Fleet fleet;
  for (const char* name : {"a", "b"})
    ASSERT_TRUE(fleet.add(name, make(solidBody(Vector3d::Constant(0.5), 100.0), space, config)).empty());
  place(fleet, 0, {-0.6, 0, 0}, {1, 0, 0});
  place(fleet, 1, {0.6, 0, 0}, {-1, 0, 0});
  run(fleet, 6000);
  // Springs in series of equal bodies are the contact of one with a wall.
  EXPECT_NEAR(fleet.vehicle(1).rootVelocity_W().x(), 0.6, 0.01);
  EXPECT_NEAR(fleet.vehicle(0).rootVelocity_W().x(), -0.6, 0.01);
}

TEST(Fleet, FrictionBetweenVehiclesIsWithinItsConeAndHolds) {
  // A plate on the ground, a smaller one on it: they stick together when the lower one is braked slowly.
  const auto floor = flatFloor();
  SimConfig config;
  config.mu_static = config.mu_kinetic = 0.5;
  Fleet fleet;
  VehicleDescription plate = fourFeet(400.0, 1.0, 0.8, 0.2);
  plate.links[0].ellipsoids.push_back(ellipsoid("top", {0, 0, 0.3}, {2.5, 2.5, 0.3}));
  ASSERT_TRUE(fleet.add("lower", make(plate, floor, config)).empty());
  ASSERT_TRUE(fleet.add("upper", make(solidBody({0.3, 0.3, 0.1}, 20.0), floor, config)).empty());
  ASSERT_TRUE(fleet.setDown(0, 0, 0, 0).empty());
  const double top = fleet.vehicle(0).rootPose().p.z() + 0.6;
  place(fleet, 1, {0, 0, top + 0.1}, {0, 0, 0});
  run(fleet, 3000);
  std::vector<ContactReport> contacts;
  fleet.vehicle(1).contacts(contacts);
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_NEAR(contacts[0].normal_force, 20.0 * 9.80665, 0.5);
  EXPECT_LE(contacts[0].friction_W.norm(), contacts[0].friction_limit * (1.0 + 1e-9));
  // Pushed along by the other's surface: it stays where it is on it.
  EXPECT_NEAR(fleet.vehicle(1).rootPose().p.head<2>().norm(), 0.0, 1e-3);
}

TEST(Fleet, OneSpawnedInsideAnotherRisesWithoutHurry) {
  const auto space = emptySpace();
  Fleet fleet;
  for (const char* name : {"a", "b"})
    ASSERT_TRUE(fleet.add(name, make(solidBody(Vector3d::Constant(0.5), 100.0), space, floating(IntegratorKind::kRk4))).empty());
  place(fleet, 0, {0, 0, 0}, {0, 0, 0});
  place(fleet, 1, {0.8, 0, 0}, {0, 0, 0});
  EXPECT_FALSE(fleet.overlaps(1).empty());
  double fastest = 0.0;
  for (int i = 0; i < 5000; ++i) {
    ASSERT_EQ(fleet.step(), StepStatus::kOk);
    fastest = std::max(fastest, fleet.vehicle(1).rootVelocity_W().norm());
  }
  EXPECT_LT(fastest, 0.05);  // 0.2 m deep, the whole spring would throw it at metres a second
  EXPECT_GT(fleet.vehicle(1).rootPose().p.x(), 0.81);
}

TEST(Fleet, SetDownInAnotherIsRefusedAndChangesNothing) {
  const auto floor = flatFloor();
  Fleet fleet;
  ASSERT_TRUE(fleet.add("red", make(car(), floor, {})).empty());
  ASSERT_TRUE(fleet.add("blue", make(car(), floor, {})).empty());
  ASSERT_TRUE(fleet.setDown(0, 0, 0, 0).empty());
  ASSERT_TRUE(fleet.setDown(1, 10, 0, 0).empty());
  run(fleet, 10);
  const std::uint64_t hash = fleet.stateHash();
  const Problems problems = fleet.setDown(1, 1.0, 0.2, 0.0);
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_NE(problems[0].text().find("vehicle 'blue': would stand in vehicle 'red'"), std::string::npos) << problems[0].text();
  EXPECT_EQ(fleet.stateHash(), hash);
}

TEST(Fleet, ARestingVehicleWakesWhenItIsHit) {
  const auto floor = flatFloor();
  Fleet fleet;
  ASSERT_TRUE(fleet.add("parked", make(car(), floor, {})).empty());
  ASSERT_TRUE(fleet.add("moving", make(car(), floor, {})).empty());
  ASSERT_TRUE(fleet.setDown(0, 0, 0, 0).empty());
  ASSERT_TRUE(fleet.setDown(1, -12, 0.4, 0).empty());
  run(fleet, 20000);
  ASSERT_TRUE(fleet.vehicle(0).isResting());
  const Vector3d before = fleet.vehicle(0).rootPose().p;
  for (int i = 0; i < 4000; ++i) {
    fleet.vehicle(1).command(twist(4.0));
    ASSERT_EQ(fleet.step(), StepStatus::kOk);
  }
  EXPECT_GT((fleet.vehicle(0).rootPose().p - before).norm(), 0.01);
}

TEST(Fleet, WhatLeantOnARemovedVehicleMovesOn) {
  const auto floor = flatFloor();
  Fleet fleet;
  SimConfig config;
  ASSERT_TRUE(fleet.add("block", make(fourFeet(200.0, 0.5, 0.4, 0.3), floor, config)).empty());
  ASSERT_TRUE(fleet.add("ball", make(solidBody({0.4, 0.4, 0.2}, 20.0), floor, config)).empty());
  ASSERT_TRUE(fleet.setDown(0, 0, 0, 0).empty());
  place(fleet, 1, {0.0, 0.0, 1.0}, {0, 0, 0});
  run(fleet, 20000);
  const double z = fleet.vehicle(1).rootPose().p.z();
  ASSERT_GT(z, 0.35);
  ASSERT_TRUE(fleet.remove("block").empty());
  run(fleet, 1000);
  EXPECT_LT(fleet.vehicle(0).rootPose().p.z(), 0.3);
}

TEST(Fleet, VehiclesComeAndGoWhileItRuns) {
  const auto floor = flatFloor();
  Fleet fleet;
  ASSERT_TRUE(fleet.add("a", make(car(), floor, {})).empty());
  ASSERT_TRUE(fleet.setDown(0, 0, 0, 0).empty());
  run(fleet, 100);
  ASSERT_TRUE(fleet.add("b", make(car(), floor, {})).empty());
  EXPECT_EQ(fleet.vehicle(1).stepCount(), 100);
  ASSERT_TRUE(fleet.setDown(1, 8, 0, 0).empty());
  const int id = fleet.id(1);
  EXPECT_FALSE(fleet.add("b", make(car(), floor, {})).empty());
  run(fleet, 100);
  EXPECT_EQ(fleet.vehicle(1).time(), fleet.time());
  const Problems unknown = fleet.remove("c");
  ASSERT_EQ(unknown.size(), 1u);
  EXPECT_NE(unknown[0].text().find("a, b"), std::string::npos);
  ASSERT_TRUE(fleet.remove("a").empty());
  EXPECT_EQ(fleet.name(0), "b");
  EXPECT_EQ(fleet.findId(id), 0);
  run(fleet, 100);
  EXPECT_EQ(fleet.stepCount(), 300);
}

TEST(Fleet, WhatCannotRunTogetherIsRefusedWithTheReason) {
  const auto floor = flatFloor();
  Fleet fleet;
  SimConfig config;
  config.integrator = IntegratorKind::kRk4Events;
  ASSERT_TRUE(fleet.add("a", make(car(), floor, config)).empty());
  Problems problems = fleet.add("b", make(car(), floor, {}));
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_NE(problems[0].text().find("the integrator rk4, allowed is that of 'a'"), std::string::npos) << problems[0].text();
  Fleet other;
  ASSERT_TRUE(other.add("a", make(car(), floor, {})).empty());
  SimConfig fine;
  fine.dt = 5e-4;
  fine.gravity = 1.6;
  problems = other.add("b", make(car(), flatFloor(), fine));
  EXPECT_EQ(problems.size(), 3u) << problemText(problems);  // terrain, step, gravity
}

// A heap of bodies thrown into a bowl.
Fleet heap(int threads, IntegratorKind kind) {
  const auto bowl = terrainOf(gridSoup(60, 0.25, [](double x, double y) { return 0.35 * ((x - 7.5) * (x - 7.5) + (y - 7.5) * (y - 7.5)); }, {-7.5, -7.5, 0.0}));
  Fleet fleet(threads);
  SimConfig config;
  config.integrator = kind;
  config.mu_static = config.mu_kinetic = 0.05;  // or most would stand on the slope
  for (int i = 0; i < 12; ++i) {
    const VehicleDescription body = i % 3 == 0 ? solidBody({0.35, 0.12, 0.35}, 20.0)
                                               : (i % 3 == 1 ? solidBody(Vector3d::Constant(0.3), 30.0) : fourFeet(60.0));
    EXPECT_TRUE(fleet.add("body" + std::to_string(i), make(body, bowl, config)).empty());
    place(fleet, i, {1.4 * (i % 3) - 1.4, 1.5 * (i / 3 % 2) - 0.7, 2.2 + 1.1 * (i / 6)}, {0.3 * (i % 2), 0.2, 0}, {0.4, 0.1 * i, 0});
  }
  return fleet;
}

TEST(Fleet, ResultsDoNotDependOnTheNumberOfThreads) {
  for (const IntegratorKind kind :
       {IntegratorKind::kRk4, IntegratorKind::kRk4Events, IntegratorKind::kDormandPrince, IntegratorKind::kLinearlyImplicit}) {
    std::vector<std::uint64_t> hashes;
    std::size_t most = 0;
    for (const int threads : {1, 2, 4}) {
      Fleet fleet = heap(threads, kind);
      if (Fleet::canUseThreads()) {
        EXPECT_EQ(fleet.threads(), threads);
      }
      for (int i = 0; i < 1000; ++i) {
        ASSERT_EQ(fleet.step(), StepStatus::kOk);
        most = std::max(most, fleet.touching().size());
      }
      hashes.push_back(fleet.stateHash());
    }
    EXPECT_GE(most, 3u) << toString(kind);
    EXPECT_EQ(hashes[1], hashes[0]) << toString(kind);
    EXPECT_EQ(hashes[2], hashes[0]) << toString(kind);
  }
}

TEST(Fleet, ASavedStateGoesOnToTheLastBit) {
  for (const IntegratorKind kind : {IntegratorKind::kSemiImplicitEuler, IntegratorKind::kRk4, IntegratorKind::kRk4Events,
                                    IntegratorKind::kDormandPrince, IntegratorKind::kLinearlyImplicit}) {
    Fleet fleet = heap(1, kind);
    while (fleet.stepCount() < 3000 && fleet.touching().size() < 2) ASSERT_EQ(fleet.step(), StepStatus::kOk);
    ASSERT_GE(fleet.touching().size(), 2u);
    const std::vector<std::uint8_t> bytes = toBytes(fleet.save(), fleet);
    run(fleet, 400);
    const std::uint64_t hash = fleet.stateHash();
    const Loaded<FleetSnapshot> snapshot = fromBytes(bytes, fleet, "saved");
    ASSERT_TRUE(snapshot) << problemText(snapshot.problems);
    ASSERT_TRUE(fleet.restore(*snapshot.value).empty());
    run(fleet, 400);
    EXPECT_EQ(fleet.stateHash(), hash);
    // Another fleet takes it too; one with other vehicles does not.
    Fleet same = heap(1, kind);
    ASSERT_TRUE(same.restore(*fromBytes(bytes, same, "saved").value).empty());
    run(same, 400);
    EXPECT_EQ(same.stateHash(), hash);
    ASSERT_TRUE(same.remove("body3").empty());
    EXPECT_FALSE(fromBytes(bytes, same, "saved"));
  }
}

TEST(Fleet, DamagedBytesAreRefused) {
  Fleet fleet = heap(1, IntegratorKind::kRk4);
  run(fleet, 5);
  std::vector<std::uint8_t> bytes = toBytes(fleet.save(), fleet);
  EXPECT_FALSE(fromBytes({1, 2, 3}, fleet, "x"));
  bytes.pop_back();
  EXPECT_FALSE(fromBytes(bytes, fleet, "x"));
  for (std::size_t i = 100; i < bytes.size(); i += bytes.size() / 50) {
    std::vector<std::uint8_t> damaged(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(i));
    EXPECT_FALSE(fromBytes(damaged, fleet, "x")) << i;
  }
}

TEST(Fleet, AResetRunsTheSameAgain) {
  Fleet fleet = heap(1, IntegratorKind::kRk4);
  run(fleet, 900);
  const std::uint64_t hash = fleet.stateHash();
  fleet.reset();
  run(fleet, 900);
  EXPECT_EQ(fleet.stateHash(), hash);
}

TEST(Fleet, PassingThroughEachOtherIsCounted) {
  const auto space = emptySpace();
  Fleet fleet;
  for (const char* name : {"a", "b"})
    ASSERT_TRUE(fleet.add(name, make(solidBody(Vector3d::Constant(0.1), 1.0), space, floating(IntegratorKind::kRk4))).empty());
  // Half a metre a tick: past each other between two ticks.
  place(fleet, 0, {-10.2, 0, 0}, {250, 0, 0});
  place(fleet, 1, {10.0, 0, 0}, {-250, 0, 0});
  run(fleet, 60);
  EXPECT_GE(fleet.vehicle(0).events().passed_through, 1);
  EXPECT_GE(fleet.vehicle(1).events().passed_through, 1);
}

TEST(Fleet, OneThatDivergesStopsAllAtTheLastGoodTick) {
  const auto floor = flatFloor();
  Fleet fleet;
  SimConfig config;
  config.allow_unstable = true;
  ASSERT_TRUE(fleet.add("good", make(car(), floor, config)).empty());
  ASSERT_TRUE(fleet.add("bad", make(solidBody(Vector3d::Constant(0.3), 10.0), floor, config)).empty());
  ASSERT_TRUE(fleet.setDown(0, 0, 0, 0).empty());
  // Faster than any vehicle within a second: gravity and a start just below the bound do it.
  place(fleet, 1, {100, 0, 5000}, {0, 0, -99999.9});
  StepStatus status = StepStatus::kOk;
  for (int i = 0; i < 1000 && status == StepStatus::kOk; ++i) {
    fleet.vehicle(0).command(twist(2.0));
    status = fleet.step();
  }
  ASSERT_EQ(status, StepStatus::kDiverged);
  EXPECT_EQ(fleet.vehicle(0).stepCount(), fleet.vehicle(1).stepCount());
  EXPECT_EQ(fleet.vehicle(0).status(), StepStatus::kOk);
  const std::int64_t steps = fleet.stepCount();
  fleet.step();
  EXPECT_EQ(fleet.stepCount(), steps);
  ASSERT_TRUE(fleet.remove("bad").empty());
  EXPECT_EQ(fleet.step(), StepStatus::kOk);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
