#include "peers.h"

#ifdef WITH_BULLET

#include <cmath>

#include "bullet_world.h"
#include "corners.h"
#include "wheel_torques.h"
// Needs the precision that the world's header chooses.
#include <BulletDynamics/ConstraintSolver/btHinge2Constraint.h>

// A DriveScene in Bullet: chassis and wheels on hinge-2 joints.

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

// Axes of its hinge-2: along the suspension, about the axle, about the other square axis, about the suspension.
enum { kTravel = 2, kAxle = 3, kSteering = 5 };
// More than any steering needs [N m], and faster than any wheel turns [rad/s].
constexpr double kSteeringTorque = 1e9, kNeverReached = 1e6;

class BulletCar {
 public:
  BulletCar(const DriveScene& scene, const CornerVehicle& vehicle, double dt)
      : scene_(scene),
        vehicle_(vehicle),
        dt_(dt),
        bullet_(scene.nhat_W, scene.p_WP, scene.gravity),
        torques_(scene, dt) {
    const Motion& x = scene.start;
    const Pose X_WP = x.X_WB * vehicle.X_BP;
    chassis_ = bullet_.addBody(shapeOf(-1), vehicle.mass, vehicle.inertia, X_WP, x.v_WB, x.w_WB);
    setContact(-1, *chassis_);
    angle_.assign(vehicle.corners.size(), 0.0);
    speed_.assign(vehicle.corners.size(), 0.0);
    for (std::size_t i = 0; i < vehicle.corners.size(); ++i) {
      const Corner& corner = vehicle.corners[i];
      addWheel(static_cast<int>(i), corner, X_WP);
      const int joint = scene.model.drive.wheels[static_cast<std::size_t>(corner.wheel)].joint;
      angle_[static_cast<std::size_t>(corner.wheel)] = x.q[static_cast<std::size_t>(joint)];
      speed_[static_cast<std::size_t>(corner.wheel)] = x.qd[static_cast<std::size_t>(joint)];
    }
  }

  void step() {
    const double time = static_cast<double>(ticks_) * dt_, end = static_cast<double>(++ticks_) * dt_;
    const std::vector<double>& torque = torques_.at(time, angle_, speed_);
    for (std::size_t i = 0; i < wheels_.size(); ++i) {
      const Wheel& wheel = wheels_[i];
      // As a motor at its limit: torques from outside are unknown to Bullet's friction, which then slips by their work.
      const double t = torque[static_cast<std::size_t>(vehicle_.corners[i].wheel)];
      wheel.joint->setTargetVelocity(kAxle, t > 0.0 ? -kNeverReached : kNeverReached);
      wheel.joint->setMaxMotorForce(kAxle, std::abs(t));
      steer(wheel, vehicle_.corners[i], axleOf(wheel), end);
    }
    bullet_.world.stepSimulation(dt_, 0);
    for (std::size_t i = 0; i < wheels_.size(); ++i) {
      const auto unit = static_cast<std::size_t>(vehicle_.corners[i].wheel);
      const btVector3 w = wheels_[i].body->getAngularVelocity() - chassis_->getAngularVelocity();
      speed_[unit] = axleOf(wheels_[i]).dot(w);
      angle_[unit] += dt_ * speed_[unit];
    }
    torques_.endStep(end, angle_, speed_);
  }

  Pose rootPose() const {
    return scene_.rootPose(fromBullet(chassis_->getCenterOfMassTransform()) * vehicle_.X_BP.inverse());
  }

 private:
  struct Wheel {
    std::unique_ptr<btRigidBody> body;
    std::unique_ptr<btHinge2Constraint> joint;
    Vector3d up_P, straight_P;  // in the chassis: steering axis, and the axle where the steering is zero
  };

  static btVector3 axleOf(const Wheel& wheel) { return wheel.body->getCenterOfMassTransform().getBasis().getColumn(1); }

  // All ellipsoids of the chassis (corner -1) or of a wheel.
  btCollisionShape& shapeOf(int corner) {
    shapes_.push_back(std::make_unique<btCompoundShape>());
    btCompoundShape& shape = *shapes_.back();
    for (const CornerEllipsoid& e : vehicle_.ellipsoids) {
      if (e.corner != corner) continue;
      ellipsoids_.push_back(
          std::make_unique<BulletEllipsoid>(scene_.model.ellipsoids[static_cast<std::size_t>(e.index)].radii));
      shape.addChildShape(toBullet(e.X), ellipsoids_.back().get());
    }
    return shape;
  }

  // A body has one law in Bullet: that of its first ellipsoid.
  void setContact(int corner, btRigidBody& body) {
    for (const CornerEllipsoid& e : vehicle_.ellipsoids) {
      if (e.corner != corner) continue;
      const ContactLaw& law = scene_.model.ellipsoids[static_cast<std::size_t>(e.index)].law;
      body.setContactStiffnessAndDamping(law.stiffness, law.damping);
      body.setFriction(scene_.mu[static_cast<std::size_t>(e.index)]);
      return;
    }
  }

  void addWheel(int index, const Corner& corner, const Pose& X_WP) {
    Wheel wheel;
    wheel.body = bullet_.addBody(shapeOf(index), corner.mass, {corner.across, corner.spin, corner.across}, corner.X_WC,
                                 corner.v_WC, corner.w_WC);
    setContact(index, *wheel.body);
    const Vector3d axle = corner.X_WC.q * Vector3d::UnitY();
    btVector3 anchor = toBullet(corner.anchor_W), up = toBullet(corner.up_W), axis = toBullet(axle);
    wheel.joint = std::make_unique<btHinge2Constraint>(*chassis_, *wheel.body, anchor, up, axis);
    btHinge2Constraint& joint = *wheel.joint;
    if (corner.stiffness > 0.0) {
      joint.setLimit(kTravel, 1.0, -1.0);  // none
      joint.setStiffness(kTravel, corner.stiffness);
      joint.setDamping(kTravel, corner.damping);
      joint.setEquilibriumPoint(kTravel, -corner.pressed);
    } else {
      joint.enableSpring(kTravel, false);
      joint.setLimit(kTravel, 0.0, 0.0);
    }
    for (const int motor : {kAxle, kSteering}) {
      joint.setLimit(motor, 1.0, -1.0);
      joint.enableMotor(motor, true);
    }
    joint.setMaxMotorForce(kSteering, kSteeringTorque);
    bullet_.world.addConstraint(&joint, true);
    wheel.up_P = X_WP.q.conjugate() * corner.up_W;
    wheel.straight_P = X_WP.q.conjugate() * axle;
    wheels_.push_back(std::move(wheel));
  }

  // The motor about the steering axis brings the wheel to its angle within the step.
  void steer(const Wheel& wheel, const Corner& corner, const btVector3& axle_W, double end) {
    const double target = corner.steer < 0 ? 0.0 : corner.steer_sign * scene_.series.path(corner.steer, end).position;
    const Vector3d axle_P = fromBullet(chassis_->getCenterOfMassTransform()).q.conjugate() * fromBullet(axle_W);
    const double rate = (target - steeredAngle(wheel.up_P, wheel.straight_P, axle_P)) / dt_;
    // Its motors turn the other way round.
    wheel.joint->setTargetVelocity(kSteering, -rate);
  }

  const DriveScene& scene_;
  const CornerVehicle& vehicle_;
  double dt_;
  // Known to the world, and so destroyed after it.
  std::vector<std::unique_ptr<BulletEllipsoid>> ellipsoids_;
  std::vector<std::unique_ptr<btCompoundShape>> shapes_;
  std::unique_ptr<btRigidBody> chassis_;
  std::vector<Wheel> wheels_;  // in the order of the corners
  BulletWorld bullet_;
  WheelTorques torques_;
  std::vector<double> angle_, speed_;  // of the drive's units
  std::int64_t ticks_ = 0;
};

}  // namespace

PeerRun driveBullet(const DriveScene& scene, double dt) {
  const Loaded<CornerVehicle> vehicle = makeCornerVehicle(scene);
  if (!vehicle) return {{}, 0.0, problemText(vehicle.problems)};
  BulletCar car(scene, *vehicle.value, dt);
  return runPeer(
      scene.duration, dt, [&car] { car.step(); }, [&car] { return car.rootPose(); });
}

}  // namespace ellipsoid_vehicle_sim

#endif
