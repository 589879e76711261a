#include "peers.h"

#ifdef WITH_ODE

#include <cmath>

#include "corners.h"
#include "ode_world.h"
#include "wheel_torques.h"

// A DriveScene in ODE: chassis and wheels on hinge-2 joints.

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

// More than any steering needs [N m].
constexpr double kSteeringTorque = 1e9;

Vector3d angularVelocity(dBodyID body) {
  const dReal* w = dBodyGetAngularVel(body);
  return {w[0], w[1], w[2]};
}

class OdeCar {
 public:
  OdeCar(const DriveScene& scene, const CornerVehicle& vehicle, double dt)
      : scene_(scene), vehicle_(vehicle), dt_(dt), ode_(scene.gravity), torques_(scene, dt) {
    const Motion& x = scene.start;
    const Pose X_WP = x.X_WB * vehicle.X_BP;
    chassis_ = ode_.addBody(vehicle.mass, vehicle.inertia, X_WP, x.v_WB, x.w_WB);
    for (const Corner& corner : vehicle.corners) addWheel(corner, X_WP);
    angle_.assign(wheels_.size(), 0.0);
    speed_.assign(wheels_.size(), 0.0);
    for (std::size_t i = 0; i < wheels_.size(); ++i) {
      const Corner& corner = vehicle.corners[i];
      const int joint = scene.model.drive.wheels[static_cast<std::size_t>(corner.wheel)].joint;
      angle_[static_cast<std::size_t>(corner.wheel)] = x.q[static_cast<std::size_t>(joint)];
      speed_[static_cast<std::size_t>(corner.wheel)] = x.qd[static_cast<std::size_t>(joint)];
    }
  }

  void step() {
    const double time = static_cast<double>(ticks_) * dt_, end = static_cast<double>(++ticks_) * dt_;
    const std::vector<double>& torque = torques_.at(time, angle_, speed_);
    const Pose X_WP = odePose(chassis_);
    for (std::size_t i = 0; i < wheels_.size(); ++i) {
      Wheel& wheel = wheels_[i];
      const Vector3d axle = odePose(wheel.body).q * Vector3d::UnitY();
      const Vector3d t = torque[static_cast<std::size_t>(vehicle_.corners[i].wheel)] * axle;
      dBodyAddTorque(wheel.body, t.x(), t.y(), t.z());
      dBodyAddTorque(chassis_, -t.x(), -t.y(), -t.z());
      steer(wheel, vehicle_.corners[i], X_WP.q.conjugate() * axle, end);
      preload(wheel, vehicle_.corners[i], X_WP);
    }
    for (const CornerEllipsoid& e : vehicle_.ellipsoids) touch(e);
    ode_.step(dt_);
    for (std::size_t i = 0; i < wheels_.size(); ++i) {
      const Vector3d axle = odePose(wheels_[i].body).q * Vector3d::UnitY();
      const auto unit = static_cast<std::size_t>(vehicle_.corners[i].wheel);
      speed_[unit] = axle.dot(angularVelocity(wheels_[i].body) - angularVelocity(chassis_));
      angle_[unit] += dt_ * speed_[unit];
    }
    torques_.endStep(end, angle_, speed_);
  }

  Pose rootPose() const { return scene_.rootPose(odePose(chassis_) * vehicle_.X_BP.inverse()); }

 private:
  struct Wheel {
    dBodyID body;
    dJointID joint;
    Vector3d up_P, straight_P;  // in the chassis: steering axis, and the axle where the steering is zero
  };

  void addWheel(const Corner& corner, const Pose& X_WP) {
    Wheel wheel{};
    wheel.body = ode_.addBody(corner.mass, {corner.across, corner.spin, corner.across}, corner.X_WC, corner.v_WC,
                              corner.w_WC);
    const Vector3d &anchor = corner.anchor_W, axle = corner.X_WC.q * Vector3d::UnitY();
    wheel.joint = dJointCreateHinge2(ode_.world, nullptr);
    dJointAttach(wheel.joint, chassis_, wheel.body);
    dJointSetHinge2Anchor(wheel.joint, anchor.x(), anchor.y(), anchor.z());
    dJointSetHinge2Axes(wheel.joint, corner.up_W.data(), axle.data());
    if (corner.stiffness > 0.0) {
      const double sum = dt_ * corner.stiffness + corner.damping;
      dJointSetHinge2Param(wheel.joint, dParamSuspensionERP, dt_ * corner.stiffness / sum);
      dJointSetHinge2Param(wheel.joint, dParamSuspensionCFM, 1.0 / sum);
    }
    dJointSetHinge2Param(wheel.joint, dParamFMax, kSteeringTorque);
    wheel.up_P = X_WP.q.conjugate() * corner.up_W;
    wheel.straight_P = X_WP.q.conjugate() * axle;
    wheels_.push_back(wheel);
  }

  // The joint's spring is slack where it was made, and pulls its two ends sideways apart by what it gives: so it is made
  // where the vehicle stands, and what the spring carries there is a force.
  void preload(const Wheel& wheel, const Corner& corner, const Pose& X_WP) const {
    const Vector3d f = corner.stiffness * corner.pressed * (X_WP.q * wheel.up_P);
    const dReal* p = dBodyGetPosition(wheel.body);
    dBodyAddForceAtPos(chassis_, f.x(), f.y(), f.z(), p[0], p[1], p[2]);
    dBodyAddForce(wheel.body, -f.x(), -f.y(), -f.z());
  }

  // The motor about the steering axis brings the wheel to its angle within the step.
  void steer(const Wheel& wheel, const Corner& corner, const Vector3d& axle_P, double end) {
    const double target = corner.steer < 0 ? 0.0 : corner.steer_sign * scene_.series.path(corner.steer, end).position;
    const double rate = (target - steeredAngle(wheel.up_P, wheel.straight_P, axle_P)) / dt_;
    // Rates of a hinge-2 are those of the first body against the second.
    dJointSetHinge2Param(wheel.joint, dParamVel, -rate);
  }

  void touch(const CornerEllipsoid& e) {
    const auto index = static_cast<std::size_t>(e.index);
    const dBodyID body = e.corner < 0 ? chassis_ : wheels_[static_cast<std::size_t>(e.corner)].body;
    const Pose X_WX = odePose(body);
    const ModelEllipsoid& ellipsoid = scene_.model.ellipsoids[index];
    const OdeContact lowest = lowestPoint(X_WX * e.X, ellipsoid.radii, scene_.nhat_W, scene_.p_WP);
    if (lowest.depth <= 0.0) return;
    const ContactLaw& law = ellipsoid.law;
    dContact contact = odeContact(lowest, scene_.nhat_W, scene_.mu[index], law.stiffness, law.damping, dt_);
    if (e.corner >= 0 && law.mode == FrictionMode::kBrush) {
      // Its manual's way to a tyre: along the wheel and across it, slip in proportion to the force.
      const Vector3d along = (X_WX.q * Vector3d::UnitY()).cross(scene_.nhat_W).normalized();
      const Vector3d running = angularVelocity(body).cross(lowest.p_WC - X_WX.p);
      const double rolling = (running - scene_.nhat_W.dot(running) * scene_.nhat_W).norm();
      contact.surface.mode |= dContactFDir1 | dContactSlip1 | dContactSlip2;
      contact.surface.slip1 = contact.surface.slip2 = rolling / (law.tangential_stiffness * law.brush_length);
      for (int i = 0; i < 3; ++i) contact.fdir1[i] = along[i];
    }
    dJointAttach(dJointCreateContact(ode_.world, ode_.contacts, &contact), body, nullptr);
  }

  const DriveScene& scene_;
  const CornerVehicle& vehicle_;
  double dt_;
  OdeWorld ode_;
  WheelTorques torques_;
  dBodyID chassis_;
  std::vector<Wheel> wheels_;          // in the order of the corners
  std::vector<double> angle_, speed_;  // of the drive's units
  std::int64_t ticks_ = 0;
};

}  // namespace

PeerRun driveOde(const DriveScene& scene, double dt) {
  const Loaded<CornerVehicle> vehicle = makeCornerVehicle(scene);
  if (!vehicle) return {{}, 0.0, problemText(vehicle.problems)};
  OdeCar car(scene, *vehicle.value, dt);
  return runPeer(
      scene.duration, dt, [&car] { car.step(); }, [&car] { return car.rootPose(); });
}

}  // namespace ellipsoid_vehicle_sim

#endif
