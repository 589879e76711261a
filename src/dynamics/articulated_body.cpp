#include "ellipsoid_vehicle_sim/dynamics/articulated_body.h"

#include <Eigen/LU>
#include <cmath>
#include <utility>

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d crossMatrix(const Vector3d& v) {
  Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

double dot(const Spatial& motion, const Spatial& force) {
  return motion.angular.dot(force.angular) + motion.linear.dot(force.linear);
}

}  // namespace

ArticulatedBody::ArticulatedBody(std::vector<Body> bodies)
    : bodies_(std::move(bodies)), kinematics_(bodies_.size()), forces_(bodies_.size()), work_(bodies_.size()) {
  for (Body& body : bodies_) {
    body.R_PB = body.X_PB.q.toRotationMatrix();
    total_mass_ += body.inertia.mass;
  }
}

void ArticulatedBody::positions(const Eigen::Quaterniond& q_WB, const double* q, const PrescribedMotion* prescribed) {
  kinematics_[0].R_WB = q_WB.toRotationMatrix();
  kinematics_[0].p_OB.setZero();
  for (std::size_t i = 1; i < bodies_.size(); ++i) {
    const Body& body = bodies_[i];
    const BodyKinematics& parent = kinematics_[body.parent];
    BodyKinematics& k = kinematics_[i];
    k.R_WB.noalias() = parent.R_WB * body.R_PB;
    k.p_OB = parent.p_OB + parent.R_WB * body.X_PB.p;
    const Vector3d axis_W = k.R_WB * body.axis_B;
    const double position = body.motion == BodyMotion::kDynamic ? q[body.coordinate] : prescribed[body.coordinate].position;
    if (body.prismatic) {
      k.axis = {Vector3d::Zero(), axis_W};
      k.p_OB += position * axis_W;
    } else {
      k.axis = {axis_W, k.p_OB.cross(axis_W)};
      if (!body.spin_symmetric) k.R_WB = k.R_WB * Eigen::AngleAxisd(position, body.axis_B).toRotationMatrix();
    }
  }
}

void ArticulatedBody::velocities(const Vector3d& w_WB, const double* qd, const PrescribedMotion* prescribed) {
  kinematics_[0].velocity = {w_WB, Vector3d::Zero()};
  for (std::size_t i = 1; i < bodies_.size(); ++i) {
    const Body& body = bodies_[i];
    const Spatial& v = kinematics_[body.parent].velocity;
    BodyKinematics& k = kinematics_[i];
    const double speed = body.motion == BodyMotion::kDynamic ? qd[body.coordinate] : prescribed[body.coordinate].velocity;
    // The joint's own speed crossed with itself vanishes: the parent's velocity is enough for the bias.
    if (body.prismatic) {
      const Vector3d sliding = speed * k.axis.linear;
      k.velocity = {v.angular, v.linear + sliding};
      k.bias = {Vector3d::Zero(), v.angular.cross(sliding)};
    } else {
      const Vector3d turning = speed * k.axis.angular;
      const Vector3d moving = speed * k.axis.linear;
      k.velocity = {v.angular + turning, v.linear + moving};
      k.bias = {v.angular.cross(turning), v.angular.cross(moving) + v.linear.cross(turning)};
    }
  }
}

void ArticulatedBody::clearForces() {
  for (Spatial& force : forces_) force = Spatial{};
}

Spatial ArticulatedBody::accelerations(const double* tau, const PrescribedMotion* prescribed, const Vector3d& gravity_W,
                                       double* qdd) {
  // Gravity is even: it accelerates O and nothing relative to it, so it enters at the very end.
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const RigidInertia& inertia = bodies_[i].inertia;
    const BodyKinematics& k = kinematics_[i];
    Work& w = work_[i];
    const Vector3d c = i == 0 ? Vector3d::Zero().eval() : (k.p_OB + k.R_WB * inertia.p_Acm).eval();
    const double m = inertia.mass;
    const Matrix3d I_W = k.R_WB * inertia.I_cm_A * k.R_WB.transpose();
    w.I.J = I_W + m * (c.squaredNorm() * Matrix3d::Identity() - c * c.transpose());
    w.I.H = m * crossMatrix(c);
    w.I.M = m * Matrix3d::Identity();
    // v x* (I v), from the centre of mass: moment w x (I w) + c x f, force m w x v_cm, plus the transport of O itself.
    const Spatial& v = k.velocity;
    const Vector3d v_cm = v.linear + v.angular.cross(c);
    const Vector3d momentum = m * v_cm;
    const Vector3d spin = I_W * v.angular;
    const Vector3d moment_O = spin + c.cross(momentum);
    w.bias_force.angular = v.angular.cross(moment_O) + v.linear.cross(momentum) - forces_[i].angular;
    w.bias_force.linear = v.angular.cross(momentum) - forces_[i].linear;
  }

  for (std::size_t i = bodies_.size() - 1; i > 0; --i) {
    const Body& body = bodies_[i];
    const BodyKinematics& k = kinematics_[i];
    Work& w = work_[i];
    Work& parent = work_[body.parent];
    const bool turns = !body.prismatic;

    // Acceleration that this body has whatever the parent and its coordinate do.
    Spatial a = k.bias;
    if (body.motion == BodyMotion::kPrescribed) {
      const double acceleration = prescribed[body.coordinate].acceleration;
      a.angular += acceleration * k.axis.angular;
      a.linear += acceleration * k.axis.linear;
    } else {
      w.U.angular = w.I.H * k.axis.linear;
      w.U.linear = w.I.M * k.axis.linear;
      if (turns) {
        w.U.angular += w.I.J * k.axis.angular;
        w.U.linear += w.I.H.transpose() * k.axis.angular;
      }
      w.D = dot(k.axis, w.U);
      w.u = tau[body.coordinate] - dot(k.axis, w.bias_force);
    }
    // The force that the parent has to pass on for it.
    Spatial passed = w.bias_force;
    passed.angular += w.I.J * a.angular + w.I.H * a.linear;
    passed.linear += w.I.H.transpose() * a.angular + w.I.M * a.linear;
    parent.I.J += w.I.J;
    parent.I.H += w.I.H;
    parent.I.M += w.I.M;
    if (body.motion == BodyMotion::kDynamic) {
      const double inv = 1.0 / w.D;
      const double along = (w.u - dot(a, w.U)) * inv;
      passed.angular += along * w.U.angular;
      passed.linear += along * w.U.linear;
      const Vector3d ua = inv * w.U.angular;
      const Vector3d ul = inv * w.U.linear;
      parent.I.J.noalias() -= ua * w.U.angular.transpose();
      parent.I.H.noalias() -= ua * w.U.linear.transpose();
      parent.I.M.noalias() -= ul * w.U.linear.transpose();
    }
    parent.bias_force.angular += passed.angular;
    parent.bias_force.linear += passed.linear;
  }

  // The base: no force but the ones collected.
  Work& base = work_[0];
  const Matrix3d M_inverse = base.I.M.inverse();
  const Matrix3d HM = base.I.H * M_inverse;
  const Matrix3d schur = base.I.J - HM * base.I.H.transpose();
  base.acceleration.angular = schur.inverse() * (HM * base.bias_force.linear - base.bias_force.angular);
  base.acceleration.linear =
      M_inverse * (-base.bias_force.linear - base.I.H.transpose() * base.acceleration.angular);

  for (std::size_t i = 1; i < bodies_.size(); ++i) {
    const Body& body = bodies_[i];
    const BodyKinematics& k = kinematics_[i];
    Work& w = work_[i];
    const Spatial& parent = work_[body.parent].acceleration;
    w.acceleration.angular = parent.angular + k.bias.angular;
    w.acceleration.linear = parent.linear + k.bias.linear;
    double speedup;
    if (body.motion == BodyMotion::kDynamic) {
      speedup = (w.u - dot(w.acceleration, w.U)) / w.D;
      qdd[body.coordinate] = speedup;
    } else {
      speedup = prescribed[body.coordinate].acceleration;
    }
    w.acceleration.angular += speedup * k.axis.angular;
    w.acceleration.linear += speedup * k.axis.linear;
  }
  return {base.acceleration.angular, base.acceleration.linear + gravity_W};
}

double ArticulatedBody::prescribedEffort(int body) const {
  const Work& w = work_[body];
  Spatial force = w.bias_force;
  force.angular += w.I.J * w.acceleration.angular + w.I.H * w.acceleration.linear;
  force.linear += w.I.H.transpose() * w.acceleration.angular + w.I.M * w.acceleration.linear;
  return dot(kinematics_[body].axis, force);
}

double ArticulatedBody::kineticEnergy(const Vector3d& v_WB) const {
  double twice = 0.0;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const BodyKinematics& k = kinematics_[i];
    const RigidInertia& inertia = bodies_[i].inertia;
    const Vector3d c = i == 0 ? Vector3d::Zero().eval() : (k.p_OB + k.R_WB * inertia.p_Acm).eval();
    const Vector3d w_B = k.R_WB.transpose() * k.velocity.angular;
    const Vector3d v_cm = v_WB + k.velocity.linear + k.velocity.angular.cross(c);
    twice += inertia.mass * v_cm.squaredNorm() + w_B.dot(inertia.I_cm_A * w_B);
  }
  return 0.5 * twice;
}

Vector3d ArticulatedBody::massMoment() const {
  Vector3d moment = Vector3d::Zero();
  for (std::size_t i = 1; i < bodies_.size(); ++i) {
    const RigidInertia& inertia = bodies_[i].inertia;
    moment += inertia.mass * (kinematics_[i].p_OB + kinematics_[i].R_WB * inertia.p_Acm);
  }
  return moment;
}

}  // namespace ellipsoid_vehicle_sim
