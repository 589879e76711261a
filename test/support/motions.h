#pragma once

#include <cmath>
#include <stdexcept>
#include <vector>

#include "support/scenes.h"

/// Starting and watching motions whose closed form a test knows.
namespace ellipsoid_vehicle_sim::test {

inline void placeAt(Simulator& simulator, const Eigen::Vector3d& p, const Eigen::Vector3d& v,
                    const Eigen::Vector3d& w = Eigen::Vector3d::Zero(),
                    const Eigen::Quaterniond& q = Eigen::Quaterniond::Identity()) {
  const Problems problems = simulator.place({p, q}, v, w);
  if (!problems.empty()) throw std::runtime_error(problemText(problems));
}

inline void standAt(Simulator& simulator, double x, double y, double yaw) {
  const Problems problems = simulator.setDown(x, y, yaw);
  if (!problems.empty()) throw std::runtime_error(problemText(problems));
}

/// Steps with the command repeated every tick.
inline void drive(Simulator& simulator, const DriveCommand& command, double seconds) {
  const auto steps = static_cast<std::int64_t>(std::llround(seconds / simulator.config().dt));
  for (std::int64_t i = 0; i < steps; ++i) {
    simulator.command(command);
    if (simulator.step() != StepStatus::kOk) throw std::runtime_error("the simulation diverged");
  }
}

inline DriveCommand twist(double speed, double yaw_rate = 0.0) {
  DriveCommand command;
  command.speed = speed;
  command.yaw_rate = yaw_rate;
  return command;
}

inline DriveCommand ackermann(double speed, double steering_angle) {
  DriveCommand command;
  command.kind = DriveCommand::Kind::kAckermann;
  command.speed = speed;
  command.steering_angle = steering_angle;
  return command;
}

inline DriveCommand coast() {
  DriveCommand command;
  command.kind = DriveCommand::Kind::kCoast;
  return command;
}

/// Sum over the contacts now.
struct GroundForce {
  double normal = 0.0;
  Eigen::Vector3d friction_W = Eigen::Vector3d::Zero();
  int contacts = 0, sliding = 0;
};

inline GroundForce groundForce(const Simulator& simulator) {
  static thread_local std::vector<ContactReport> contacts;
  simulator.contacts(contacts);
  GroundForce sum;
  for (const ContactReport& contact : contacts) {
    sum.normal += contact.normal_force;
    sum.friction_W += contact.friction_W;
    sum.sliding += contact.sliding ? 1 : 0;
    ++sum.contacts;
  }
  return sum;
}

/// A contact without friction: stiffness and damping as given, no gravity unless set.
inline SimConfig springConfig(IntegratorKind integrator, double dt, double stiffness, double damping) {
  SimConfig config;
  config.integrator = integrator;
  config.dt = dt;
  config.gravity = 0.0;
  config.stiffness = stiffness;
  config.damping = damping;
  config.body_friction = FrictionMode::kViscous;
  config.viscous_friction = 0.0;
  config.mu_static = config.mu_kinetic = 0.0;
  config.allow_unstable = true;  // explicit Euler holds no undamped spring at all
  return config;
}

struct Bounce {
  double contact_time = 0.0, exit_speed = 0.0, depth = 0.0;
};

/// Lets a body that falls on flat ground touch it and come off again; times are resolved to a step.
inline Bounce bounce(Simulator& simulator, double longest = 1.0) {
  Bounce result;
  const auto most = static_cast<std::int64_t>(longest / simulator.config().dt);
  std::int64_t pushed = 0;
  bool touched = false;
  for (std::int64_t i = 0; i < most; ++i) {
    if (simulator.step() != StepStatus::kOk) throw std::runtime_error("the simulation diverged");
    const bool pushing = groundForce(simulator).normal > 0.0;
    if (touched && !pushing) break;
    touched = touched || pushing;
    pushed += pushing ? 1 : 0;
    result.depth = std::max(result.depth, simulator.largestPenetration());
  }
  result.contact_time = static_cast<double>(pushed) * simulator.config().dt;
  result.exit_speed = simulator.rootVelocity_W().z();
  return result;
}

/// Two masses on one spring in free flight: a body and a wheel on a suspension joint without damper. Without gravity
/// the joint starts compressed by the body's weight, so it swings for ever at omega^2 = k / m, m the reduced mass.
inline VehicleDescription springPair(double reduced_mass, double stiffness) {
  VehicleDescription v;
  v.name = "spring pair";
  v.root = "body";
  v.layout = DriveLayout::kDifferential;
  const Eigen::Matrix3d unit = Eigen::Matrix3d::Identity();
  v.links = {link("body", 4.0 * reduced_mass, Eigen::Vector3d::Zero(), 100.0 * unit),
             link("upright", 0.0, Eigen::Vector3d::Zero(), Eigen::Matrix3d::Zero()),
             link("wheel", 4.0 / 3.0 * reduced_mass, Eigen::Vector3d::Zero(), 10.0 * unit)};
  v.links[2].ellipsoids = {ellipsoid("wheel", Eigen::Vector3d::Zero(), {0.35, 0.12, 0.35})};
  JointDescription spring;
  spring.name = "spring";
  spring.type = JointType::kPrismatic;
  spring.role = JointRole::kSuspension;
  spring.parent = "body";
  spring.child = "upright";
  spring.X_PJ.p = {0.0, 0.0, -0.5};
  spring.axis = Eigen::Vector3d::UnitZ();
  spring.spring_stiffness = stiffness;
  JointDescription axle;
  axle.name = "axle";
  axle.type = JointType::kContinuous;
  axle.role = JointRole::kFreeWheel;
  axle.parent = "upright";
  axle.child = "wheel";
  axle.axis = Eigen::Vector3d::UnitY();
  v.joints = {spring, axle};
  return v;
}

}  // namespace ellipsoid_vehicle_sim::test
