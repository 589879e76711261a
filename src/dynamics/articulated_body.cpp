#include "ellipsoid_vehicle_sim/dynamics/articulated_body.h"

#include <Eigen/LU>
#include <cmath>
#include <utility>

namespace ellipsoid_vehicle_sim {

using Eigen::Matrix3d;
using Eigen::Vector3d;

ArticulatedBody::ArticulatedBody(std::vector<Body> bodies)
    : bodies_(std::move(bodies)), kinematics_(bodies_.size()), forces_(bodies_.size()), work_(bodies_.size()) {
  for (const Body& body : bodies_) {
    total_mass_ += body.inertia.mass;
    shortcuts_.push_back(shortcutOf(body));
  }
}

ArticulatedBody::Shortcut ArticulatedBody::shortcutOf(const Body& body) {
  Shortcut shortcut;
  shortcut.R_PB = body.X_PB.q.toRotationMatrix();
  shortcut.aligned = shortcut.R_PB == Matrix3d::Identity();
  const Matrix3d& I = body.inertia.I_cm_A;
  const Vector3d& k = body.axis_B;
  shortcut.along = k.dot(I * k);
  shortcut.across = 0.5 * (I.trace() - shortcut.along);
  const Matrix3d form = shortcut.across * Matrix3d::Identity() + (shortcut.along - shortcut.across) * k * k.transpose();
  shortcut.axial = (I - form).cwiseAbs().maxCoeff() <= 1e-12 * I.cwiseAbs().maxCoeff();
  const Vector3d off = body.inertia.p_Acm - k.dot(body.inertia.p_Acm) * k;
  shortcut.balanced = shortcut.axial && body.spin_symmetric && !body.prismatic && off.isZero(0.0);
  return shortcut;
}

void ArticulatedBody::positions(const Eigen::Quaterniond& q_WB, const double* q, const PrescribedMotion* prescribed) {
  kinematics_[0].R_WB = q_WB.toRotationMatrix();
  kinematics_[0].p_OB.setZero();
  for (std::size_t i = 1; i < bodies_.size(); ++i) {
    const Body& body = bodies_[i];
    const BodyKinematics& parent = kinematics_[body.parent];
    BodyKinematics& k = kinematics_[i];
    if (shortcuts_[i].aligned) {
      k.R_WB = parent.R_WB;
    } else {
      k.R_WB.noalias() = parent.R_WB * shortcuts_[i].R_PB;
    }
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
    Vector3d c = Vector3d::Zero();
    if (i > 0) c = k.p_OB + k.R_WB * inertia.p_Acm;
    const double m = inertia.mass;
    Matrix3d I_W;
    const Shortcut& shortcut = shortcuts_[i];
    if (shortcut.axial) {
      const Vector3d axis_W = k.R_WB * bodies_[i].axis_B;
      I_W.noalias() = ((shortcut.along - shortcut.across) * axis_W) * axis_W.transpose();
      I_W.diagonal().array() += shortcut.across;
    } else {
      const Matrix3d RI = k.R_WB * inertia.I_cm_A;
      I_W.noalias() = RI * k.R_WB.transpose();
    }
    w.I.setRigid(m, c, I_W);
    // v x* (I v), from the centre of mass: the moment of momentum about O turns, and O's own transport adds v x p.
    const Spatial& v = k.velocity;
    const Vector3d momentum = m * (v.linear + v.angular.cross(c));
    const Vector3d moment_O = I_W * v.angular + c.cross(momentum);
    w.bias_force.angular = v.angular.cross(moment_O) + v.linear.cross(momentum) - forces_[i].angular;
    w.bias_force.linear = v.angular.cross(momentum) - forces_[i].linear;
  }

  for (std::size_t i = bodies_.size() - 1; i > 0; --i) {
    const Body& body = bodies_[i];
    const BodyKinematics& k = kinematics_[i];
    Work& w = work_[i];
    Work& parent = work_[body.parent];

    // Acceleration that this body has whatever the parent and its coordinate do, and the force that it takes.
    Spatial a = k.bias;
    if (body.motion == BodyMotion::kPrescribed) {
      const double acceleration = prescribed[body.coordinate].acceleration;
      a.angular += acceleration * k.axis.angular;
      a.linear += acceleration * k.axis.linear;
    }
    Spatial passed = w.I * a;
    passed.angular += w.bias_force.angular;
    passed.linear += w.bias_force.linear;
    if (body.motion == BodyMotion::kDynamic) {
      if (shortcuts_[i].balanced) {
        w.U = {shortcuts_[i].along * k.axis.angular, Vector3d::Zero()};
        w.D = shortcuts_[i].along;
      } else {
        w.U = body.prismatic ? w.I.timesLinear(k.axis.linear) : w.I * k.axis;
        w.D = dot(k.axis, w.U);
      }
      w.u = tau[body.coordinate] - dot(k.axis, w.bias_force);
      const double inverse_D = 1.0 / w.D;
      const double along = (w.u - dot(a, w.U)) * inverse_D;
      passed.angular += along * w.U.angular;
      passed.linear += along * w.U.linear;
      if (shortcuts_[i].balanced) {
        parent.I.addWithoutTurning(w.I, k.axis.angular, w.D);
      } else {
        parent.I.addWithout(w.I, w.U, inverse_D);
      }
    } else {
      parent.I.add(w.I);
    }
    parent.bias_force.angular += passed.angular;
    parent.bias_force.linear += passed.linear;
  }

  // The base: no force but the ones collected.
  Work& base = work_[0];
  if (bodies_.size() == 1) {
    // One rigid body about its centre of mass: turning and moving do not mix.
    base.acceleration.angular = base.I.J().inverse() * -base.bias_force.angular;
    base.acceleration.linear = base.bias_force.linear / -bodies_[0].inertia.mass;
  } else {
    const Matrix3d H = base.I.H();
    const Matrix3d M_inverse = base.I.M().inverse();
    const Matrix3d HM = H * M_inverse;
    const Matrix3d schur = base.I.J() - HM * H.transpose();
    base.acceleration.angular = schur.inverse() * (HM * base.bias_force.linear - base.bias_force.angular);
    base.acceleration.linear = M_inverse * (-base.bias_force.linear - H.transpose() * base.acceleration.angular);
  }

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
  Spatial force = w.I * w.acceleration;
  force.angular += w.bias_force.angular;
  force.linear += w.bias_force.linear;
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
