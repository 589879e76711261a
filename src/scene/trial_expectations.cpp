#include "trial_expectations.h"

#include <algorithm>
#include <cmath>

#include "ellipsoid_vehicle_sim/description/number_text.h"
#include "ellipsoid_vehicle_sim/description/vehicle_tree.h"
#include "ellipsoid_vehicle_sim/vehicle/skid_steer.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

constexpr double kSlowest = 0.05, kFastest = 2.0;  // [m/s]
constexpr double kSideways = 0.5;                  // acceleration in a trial's turn, at most [m/s^2]
constexpr double kReserve = 1.1;                   // torque and grip over what the slope asks for: curves, joints, slip

std::vector<ContactReport> contactsOf(const Simulator& simulator) {
  std::vector<ContactReport> contacts;
  simulator.contacts(contacts);
  return contacts;
}

std::vector<double> wheelLoads(const Simulator& simulator) {
  const std::vector<ContactReport> contacts = contactsOf(simulator);
  std::vector<double> loads;
  for (const WheelUnit& wheel : simulator.model().drive.wheels) {
    double load = 0.0;
    for (const ContactReport& contact : contacts)
      if (contact.ellipsoid == wheel.ellipsoid) load += contact.normal_force;
    loads.push_back(load);
  }
  return loads;
}

bool freeToSwivel(const WheelUnit& wheel) { return !wheel.driven && !wheel.braked; }

/// What carries weight and is no wheel: a ball that stands for a caster, a skid.
std::vector<ContactReport> skids(const Simulator& simulator) {
  std::vector<ContactReport> found;
  for (const ContactReport& contact : contactsOf(simulator))
    if (!simulator.ellipsoids()[contact.ellipsoid].ground_wheel) found.push_back(contact);
  return found;
}

/// Whether every wheel that cannot swivel has its axle on one line across the vehicle, and nothing else touches.
bool rollsCleanly(const Simulator& simulator) {
  if (!skids(simulator).empty()) return false;
  const VehicleModel& model = simulator.model();
  double low = 1e300, high = -1e300, radius = 0.0;
  for (const WheelUnit& wheel : model.drive.wheels) {
    if (freeToSwivel(wheel)) continue;
    low = std::min(low, wheel.p_FW.x());
    high = std::max(high, wheel.p_FW.x());
    radius = std::max(radius, wheel.radius);
  }
  return high - low < 0.05 * radius;
}

/// Surfaces differ in a world; the trial's flat one has a friction of its own or none.
double frictionOf(const Simulator& simulator) {
  return simulator.terrain().surface(0).mu_kinetic.value_or(simulator.config().mu_kinetic);
}

/// Yaw rate by the balance; `torque` is the largest share of its motor's torque that a wheel needs for it.
std::optional<double> skidYawRate(const Simulator& simulator, double speed, double yaw_rate, double& torque) {
  const VehicleModel& model = simulator.model();
  const std::vector<double> loads = wheelLoads(simulator);
  std::vector<SkiddingWheel> wheels;
  for (std::size_t i = 0; i < model.drive.wheels.size(); ++i) {
    const WheelUnit& unit = model.drive.wheels[i];
    if (freeToSwivel(unit)) continue;
    SkiddingWheel wheel;
    wheel.p = unit.p_FW.head<2>();
    wheel.rim_speed = speed - yaw_rate * wheel.p.y();
    wheel.free = !unit.driven;
    wheel.load = loads[i];
    wheel.mu = frictionOf(simulator);
    wheel.law = model.ellipsoids[unit.ellipsoid].law;
    wheels.push_back(wheel);
  }
  const Pose X_WR = simulator.rootPose();
  const Eigen::Quaterniond q_FR(Eigen::AngleAxisd(-model.description.forward_yaw, Vector3d::UnitZ()));
  for (const ContactReport& contact : skids(simulator)) {
    SkiddingWheel skid;
    skid.p = (q_FR * (X_WR.inverse() * contact.p_WC)).head<2>();
    skid.load = contact.normal_force;
    skid.mu = contact.friction_limit / std::max(contact.normal_force, 1e-9);
    skid.law = model.ellipsoids[contact.ellipsoid].law;
    wheels.push_back(skid);
  }
  const auto steady = steadySkid(wheels);
  if (!steady) return std::nullopt;
  torque = 0.0;
  for (std::size_t i = 0, k = 0; i < model.drive.wheels.size(); ++i) {
    const WheelUnit& unit = model.drive.wheels[i];
    if (freeToSwivel(unit)) continue;
    const double push = std::abs(forceOn(wheels[k++], *steady).x()) * unit.radius;
    if (unit.driven) torque = std::max(torque, push / unit.max_torque);
  }
  return steady->yaw_rate;
}

}  // namespace

Vector3d forwardOf(const VehicleModel& model) {
  const double yaw = model.description.forward_yaw;
  return {std::cos(yaw), std::sin(yaw), 0.0};
}

double trialSpeed(const VehicleModel& model, const SimConfig& config, double radii_per_second) {
  double speed = std::min(kFastest, config.max_speed);
  for (const WheelUnit& wheel : model.drive.wheels) {
    if (!wheel.driven) continue;
    speed = std::min(speed, radii_per_second * wheel.radius);
    for (const JointDescription& joint : model.description.joints)
      if (joint.name == wheel.name) speed = std::min(speed, 0.5 * joint.velocity_limit * wheel.radius);
  }
  return std::max(speed, kSlowest);
}

Footprint footprintOf(const VehicleModel& model) {
  const VehicleDescription& vehicle = model.description;
  const std::vector<Pose> X_RL = linkPosesAtZero(vehicle);
  const Eigen::Quaterniond q_FR(Eigen::AngleAxisd(-vehicle.forward_yaw, Vector3d::UnitZ()));
  Footprint f{0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1e9, 0.0};
  double bottom = 1e300, top = -1e300, radius = 1e300, body = 1e300;
  for (std::size_t l = 0; l < vehicle.links.size(); ++l)
    for (const EllipsoidDescription& e : vehicle.links[l].ellipsoids) {
      const Pose X_FE = Pose{Vector3d::Zero(), q_FR} * X_RL[l] * e.X_LE;
      const Vector3d reach = (X_FE.q.toRotationMatrix() * e.radii.asDiagonal()).rowwise().norm();
      f.front = std::max(f.front, X_FE.p.x() + reach.x());
      f.rear = std::max(f.rear, reach.x() - X_FE.p.x());
      f.half_width = std::max(f.half_width, std::abs(X_FE.p.y()) + reach.y());
      bottom = std::min(bottom, X_FE.p.z() - reach.z());
      const bool wheel = l > 0 && (vehicle.joints[l - 1].role == JointRole::kDrive ||
                                   vehicle.joints[l - 1].role == JointRole::kFreeWheel);
      if (!wheel) body = std::min(body, X_FE.p.z() - reach.z());
      top = std::max(top, X_FE.p.z() + reach.z());
    }
  for (const WheelUnit& wheel : model.drive.wheels) radius = std::min(radius, wheel.radius);
  f.height = std::max(0.05, top - bottom);
  const bool wheels = !model.drive.wheels.empty();
  f.step = wheels ? 0.2 * radius : 0.01;
  f.clearance = std::max(wheels ? 0.2 * radius : 0.01, body - bottom);
  // A vehicle that cannot warp lifts a wheel instead, and may be left with one that drives in the air.
  bool warps = false;
  for (const DynamicJoint& joint : model.dynamic_joints) warps = warps || joint.role == JointRole::kSuspension;
  f.warp = wheels ? (warps ? 0.5 : 0.2) * radius : 0.02;
  // Stiff, with wheels between its ends, some of which do not drive: those that do must not be lifted.
  bool idle = false, between = false;
  double front = -1e300, rear = 1e300;
  for (const WheelUnit& wheel : model.drive.wheels) {
    idle = idle || !wheel.driven;
    front = std::max(front, wheel.p_FW.x());
    rear = std::min(rear, wheel.p_FW.x());
  }
  for (const WheelUnit& wheel : model.drive.wheels) {
    const double along = (wheel.p_FW.x() - rear) / std::max(front - rear, 1e-9);
    between = between || (along > 0.1 && along < 0.9);
  }
  if (wheels && !warps && idle && between) {
    f.warp = 0.1 * radius;
    f.clearance = std::min(f.clearance, 0.2 * radius);
    f.hollow = 0.1 * radius;
  }
  return f;
}

TurnExpectation turnFor(const Simulator& simulator, double speed, double side) {
  const VehicleModel& model = simulator.model();
  TurnExpectation turn;
  turn.speed = speed;
  if (model.drive.layout == DriveLayout::kAckermann) {
    const double sharpest = side > 0.0 ? model.drive.max_curvature_left : model.drive.max_curvature_right;
    double curvature = std::min(0.5 * sharpest, 1.0 / std::max(model.drive.wheelbase, 0.1));
    if (!(curvature > 1e-4)) {
      turn.law = "steering does not turn that way";
      return turn;
    }
    turn.speed = std::min(speed, std::sqrt(kSideways / curvature));
    turn.commanded = turn.expected = side * turn.speed * curvature;
    turn.law = "Ackermann's law";
  } else if (model.drive.layout == DriveLayout::kDifferential) {
    double half_track = 0.05;
    for (const WheelUnit& wheel : model.drive.wheels)
      if (wheel.driven) half_track = std::max(half_track, std::abs(wheel.p_FW.y()));
    const double rate = std::min(0.5 * speed / half_track, kSideways / speed);
    turn.commanded = turn.expected = side * rate;
    turn.law = "the wheels' difference";
    if (!rollsCleanly(simulator)) {
      double torque = 0.0;
      const auto skidding = skidYawRate(simulator, speed, turn.commanded, torque);
      if (skidding && torque > 0.98) {
        turn.law = "skidding as this asks for " + numberText(std::round(100.0 * torque)) +
                   " % of the torque that a motor has: it cannot";
        return turn;
      }
      if (!skidding) {
        turn.law = "no balance of the friction under the wheels was found";
        return turn;
      }
      turn.expected = *skidding;
      turn.law = "the balance of skidding wheels";
    }
  } else {
    turn.law = "nothing steers it";
    return turn;
  }
  turn.possible = true;
  return turn;
}

ClimbExpectation climbFor(const Simulator& simulator, double slope) {
  const VehicleModel& model = simulator.model();
  const std::vector<double> loads = wheelLoads(simulator);
  double force = 0.0;
  for (std::size_t i = 0; i < model.drive.wheels.size(); ++i) {
    const WheelUnit& wheel = model.drive.wheels[i];
    if (!wheel.driven) continue;
    force += std::min(wheel.max_torque / wheel.radius, frictionOf(simulator) * loads[i] * std::cos(slope));
  }
  const double needed = model.mass * simulator.config().gravity * std::sin(slope);
  ClimbExpectation climb;
  climb.possible = force > kReserve * needed;
  const auto text = [](double value) { return numberText(std::round(value * 10.0) / 10.0); };
  climb.text = "its driven wheels push with " + text(force) + " N, the slope asks for " + text(needed) + " N";
  return climb;
}

}  // namespace ellipsoid_vehicle_sim
