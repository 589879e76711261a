#include "set_down.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "contact_laws.h"
#include "ellipsoid_vehicle_sim/dynamics/integrator.h"
#include "ellipsoid_vehicle_sim/vehicle/tick_stepper.h"
#include "ellipsoid_vehicle_sim/vehicle/drive.h"
#include "settling_damper.h"
#include "wheel_loads.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

// Ground steeper than this is no place to stand [rad].
constexpr double kSteepest = 50.0 * M_PI / 180.0;
// At rest when no part moves faster than this, in metres and radians per second.
constexpr double kAtRest = 1e-6;
constexpr int kQuietSteps = 100;
constexpr double kLongestSettling = 12.0;  // [s]
// Where the stiffest contact asks for smaller steps than this, explicit ones would never come to an end [s]. Implicit ones
// then; each costs as much as ten, and bears any length.
constexpr double kSmallestSettlingStep = 3e-4;
constexpr double kImplicitStep = 4e-3;
constexpr int kQuietImplicitSteps = 25;

// Height of the topmost ground that faces up below (x, y).
std::optional<double> groundHeight(const Terrain& terrain, double x, double y) {
  for (const HeightHit& hit : terrain.heights(x, y))
    if (hit.faces_up) return hit.z;
  return std::nullopt;
}

std::string at(double x, double y) {
  char text[80];
  std::snprintf(text, sizeof text, "set-down at (%.4g, %.4g)", x, y);
  return text;
}

// Places that carry the vehicle, from the root link, with x along the root's: its wheels, or where there are fewer than
// three, what hangs lowest.
std::vector<Vector3d> supportsOf(const VehicleModel& model) {
  std::vector<Vector3d> places;
  const Eigen::Quaterniond q_RF(Eigen::AngleAxisd(model.description.forward_yaw, Vector3d::UnitZ()));
  for (const WheelUnit& wheel : model.drive.wheels) places.push_back(q_RF * wheel.p_FW);
  if (places.size() >= 3) return places;
  const RestGeometry rest = restGeometry(model);
  double lowest = std::numeric_limits<double>::infinity(), size = 0.0;
  std::vector<std::pair<double, Vector3d>> bottoms;
  for (const ModelEllipsoid& e : model.ellipsoids) {
    const Pose X_RE = rest.X_RB[e.body] * e.X_BE;
    const Eigen::Matrix3d R = X_RE.q.toRotationMatrix();
    const double reach = (R * e.radii.asDiagonal()).row(2).norm();
    bottoms.emplace_back(X_RE.p.z() - reach, X_RE.p);
    lowest = std::min(lowest, X_RE.p.z() - reach);
    size = std::max(size, e.radii.maxCoeff());
  }
  for (const auto& [bottom, p] : bottoms)
    if (bottom < lowest + 0.2 * size) places.push_back(p);
  return places;
}

// Mean slope of the ground under the supports, as the up direction; straight up where it cannot be told.
Vector3d groundNormal(const std::vector<Vector3d>& supports, const Terrain& terrain, double x, double y, double yaw,
                      double z) {
  std::vector<Vector3d> ground;
  for (const Vector3d& p_R : supports) {
    const Vector3d p = Eigen::AngleAxisd(yaw, Vector3d::UnitZ()) * p_R;
    if (const auto height = groundHeight(terrain, x + p.x(), y + p.y()))
      ground.emplace_back(p.x(), p.y(), *height - z);
  }
  // One place alone, or all on a line: the slope of the triangle itself says the rest.
  constexpr double kApart = 1e-3;
  Vector3d low = Vector3d::Zero(), high = low;
  for (const Vector3d& p : ground) low = low.cwiseMin(p), high = high.cwiseMax(p);
  if (ground.size() < 3 || (high - low).head<2>().minCoeff() < kApart) {
    for (const HeightHit& hit : terrain.heights(x, y)) {
      if (!hit.faces_up) continue;
      const Vector3d n = terrain.triangle(hit.triangle).nhat_W;
      return std::acos(std::clamp(n.z(), -1.0, 1.0)) < kSteepest ? n : Vector3d::UnitZ();
    }
    return Vector3d::UnitZ();
  }
  Eigen::MatrixXd A(ground.size(), 3);
  Eigen::VectorXd b(ground.size());
  for (std::size_t i = 0; i < ground.size(); ++i) {
    A.row(i) << 1.0, ground[i].x(), ground[i].y();
    b[i] = ground[i].z();
  }
  const Vector3d fit = A.completeOrthogonalDecomposition().solve(b);
  const Vector3d n = Vector3d(-fit[1], -fit[2], 1.0).normalized();
  return std::acos(std::clamp(n.z(), -1.0, 1.0)) < kSteepest ? n : Vector3d::UnitZ();
}

double largestSpeed(const Motion& x) {
  double speed = std::max(x.v_WB.norm(), x.w_WB.norm());
  for (const double qd : x.qd) speed = std::max(speed, std::abs(qd));
  return speed;
}

// A step that every contact bears while settling, whatever the run's own step.
double settlingStep(const VehicleModel& model) {
  double dt = kDefaultTick;
  for (const ModelEllipsoid& e : model.ellipsoids) {
    const auto limit = [&](double k, double c, double m) {
      if (!(m > 0.0)) return;
      const double rate = std::max(std::sqrt(k / m), c / m);
      if (rate > 0.0) dt = std::min(dt, 0.4 / rate);
    };
    limit(e.law.stiffness, e.law.damping, e.normal_mass);
    limit(e.law.tangential_stiffness, e.law.tangential_damping, e.tangential_mass);
  }
  return dt;
}

// Raises the vehicle until nothing overlaps the ground and no centre is below it. `risen`: how far; `what`: the ellipsoid
// that asked for most of it, and what it met.
bool raiseClear(const VehicleModel& model, const Terrain& terrain, const SimConfig& config, VehicleDynamics& dynamics,
                VehicleState& state, double& risen, std::string& what) {
  ContactOptions options{config.contact_rule, ContactsPerEllipsoid::kOne, false, false};
  std::vector<ContactFinder> finders(model.ellipsoids.size());
  MotionRate k = dynamics.makeRate();
  const ContactMemory unknown;
  risen = 0.0;
  double most = 0.0;
  for (int attempt = 0; attempt < 200; ++attempt) {
    dynamics.evaluate(state, k);
    double lift = 0.0;
    for (std::size_t i = 0; i < model.ellipsoids.size(); ++i) {
      const ModelEllipsoid& e = model.ellipsoids[i];
      const PosedEllipsoid& posed = dynamics.posedEllipsoids()[i];
      double asked = 0.0;
      int triangle = -1;
      for (const HeightHit& hit : terrain.heights(posed.p_WE.x(), posed.p_WE.y())) {
        if (!hit.faces_up) continue;
        asked = std::max(asked, hit.z + 1e-3 * e.radii.minCoeff() - posed.p_WE.z());
        triangle = hit.triangle;
        break;
      }
      const EllipsoidContacts contacts = findContacts(posed, unknown, terrain, options, finders[i]);
      if (contacts.count > 0) {
        const Contact& contact = contacts.contact[0];
        const double out = contact.depth / std::max(contact.nhat_W.z(), 0.2) + 1e-6;
        if (out > asked) triangle = contact.triangle;
        asked = std::max(asked, out);
      }
      if (asked > most && triangle >= 0) {
        most = asked;
        what = "'" + e.name + "' is in surface '" + terrain.surface(triangle).name + "' (triangle " +
               std::to_string(triangle) + ")";
      }
      lift = std::max(lift, asked);
    }
    if (lift == 0.0) return true;
    state.motion.X_WB.p.z() += lift;
    risen += lift;
  }
  return false;
}

bool steepAt(const Terrain& terrain, double x, double y) {
  for (const HeightHit& hit : terrain.heights(x, y))
    if (hit.faces_up) return terrain.triangle(hit.triangle).nhat_W.z() < std::cos(kSteepest);
  return false;
}

// All of the vehicle, as last posed, is below all of the ground.
bool fellOff(const VehicleDynamics& dynamics, const Terrain& terrain) {
  const double lowest = terrain.bounds().min().z();
  const std::vector<PosedEllipsoid>& posed = dynamics.posedEllipsoids();
  return std::all_of(posed.begin(), posed.end(),
                     [lowest](const PosedEllipsoid& e) { return e.p_WE.z() + e.halfBox().z() < lowest; });
}

// How far the vehicle may have to rise above the mean slope of the ground and still stand on that ground [m]: its wheels
// climb kerbs, its body has some way down, and the ground bends.
double tolerableRise(const VehicleModel& model, const std::vector<Vector3d>& supports) {
  double radius = 0.0, reach = 0.0;
  for (const WheelUnit& wheel : model.drive.wheels) radius = std::max(radius, wheel.radius);
  if (model.drive.wheels.empty())
    for (const ModelEllipsoid& e : model.ellipsoids) radius = std::max(radius, e.radii.maxCoeff());
  for (const Vector3d& p : supports) reach = std::max(reach, p.head<2>().norm());
  return radius + 0.2 * reach;
}

}  // namespace

VehicleState restState(const VehicleModel& model, const VehicleDynamics& dynamics) {
  VehicleState state;
  state.motion = dynamics.makeMotion();
  for (std::size_t j = 0; j < model.dynamic_joints.size(); ++j) state.motion.q[j] = model.dynamic_joints[j].rest;
  state.memory.assign(model.ellipsoids.size(), ContactMemory{});
  state.profiles.assign(model.prescribed_joints.size(), ProfileState{});
  for (std::size_t p = 0; p < model.prescribed_joints.size(); ++p) {
    const PrescribedJoint& joint = model.prescribed_joints[p];
    state.profiles[p].position = state.profiles[p].target = std::clamp(0.0, joint.lower, joint.upper);
  }
  followLeaders(model, state);
  state.treads.assign(model.treads.size(), TreadState{});
  // The brakes are on.
  for (const WheelUnit& wheel : model.drive.wheels)
    if (wheel.tread >= 0 && wheel.braked) state.treads[static_cast<std::size_t>(wheel.tread)].mode = TreadState::Mode::kTurning;
  DriveState& d = state.drive;
  for (auto* values : {&d.wheel_speed, &d.wheel_acceleration, &d.integral, &d.integral_gain, &d.angle})
    values->assign(model.drive.wheels.size(), 0.0);
  state.drive.own_mode.assign(model.drive.wheels.size(), OwnMode::kNone);
  state.drive.wheel_command.assign(model.drive.wheels.size(), JointCommand{});
  state.drive.profile_command.assign(model.prescribed_joints.size(), JointCommand{});
  return state;
}

Problems settle(const VehicleModel& model, const SimConfig& config, const Terrain& terrain, VehicleDynamics& dynamics,
                double x, double y, double yaw, VehicleState& state) {
  if (!std::isfinite(x) || !std::isfinite(y) || !std::isfinite(yaw)) return {{at(x, y), "position and heading must be finite numbers"}};
  const auto ground = groundHeight(terrain, x, y);
  if (!ground) return {{at(x, y), "there is no ground below that faces up"}};

  // Just above the ground, along its mean slope.
  VehicleState start = restState(model, dynamics);
  const std::vector<Vector3d> places = supportsOf(model);
  const Vector3d up = groundNormal(places, terrain, x, y, yaw, *ground);
  const Eigen::Quaterniond q =
      Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), up) * Eigen::AngleAxisd(yaw, Vector3d::UnitZ());
  double bottom = 0.0;
  const RestGeometry rest = restGeometry(model);
  for (const ModelEllipsoid& e : model.ellipsoids) {
    const Pose X_RE = rest.X_RB[e.body] * e.X_BE;
    bottom = std::min(bottom, X_RE.p.z() - (X_RE.q.toRotationMatrix() * e.radii.asDiagonal()).row(2).norm());
  }
  const Pose X_WR{Vector3d(x, y, *ground) - up * bottom, q};
  start.motion.X_WB = X_WR * model.X_BR.inverse();
  double risen = 0.0;
  std::string what;
  if (!raiseClear(model, terrain, config, dynamics, start, risen, what))
    return {{at(x, y), "no free space above the ground found there"}};
  // On ground too steep to stand on no rise means anything: the vehicle will slide off it, and that is then said.
  if (risen > tolerableRise(model, places) && !steepAt(terrain, x, y)) {
    char text[80];
    std::snprintf(text, sizeof text, "it would have to rise by %.3g m to be clear of it", risen);
    return {{at(x, y), "the vehicle would be inside geometry: " + what + "; " + text}};
  }

  if (config.gravity == 0.0) {
    dynamics.accept(start, 0.0);
    state = start;
    return {};
  }

  // Let down: brakes on, friction that holds, extra damping. Statics do not depend on how it got there.
  dynamics.overrideFriction(FrictionMode::kAnchored);
  const double explicit_step = settlingStep(model);
  const bool stiff = explicit_step < kSmallestSettlingStep || config.integrator == IntegratorKind::kLinearlyImplicit;
  const double dt = stiff ? kImplicitStep : explicit_step;
  const int quiet_steps = stiff ? kQuietImplicitSteps : kQuietSteps;
  SimConfig settling = config;
  settling.integrator = IntegratorKind::kLinearlyImplicit;
  settling.dt = dt;
  TickStepper implicit(model, settling, dynamics);
  std::vector<ContactMemory> before = start.memory;
  MotionRate k[4] = {dynamics.makeRate(), dynamics.makeRate(), dynamics.makeRate(), dynamics.makeRate()};
  Motion scratch = dynamics.makeMotion();
  dynamics.accept(start, dt);
  SettlingDamper damper;
  int quiet = 0;
  const int most = static_cast<int>(kLongestSettling / dt);
  bool finite = true, fell = false;
  int step = 0;
  for (; step < most && quiet < quiet_steps && !fell; ++step) {
    if (stiff) {
      finite = implicit.advance(start, before).sane;
      if (!finite) break;
    } else {
      dynamics.beginStep(start, dt);
      semiImplicitEulerStep(dynamics, start.motion, dt, k, scratch);
    }
    const double speed = largestSpeed(start.motion), remainder = damper.remainder(speed, dt);
    start.motion.v_WB *= remainder;
    start.motion.w_WB *= remainder;
    for (double& qd : start.motion.qd) qd *= remainder;
    finite = start.motion.allFinite() && remainder * speed < 1e6;
    if (!finite) break;
    if (!stiff) dynamics.accept(start, dt);
    bool touching = false;
    for (const ContactMemory& memory : start.memory) touching = touching || memory.count > 0;
    fell = !touching && fellOff(dynamics, terrain);
    quiet = touching && largestSpeed(start.motion) < kAtRest ? quiet + 1 : 0;
  }
  dynamics.overrideFriction(std::nullopt);
  if (!finite || quiet < quiet_steps) {
    char text[200];
    if (fell)
      std::snprintf(text, sizeof text, "the vehicle finds no rest there: after %.3g s it has fallen off the ground", step * dt);
    else
      std::snprintf(text, sizeof text, "the vehicle finds no rest there: after %.3g s it still moves at %.3g m/s (it slides or tips)",
                    step * dt, finite ? largestSpeed(start.motion) : INFINITY);
    return {{at(x, y), text}};
  }

  int supports = 0;
  for (const ContactMemory& memory : start.memory) supports += memory.count > 0 ? 1 : 0;
  const int needed = std::min<int>(3, static_cast<int>(model.ellipsoids.size()));
  if (supports < needed)
    return {{at(x, y), "the vehicle would rest on " + std::to_string(supports) + " support(s); at least " +
                           std::to_string(needed) + " are needed"}};

  // Exactly still; what slack the touch-down left is none of the run's business.
  start.motion.v_WB.setZero();
  start.motion.w_WB.setZero();
  std::fill(start.motion.qd.begin(), start.motion.qd.end(), 0.0);
  for (ContactMemory& memory : start.memory) memory.slack = 0.0;
  state = start;
  return {};
}

}  // namespace ellipsoid_vehicle_sim
