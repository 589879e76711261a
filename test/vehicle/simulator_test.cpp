#include "ellipsoid_vehicle_sim/vehicle/simulator.h"

#include <gtest/gtest.h>

#include <limits>

#include "support/motions.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Vector3d;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInfinity = std::numeric_limits<double>::infinity();

SimConfig configOf(IntegratorKind kind) {
  SimConfig config;
  config.integrator = kind;
  return config;
}

Simulator standingCar(IntegratorKind kind = IntegratorKind::kSemiImplicitEuler) {
  Simulator simulator = make(car(), flatFloor(), configOf(kind));
  standAt(simulator, 0.0, 0.0, 0.0);
  return simulator;
}

/// A drive with everything in it; returns the hash after every tenth of a second.
std::vector<std::uint64_t> eventfulDrive(Simulator& simulator) {
  std::vector<std::uint64_t> hashes;
  for (int i = 0; i < 20; ++i) {
    simulator.command(ackermann(i < 12 ? 8.0 : 0.0, 0.3 * std::sin(i)));
    run(simulator, 0.1);
    hashes.push_back(simulator.stateHash());
  }
  return hashes;
}

TEST(Simulator, ResetReplaysBitForBit) {
  for (const IntegratorKind kind : {IntegratorKind::kSemiImplicitEuler, IntegratorKind::kRk4}) {
    Simulator simulator = standingCar(kind);
    const std::uint64_t home = simulator.stateHash();
    const std::vector<std::uint64_t> first = eventfulDrive(simulator);
    simulator.reset();
    EXPECT_EQ(simulator.stateHash(), home);
    EXPECT_EQ(eventfulDrive(simulator), first) << toString(kind);
    // And in another simulator of the same vehicle, where no cache has seen anything before.
    Simulator other = standingCar(kind);
    EXPECT_EQ(eventfulDrive(other), first) << toString(kind);
  }
}

TEST(Simulator, AskingChangesNothing) {
  Simulator asked = standingCar(), left_alone = standingCar();
  std::vector<JointReading> joints;
  std::vector<ContactReport> contacts;
  for (int i = 0; i < 500; ++i) {
    asked.command(twist(3.0, 0.2));
    left_alone.command(twist(3.0, 0.2));
    asked.step();
    left_alone.step();
    asked.jointReadings(joints);
    asked.contacts(contacts);
    asked.energy();
  }
  EXPECT_EQ(asked.stateHash(), left_alone.stateHash());
}

TEST(Simulator, TimeIsStepsAndNeverGoesBack) {
  Simulator simulator = standingCar();
  EXPECT_EQ(simulator.stepCount(), 0);
  run(simulator, 0.25);
  EXPECT_EQ(simulator.stepCount(), 250);
  simulator.reset();
  EXPECT_EQ(simulator.stepCount(), 250);
  EXPECT_DOUBLE_EQ(simulator.time(), 0.25);
  standAt(simulator, 1.0, 0.0, 0.0);
  placeAt(simulator, {0.0, 0.0, 2.0}, Vector3d::Zero());
  EXPECT_EQ(simulator.stepCount(), 250);
  run(simulator, 0.1);
  EXPECT_EQ(simulator.stepCount(), 350);
}

TEST(Simulator, NonFiniteCommandsAreDroppedAndCounted) {
  Simulator simulator = standingCar();
  EXPECT_TRUE(simulator.command(twist(1.0)));
  const std::uint64_t before = simulator.stateHash();
  DriveCommand bad_angle = ackermann(1.0, kNan), bad_yaw = twist(1.0, kInfinity);
  for (const DriveCommand& bad : {twist(kNan), twist(-kInfinity), bad_yaw, bad_angle})
    EXPECT_FALSE(simulator.command(bad));
  EXPECT_EQ(simulator.events().rejected_commands, 4);
  EXPECT_EQ(simulator.stateHash(), before);
  EXPECT_EQ(simulator.state().drive.command.speed, 1.0);
  run(simulator, 0.3);
  EXPECT_GT(simulator.rootVelocity_W().x(), 0.1);
}

TEST(Simulator, AnOldCommandBrakesToStandstill) {
  for (const IntegratorKind kind : {IntegratorKind::kSemiImplicitEuler, IntegratorKind::kRk4}) {
    Simulator simulator = standingCar(kind);
    drive(simulator, twist(6.0), 4.0);
    ASSERT_NEAR(simulator.rootVelocity_W().x(), 6.0, 0.1);
    EXPECT_TRUE(simulator.commandInForce());
    // In force for 0.5 s, then 6 m/s at 6 m/s^2, and time to come to rest on the springs.
    run(simulator, 0.45);
    EXPECT_TRUE(simulator.commandInForce());
    EXPECT_NEAR(simulator.rootVelocity_W().x(), 6.0, 0.1);
    run(simulator, 4.0);
    EXPECT_FALSE(simulator.commandInForce());
    EXPECT_EQ(simulator.events().command_timeouts, 1);
    EXPECT_LT(simulator.rootVelocity_W().norm(), 1e-4) << toString(kind);
    const Vector3d stood = simulator.rootPose().p;
    run(simulator, 10.0);
    EXPECT_LT((simulator.rootPose().p - stood).norm(), 1e-4) << toString(kind);
    EXPECT_LT(simulator.rootVelocity_W().norm(), 1e-9) << toString(kind);
  }
}

TEST(Simulator, TheBrakesSlowDownAsAsked) {
  // 6 m/s^2 of the whole car; the first fifth of a second is the brakes' and the springs' own.
  Simulator simulator = standingCar();
  drive(simulator, twist(10.0), 6.0);
  drive(simulator, twist(0.0), 0.3);
  const double v1 = simulator.rootVelocity_W().x();
  drive(simulator, twist(0.0), 0.8);
  EXPECT_NEAR((v1 - simulator.rootVelocity_W().x()) / 0.8, 6.0, 0.3);
}

TEST(Simulator, DrivesTenMetresStraightOnTheFlat) {
  for (const IntegratorKind kind : allIntegrators()) {
    Simulator simulator = standingCar(kind);
    const double y0 = simulator.rootPose().p.y();
    for (int i = 0; i < 20000 && simulator.rootPose().p.x() < 10.0; ++i) {
      simulator.command(twist(2.0));
      ASSERT_EQ(simulator.step(), StepStatus::kOk);
    }
    EXPECT_GE(simulator.rootPose().p.x(), 10.0);
    EXPECT_LT(std::abs(simulator.rootPose().p.y() - y0), 1e-3) << toString(kind);
    EXPECT_NEAR(simulator.rootVelocity_W().x(), 2.0, 0.02) << toString(kind);
    EXPECT_NEAR(simulator.encoderSpeed(), simulator.rootVelocity_W().x(), 0.02) << toString(kind);
  }
}

TEST(Simulator, SetDownLoadsAllFourWheelsWithTheWholeWeight) {
  CarShape nose_heavy;
  nose_heavy.front = 1.1;
  nose_heavy.rear = -1.5;
  for (const CarShape& shape : {CarShape{}, nose_heavy})
    for (const double yaw : {0.0, 2.0}) {
      Simulator simulator = make(car(shape), flatFloor(), configOf(IntegratorKind::kSemiImplicitEuler));
      standAt(simulator, 3.0, -2.0, yaw);
      std::vector<ContactReport> contacts;
      simulator.contacts(contacts);
      ASSERT_EQ(contacts.size(), 4u);
      double sum = 0.0;
      for (const ContactReport& contact : contacts) {
        EXPECT_GT(contact.normal_force, 0.1 * shape.mass * 9.80665);
        sum += contact.normal_force;
      }
      // At rest to 1e-6 m/s: the springs are out by a newton at most.
      EXPECT_NEAR(sum, shape.mass * 9.80665, 1.0);
      const Vector3d p = simulator.rootPose().p;
      run(simulator, 2.0);
      EXPECT_LT((simulator.rootPose().p - p).norm(), 1e-5);
    }
}

TEST(Simulator, SetDownOnAPlainSlopeStandsAndStays) {
  const double slope = 15.0 * M_PI / 180.0;
  Simulator simulator =
      make(car(), terrainOf(floorSoup(500.0, 1, slope)), configOf(IntegratorKind::kSemiImplicitEuler));
  for (const double yaw : {0.0, 1.0, M_PI}) {
    standAt(simulator, 0.0, 0.0, yaw);
    const Vector3d p = simulator.rootPose().p;
    run(simulator, 5.0);
    EXPECT_LT((simulator.rootPose().p - p).norm(), 1e-5) << yaw;
  }
}

std::string refusal(Simulator& simulator, double x, double y) {
  const std::uint64_t before = simulator.stateHash();
  const Problems problems = simulator.setDown(x, y, 0.0);
  EXPECT_FALSE(problems.empty());
  EXPECT_EQ(simulator.stateHash(), before) << "a refused set-down must change nothing";
  return problemText(problems);
}

TEST(Simulator, SetDownWhereThereIsNoGroundIsRefused) {
  Simulator simulator = make(car(), flatFloor(10.0), configOf(IntegratorKind::kSemiImplicitEuler));
  standAt(simulator, 0.0, 0.0, 0.0);
  const std::string text = refusal(simulator, 50.0, 0.0);
  EXPECT_NE(text.find("no ground below"), std::string::npos) << text;
  EXPECT_NE(text.find("(50, 0)"), std::string::npos) << text;
  EXPECT_NE(refusal(simulator, kNan, 0.0).find("finite"), std::string::npos);
}

TEST(Simulator, SetDownOverABackSideIsRefused) {
  TriangleSoup soup = floorSoup(10.0, 1);
  for (auto& triangle : soup.triangles) std::swap(triangle[1], triangle[2]);
  Simulator simulator = make(car(), terrainOf(std::move(soup)), configOf(IntegratorKind::kSemiImplicitEuler));
  EXPECT_NE(refusal(simulator, 0.0, 0.0).find("faces up"), std::string::npos);
}

TEST(Simulator, SetDownWhereTheVehicleSlidesIsRefused) {
  for (const double degrees : {30.0, 60.0}) {
    SimConfig config = configOf(IntegratorKind::kSemiImplicitEuler);
    config.mu_static = config.mu_kinetic = 0.4;
    Simulator simulator = make(car(), terrainOf(floorSoup(500.0, 1, degrees * M_PI / 180.0)), config);
    const std::string text = refusal(simulator, 0.0, 0.0);
    EXPECT_NE(text.find("finds no rest"), std::string::npos) << text;
  }
}

TEST(Simulator, SetDownOnFewerThanThreeSupportsIsRefused) {
  // Frictionless, so that it cannot lean: a sledge of four feet on a ridge narrower than its track.
  TriangleSoup soup;
  addQuad(soup, {-5, -0.05, 0}, {5, -0.05, 0}, {5, 0.05, 0}, {-5, 0.05, 0});
  Simulator simulator = make(fourFeet(50.0), terrainOf(std::move(soup)), configOf(IntegratorKind::kSemiImplicitEuler));
  EXPECT_FALSE(refusal(simulator, 0.0, 0.0).empty());
}

TEST(Simulator, ADivergedRunFreezesAtTheLastGoodState) {
  // Explicit Euler on an undamped spring gains 2 % a step: beyond all bounds within a thousand.
  SimConfig config = springConfig(IntegratorKind::kExplicitEuler, 1e-3, 1e5, 100.0);
  Simulator simulator = make(springPair(250.0, 1e7), emptySpace(), config);
  placeAt(simulator, Vector3d::Zero(), Vector3d::Zero());
  std::uint64_t last = simulator.stateHash();
  StepStatus status = StepStatus::kOk;
  for (int i = 0; i < 5000 && status == StepStatus::kOk; ++i) {
    last = simulator.stateHash();
    status = simulator.step();
  }
  ASSERT_EQ(status, StepStatus::kDiverged);
  EXPECT_EQ(simulator.stateHash(), last);
  EXPECT_TRUE(simulator.state().motion.allFinite());
  const std::int64_t count = simulator.stepCount();
  for (int i = 0; i < 10; ++i) EXPECT_EQ(simulator.step(), StepStatus::kDiverged);
  EXPECT_EQ(simulator.status(), StepStatus::kDiverged);
  EXPECT_EQ(simulator.stateHash(), last);
  EXPECT_EQ(simulator.stepCount(), count);
  // Questions are still answered, and a reset starts anew.
  EXPECT_TRUE(std::isfinite(simulator.energy()));
  simulator.reset();
  EXPECT_EQ(simulator.status(), StepStatus::kOk);
  EXPECT_EQ(simulator.step(), StepStatus::kOk);
}

TEST(Simulator, BoundsOfACommandMustNotBeNegative) {
  Simulator simulator = standingCar();
  for (double DriveCommand::*bound :
       {&DriveCommand::steering_angle_velocity, &DriveCommand::acceleration, &DriveCommand::jerk}) {
    DriveCommand command = ackermann(1.0, 0.1);
    command.*bound = -0.1;
    EXPECT_FALSE(simulator.command(command));
    command.*bound = kNan;
    EXPECT_FALSE(simulator.command(command));
  }
  EXPECT_EQ(simulator.events().rejected_commands, 6);
}

TEST(Simulator, FrictionScaleMovesTheLimitOfTheSlope) {
  // mu 0.9 holds on 30 degrees, tan = 0.577; half of it does not: it slides with g (sin - mu cos).
  const double slope = M_PI / 6.0;
  Simulator simulator = make(fourFeet(50.0), terrainOf(floorSoup(500.0, 1, slope)), configOf(IntegratorKind::kRk4));
  standAt(simulator, 0.0, 0.0, 0.0);
  run(simulator, 1.0);
  EXPECT_LT(simulator.rootVelocity_W().norm(), 1e-6);
  simulator.setFrictionScale(0.5);
  run(simulator, 0.2);
  const double before = simulator.rootVelocity_W().norm();
  run(simulator, 1.0);
  EXPECT_NEAR(simulator.rootVelocity_W().norm() - before, 9.80665 * (std::sin(slope) - 0.45 * std::cos(slope)), 0.02);
  simulator.reset();
  EXPECT_EQ(simulator.frictionScale(), 0.5);
}

TEST(Simulator, RootAccelerationIsTheDerivativeOfItsVelocity) {
  Simulator simulator = make(car(), emptySpace(), configOf(IntegratorKind::kRk4));
  // Tumbling freely: gravity, and the root link circling about the centre of mass.
  placeAt(simulator, Vector3d::Zero(), {1.0, 2.0, 3.0}, {0.5, 1.0, -0.8});
  run(simulator, 0.1);
  const Vector3d a = simulator.rootAcceleration_W(), v0 = simulator.rootVelocity_W();
  simulator.step();
  const Vector3d v1 = simulator.rootVelocity_W(), a1 = simulator.rootAcceleration_W();
  // Trapezoidal rule: the error is of the order dt^2 times the jerk's rate.
  EXPECT_LT(((v1 - v0) / 1e-3 - 0.5 * (a + a1)).norm(), 1e-4);
  EXPECT_GT((a - Vector3d(0, 0, -9.80665)).norm(), 1e-3) << "the root link is not the centre of mass";
}

TEST(Simulator, ExplainContactNamesTheWinnerAndWhyTheOthersLost) {
  // A ball on a floor of two cells a metre wide, 0.1 m beside the seam along x = 0, far from the others.
  SimConfig config = configOf(IntegratorKind::kRk4);
  config.stiffness = 1e4;
  config.damping = 100.0;
  Simulator simulator = make(solidBody(Vector3d::Constant(0.5), 50.0), flatFloor(2.0, 4), config);
  standAt(simulator, 0.1, 0.3, 0.0);
  run(simulator, 1.0);
  const ContactExplanation explanation = simulator.explainContact(0);
  ASSERT_EQ(explanation.contacts.size(), 1u);
  EXPECT_NEAR(explanation.contacts[0].normal_force, 50.0 * 9.80665, 1e-3);
  EXPECT_FALSE(explanation.contacts[0].sliding);
  int winners = 0, losers = 0;
  for (const CandidateReport& candidate : explanation.candidates) {
    if (candidate.rank == 0) {
      ++winners;
      EXPECT_EQ(candidate.triangle, explanation.contacts[0].triangle);
      EXPECT_EQ(candidate.alone.feature, Feature::kFace);
      EXPECT_NEAR(candidate.alone.depth, explanation.contacts[0].depth, 1e-12);
      EXPECT_NE(candidate.reason.find("pushes, with its face"), std::string::npos) << candidate.reason;
    } else if (candidate.alone) {
      ++losers;
      // The seam is nearer than the ball's cap is wide: the neighbour touches with its edge, less deep.
      EXPECT_LT(candidate.alone.depth, explanation.contacts[0].depth);
      EXPECT_NE(candidate.reason.find("less than triangle"), std::string::npos) << candidate.reason;
    } else {
      EXPECT_NE(candidate.reason.find("no contact"), std::string::npos) << candidate.reason;
    }
  }
  EXPECT_EQ(winners, 1);
  EXPECT_GT(losers, 0);
  double next = 0.0;
  for (const CandidateReport& candidate : explanation.candidates)
    if (candidate.rank != 0 && candidate.admitted) next = std::max(next, candidate.alone.depth);
  EXPECT_NEAR(explanation.margin, explanation.contacts[0].depth - next, 1e-12);
}

TEST(Simulator, ExplainContactSaysThatABackSideDoesNotPush) {
  // The floor's back is above: the ball hangs in it with its centre behind.
  Simulator simulator = make(solidBody(Vector3d::Constant(0.5), 50.0), flatFloor(2.0, 1), configOf(IntegratorKind::kRk4));
  placeAt(simulator, {0.3, 0.1, -0.2}, Vector3d::Zero());
  const ContactExplanation explanation = simulator.explainContact(0);
  EXPECT_TRUE(explanation.contacts.empty());
  ASSERT_FALSE(explanation.candidates.empty());
  for (const CandidateReport& candidate : explanation.candidates)
    EXPECT_NE(candidate.reason.find("behind it, and it is one-sided"), std::string::npos) << candidate.reason;
}

TEST(Simulator, PlaceRefusesWhatIsNotANumber) {
  Simulator simulator = standingCar();
  const std::uint64_t before = simulator.stateHash();
  EXPECT_FALSE(
      simulator.place({Vector3d(kNan, 0, 0), Eigen::Quaterniond::Identity()}, Vector3d::Zero(), Vector3d::Zero())
          .empty());
  EXPECT_FALSE(
      simulator.place({Vector3d::Zero(), Eigen::Quaterniond(0, 0, 0, 0)}, Vector3d::Zero(), Vector3d::Zero()).empty());
  EXPECT_FALSE(simulator.place(Pose{}, Vector3d(1e8, 0, 0), Vector3d::Zero()).empty());
  EXPECT_EQ(simulator.stateHash(), before);
}

TEST(Simulator, PlaceMovesTheRootLinkAsAsked) {
  // The base's centre of mass lies elsewhere: velocities are those of the root link's origin.
  Simulator simulator = make(car(), emptySpace(), configOf(IntegratorKind::kRk4));
  const Pose X{{1.0, 2.0, 3.0}, Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()))};
  const Vector3d v(0.5, -1.0, 2.0), w(0.3, 0.1, -0.7);
  ASSERT_TRUE(simulator.place(X, v, w).empty());
  EXPECT_LT((simulator.rootPose().p - X.p).norm(), 1e-14);
  EXPECT_LT(simulator.rootPose().q.angularDistance(X.q), 1e-14);
  EXPECT_LT((simulator.rootVelocity_W() - v).norm(), 1e-14);
  EXPECT_LT((simulator.rootAngularVelocity_W() - w).norm(), 1e-14);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
