// The account of energy: what motors supply and what is lost for good, as powers that are integrated beside the motion by the
// same method. In every motion energy() + lost - supplied stays what it was; what it strays by is the integrator's doing.
#include <algorithm>

#include "ellipsoid_vehicle_sim/vehicle/vehicle_dynamics.h"

namespace ellipsoid_vehicle_sim {

using Eigen::Vector3d;

// What forces take from the motion x other than gravity and the springs of contacts and joints, and what feeds it: losses, and
// what fills the stretches of friction and brakes. A tread that turns has its motor push through the ground.
Work VehicleDynamics::drainedPower(const Motion& x) {
  Work power = resisted_;
  for (ActiveContact& active : active_) {
    const ModelEllipsoid& ellipsoid = model_.ellipsoids[active.ellipsoid];
    const Vec3 force = active.force.normal * Vec3::from(active.contact.nhat_W) + Vec3::from(active.force.friction_W);
    const Vec3 v = pointVelocity(x, ellipsoid.body, Vec3::from(active.p_OC));
    Vec3 at_ground = v;
    if (ellipsoid.tread >= 0 && frozen_->treads[ellipsoid.tread].mode == TreadState::Mode::kTurning)
      at_ground = surfaceMotion(x, active).v;
    const double spring = lawOf(active.ellipsoid).stiffness * active.contact.share * active.contact.pressed;
    power.lost -= dot(force, at_ground) - spring * dot(Vec3::from(active.contact.nhat_W), v);
    power.supplied += dot(force, v - at_ground);
  }
  for (std::size_t j = 0; j < joint_effort_.size(); ++j) {
    const DynamicJoint& joint = model_.dynamic_joints[j];
    const double above = std::max(0.0, x.q[j] - joint.upper), below = std::max(0.0, joint.lower - x.q[j]);
    const double spring = joint.stiffness * (x.q[j] - joint.reference) + joint.stop_stiffness * (above - below);
    power.lost -= (joint_effort_[j] + spring) * x.qd[j];
  }
  for (std::size_t i = 0; i < motor_torque_.size(); ++i) {
    const int joint = model_.drive.wheels[i].joint;
    if (joint < 0) continue;
    const double supplied = motor_torque_[i] * x.qd[joint];
    power.supplied += supplied;
    power.lost += supplied;  // the joint's effort above has it, too
  }
  for (std::size_t p = 0; p < model_.prescribed_joints.size(); ++p)
    if (model_.prescribed_joints[p].body >= 0)
      power.supplied += prescribedEffort(static_cast<int>(p)) * prescribed_[p].velocity;
  return power;
}

// How fast the stretches of friction and brakes fill at the rates k. They are cut at the end of the step; methods of one stage
// are asked in the middle of their way, where the rate times the step is just what is stored.
double VehicleDynamics::stretchPower(const Motion& x, const MotionRate& k) const {
  double to_middle = 0.0;
  if (config_.integrator == IntegratorKind::kExplicitEuler || config_.integrator == IntegratorKind::kSemiImplicitEuler)
    to_middle = 0.5 * dt_;
  if (config_.integrator == IntegratorKind::kLinearlyImplicit) to_middle = -0.5 * dt_;

  double power = 0.0;
  for (const ActiveContact& active : active_) {
    const ContactLaw& law = lawOf(active.ellipsoid);
    if (active.from < 0 || law.mode == FrictionMode::kViscous) continue;
    const auto slot = static_cast<std::size_t>(active.from);
    const Vector3d& rate = k.anchor[active.ellipsoid][slot];
    const Vector3d stretch = x.anchor[active.ellipsoid][slot] + to_middle * rate;
    power += active.contact.share * law.tangential_stiffness * stretch.dot(rate);
  }
  for (std::size_t j = 0; j < model_.dynamic_joints.size(); ++j)
    power += model_.dynamic_joints[j].hold.stiffness * (x.stretch[j] + to_middle * k.stretch[j]) * k.stretch[j];
  return power;
}

// What friction stored where an ellipsoid has come off the ground [J]: lost with its contacts.
double VehicleDynamics::anchorsLetGo(const Motion& x) const {
  double energy = 0.0;
  for (std::size_t i = 0; i < x.anchor.size(); ++i) {
    const ContactLaw& law = laws_[i];
    if (law.mode == FrictionMode::kViscous) continue;
    if (contacts_[i].count > 0) continue;
    for (const Vector3d& z : x.anchor[i]) energy += 0.5 * law.tangential_stiffness * z.squaredNorm();
  }
  return energy;
}

}  // namespace ellipsoid_vehicle_sim
