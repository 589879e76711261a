#include "ellipsoid_vehicle_sim/vehicle/drive.h"
#include "ellipsoid_vehicle_sim/vehicle/profile.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "support/motions.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Vector3d;

/// Follows the profile as the simulator does, for `seconds` or until it has stood at the target for a while.
struct Followed {
  double position = 0.0, velocity = 0.0, fastest = 0.0, hardest = 0.0, beyond = 0.0, arrival = 0.0;
};

Followed follow(const PrescribedJoint& joint, double start, double target, double dt, double seconds) {
  ProfileState p;
  p.position = start;
  p.target = target;
  Followed f;
  const double towards = target >= start ? 1.0 : -1.0;
  for (double t = 0.0; t < seconds; t += dt) {
    planProfile(joint, joint.max_speed, dt, p);
    f.hardest = std::max({f.hardest, std::abs(p.acceleration), std::abs(p.then)});
    carryProfile(dt, true, p);
    f.fastest = std::max(f.fastest, std::abs(p.velocity));
    f.beyond = std::max(f.beyond, towards * (p.position - target));
    if (std::abs(p.position - target) > 1e-9) f.arrival = t + dt;
  }
  f.position = p.position;
  f.velocity = p.velocity;
  return f;
}

PrescribedJoint steerJoint(double speed, double acceleration) {
  PrescribedJoint joint;
  joint.max_speed = speed;
  joint.max_acceleration = acceleration;
  joint.lower = -10.0;
  joint.upper = 10.0;
  return joint;
}

TEST(Drive, ProfileReachesItsTargetWithinTheLimitsAndWithoutOvershoot) {
  for (const double dt : {1e-4, 1e-3, 1e-2})
    for (const double distance : {1e-6, 1e-3, 0.05, 0.6, -0.6, 3.0}) {
      const PrescribedJoint joint = steerJoint(1.0, 20.0);
      const double start = 0.2;
      const Followed f = follow(joint, start, start + distance, dt, 6.0);
      SCOPED_TRACE("dt " + std::to_string(dt) + " distance " + std::to_string(distance));
      EXPECT_NEAR(f.position, start + distance, 1e-15 * 8.0);
      EXPECT_NEAR(f.velocity, 0.0, 1e-12);
      EXPECT_LE(f.fastest, joint.max_speed * (1.0 + 1e-12));
      EXPECT_LE(f.hardest, joint.max_acceleration * (1.0 + 1e-12));
      EXPECT_LE(f.beyond, 1e-13) << "but for the rounding of thousands of ticks";
      // As fast as the limits allow, but for a few ticks: trapezium or triangle of the speed.
      const double d = std::abs(distance), v = joint.max_speed, a = joint.max_acceleration;
      const double best = d > v * v / a ? d / v + v / a : 2.0 * std::sqrt(d / a);
      EXPECT_LE(f.arrival, best + 4.0 * dt);
    }
}

TEST(Drive, ProfileIsTheSamePathWhateverTheTick) {
  // A trapezium of the speed: 0.05 s up, 0.55 s at full speed, 0.05 s down; corners that no tick of these hits.
  const PrescribedJoint joint = steerJoint(1.0, 20.0);
  const auto exact = [](double t) {
    const double total = 0.65, t1 = 0.05;
    if (t < t1) return 10.0 * t * t;
    if (t > total) return 0.6;
    const double left = total - t;
    return left < t1 ? 0.6 - 10.0 * left * left : 0.025 + (t - t1);
  };
  for (const double dt : {0.7e-3, 3.1e-3, 11e-3}) {
    ProfileState p;
    p.target = 0.6;
    for (int i = 1; i * dt < 0.66; ++i) {
      planProfile(joint, joint.max_speed, dt, p);
      const ProfilePoint between = profileAt(p, 0.3 * dt);
      ASSERT_NEAR(between.position, exact((i - 0.7) * dt), 1e-9) << dt << " " << i;
      carryProfile(0.4 * dt, false, p);
      carryProfile(0.6 * dt, true, p);
      ASSERT_NEAR(p.position, exact(i * dt), 1e-9) << dt << " " << i;
    }
  }
}

TEST(Drive, ProfileTurnsRoundWhenTheTargetMoves) {
  // Targets thrown about at random, from any speed within the limits: never beyond them, and at the last one in the
  // end.
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> target(-0.6, 0.6);
  const PrescribedJoint joint = steerJoint(1.0, 20.0);
  const double dt = 1e-3;
  ProfileState p;
  for (int i = 0; i < 20000; ++i) {
    if (i % 137 == 0) p.target = target(random);
    planProfile(joint, joint.max_speed, dt, p);
    ASSERT_LE(std::max(std::abs(p.acceleration), std::abs(p.then)), 20.0 * (1.0 + 1e-12));
    carryProfile(dt, true, p);
    ASSERT_LE(std::abs(p.velocity), 1.0 + 1e-12);
    // Braking from full speed takes v^2 / 2 a = 25 mm.
    ASSERT_LE(std::abs(p.position), 0.6 + 0.025 + 1e-3);
  }
  for (int i = 0; i < 3000; ++i) {
    planProfile(joint, joint.max_speed, dt, p);
    carryProfile(dt, true, p);
  }
  EXPECT_NEAR(p.position, p.target, 1e-15);
}

/// A car at rest, and what updateDrive makes of a command for it.
class DriveOfACar : public ::testing::Test {
 protected:
  static Simulator carWith(const SimConfig& config) { return make(car(), emptySpace(), config); }

  static VehicleState commanded(const Simulator& simulator, const DriveCommand& command) {
    VehicleState state = simulator.state();
    state.drive.command = command;
    state.drive.has_command = true;
    state.drive.command_age = 0;
    bool timed_out = false;
    updateDrive(simulator.model(), simulator.config(), state, timed_out);
    EXPECT_FALSE(timed_out);
    return state;
  }

  /// Targets of the front left and right wheel's steering [rad].
  static std::pair<double, double> steerTargets(const Simulator& simulator, const DriveCommand& command) {
    const VehicleState state = commanded(simulator, command);
    std::pair<double, double> angles;
    for (const SteerUnit& steer : simulator.model().drive.steers)
      (steer.p_FS.y() > 0.0 ? angles.first : angles.second) =
          steer.sign * state.profiles[static_cast<std::size_t>(steer.prescribed)].target;
    return angles;
  }

  static constexpr double kWheelbase = 2.6, kTrack = 1.5;
};

TEST_F(DriveOfACar, WheelsSteerAboutOneCentreOnTheRearAxle) {
  const Simulator simulator = carWith(SimConfig{});
  EXPECT_NEAR(simulator.model().drive.wheelbase, kWheelbase, 1e-12);
  for (const double angle : {0.02, 0.2, 0.4, -0.3}) {
    const auto [left, right] = steerTargets(simulator, ackermann(2.0, angle));
    // cot(right) - cot(left) = track / wheelbase, and the mean of the cotangents is the virtual front wheel's.
    EXPECT_NEAR(1.0 / std::tan(right) - 1.0 / std::tan(left), kTrack / kWheelbase, 1e-9) << angle;
    EXPECT_NEAR(0.5 * (1.0 / std::tan(right) + 1.0 / std::tan(left)), 1.0 / std::tan(angle), 1e-9) << angle;
  }
}

TEST_F(DriveOfACar, ATwistSteersForItsCurvatureAndBackwardsTheOtherWay) {
  const Simulator simulator = carWith(SimConfig{});
  const auto forward = steerTargets(simulator, twist(2.0, 0.4));
  const auto angle = steerTargets(simulator, ackermann(2.0, std::atan(0.2 * kWheelbase)));
  EXPECT_NEAR(forward.first, angle.first, 1e-12);
  EXPECT_NEAR(forward.second, angle.second, 1e-12);
  const auto backwards = steerTargets(simulator, twist(-2.0, 0.4));
  EXPECT_NEAR(backwards.first, -forward.second, 1e-12);
  EXPECT_NEAR(backwards.second, -forward.first, 1e-12);
}

TEST_F(DriveOfACar, CurvatureStopsWhereTheInnerWheelReachesItsLimit) {
  const Simulator simulator = carWith(SimConfig{});
  for (const double sign : {1.0, -1.0}) {
    const auto [left, right] = steerTargets(simulator, ackermann(2.0, sign * 1.4));
    const double inner = sign > 0.0 ? left : right, outer = sign > 0.0 ? right : left;
    EXPECT_NEAR(inner, sign * 0.6, 1e-9);
    EXPECT_NEAR(1.0 / std::tan(std::abs(outer)) - 1.0 / std::tan(std::abs(inner)), kTrack / kWheelbase, 1e-8);
  }
  // tan(0.6) = kappa L / (1 - kappa t / 2).
  const double limit = std::tan(0.6) / (kWheelbase + 0.5 * kTrack * std::tan(0.6));
  EXPECT_NEAR(simulator.model().drive.max_curvature_left, limit, 1e-9);
  EXPECT_NEAR(simulator.model().drive.max_curvature_right, limit, 1e-9);
}

TEST_F(DriveOfACar, SpeedCommandsAreLimitedInValueAndAcceleration) {
  SimConfig config;
  config.max_speed = 5.0;
  config.max_acceleration = 2.0;
  config.max_deceleration = 4.0;
  const Simulator simulator = carWith(config);
  VehicleState state = commanded(simulator, twist(100.0));
  bool timed_out = false;
  double last = state.drive.speed;
  EXPECT_NEAR(last, 2e-3, 1e-12);
  const auto follow_for = [&](int ticks, double speed) {
    for (int i = 0; i < ticks; ++i) {
      state.drive.command = twist(speed);
      state.drive.command_age = 0;
      updateDrive(simulator.model(), config, state, timed_out);
      ASSERT_LE(state.drive.speed - last, 2e-3 + 1e-12);
      ASSERT_GE(state.drive.speed - last, -4e-3 - 1e-12);
      last = state.drive.speed;
    }
  };
  follow_for(3000, 100.0);
  EXPECT_EQ(state.drive.speed, 5.0);
  follow_for(500, 1.0);
  EXPECT_NEAR(state.drive.speed, 3.0, 1e-9);
  follow_for(1000, 1.0);
  EXPECT_EQ(state.drive.speed, 1.0);
}

TEST_F(DriveOfACar, TheInnerWheelIsAskedToTurnSlower) {
  SimConfig config;
  config.max_acceleration = 1000.0;
  const Simulator simulator = carWith(config);
  VehicleState state = simulator.state();
  const double kappa = 0.2;
  for (const SteerUnit& steer : simulator.model().drive.steers) {
    const double angle = std::atan(kappa * kWheelbase / (1.0 - kappa * steer.p_FS.y()));
    state.profiles[static_cast<std::size_t>(steer.prescribed)].position = steer.sign * angle;
  }
  EXPECT_NEAR(actualCurvature(simulator.model(), state), kappa, 1e-12);
  state.drive.command = twist(1.0, kappa);
  state.drive.has_command = true;
  bool timed_out = false;
  updateDrive(simulator.model(), config, state, timed_out);
  for (std::size_t i = 0; i < simulator.model().drive.wheels.size(); ++i) {
    const WheelUnit& wheel = simulator.model().drive.wheels[i];
    // Each rolls about the common centre at its own distance.
    const double radius = std::hypot(1.0 / kappa - wheel.p_FW.y(), wheel.p_FW.x() + 1.3);
    const double asked = state.drive.wheel_speed[i] + config.dt * state.drive.wheel_acceleration[i];
    EXPECT_NEAR(asked * wheel.radius, kappa * radius, 1e-9) << wheel.name;
  }
}

/// Torques of the driven wheels (rear left, rear right) at their speeds, asked to run at 10 rad/s.
std::pair<double, double> torques(const SimConfig& config, double left_speed, double right_speed) {
  const Simulator simulator = make(car(), emptySpace(), config);
  const VehicleModel& model = simulator.model();
  VehicleState state = simulator.state();
  state.drive.mode = DriveState::Mode::kDrive;
  std::vector<double> torque(model.drive.wheels.size(), 0.0);
  std::pair<double, double> result;
  for (std::size_t i = 0; i < model.drive.wheels.size(); ++i) {
    const WheelUnit& wheel = model.drive.wheels[i];
    state.drive.wheel_speed[i] = 10.0;
    if (wheel.driven)
      state.motion.qd[static_cast<std::size_t>(wheel.joint)] = wheel.p_FW.y() > 0.0 ? left_speed : right_speed;
  }
  driveTorques(model, config, state.drive, 0.0, state.motion.q, state.motion.qd, torque);
  for (std::size_t i = 0; i < model.drive.wheels.size(); ++i) {
    const WheelUnit& wheel = model.drive.wheels[i];
    if (!wheel.driven) {
      EXPECT_EQ(torque[i], 0.0) << wheel.name;
      continue;
    }
    (wheel.p_FW.y() > 0.0 ? result.first : result.second) = torque[i];
  }
  return result;
}

TEST(Drive, AnOpenDifferentialGivesBothWheelsTheSameTorque) {
  SimConfig config;
  config.differential = Differential::kOpen;
  const auto [left, right] = torques(config, 9.0, 9.8);
  EXPECT_GT(left, 0.0);
  EXPECT_DOUBLE_EQ(left, right);
  // And none where the mean speed is right already, however different the wheels.
  const auto [none, neither] = torques(config, 8.0, 12.0);
  EXPECT_NEAR(none, 0.0, 1e-12);
  EXPECT_NEAR(neither, 0.0, 1e-12);
}

TEST(Drive, ALockedDifferentialMovesTorqueToTheSlowerWheel) {
  SimConfig config;
  config.differential = Differential::kLocked;
  const auto [left, right] = torques(config, 9.9, 10.1);
  EXPECT_GT(left, 0.0);
  EXPECT_NEAR(left + right, 0.0, 1e-9) << "the coupling itself drives nothing";
}

TEST(Drive, PerWheelMotorsCorrectEachItsOwnSpeed) {
  SimConfig config;
  config.differential = Differential::kPerWheel;
  const auto [left, right] = torques(config, 9.9, 10.2);
  EXPECT_GT(left, 0.0);
  EXPECT_NEAR(right, -2.0 * left, 1e-9 * std::abs(right));
}

TEST(Drive, TorqueIsBoundedByEffortAndPower) {
  SimConfig config;
  config.max_drive_torque = 100.0;
  EXPECT_DOUBLE_EQ(torques(config, 0.0, 0.0).first, 100.0);
  EXPECT_DOUBLE_EQ(torques(config, 1000.0, 1000.0).first, -100.0);
  config.max_power = 600.0;
  const auto [left, right] = torques(config, 5.0, 5.0);
  EXPECT_NEAR(5.0 * (left + right), 600.0, 1e-9);
}

TEST(Drive, BrakesShareTheDecelerationByTheBalance) {
  SimConfig config;
  config.brake_balance = 0.7;
  config.max_deceleration = 5.0;
  const Simulator simulator = make(car(), emptySpace(), config);
  DriveState braking, driving;
  driving.mode = DriveState::Mode::kDrive;
  double front = 0.0, rear = 0.0;
  for (const WheelUnit& wheel : simulator.model().drive.wheels) {
    (wheel.p_FW.x() > 0.0 ? front : rear) += brakeTorque(wheel, braking) / wheel.radius;
    EXPECT_EQ(brakeTorque(wheel, driving), 0.0);
  }
  EXPECT_NEAR(front + rear, 1200.0 * 5.0, 1e-9);
  EXPECT_NEAR(front / (front + rear), 0.7, 1e-12);
}

TEST(Drive, ZeroSpeedAndYawRateMeanBrakeAndCoastMeansNeither) {
  const Simulator simulator = make(car(), emptySpace(), SimConfig{});
  const auto modeOf = [&](const DriveCommand& command) {
    VehicleState state = simulator.state();
    state.drive.command = command;
    state.drive.has_command = true;
    bool timed_out = false;
    updateDrive(simulator.model(), simulator.config(), state, timed_out);
    return state.drive.mode;
  };
  EXPECT_EQ(modeOf(twist(0.0)), DriveState::Mode::kBrake);
  EXPECT_EQ(modeOf(twist(1.0)), DriveState::Mode::kDrive);
  EXPECT_EQ(modeOf(coast()), DriveState::Mode::kCoast);
}

TEST_F(DriveOfACar, AnAckermannCommandBoundsSteeringRateAccelerationAndJerk) {
  SimConfig config;
  config.max_acceleration = 4.0;
  config.max_deceleration = 8.0;
  const Simulator simulator = carWith(config);
  DriveCommand command = ackermann(3.0, 0.3);
  command.steering_angle_velocity = 0.5;
  command.acceleration = 1.5;
  command.jerk = 3.0;
  VehicleState state = commanded(simulator, command);
  bool timed_out = false;
  double speed = state.drive.speed, acceleration = state.drive.acceleration, steering = state.drive.steering;
  double time_to_speed = 0.0, time_to_angle = 0.0;
  const auto follow_for = [&](double seconds) {
    for (int i = 0; i < static_cast<int>(seconds / config.dt); ++i) {
      state.drive.command = command;
      state.drive.command_age = 0;
      updateDrive(simulator.model(), config, state, timed_out);
      ASSERT_LE(std::abs(state.drive.speed - speed), 1.5 * config.dt * (1.0 + 1e-9));
      ASSERT_LE(std::abs(state.drive.acceleration - acceleration), 3.0 * config.dt * (1.0 + 1e-9));
      ASSERT_LE(std::abs(state.drive.steering - steering), 0.5 * config.dt * (1.0 + 1e-9));
      speed = state.drive.speed;
      acceleration = state.drive.acceleration;
      steering = state.drive.steering;
      if (std::abs(speed - command.speed) > 1e-6) time_to_speed += config.dt;
      if (std::abs(steering - 0.3) > 1e-9) time_to_angle += config.dt;
    }
  };
  follow_for(5.0);
  EXPECT_NEAR(speed, 3.0, 1e-9);
  EXPECT_NEAR(steering, 0.3, 1e-12);
  // Trapezium of the acceleration: v / a + a / j, the last tenth of it being the dead-beat end of the profile.
  EXPECT_NEAR(time_to_speed, 3.0 / 1.5 + 1.5 / 3.0, 0.25);
  EXPECT_NEAR(time_to_angle, 0.3 / 0.5, 3.0 * config.dt);
  // Asked to stop it slows down as gently, and only then the brakes hold.
  command.speed = 0.0;
  follow_for(1.0);
  EXPECT_EQ(state.drive.mode, DriveState::Mode::kDrive);
  EXPECT_GT(speed, 1.0);
  follow_for(3.0);
  EXPECT_EQ(state.drive.mode, DriveState::Mode::kBrake);
}

TEST_F(DriveOfACar, AnAckermannCommandWithoutBoundsStopsByTheBrakesAtOnce) {
  const Simulator simulator = carWith(SimConfig{});
  VehicleState state = commanded(simulator, ackermann(3.0, 0.0));
  ASSERT_EQ(state.drive.mode, DriveState::Mode::kDrive);
  state.drive.command = ackermann(0.0, 0.0);
  bool timed_out = false;
  updateDrive(simulator.model(), simulator.config(), state, timed_out);
  EXPECT_EQ(state.drive.mode, DriveState::Mode::kBrake);
}

JointRequest request(const std::string& joint) {
  JointRequest result;
  result.joint = joint;
  return result;
}

/// What the wheel unit of a joint is told.
OwnMode modeOf(const Simulator& simulator, const std::string& joint) {
  for (const WheelUnit& wheel : simulator.model().drive.wheels)
    if (wheel.name == joint) return simulator.state().drive.own(wheel.unit);
  throw std::runtime_error("no wheel " + joint);
}

JointReading readingOf(const Simulator& simulator, const std::string& joint) {
  std::vector<JointReading> readings;
  simulator.jointReadings(readings);
  for (std::size_t i = 0; i < readings.size(); ++i)
    if (simulator.jointNames()[i] == joint) return readings[i];
  throw std::runtime_error("no joint " + joint);
}

TEST(JointCommands, WheelSpeedsDriveTheCarAndZeroHoldsIt) {
  Simulator simulator = make(car(), flatFloor(), SimConfig{});
  standAt(simulator, 0.0, 0.0, 0.0);
  std::vector<JointRequest> wheels = {request("rear_left_axle"), request("rear_right_axle")};
  const auto drive_wheels = [&](double omega, double seconds) {
    for (JointRequest& wheel : wheels) wheel.velocity = omega;
    for (int i = 0; i < static_cast<int>(seconds * 100.0); ++i) {
      ASSERT_TRUE(simulator.commandJoints(wheels).empty());
      run(simulator, 0.01);
    }
  };
  drive_wheels(10.0, 8.0);
  EXPECT_NEAR(readingOf(simulator, "rear_left_axle").velocity, 10.0, 0.1);
  // The loaded tyre rolls on less than its radius of 0.35 m, by its sag and slip.
  EXPECT_NEAR(simulator.rootVelocity_W().x(), 10.0 * 0.34, 0.15);
  drive_wheels(0.0, 3.0);
  EXPECT_EQ(modeOf(simulator, "rear_left_axle"), OwnMode::kBrake);
  EXPECT_LT(simulator.rootVelocity_W().norm(), 1e-4);
}

TEST(JointCommands, WheelTorqueAcceleratesByNewton) {
  // Coasting otherwise; two motors of 100 N m on wheels of 0.35 m push 1200 kg and the wheels' own inertia.
  Simulator simulator = make(car(), flatFloor(), SimConfig{});
  standAt(simulator, 0.0, 0.0, 0.0);
  std::vector<JointRequest> wheels = {request("rear_left_axle"), request("rear_right_axle")};
  for (JointRequest& wheel : wheels) wheel.effort = 100.0;
  const auto push_for = [&](double seconds) {
    for (int i = 0; i < static_cast<int>(std::lround(seconds / 0.01)); ++i) {
      simulator.command(coast());
      ASSERT_TRUE(simulator.commandJoints(wheels).empty());
      run(simulator, 0.01);
    }
  };
  push_for(1.0);  // the suspension settles
  const double before = simulator.rootVelocity_W().x();
  push_for(2.0);
  double spin = 0.0;
  for (const WheelUnit& wheel : simulator.model().drive.wheels)
    spin += 0.2 * 20.0 * (0.35 * 0.35 + 0.35 * 0.35) / (wheel.radius * wheel.radius);
  const double expected = 2.0 * 100.0 / 0.35 / (1200.0 + spin);
  EXPECT_NEAR((simulator.rootVelocity_W().x() - before) / 2.0, expected, 0.01 * expected);
}

TEST(JointCommands, SteeringFollowsItsPositionWhileTheCarIsDriven) {
  Simulator simulator = make(car(), flatFloor(), SimConfig{});
  standAt(simulator, 0.0, 0.0, 0.0);
  std::vector<JointRequest> steering = {request("front_left_steer"), request("front_right_steer")};
  steering[0].position = 0.1;
  steering[1].position = 5.0;  // its limit is 0.6
  for (int i = 0; i < 200; ++i) {
    simulator.command(twist(2.0));
    ASSERT_TRUE(simulator.commandJoints(steering).empty());
    run(simulator, 0.01);
  }
  EXPECT_NEAR(readingOf(simulator, "front_left_steer").position, 0.1, 1e-9);
  EXPECT_NEAR(readingOf(simulator, "front_right_steer").position, 0.6, 1e-9);
  EXPECT_GT(simulator.rootVelocity_W().norm(), 0.5);
}

TEST(JointCommands, ASteeringSpeedMovesAtThatSpeedAndHoldsWhenItGetsTooOld) {
  Simulator simulator = make(car(), flatFloor(), SimConfig{});
  standAt(simulator, 0.0, 0.0, 0.0);
  std::vector<JointRequest> steering = {request("front_left_steer")};
  steering[0].velocity = -0.2;
  ASSERT_TRUE(simulator.commandJoints(steering).empty());
  run(simulator, 0.4);
  EXPECT_NEAR(readingOf(simulator, "front_left_steer").velocity, -0.2, 1e-9);
  run(simulator, 0.3);  // 0.5 s is the timeout
  EXPECT_NEAR(readingOf(simulator, "front_left_steer").velocity, 0.0, 1e-9);
  EXPECT_EQ(simulator.events().command_timeouts, 1);
  EXPECT_NEAR(readingOf(simulator, "front_left_steer").position, -0.1, 0.01);
}

TEST(JointCommands, AnOwnCommandWinsOverTheVehiclesUntilItIsTooOld) {
  Simulator simulator = make(car(), flatFloor(), SimConfig{});
  standAt(simulator, 0.0, 0.0, 0.0);
  std::vector<JointRequest> wheel = {request("rear_left_axle")};
  wheel[0].velocity = 3.0;
  ASSERT_TRUE(simulator.commandJoints(wheel).empty());
  drive(simulator, twist(1.0), 0.4);
  EXPECT_EQ(modeOf(simulator, "rear_left_axle"), OwnMode::kVelocity);
  EXPECT_EQ(modeOf(simulator, "rear_right_axle"), OwnMode::kNone);
  drive(simulator, twist(1.0), 0.2);
  EXPECT_EQ(modeOf(simulator, "rear_left_axle"), OwnMode::kNone);
  EXPECT_EQ(simulator.events().command_timeouts, 1);
}

TEST(JointCommands, AllOrNothingWithEveryReason) {
  Simulator simulator = make(car(), flatFloor(), SimConfig{});
  standAt(simulator, 0.0, 0.0, 0.0);
  const std::uint64_t before = simulator.stateHash();
  JointRequest good = request("rear_left_axle"), none = request("rear_right_axle"), unknown = request("wheel_9");
  JointRequest passive = request("front_left_suspension"), angle = request("rear_right_axle");
  JointRequest force = request("front_left_steer"), infinite = request("front_right_steer");
  good.velocity = unknown.velocity = passive.position = angle.position = force.effort = 1.0;
  infinite.position = std::numeric_limits<double>::infinity();
  const auto refused = [&](const std::vector<JointRequest>& requests, const std::string& reason) {
    const std::string text = problemText(simulator.commandJoints(requests));
    EXPECT_NE(text.find(reason), std::string::npos) << text;
    EXPECT_EQ(simulator.stateHash(), before) << reason;
  };
  refused({good, unknown}, "joint 'wheel_9': there is no such joint; those that can be asked for something are: ");
  refused({good, passive}, "joint 'front_left_suspension': is suspension: it has no motor");
  refused({good, angle}, "its velocity or effort can be asked for, not its position");
  refused({good, force}, "its position or velocity can be asked for, not effort");
  refused({good, infinite}, "not finite");
  refused({good, none}, "no position, velocity or effort");
  refused({good, good}, "is named twice");
  refused({}, "names no joint");
  refused(std::vector<JointRequest>(20000, good), "names 20000 joints; the vehicle has ");
  EXPECT_EQ(simulator.events().rejected_commands, 9);
  EXPECT_TRUE(simulator.commandJoints({good}).empty());
}

TEST(Drive, ASteeringMotorTooWeakHoldsAndSaysSo) {
  // Parked, the front wheels scrub: turning them takes torque. A motor of 1 N m must not get far, a strong one must.
  for (const double effort : {1.0, 1e6}) {
    VehicleDescription vehicle = car();
    for (JointDescription& joint : vehicle.joints)
      if (joint.role == JointRole::kSteer) joint.effort_limit = effort;
    SimConfig config;
    config.integrator = IntegratorKind::kSemiImplicitEuler;
    Simulator simulator = make(vehicle, flatFloor(), config);
    standAt(simulator, 0.0, 0.0, 0.0);
    // The brakes stay on: only the steering is asked for.
    drive(simulator, ackermann(0.0, 0.4), 2.0);
    double largest = 0.0;
    for (const ProfileState& profile : simulator.state().profiles)
      largest = std::max(largest, std::abs(profile.position));
    if (effort < 10.0) {
      EXPECT_GT(simulator.events().effort_exceeded, 0);
      EXPECT_LT(largest, 0.2);
    } else {
      EXPECT_EQ(simulator.events().effort_exceeded, 0);
      EXPECT_GT(largest, 0.4);
    }
  }
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
