#include "ellipsoid_vehicle_sim/vehicle/drive.h"

#include <algorithm>
#include <cmath>

#include "drive_model.h"
#include "ellipsoid_vehicle_sim/vehicle/profile.h"

namespace ellipsoid_vehicle_sim {
namespace {

// Below this a speed divides no yaw rate any more: the steering stays where it is [m/s].
constexpr double kSteerableSpeed = 1e-3;

// A speed with bounded jerk ends in its target but for rounding; this close it is there [m/s].
constexpr double kReachedSpeed = 1e-9;

double approach(double from, double to, double step) { return from + std::clamp(to - from, -step, step); }

// Moves d.speed towards `wanted` within the limits of the vehicle and of the command.
void rampSpeed(DriveState& d, double wanted, const SimConfig& config) {
  const bool slower = std::abs(wanted) < std::abs(d.speed) || d.speed * wanted < 0.0;
  double limit = slower ? config.max_deceleration : config.max_acceleration;
  const bool ackermann = d.command.kind == DriveCommand::Kind::kAckermann;
  if (ackermann && d.command.acceleration > 0.0) limit = std::min(limit, d.command.acceleration);
  const double before = d.speed;
  if (ackermann && d.command.jerk > 0.0) {
    // A speed with limits on its first and second derivative is a path with limits on speed and acceleration.
    const double change = profileChange(wanted - d.speed, d.acceleration, limit, d.command.jerk, config.dt);
    d.speed += config.dt * (d.acceleration + 0.5 * config.dt * change);
    d.acceleration += config.dt * change;
    if (std::abs(wanted - d.speed) < kReachedSpeed && std::abs(d.acceleration) < kReachedSpeed / config.dt) {
      d.speed = wanted;
      d.acceleration = 0.0;
    }
    return;
  }
  d.speed = approach(d.speed, wanted, limit * config.dt);
  d.acceleration = (d.speed - before) / config.dt;
}

// Curvature that the command asks for, within what the steering can do; keeps the virtual front wheel's angle.
double commandedCurvature(const DriveModel& drive, DriveState& d, double present, double dt) {
  const DriveCommand& command = d.command;
  double curvature = present;
  if (command.kind == DriveCommand::Kind::kAckermann) {
    const double wanted = std::clamp(command.steering_angle, -std::atan(drive.max_curvature_right * drive.wheelbase),
                                     std::atan(drive.max_curvature_left * drive.wheelbase));
    const bool bounded = command.steering_angle_velocity > 0.0;
    d.steering = bounded ? approach(d.steering, wanted, command.steering_angle_velocity * dt) : wanted;
    curvature = drive.wheelbase > 0.0 ? std::tan(d.steering) / drive.wheelbase : 0.0;
  } else {
    if (std::abs(command.speed) > kSteerableSpeed) curvature = command.yaw_rate / command.speed;
    d.steering = std::atan(present * drive.wheelbase);
  }
  return std::clamp(curvature, -drive.max_curvature_right, drive.max_curvature_left);
}

bool inForce(const JointCommand& command, const SimConfig& config) {
  return command.kind != JointCommand::Kind::kNone &&
         static_cast<double>(command.age) * config.dt <= config.command_timeout;
}

// Counts the tick, and forgets a command that has become too old; true in that tick.
bool ageCommand(JointCommand& command, const SimConfig& config) {
  if (command.kind == JointCommand::Kind::kNone) return false;
  if (inForce(command, config)) {
    ++command.age;
    return false;
  }
  command = JointCommand{};
  return true;
}

// What each wheel does by itself in the coming tick, and the speed it is asked for.
void applyWheelCommands(const DriveModel& drive, const SimConfig& config, DriveState& d, bool& timed_out) {
  for (std::size_t i = 0; i < d.wheel_command.size(); ++i) {
    JointCommand& command = d.wheel_command[i];
    timed_out = ageCommand(command, config) || timed_out;
    OwnMode mode = OwnMode::kNone;
    if (command.kind == JointCommand::Kind::kEffort) {
      mode = OwnMode::kEffort;
    } else if (command.kind == JointCommand::Kind::kVelocity) {
      // Like the vehicle: zero means brake, so that it stays where it stands.
      mode = command.value == 0.0 && command.effort == 0.0 ? OwnMode::kBrake : OwnMode::kVelocity;
      const double fastest = config.max_speed / drive.wheels[i].radius;
      d.wheel_speed[i] = std::clamp(command.value, -fastest, fastest);
      d.wheel_acceleration[i] = 0.0;
    }
    d.own_mode[i] = mode;
  }
}

// Ground speed of a wheel along its own rolling direction, for a vehicle whose reference point moves at `speed` with
// `yaw_rate`; `angle` is the wheel's steering.
double rollingSpeed(const WheelUnit& wheel, double reference_x, double speed, double yaw_rate, double angle) {
  const double vx = speed - yaw_rate * wheel.p_FW.y();
  const double vy = yaw_rate * (wheel.p_FW.x() - reference_x);
  return angle == 0.0 ? vx : vx * std::cos(angle) + vy * std::sin(angle);
}

double steerAngle(const VehicleModel& model, const VehicleState& state, int steer, double ahead) {
  if (steer < 0) return 0.0;
  const SteerUnit& unit = model.drive.steers[steer];
  return unit.sign * profileAt(state.profiles[unit.prescribed], ahead).position;
}

// What is asked of every wheel at the end of the tick, for the vehicle's speed and turn and the steering as they are then.
void aimWheels(const VehicleModel& model, const SimConfig& config, VehicleState& state) {
  const DriveModel& drive = model.drive;
  DriveState& d = state.drive;
  const bool ackermann = drive.layout == DriveLayout::kAckermann;
  const double turning = ackermann ? d.speed * actualCurvature(model, state, config.dt) : d.yaw_rate;
  for (std::size_t i = 0; i < drive.wheels.size(); ++i) {
    const WheelUnit& wheel = drive.wheels[i];
    const double angle = steerAngle(model, state, wheel.steer, config.dt);
    const double ground = rollingSpeed(wheel, drive.reference_x, d.speed, turning, angle);
    const double target = wheel.forward_sign * ground / wheel.radius;
    if (d.mode == DriveState::Mode::kDrive) {
      d.wheel_acceleration[i] = (target - d.wheel_speed[i]) / config.dt;
    } else {
      d.wheel_speed[i] = target;
      d.wheel_acceleration[i] = 0.0;
    }
  }
}

// With what gain the integrals of the wheels' servos grow; not at all while a torque is at its limit.
void updateIntegrals(const DriveModel& drive, VehicleState& state) {
  DriveState& d = state.drive;
  const auto errorOf = [&](std::size_t i) { return d.wheel_speed[i] - state.motion.qd[drive.wheels[i].joint]; };
  double mean_error = 0.0;
  int driven = 0;
  for (std::size_t i = 0; i < drive.wheels.size(); ++i) {
    const WheelUnit& wheel = drive.wheels[i];
    if (!wheel.driven || wheel.joint < 0 || d.own_mode[i] != OwnMode::kNone) continue;
    mean_error += wheel.forward_sign * errorOf(i);
    ++driven;
  }
  const bool shared = drive.layout == DriveLayout::kAckermann && drive.differential != Differential::kPerWheel;
  for (std::size_t i = 0; i < drive.wheels.size(); ++i) {
    const WheelUnit& wheel = drive.wheels[i];
    const OwnMode own = d.own_mode[i];
    if (!wheel.driven || wheel.joint < 0 || drive.integral_gain <= 0.0) continue;
    d.angle[i] = state.motion.q[wheel.joint];
    if (own != OwnMode::kVelocity && (own != OwnMode::kNone || d.mode != DriveState::Mode::kDrive)) {
      d.integral[i] = d.integral_gain[i] = 0.0;
      continue;
    }
    const bool alone = own == OwnMode::kVelocity || !shared;
    const double error = alone ? errorOf(i) : wheel.forward_sign * mean_error / driven;
    const double added = own == OwnMode::kVelocity ? d.wheel_command[i].effort : 0.0;
    const bool within = std::abs(drive.speed_gain * error + d.integral[i] + added) < wheel.max_torque;
    d.integral_gain[i] = within ? drive.integral_gain : 0.0;
  }
}

// The target of a joint on a path, where it has a command of its own; true in the tick in which that becomes too old.
bool applyProfileCommand(const PrescribedJoint& joint, const SimConfig& config, JointCommand& command,
                         ProfileState& profile) {
  const bool moving = command.kind == JointCommand::Kind::kVelocity;
  const bool timed_out = ageCommand(command, config);
  if (command.kind == JointCommand::Kind::kPosition) {
    profile.target = std::clamp(command.value, joint.lower, joint.upper);
  } else if (command.kind == JointCommand::Kind::kVelocity && command.value != 0.0) {
    profile.target = command.value > 0.0 ? joint.upper : joint.lower;
  } else if (moving) {
    // Stopped, or its command is too old: it holds where it can come to rest.
    const double stop = profile.position + profile.velocity * std::abs(profile.velocity) / (2.0 * joint.max_acceleration);
    profile.target = std::clamp(stop, joint.lower, joint.upper);
  }
  return timed_out;
}

double speedLimit(const PrescribedJoint& joint, const JointCommand& command) {
  const bool moving = command.kind == JointCommand::Kind::kVelocity && command.value != 0.0;
  return moving ? std::min(joint.max_speed, std::abs(command.value)) : joint.max_speed;
}

}  // namespace

double actualCurvature(const VehicleModel& model, const VehicleState& state, double ahead) {
  // Each steered wheel tells a curvature, tan(angle) = kappa x / (1 - kappa y); their mean is the vehicle's.
  double sum = 0.0;
  int count = 0;
  for (const SteerUnit& steer : model.drive.steers) {
    const double t = std::tan(steer.sign * profileAt(state.profiles[steer.prescribed], ahead).position);
    const double lever = steer.p_FS.x() - model.drive.reference_x;
    if (std::abs(lever) < 1e-9) continue;
    sum += t / (lever + t * steer.p_FS.y());
    ++count;
  }
  return count > 0 ? sum / count : 0.0;
}

bool effortExceeded(const PrescribedJoint& joint, const ProfileState& profile) {
  return std::abs(profile.effort) > joint.effort_limit &&
         profile.effort * (profile.target - profile.position) > 0.0;
}

void followLeaders(const VehicleModel& model, VehicleState& state) {
  for (std::size_t p = 0; p < model.prescribed_joints.size(); ++p) {
    const PrescribedJoint& joint = model.prescribed_joints[p];
    if (joint.leader < 0) continue;
    const ProfileState& leader = state.profiles[joint.leader];
    ProfileState& profile = state.profiles[p];
    profile.position = joint.multiplier * leader.position + joint.offset;
    profile.velocity = joint.multiplier * leader.velocity;
    profile.acceleration = joint.multiplier * leader.acceleration;
    profile.until = leader.until;
    profile.then = joint.multiplier * leader.then;
    profile.target = joint.multiplier * leader.target + joint.offset;
  }
}

void updateDrive(const VehicleModel& model, const SimConfig& config, VehicleState& state, bool& timed_out) {
  const DriveModel& drive = model.drive;
  DriveState& d = state.drive;
  timed_out = false;

  const double age = static_cast<double>(d.command_age) * config.dt;
  const bool fresh = d.has_command && age <= config.command_timeout;
  if (d.has_command && !fresh && static_cast<double>(d.command_age - 1) * config.dt <= config.command_timeout)
    timed_out = true;
  if (d.has_command) ++d.command_age;

  const DriveCommand& command = d.command;
  const double actual = actualCurvature(model, state);
  double speed = 0.0, yaw_rate = 0.0, curvature = actual;
  // A command that says how fast to slow down is followed to the end; then the brakes hold.
  const bool slowing = d.mode == DriveState::Mode::kDrive && command.kind == DriveCommand::Kind::kAckermann &&
                       (command.acceleration > 0.0 || command.jerk > 0.0) && d.speed != 0.0;
  if (!fresh) d.steering = std::atan(curvature * drive.wheelbase);
  d.mode = DriveState::Mode::kBrake;
  if (fresh && command.kind == DriveCommand::Kind::kCoast) {
    d.mode = DriveState::Mode::kCoast;
  } else if (fresh) {
    speed = std::clamp(command.speed, -config.max_speed, config.max_speed);
    if (drive.layout == DriveLayout::kAckermann) {
      curvature = commandedCurvature(drive, d, curvature, config.dt);
    } else {
      yaw_rate = command.kind == DriveCommand::Kind::kTwist ? command.yaw_rate : 0.0;
    }
    if (speed != 0.0 || yaw_rate != 0.0 || slowing) d.mode = DriveState::Mode::kDrive;
    if (drive.layout == DriveLayout::kAckermann)
      for (const SteerUnit& steer : drive.steers) {
        const double angle = std::clamp(ackermannAngle(curvature, steer.p_FS, drive.reference_x), steer.lower, steer.upper);
        state.profiles[steer.prescribed].target = steer.sign * angle;
      }
  }

  if (d.mode == DriveState::Mode::kDrive) {
    rampSpeed(d, speed, config);
    // Yaw rates follow with the acceleration that the outermost wheel is allowed.
    double half_track = 0.05;
    for (const WheelUnit& wheel : drive.wheels) half_track = std::max(half_track, std::abs(wheel.p_FW.y()));
    d.yaw_rate = approach(d.yaw_rate, yaw_rate, config.max_deceleration / half_track * config.dt);
  } else {
    // Where the servo takes over again: at the speed the wheels have.
    double sum = 0.0;
    int count = 0;
    for (const WheelUnit& wheel : drive.wheels) {
      if (!wheel.driven) continue;
      const double omega = wheel.joint >= 0 ? state.motion.qd[wheel.joint] : state.treads[wheel.tread].speed;
      sum += wheel.forward_sign * omega * wheel.radius;
      ++count;
    }
    d.speed = count > 0 ? sum / count : 0.0;
    d.yaw_rate = 0.0;
    d.acceleration = 0.0;
  }

  for (std::size_t p = 0; p < model.prescribed_joints.size(); ++p) {
    const PrescribedJoint& joint = model.prescribed_joints[p];
    ProfileState& profile = state.profiles[p];
    if (joint.leader >= 0) continue;
    timed_out = applyProfileCommand(joint, config, d.profile_command[p], profile) || timed_out;
    if (effortExceeded(joint, profile)) {
      setProfile(std::clamp(-profile.velocity / config.dt, -joint.max_acceleration, joint.max_acceleration), profile);
    } else {
      planProfile(joint, speedLimit(joint, d.profile_command[p]), config.dt, profile);
    }
  }

  followLeaders(model, state);
  aimWheels(model, config, state);
  applyWheelCommands(drive, config, d, timed_out);
  updateIntegrals(drive, state);

  // Treads have no mass: a driven one runs at the speed asked for, a braked one slows down within the limit.
  for (std::size_t i = 0; i < drive.wheels.size(); ++i) {
    const WheelUnit& wheel = drive.wheels[i];
    if (wheel.tread < 0) continue;
    TreadState& tread = state.treads[wheel.tread];
    tread.mode = TreadState::Mode::kFree;
    tread.acceleration = 0.0;
    double target = 0.0;
    const OwnMode own = d.own(static_cast<int>(i));
    if (own == OwnMode::kVelocity || (own == OwnMode::kNone && d.mode == DriveState::Mode::kDrive && wheel.driven)) {
      target = d.wheel_speed[i] + config.dt * d.wheel_acceleration[i];
    } else if ((own == OwnMode::kNone && d.mode != DriveState::Mode::kBrake) || !wheel.braked) {
      continue;
    }
    tread.mode = TreadState::Mode::kTurning;
    const double step = config.max_deceleration / wheel.radius * config.dt;
    tread.acceleration = (approach(tread.speed, target, step) - tread.speed) / config.dt;
  }
}

namespace {

// Whether a wheel follows what the vehicle as a whole is asked for.
bool follows(const WheelUnit& wheel, const DriveState& d) {
  return d.mode == DriveState::Mode::kDrive && wheel.driven && wheel.joint >= 0 && d.own(wheel.unit) == OwnMode::kNone;
}

// The wheels' servos some time after the moment of the state: what is asked, and what they have been behind since.
class Servos {
 public:
  Servos(const DriveModel& drive, const DriveState& d, double elapsed, const std::vector<double>& q)
      : d_(d), elapsed_(elapsed), q_(q) {
    shared = drive.layout == DriveLayout::kAckermann && drive.differential != Differential::kPerWheel;
    if (!shared) return;
    int driven = 0;
    for (std::size_t i = 0; i < drive.wheels.size(); ++i) {
      const WheelUnit& wheel = drive.wheels[i];
      if (!follows(wheel, d)) continue;
      mean_behind_ += wheel.forward_sign * behind(i, wheel);
      ++driven;
    }
    mean_behind_ /= std::max(driven, 1);
  }

  double asked(std::size_t i) const { return d_.wheel_speed[i] + elapsed_ * d_.wheel_acceleration[i]; }
  double integral(std::size_t i, const WheelUnit& wheel) const {
    if (d_.integral_gain[i] == 0.0) return d_.integral[i];
    const bool together = shared && follows(wheel, d_);
    return d_.integral[i] + d_.integral_gain[i] * (together ? wheel.forward_sign * mean_behind_ : behind(i, wheel));
  }

  bool shared = false;  // an open differential: one servo for all driven wheels

 private:
  // [rad]
  double behind(std::size_t i, const WheelUnit& wheel) const {
    const double way = elapsed_ * (d_.wheel_speed[i] + 0.5 * elapsed_ * d_.wheel_acceleration[i]);
    return way - (q_[wheel.joint] - d_.angle[i]);
  }

  const DriveState& d_;
  double elapsed_;
  const std::vector<double>& q_;
  double mean_behind_ = 0.0;
};

}  // namespace

void carryDrive(const VehicleModel& model, double dt, const std::vector<double>& q, bool ends_tick, DriveState& d) {
  const std::vector<WheelUnit>& wheels = model.drive.wheels;
  const Servos servos(model.drive, d, dt, q);
  for (std::size_t i = 0; i < wheels.size(); ++i) d.integral[i] = servos.integral(i, wheels[i]);
  for (std::size_t i = 0; i < wheels.size(); ++i) {
    d.wheel_speed[i] += dt * d.wheel_acceleration[i];
    if (wheels[i].joint >= 0) d.angle[i] = q[wheels[i].joint];
    if (ends_tick) d.wheel_acceleration[i] = d.integral_gain[i] = 0.0;
  }
}

void driveTorques(const VehicleModel& model, const SimConfig& config, const DriveState& drive_state, double elapsed,
                  const std::vector<double>& q, const std::vector<double>& qd, std::vector<double>& torque) {
  const DriveModel& drive = model.drive;
  std::fill(torque.begin(), torque.end(), 0.0);
  const bool body = drive_state.mode == DriveState::Mode::kDrive;
  const auto is_own = [](OwnMode mode) { return mode != OwnMode::kNone; };
  if (!body && std::none_of(drive_state.own_mode.begin(), drive_state.own_mode.end(), is_own)) return;
  const Servos servos(drive, drive_state, elapsed, q);
  const bool shared = servos.shared;
  double mean_error = 0.0, mean_speed = 0.0;
  int driven = 0;
  if (shared) {
    for (std::size_t i = 0; i < drive.wheels.size(); ++i) {
      const WheelUnit& wheel = drive.wheels[i];
      if (!follows(wheel, drive_state)) continue;
      mean_error += wheel.forward_sign * (servos.asked(i) - qd[wheel.joint]);
      mean_speed += wheel.forward_sign * qd[wheel.joint];
      ++driven;
    }
    mean_error /= std::max(driven, 1);
    mean_speed /= std::max(driven, 1);
  }

  double power = 0.0;
  for (std::size_t i = 0; i < drive.wheels.size(); ++i) {
    const WheelUnit& wheel = drive.wheels[i];
    const OwnMode own = drive_state.own(wheel.unit);
    if (follows(wheel, drive_state)) {
      // An open differential gives every wheel the same torque, whatever its speed.
      const double error = shared ? wheel.forward_sign * mean_error : servos.asked(i) - qd[wheel.joint];
      torque[i] = drive.speed_gain * error + servos.integral(i, wheel);
    } else if (own == OwnMode::kVelocity && wheel.joint >= 0) {
      torque[i] = drive.speed_gain * (servos.asked(i) - qd[wheel.joint]) + servos.integral(i, wheel) +
                  drive_state.wheel_command[i].effort;
    } else if (own == OwnMode::kEffort) {
      torque[i] = drive_state.wheel_command[i].value;
    } else {
      continue;
    }
    torque[i] = std::clamp(torque[i], -wheel.max_torque, wheel.max_torque);
    power += std::abs(torque[i] * qd[wheel.joint]);
  }
  if (config.max_power && power > *config.max_power)
    for (double& t : torque) t *= *config.max_power / power;
  if (shared && drive.differential == Differential::kLocked)
    for (std::size_t i = 0; i < drive.wheels.size(); ++i) {
      const WheelUnit& wheel = drive.wheels[i];
      if (follows(wheel, drive_state))
        torque[i] += drive.lock_gain * (wheel.forward_sign * mean_speed - qd[wheel.joint]);
    }
}

double brakeTorque(const WheelUnit& wheel, const DriveState& drive) {
  const OwnMode own = drive.own(wheel.unit);
  const bool brake = own == OwnMode::kBrake || (own == OwnMode::kNone && drive.mode == DriveState::Mode::kBrake);
  return brake && wheel.braked ? wheel.brake_torque : 0.0;
}

}  // namespace ellipsoid_vehicle_sim
