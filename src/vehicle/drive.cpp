#include "ellipsoid_vehicle_sim/vehicle/drive.h"

#include <algorithm>
#include <cmath>

#include "drive_model.h"

namespace ellipsoid_vehicle_sim {
namespace {

// Below this a speed divides no yaw rate any more: the steering stays where it is [m/s].
constexpr double kSteerableSpeed = 1e-3;

double approach(double from, double to, double step) { return from + std::clamp(to - from, -step, step); }

// Speeding up is bounded by one limit, slowing down by the other.
double limited(double now, double wanted, const SimConfig& config) {
  const bool slower = std::abs(wanted) < std::abs(now) || now * wanted < 0.0;
  return approach(now, wanted, (slower ? config.max_deceleration : config.max_acceleration) * config.dt);
}

// Curvature that the command asks for, within what the steering can do.
double commandedCurvature(const DriveModel& drive, const DriveCommand& command, double present) {
  double curvature = present;
  if (command.kind == DriveCommand::Kind::kAckermann) {
    curvature = drive.wheelbase > 0.0 ? std::tan(std::clamp(command.steering_angle, -1.5, 1.5)) / drive.wheelbase : 0.0;
  } else if (std::abs(command.speed) > kSteerableSpeed) {
    curvature = command.yaw_rate / command.speed;
  }
  return std::clamp(curvature, -drive.max_curvature_right, drive.max_curvature_left);
}

// Ground speed of a wheel along its own rolling direction, for a vehicle whose reference point moves at `speed` with
// `yaw_rate`; `angle` is the wheel's steering.
double rollingSpeed(const WheelUnit& wheel, double reference_x, double speed, double yaw_rate, double angle) {
  const double vx = speed - yaw_rate * wheel.p_RW.y();
  const double vy = yaw_rate * (wheel.p_RW.x() - reference_x);
  return vx * std::cos(angle) + vy * std::sin(angle);
}

double steerAngle(const VehicleModel& model, const VehicleState& state, int steer) {
  if (steer < 0) return 0.0;
  const SteerUnit& unit = model.drive.steers[steer];
  return unit.sign * state.profiles[unit.prescribed].position;
}

}  // namespace

double actualCurvature(const VehicleModel& model, const VehicleState& state) {
  // Each steered wheel tells a curvature, tan(angle) = kappa x / (1 - kappa y); their mean is the vehicle's.
  double sum = 0.0;
  int count = 0;
  for (const SteerUnit& steer : model.drive.steers) {
    const double t = std::tan(steer.sign * state.profiles[steer.prescribed].position);
    const double ahead = steer.p_RS.x() - model.drive.reference_x;
    if (std::abs(ahead) < 1e-9) continue;
    sum += t / (ahead + t * steer.p_RS.y());
    ++count;
  }
  return count > 0 ? sum / count : 0.0;
}

bool effortExceeded(const PrescribedJoint& joint, const ProfileState& profile) {
  return std::abs(profile.effort) > joint.effort_limit &&
         profile.effort * (profile.target - profile.position) > 0.0;
}

double profileAcceleration(const PrescribedJoint& joint, const ProfileState& profile, double dt) {
  const double A = joint.max_acceleration;
  const double distance = profile.target - profile.position;
  // Speed at the end of the tick from which the joint can still stop at the target: what is left after this tick, with one
  // more tick at that speed, is the braking distance v^2 / (2 A). Solved for v; near the target it is dead-beat.
  const double left = distance - 0.5 * profile.velocity * dt;
  const double v = std::copysign(A * (std::sqrt(dt * dt + 2.0 * std::abs(left) / A) - dt), left);
  const double wanted = std::clamp(v, -joint.max_speed, joint.max_speed);
  return std::clamp((wanted - profile.velocity) / dt, -A, A);
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
  double speed = 0.0, yaw_rate = 0.0, curvature = actualCurvature(model, state);
  d.mode = DriveState::Mode::kBrake;
  if (fresh && command.kind == DriveCommand::Kind::kCoast) {
    d.mode = DriveState::Mode::kCoast;
  } else if (fresh) {
    speed = std::clamp(command.speed, -config.max_speed, config.max_speed);
    if (drive.layout == DriveLayout::kAckermann) {
      curvature = commandedCurvature(drive, command, curvature);
    } else {
      yaw_rate = command.kind == DriveCommand::Kind::kTwist ? command.yaw_rate : 0.0;
    }
    if (speed != 0.0 || yaw_rate != 0.0) d.mode = DriveState::Mode::kDrive;
    if (drive.layout == DriveLayout::kAckermann)
      for (const SteerUnit& steer : drive.steers) {
        const double angle = std::clamp(ackermannAngle(curvature, steer.p_RS, drive.reference_x), steer.lower, steer.upper);
        state.profiles[steer.prescribed].target = steer.sign * angle;
      }
  }

  if (d.mode == DriveState::Mode::kDrive) {
    d.speed = limited(d.speed, speed, config);
    // Yaw rates follow with the acceleration that the outermost wheel is allowed.
    double half_track = 0.05;
    for (const WheelUnit& wheel : drive.wheels) half_track = std::max(half_track, std::abs(wheel.p_RW.y()));
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
    std::fill(d.integral.begin(), d.integral.end(), 0.0);
  }

  const double turning = drive.layout == DriveLayout::kAckermann ? d.speed * actualCurvature(model, state) : d.yaw_rate;
  for (std::size_t i = 0; i < drive.wheels.size(); ++i) {
    const WheelUnit& wheel = drive.wheels[i];
    const double angle = steerAngle(model, state, wheel.steer);
    const double ground = rollingSpeed(wheel, drive.reference_x, d.speed, turning, angle);
    d.wheel_speed[i] = wheel.forward_sign * ground / wheel.radius;
  }

  // Integrals of the wheels' servos; none while a torque is at its limit.
  if (d.mode == DriveState::Mode::kDrive && drive.integral_gain > 0.0) {
    double mean_error = 0.0;
    int driven = 0;
    for (std::size_t i = 0; i < drive.wheels.size(); ++i) {
      const WheelUnit& wheel = drive.wheels[i];
      if (!wheel.driven || wheel.joint < 0) continue;
      mean_error += wheel.forward_sign * (d.wheel_speed[i] - state.motion.qd[wheel.joint]);
      ++driven;
    }
    const bool shared = drive.layout == DriveLayout::kAckermann && drive.differential != Differential::kPerWheel;
    for (std::size_t i = 0; i < drive.wheels.size(); ++i) {
      const WheelUnit& wheel = drive.wheels[i];
      if (!wheel.driven || wheel.joint < 0) continue;
      const double error = shared ? wheel.forward_sign * mean_error / driven : d.wheel_speed[i] - state.motion.qd[wheel.joint];
      if (std::abs(drive.speed_gain * error + d.integral[i]) < wheel.max_torque)
        d.integral[i] += drive.integral_gain * error * config.dt;
    }
  }

  for (std::size_t p = 0; p < model.prescribed_joints.size(); ++p) {
    const PrescribedJoint& joint = model.prescribed_joints[p];
    ProfileState& profile = state.profiles[p];
    profile.acceleration = effortExceeded(joint, profile)
                               ? std::clamp(-profile.velocity / config.dt, -joint.max_acceleration, joint.max_acceleration)
                               : profileAcceleration(joint, profile, config.dt);
  }

  // Treads have no mass: a driven one runs at the speed asked for, a braked one slows down within the limit.
  for (std::size_t i = 0; i < drive.wheels.size(); ++i) {
    const WheelUnit& wheel = drive.wheels[i];
    if (wheel.tread < 0) continue;
    TreadState& tread = state.treads[wheel.tread];
    tread.mode = TreadState::Mode::kFree;
    tread.acceleration = 0.0;
    double target = 0.0;
    if (d.mode == DriveState::Mode::kDrive && wheel.driven) {
      target = d.wheel_speed[i];
    } else if (d.mode != DriveState::Mode::kBrake || !wheel.braked) {
      continue;
    }
    tread.mode = TreadState::Mode::kTurning;
    const double step = config.max_deceleration / wheel.radius * config.dt;
    tread.acceleration = (approach(tread.speed, target, step) - tread.speed) / config.dt;
  }
}

void driveTorques(const VehicleModel& model, const SimConfig& config, const DriveState& drive_state,
                  const std::vector<double>& qd, std::vector<double>& torque) {
  const DriveModel& drive = model.drive;
  std::fill(torque.begin(), torque.end(), 0.0);
  if (drive_state.mode != DriveState::Mode::kDrive) return;

  const bool shared = drive.layout == DriveLayout::kAckermann && drive.differential != Differential::kPerWheel;
  double mean_error = 0.0, mean_speed = 0.0;
  int driven = 0;
  if (shared) {
    for (std::size_t i = 0; i < drive.wheels.size(); ++i) {
      const WheelUnit& wheel = drive.wheels[i];
      if (!wheel.driven || wheel.joint < 0) continue;
      mean_error += wheel.forward_sign * (drive_state.wheel_speed[i] - qd[wheel.joint]);
      mean_speed += wheel.forward_sign * qd[wheel.joint];
      ++driven;
    }
    if (driven == 0) return;
    mean_error /= driven;
    mean_speed /= driven;
  }

  double power = 0.0;
  for (std::size_t i = 0; i < drive.wheels.size(); ++i) {
    const WheelUnit& wheel = drive.wheels[i];
    if (!wheel.driven || wheel.joint < 0) continue;
    // An open differential gives every wheel the same torque, whatever its speed.
    const double error = shared ? wheel.forward_sign * mean_error : drive_state.wheel_speed[i] - qd[wheel.joint];
    torque[i] = std::clamp(drive.speed_gain * error + drive_state.integral[i], -wheel.max_torque, wheel.max_torque);
    power += std::abs(torque[i] * qd[wheel.joint]);
  }
  if (config.max_power && power > *config.max_power)
    for (double& t : torque) t *= *config.max_power / power;
  if (shared && drive.differential == Differential::kLocked)
    for (std::size_t i = 0; i < drive.wheels.size(); ++i) {
      const WheelUnit& wheel = drive.wheels[i];
      if (wheel.driven && wheel.joint >= 0)
        torque[i] += drive.lock_gain * (wheel.forward_sign * mean_speed - qd[wheel.joint]);
    }
}

double brakeTorque(const WheelUnit& wheel, const DriveState& drive) {
  return drive.mode == DriveState::Mode::kBrake && wheel.braked ? wheel.brake_torque : 0.0;
}

}  // namespace ellipsoid_vehicle_sim
