// Vehicles that touch each other under every integrator, those that size their steps within the tick among them.
#include <gtest/gtest.h>

#include "ellipsoid_vehicle_sim/contact/damped_spring.h"
#include "ellipsoid_vehicle_sim/fleet/fleet.h"
#include "support/fleet_sums.h"
#include "support/motions.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Vector3d;

constexpr double kTick = 1e-3;

std::vector<IntegratorKind> withinTheTick() {
  return {IntegratorKind::kRk4Events, IntegratorKind::kDormandPrince, IntegratorKind::kLinearlyImplicit};
}

void add(Fleet& fleet, Simulator vehicle) {
  const Problems problems = fleet.add("v" + std::to_string(fleet.size()), std::move(vehicle));
  ASSERT_TRUE(problems.empty()) << problemText(problems);
}

/// Two rugby balls on elastic springs, off-centre and spinning, touch once in flight.
struct Balls {
  Balls(IntegratorKind kind, double dt, double damping = 0.0, double tolerance = 1e-8) {
    const auto space = emptySpace();
    SimConfig config = springConfig(kind, dt, 5e5, damping);
    config.error_tolerance = tolerance;
    add(fleet, make(solidBody({0.3, 0.15, 0.15}, 5.0), space, config));
    add(fleet, make(solidBody({0.2, 0.25, 0.2}, 8.0), space, config));
    placeAt(fleet.vehicle(0), {-0.6, 0.03, 0.0}, {2.0, 0.0, 0.1}, {1.0, 4.0, 2.0});
    placeAt(fleet.vehicle(1), {0.3, 0.0, 0.02}, {-1.0, 0.1, 0.0}, {0.0, -2.0, 1.0});
    momentum = momentumOf(fleet);
    energy = energyOf(fleet);
  }
  void run(double seconds) {
    const auto steps = std::llround(seconds / fleet.vehicle(0).config().dt);
    for (std::int64_t i = 0; i < steps; ++i) {
      ASSERT_EQ(fleet.step(), StepStatus::kOk);
      touched = touched || !fleet.touching().empty();
      lost = std::max(lost, (momentumOf(fleet) - momentum).norm());
      gained = std::max(gained, energyOf(fleet) / energy - 1.0);
    }
    ASSERT_TRUE(touched);
    ASSERT_TRUE(fleet.touching().empty());
  }
  /// How far both are from where they are in the other run [m].
  double apart(const Balls& other) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < 2; ++i)
      sum += (fleet.vehicle(i).rootPose().p - other.fleet.vehicle(i).rootPose().p).norm();
    return sum;
  }

  Fleet fleet;
  Vector3d momentum;
  double energy = 0.0, lost = 0.0, gained = 0.0;
  bool touched = false;
};

TEST(FleetIntegrators, BallsThatCollideInFlightKeepTheirMomentum) {
  for (const IntegratorKind kind : allIntegrators()) {
    Balls balls(kind, kTick, 30.0);
    balls.run(0.4);
    // Each brings 10 N s. Forces are equal and opposite in every evaluation, and so are the differences of
    // linearly_implicit.
    EXPECT_LT(balls.lost, kind == IntegratorKind::kLinearlyImplicit ? 1e-9 : 1e-12) << toString(kind);
  }
}

TEST(FleetIntegrators, ACollisionMakesNoEnergy) {
  Balls events(IntegratorKind::kRk4Events, kTick), controlled(IntegratorKind::kDormandPrince, kTick),
      implicit(IntegratorKind::kLinearlyImplicit, kTick);
  events.run(0.4);
  controlled.run(0.4);
  implicit.run(0.4);
  EXPECT_LT(events.gained, 1e-5);
  EXPECT_LT(controlled.gained, 1e-5);
  EXPECT_LT(implicit.gained, 1e-3);  // of its spinning: first order
}

TEST(FleetIntegrators, EventsAndErrorControlAreFarMoreExactThroughATouchDown) {
  Balls exact(IntegratorKind::kRk4, 2e-6);
  exact.run(0.4);
  const auto error = [&exact](IntegratorKind kind) {
    Balls balls(kind, kTick);
    balls.run(0.4);
    return balls.apart(exact);
  };
  const double rk4 = error(IntegratorKind::kRk4);
  EXPECT_GT(rk4, 1e-4);
  EXPECT_LT(error(IntegratorKind::kRk4Events), 0.02 * rk4);
  EXPECT_LT(error(IntegratorKind::kDormandPrince), 0.02 * rk4);
}

TEST(FleetIntegrators, EventsAreOfFourthOrderThroughATouchDown) {
  Balls fine(IntegratorKind::kRk4Events, 2e-5);
  fine.run(0.4);
  const auto error = [&fine](double dt) {
    Balls balls(IntegratorKind::kRk4Events, dt);
    balls.run(0.4);
    return balls.apart(fine);
  };
  const double order = 0.5 * std::log2(error(2e-3) / error(0.5e-3));
  EXPECT_GT(order, 3.5);
  EXPECT_LT(order, 5.5);
}

TEST(FleetIntegrators, TheErrorFollowsTheTolerance) {
  Balls fine(IntegratorKind::kRk4Events, 2e-5);
  fine.run(0.4);
  const auto error = [&fine](double tolerance) {
    Balls balls(IntegratorKind::kDormandPrince, 1e-2, 0.0, tolerance);
    balls.run(0.4);
    return balls.apart(fine);
  };
  EXPECT_LT(error(1e-5), 1e-2);
  EXPECT_LT(error(1e-9), 1e-5);
}

/// Exit speed over impact speed of two equal spheres head-on, first touch at `phase` of a tick.
double restitutionOf(IntegratorKind kind, double zeta, double phase, const double (&substeps)[2] = {4.0, 4.0}) {
  constexpr double kMass = 10.0, kOmega = 200.0, kSpeed = 0.5, kRadius = 0.3;
  const auto space = emptySpace();
  Fleet fleet;
  for (const double count : substeps) {
    SimConfig config = springConfig(kind, kTick, kMass * kOmega * kOmega, 2.0 * zeta * kMass * kOmega);
    config.contact_substeps = count;
    config.error_tolerance = 1e-8;
    add(fleet, make(solidBody(Vector3d::Constant(kRadius), kMass), space, config));
  }
  const double x = kRadius + (1.0 + phase) * kSpeed * kTick;
  placeAt(fleet.vehicle(0), {-x, 0.0, 0.0}, {kSpeed, 0.0, 0.0});
  placeAt(fleet.vehicle(1), {x, 0.0, 0.0}, {-kSpeed, 0.0, 0.0});
  for (int i = 0; i < 60; ++i) EXPECT_EQ(fleet.step(), StepStatus::kOk);
  EXPECT_TRUE(fleet.touching().empty());
  return fleet.vehicle(1).rootVelocity_W().x() / kSpeed;
}

TEST(FleetIntegrators, AContactThatBeginsWithinATickReboundsByTheClosedForm) {
  // Both springs in series of two equal bodies are one spring on a wall. RK4 alone is up to 1.9 % off.
  for (const double zeta : {0.0, 0.1, 0.3, 0.7})
    for (const double phase : {0.0, 0.13, 0.5, 0.97}) {
      const double expected = bounceOfDampedSpring(zeta).restitution;
      EXPECT_NEAR(restitutionOf(IntegratorKind::kRk4Events, zeta, phase), expected, 2e-5) << zeta << " " << phase;
      EXPECT_NEAR(restitutionOf(IntegratorKind::kDormandPrince, zeta, phase), expected, 1e-3) << zeta << " " << phase;
    }
}

TEST(FleetIntegrators, AnIslandTakesTheMostSubstepsOfItsVehicles) {
  const double strict = restitutionOf(IntegratorKind::kRk4Events, 0.3, 0.4, {16.0, 16.0});
  EXPECT_EQ(restitutionOf(IntegratorKind::kRk4Events, 0.3, 0.4, {4.0, 16.0}), strict);
  EXPECT_EQ(restitutionOf(IntegratorKind::kRk4Events, 0.3, 0.4, {16.0, 4.0}), strict);
  EXPECT_NE(restitutionOf(IntegratorKind::kRk4Events, 0.3, 0.4), strict);
}

TEST(FleetIntegrators, StepsAtTheFloorAreCountedForAll) {
  Balls balls(IntegratorKind::kDormandPrince, 1e-2, 300.0, 1e-12);
  balls.run(0.4);
  EXPECT_GT(balls.fleet.vehicle(0).events().floor_steps, 0);
  EXPECT_EQ(balls.fleet.vehicle(0).events().floor_steps, balls.fleet.vehicle(1).events().floor_steps);
  EXPECT_EQ(balls.fleet.stepCount(), 40);
}

/// A car sets off against one that coasts, and pushes it along for more than a second.
Fleet push(IntegratorKind kind, double dt) {
  const auto floor = flatFloor();
  SimConfig config;
  config.integrator = kind;
  config.dt = dt;
  config.allow_unstable = true;
  Fleet fleet;
  add(fleet, make(car(), floor, config));
  add(fleet, make(car(), floor, config));
  EXPECT_TRUE(fleet.setDown(0, 0.0, 0.0, 0.0).empty());
  EXPECT_TRUE(fleet.setDown(1, 4.02, 0.1, 0.0).empty());
  const auto steps = std::llround(3.0 / dt);
  double touching = 0.0;
  for (std::int64_t i = 0; i < steps; ++i) {
    fleet.vehicle(0).command(twist(2.0));
    fleet.vehicle(1).command(coast());
    EXPECT_EQ(fleet.step(), StepStatus::kOk);
    touching += fleet.touching().empty() ? 0.0 : dt;
  }
  EXPECT_GT(touching, 1.0) << toString(kind);
  return fleet;
}

TEST(FleetIntegrators, ACarPushesAnotherAlongTheSameWayWithEach) {
  const Fleet reference = push(IntegratorKind::kRk4Events, 2.5e-4);
  const Vector3d expected = reference.vehicle(1).rootPose().p;
  EXPECT_GT(expected.x(), 9.0);
  for (const IntegratorKind kind : allIntegrators()) {
    const Fleet fleet = push(kind, kTick);
    const bool first_order = kind <= IntegratorKind::kSemiImplicitEuler || kind == IntegratorKind::kLinearlyImplicit;
    EXPECT_LT((fleet.vehicle(1).rootPose().p - expected).norm(), first_order ? 1e-2 : 1e-4) << toString(kind);
    EXPECT_EQ(fleet.vehicle(0).events().floor_steps, 0) << toString(kind);
  }
}

TEST(FleetIntegrators, LinearlyImplicitPushesAtTenTimesTheTick) {
  const Fleet reference = push(IntegratorKind::kRk4, kTick), fleet = push(IntegratorKind::kLinearlyImplicit, 0.01);
  EXPECT_LT((fleet.vehicle(1).rootPose().p - reference.vehicle(1).rootPose().p).norm(), 0.05);
  EXPECT_EQ(fleet.vehicle(0).events().floor_steps, 0);
}

/// Three stiff bodies on top of each other on the ground.
TEST(FleetIntegrators, LinearlyImplicitSettlesAStackAtTenTimesTheExplicitLimit) {
  constexpr double kOmega = 2000.0, kMass = 10.0, kRadius = 0.3;
  SimConfig config =
      springConfig(IntegratorKind::kLinearlyImplicit, 0.01, kMass * kOmega * kOmega, 0.6 * kMass * kOmega);
  config.gravity = 9.81;
  const auto floor = flatFloor();
  Fleet fleet;
  for (int i = 0; i < 3; ++i) {
    add(fleet, make(solidBody(Vector3d::Constant(kRadius), kMass), floor, config));
    placeAt(fleet.vehicle(static_cast<std::size_t>(i)), {0.0, 0.0, 0.31 + 0.62 * i}, Vector3d::Zero());
  }
  EXPECT_GT(config.dt, 5.0 * fleet.vehicle(0).certificate().largestStep(IntegratorKind::kRk4));
  const double start = energyOf(fleet);
  for (int i = 0; i < 300; ++i) {
    ASSERT_EQ(fleet.step(), StepStatus::kOk);
    EXPECT_LE(energyOf(fleet), start * (1.0 + 1e-9)) << i;
  }
  EXPECT_EQ(fleet.touching().size(), 2u);
  // Each spring is pressed by what stands on it; those between two bodies are half as stiff.
  double z = kRadius - 3.0 * 9.81 / (kOmega * kOmega);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(fleet.vehicle(i).rootPose().p.z(), z, 1e-8) << i;
    EXPECT_LT(fleet.vehicle(i).rootVelocity_W().norm(), 1e-6) << i;
    z += 2.0 * kRadius - 2.0 * (2.0 - static_cast<double>(i)) * 9.81 / (kOmega * kOmega);
  }
}

TEST(FleetIntegrators, FrictionHoldsOneVehicleOnAnotherOnASlope) {
  // Twelve degrees, where what holds is a fifth of the weight and friction could hold half of it.
  constexpr double kSlope = 0.21;
  const auto slope = terrainOf(floorSoup(50.0, 1, kSlope));
  for (const IntegratorKind kind : withinTheTick()) {
    SimConfig config;
    config.integrator = kind;
    config.dt = kind == IntegratorKind::kLinearlyImplicit ? 0.01 : kTick;
    config.mu_static = config.mu_kinetic = 0.5;
    config.rest_detection = false;
    Fleet fleet;
    VehicleDescription plate = fourFeet(400.0, 1.0, 0.8, 0.2);
    plate.links[0].ellipsoids.push_back(ellipsoid("top", {0, 0, 0.3}, {2.5, 2.5, 0.3}));
    add(fleet, make(plate, slope, config));
    add(fleet, make(fourFeet(20.0, 0.2, 0.2, 0.1), slope, config));
    ASSERT_TRUE(fleet.setDown(0, 0.0, 0.0, 0.0).empty());
    const Pose lower = fleet.vehicle(0).rootPose();
    placeAt(fleet.vehicle(1), lower.p + lower.q * Vector3d(0.0, 0.0, 0.7), Vector3d::Zero(), Vector3d::Zero(), lower.q);
    const auto run = [&fleet](double seconds) {
      const auto steps = std::llround(seconds / fleet.vehicle(0).config().dt);
      for (std::int64_t i = 0; i < steps; ++i) ASSERT_EQ(fleet.step(), StepStatus::kOk);
    };
    run(1.0);
    const Vector3d before = fleet.vehicle(1).rootPose().p;
    run(1.0);
    EXPECT_LT((fleet.vehicle(1).rootPose().p - before).norm(), 1e-5) << toString(kind);
    EXPECT_EQ(fleet.touching().size(), 4u) << toString(kind);
    EXPECT_EQ(fleet.vehicle(1).events().floor_steps, 0) << toString(kind);
    Vector3d pushed = Vector3d::Zero();
    std::vector<ContactReport> contacts;
    fleet.vehicle(1).contacts(contacts);
    for (const ContactReport& c : contacts) pushed += c.normal_force * c.nhat_W + c.friction_W;
    EXPECT_LT((pushed - Vector3d(0.0, 0.0, 20.0 * 9.80665)).norm(), 0.1) << toString(kind);
  }
}

TEST(FleetIntegrators, VehiclesFarFromEachOtherRunAsAloneToTheLastBit) {
  const auto floor = flatFloor();
  for (const IntegratorKind kind : withinTheTick()) {
    SimConfig config;
    config.integrator = kind;
    Fleet fleet;
    std::vector<Simulator> alone;
    for (int i = 0; i < 2; ++i) {
      alone.push_back(make(car(), floor, config));
      add(fleet, make(car(), floor, config));
      standAt(alone.back(), 0, 20.0 * i, 0);
      standAt(fleet.vehicle(static_cast<std::size_t>(i)), 0, 20.0 * i, 0);
    }
    for (int step = 0; step < 300; ++step) {
      for (std::size_t i = 0; i < 2; ++i) {
        alone[i].command(twist(4.0));
        fleet.vehicle(i).command(twist(4.0));
        alone[i].step();
      }
      ASSERT_EQ(fleet.step(), StepStatus::kOk);
    }
    for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(fleet.vehicle(i).stateHash(), alone[i].stateHash()) << toString(kind);
  }
}

TEST(FleetIntegrators, OneThatDivergesTakesItsIslandBackToTheTicksStart) {
  // One falls past a car a hundred metres a tick and beyond the bound of any speed, so near that both are stepped
  // together: the car has taken sub-steps of the tick already that is not one in the end.
  for (const IntegratorKind kind : allIntegrators()) {
    const auto floor = flatFloor();
    SimConfig config;
    config.integrator = kind;
    config.allow_unstable = true;
    Fleet fleet;
    add(fleet, make(car(), floor, config));
    add(fleet, make(solidBody(Vector3d::Constant(0.1), 10.0), floor, config));
    ASSERT_TRUE(fleet.setDown(0, 0.0, 0.0, 0.0).empty());
    placeAt(fleet.vehicle(1), {2.5, 0.0, 1149.0}, {0.0, 0.0, -99999.9});
    std::uint64_t before = 0;
    StepStatus status = StepStatus::kOk;
    for (int i = 0; i < 20 && status == StepStatus::kOk; ++i) {
      fleet.vehicle(0).command(twist(2.0));
      before = fleet.stateHash();
      status = fleet.step();
    }
    ASSERT_EQ(status, StepStatus::kDiverged) << toString(kind);
    EXPECT_EQ(fleet.stepCount(), 10) << toString(kind);
    EXPECT_EQ(fleet.vehicle(0).stepCount(), 10) << toString(kind);
    EXPECT_EQ(fleet.vehicle(0).status(), StepStatus::kOk) << toString(kind);
    EXPECT_EQ(fleet.stateHash(), before) << toString(kind);
  }
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
