#include "ellipsoid_vehicle_sim/dynamics/articulated_body.h"

#include <cmath>
#include <utility>

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Inertia that is the same about every axis square to k to within rounding counts as balanced [-].
constexpr double kBalanced = 1e-12;

double alongAxis(const Body& body) { return body.axis_B.dot(body.inertia.I_cm_A * body.axis_B); }

// The body turns about an axis that its mass is even about: the turn moves no mass.
bool isBalanced(const Body& body) {
  if (body.motion != BodyMotion::kDynamic || body.prismatic || !body.spin_symmetric) return false;
  const Matrix3d& I = body.inertia.I_cm_A;
  const Vector3d& k = body.axis_B;
  const double along = alongAxis(body), across = 0.5 * (I.trace() - along);
  const Matrix3d even = across * Matrix3d::Identity() + (along - across) * k * k.transpose();
  const Vector3d off = body.inertia.p_Acm - k.dot(body.inertia.p_Acm) * k;
  return off.isZero(0.0) && (I - even).cwiseAbs().maxCoeff() <= kBalanced * I.cwiseAbs().maxCoeff();
}

// A turn by `angle` about the unit axis k.
Frame3 turnAbout(const Vec3& k, double angle) {
  const double s = std::sin(angle), c = std::cos(angle);
  const Vec3 t = (1.0 - c) * k, sk = s * k;
  return {{c + t.x * k.x, t.x * k.y + sk.z, t.x * k.z - sk.y},
          {t.x * k.y - sk.z, c + t.y * k.y, t.y * k.z + sk.x},
          {t.x * k.z + sk.y, t.y * k.z - sk.x, c + t.z * k.z}};
}

}  // namespace

ArticulatedBody::ArticulatedBody(std::vector<Body> bodies, std::vector<CoordinateCoupling> couplings)
    : bodies_(std::move(bodies)),
      kinematics_(bodies_.size()),
      forces_(bodies_.size()),
      work_(bodies_.size()),
      spin_acceleration_(bodies_.size(), 0.0),
      couplings_(std::move(couplings)),
      coupled_tau_(couplings_.empty() ? 0 : bodies_.size(), 0.0),
      coupling_matrix_(couplings_.size() * couplings_.size(), 0.0),
      gaps_(couplings_.size(), 0.0) {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    total_mass_ += bodies_[i].inertia.mass;
    constants_.push_back(constantsOf(i));
    (constants_[i].rotor ? rotors_ : branches_).push_back(static_cast<int>(i));
  }
  carryRotors();
  settleOrientations();
}

ArticulatedBody::Constants ArticulatedBody::constantsOf(std::size_t i) const {
  const Body& body = bodies_[i];
  Constants c;
  c.R_PB = columns(body.X_PB.q.toRotationMatrix());
  c.p_PB = Vec3::from(body.X_PB.p);
  c.axis_B = Vec3::from(body.axis_B);
  c.mass = body.inertia.mass;
  c.p_Bcm = Vec3::from(body.inertia.p_Acm);
  c.I_cm_B = Symmetric3::from(body.inertia.I_cm_A);
  c.rotor = isBalanced(body);
  for (const Body& other : bodies_) c.rotor = c.rotor && other.parent != static_cast<int>(i);
  c.spin_inertia = c.rotor ? alongAxis(body) : 0.0;
  return c;
}

// Mass and inertia across the axis of every rotor go to the body that carries it.
void ArticulatedBody::carryRotors() {
  std::vector<RigidInertia> carried;
  for (const Body& body : bodies_) carried.push_back(body.inertia);
  for (const int i : rotors_) {
    RigidInertia still = bodies_[i].inertia;
    still.I_cm_A -= constants_[i].spin_inertia * bodies_[i].axis_B * bodies_[i].axis_B.transpose();
    carried[bodies_[i].parent] = carried[bodies_[i].parent] + still.seenFrom(bodies_[i].X_PB);
  }
  for (const int i : branches_) {
    constants_[i].mass = carried[i].mass;
    constants_[i].p_Bcm = Vec3::from(carried[i].p_Acm);
    constants_[i].I_cm_B = Symmetric3::from(carried[i].I_cm_A);
  }
}

// Along slides and about the axes of symmetric bodies nothing turns.
void ArticulatedBody::settleOrientations() {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    Constants& c = constants_[i];
    BodyKinematics& k = kinematics_[i];
    if (i > 0) {
      const int parent = bodies_[i].parent;
      c.steady = constants_[parent].steady && (bodies_[i].prismatic || bodies_[i].spin_symmetric);
      k.R_OB = fromFrame(kinematics_[parent].R_OB, c.R_PB);
      c.p_PB_O = fromFrame(kinematics_[parent].R_OB, c.p_PB);
    } else {
      c.steady = true;
      c.p_PB_O = {0.0, 0.0, 0.0};
    }
    c.p_cm_O = fromFrame(k.R_OB, c.p_Bcm);
    c.I_cm_O = turned(k.R_OB, c.I_cm_B);
    const Vec3 axis = fromFrame(k.R_OB, c.axis_B);
    (bodies_[i].prismatic ? k.axis.linear : k.axis.angular) = axis;
  }
}

void ArticulatedBody::positions(const double* q, const PrescribedMotion* prescribed) {
  for (std::size_t i = 1; i < bodies_.size(); ++i) {
    const Body& body = bodies_[i];
    const Constants& c = constants_[i];
    const BodyKinematics& parent = kinematics_[body.parent];
    BodyKinematics& k = kinematics_[i];
    const double position =
        body.motion == BodyMotion::kDynamic ? q[body.coordinate] : prescribed[body.coordinate].position;
    k.p_OB = parent.p_OB + (constants_[body.parent].steady ? c.p_PB_O : fromFrame(parent.R_OB, c.p_PB));
    if (!c.steady) {
      // The joint leaves its own axis where it is.
      k.R_OB = fromFrame(parent.R_OB, c.R_PB);
      (body.prismatic ? k.axis.linear : k.axis.angular) = fromFrame(k.R_OB, c.axis_B);
      if (!body.prismatic && !body.spin_symmetric) k.R_OB = fromFrame(k.R_OB, turnAbout(c.axis_B, position));
    }
    if (body.prismatic) {
      k.p_OB += position * k.axis.linear;
    } else {
      k.axis.linear = cross(k.p_OB, k.axis.angular);
    }
  }
}

void ArticulatedBody::velocities(const Vec3& w_B, const double* qd, const PrescribedMotion* prescribed) {
  kinematics_[0].velocity = {w_B, {0.0, 0.0, 0.0}};
  for (std::size_t i = 1; i < bodies_.size(); ++i) {
    const Body& body = bodies_[i];
    const Spatial& v = kinematics_[body.parent].velocity;
    BodyKinematics& k = kinematics_[i];
    const double speed =
        body.motion == BodyMotion::kDynamic ? qd[body.coordinate] : prescribed[body.coordinate].velocity;
    // The joint's own speed crossed with itself vanishes: the parent's velocity is enough for the bias.
    const Vec3 moving = speed * k.axis.linear;
    if (body.prismatic) {
      k.velocity = {v.angular, v.linear + moving};
      k.bias = {{0.0, 0.0, 0.0}, cross(v.angular, moving)};
    } else {
      const Vec3 turning = speed * k.axis.angular;
      k.velocity = {v.angular + turning, v.linear + moving};
      if (!constants_[i].rotor)
        k.bias = {cross(v.angular, turning), cross(v.angular, moving) + cross(v.linear, turning)};
    }
  }
}

void ArticulatedBody::clearForces() {
  for (Spatial& force : forces_) force = Spatial{};
}

// The body by itself: its inertia at O and v x* (I v), less the external force.
void ArticulatedBody::setOwnInertia(std::size_t i) {
  const Constants& body = constants_[i];
  const BodyKinematics& k = kinematics_[i];
  Work& w = work_[i];
  const Vec3 c = k.p_OB + (body.steady ? body.p_cm_O : fromFrame(k.R_OB, body.p_Bcm));
  const Symmetric3 I = body.steady ? body.I_cm_O : turned(k.R_OB, body.I_cm_B);
  w.I.setRigid(body.mass, c, I);
  // From the centre of mass: the moment of momentum about O turns, and O's own transport adds v x p.
  const Spatial& v = k.velocity;
  const Vec3 momentum = body.mass * (v.linear + cross(v.angular, c));
  const Vec3 moment_O = I * v.angular + cross(c, momentum);
  w.bias_force = {cross(v.angular, moment_O) + cross(v.linear, momentum) - forces_[i].angular,
                  cross(v.angular, momentum) - forces_[i].linear};
}

// A rotor hands every force on to its carrier but the moment along its axis, which spins it up together with the
// joint's effort; and the carrier has to turn its momentum.
void ArticulatedBody::releaseRotor(std::size_t i, const double* tau) {
  const Body& body = bodies_[i];
  const BodyKinematics& k = kinematics_[i];
  const Spatial& external = forces_[i];
  Work& parent = work_[body.parent];
  const double moment = tau[body.coordinate] + dot(k.axis, external);
  const double momentum = constants_[i].spin_inertia * dot(k.axis.angular, k.velocity.angular);
  parent.bias_force.angular += moment * k.axis.angular +
                               momentum * cross(kinematics_[body.parent].velocity.angular, k.axis.angular) -
                               external.angular;
  parent.bias_force.linear -= external.linear;
  spin_acceleration_[i] = moment / constants_[i].spin_inertia;
}

// What the parent feels of the body below it: all of its inertia but along the joint's free motion, and the force that
// comes with what moves whatever the parent does.
void ArticulatedBody::passToParent(std::size_t i, const double* tau, const PrescribedMotion* prescribed) {
  const Body& body = bodies_[i];
  const BodyKinematics& k = kinematics_[i];
  Work& w = work_[i];
  Work& parent = work_[body.parent];
  Spatial a = k.bias;
  if (body.motion == BodyMotion::kPrescribed) a += prescribed[body.coordinate].acceleration * k.axis;
  Spatial passed = w.I * a + w.bias_force;
  if (body.motion == BodyMotion::kDynamic) {
    w.U = body.prismatic ? w.I.timesLinear(k.axis.linear) : w.I * k.axis;
    w.D = dot(k.axis, w.U);
    w.u = tau[body.coordinate] - dot(k.axis, w.bias_force);
    const double inverse_D = 1.0 / w.D;
    passed += ((w.u - dot(a, w.U)) * inverse_D) * w.U;
    parent.I.addWithout(w.I, w.U, inverse_D);
  } else {
    parent.I.add(w.I);
  }
  parent.bias_force += passed;
}

Spatial ArticulatedBody::accelerations(const double* tau, const PrescribedMotion* prescribed, const Vec3& gravity,
                                       double* qdd) {
  if (!couplings_.empty()) return coupledAccelerations(tau, prescribed, gravity, qdd);
  return uncoupledAccelerations(tau, prescribed, gravity, qdd);
}

// What is left of qdd = G qdd_independent.
double ArticulatedBody::couplingGap(std::size_t coupling, const double* qdd) const {
  const CoordinateCoupling& c = couplings_[coupling];
  return qdd[c.coordinate] - c.multiplier * qdd[c.leader];
}

// Along the coupling's own motion, which the coupling forbids: no work in any that it allows.
void ArticulatedBody::addCouplingEffort(std::size_t coupling, double effort) {
  const CoordinateCoupling& c = couplings_[coupling];
  coupled_tau_[c.coordinate] += effort;
  coupled_tau_[c.leader] -= c.multiplier * effort;
}

// Gauss without exchange of rows: the matrix is symmetric and positive definite. gaps_ becomes lambda.
void ArticulatedBody::solveCouplings() {
  const std::size_t n = couplings_.size();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) {
      const double factor = coupling_matrix_[j * n + i] / coupling_matrix_[i * n + i];
      for (std::size_t k = i; k < n; ++k) coupling_matrix_[j * n + k] -= factor * coupling_matrix_[i * n + k];
      gaps_[j] -= factor * gaps_[i];
    }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t k = i + 1; k < n; ++k) gaps_[i] -= coupling_matrix_[i * n + k] * gaps_[k];
    gaps_[i] /= coupling_matrix_[i * n + i];
  }
}

Spatial ArticulatedBody::coupledAccelerations(const double* tau, const PrescribedMotion* prescribed,
                                              const Vec3& gravity, double* qdd) {
  const std::size_t n = couplings_.size();
  int coordinates = 0;
  for (const Body& body : bodies_)
    if (body.motion == BodyMotion::kDynamic) ++coordinates;
  for (int i = 0; i < coordinates; ++i) coupled_tau_[i] = tau[i];
  Spatial base = uncoupledAccelerations(coupled_tau_.data(), prescribed, gravity, qdd);
  // A second round takes away what rounding of the differences has left of the gaps.
  for (int round = 0; round < 2; ++round) {
    for (std::size_t i = 0; i < n; ++i) gaps_[i] = -couplingGap(i, qdd);
    for (std::size_t j = 0; j < n; ++j) {
      addCouplingEffort(j, 1.0);
      uncoupledAccelerations(coupled_tau_.data(), prescribed, gravity, qdd);
      for (std::size_t i = 0; i < n; ++i) coupling_matrix_[i * n + j] = couplingGap(i, qdd) + gaps_[i];
      addCouplingEffort(j, -1.0);
    }
    solveCouplings();
    for (std::size_t j = 0; j < n; ++j) addCouplingEffort(j, gaps_[j]);
    base = uncoupledAccelerations(coupled_tau_.data(), prescribed, gravity, qdd);
  }
  return base;
}

Spatial ArticulatedBody::uncoupledAccelerations(const double* tau, const PrescribedMotion* prescribed,
                                                const Vec3& gravity, double* qdd) {
  // Gravity is even: it accelerates O and nothing relative to it, so it enters at the very end.
  for (const int i : branches_) setOwnInertia(i);
  for (const int i : rotors_) releaseRotor(i, tau);
  for (std::size_t j = branches_.size() - 1; j > 0; --j) passToParent(branches_[j], tau, prescribed);

  // The base: no force but the ones collected.
  Work& base = work_[0];
  if (bodies_.size() == 1) {
    // One rigid body about its centre of mass: turning and moving do not mix.
    base.acceleration = {base.I.J().solve(-base.bias_force.angular),
                         (-1.0 / constants_[0].mass) * base.bias_force.linear};
  } else {
    base.acceleration = base.I.accelerationUnder(-1.0 * base.bias_force);
  }

  for (std::size_t j = 1; j < branches_.size(); ++j) {
    const int i = branches_[j];
    const Body& body = bodies_[i];
    const BodyKinematics& k = kinematics_[i];
    Work& w = work_[i];
    w.acceleration = work_[body.parent].acceleration + k.bias;
    double speedup;
    if (body.motion == BodyMotion::kDynamic) {
      speedup = (w.u - dot(w.acceleration, w.U)) / w.D;
      qdd[body.coordinate] = speedup;
    } else {
      speedup = prescribed[body.coordinate].acceleration;
    }
    w.acceleration += speedup * k.axis;
  }
  for (const int i : rotors_) {
    const Body& body = bodies_[i];
    spin_acceleration_[i] -= dot(kinematics_[i].axis.angular, work_[body.parent].acceleration.angular);
    qdd[body.coordinate] = spin_acceleration_[i];
  }
  return {base.acceleration.angular, base.acceleration.linear + gravity};
}

Spatial ArticulatedBody::acceleration(int body) const {
  if (!constants_[body].rotor) return work_[body].acceleration;
  const BodyKinematics& k = kinematics_[body];
  const Spatial& v = kinematics_[bodies_[body].parent].velocity;
  const Vec3 turning = k.velocity.angular - v.angular, moving = k.velocity.linear - v.linear;
  const Spatial bias{cross(v.angular, turning), cross(v.angular, moving) + cross(v.linear, turning)};
  return work_[bodies_[body].parent].acceleration + bias + spin_acceleration_[body] * k.axis;
}

double ArticulatedBody::prescribedEffort(int body) const {
  const Work& w = work_[body];
  return dot(kinematics_[body].axis, w.I * w.acceleration + w.bias_force);
}

double ArticulatedBody::articulatedInertia(int body) const {
  return constants_[body].rotor ? constants_[body].spin_inertia : work_[body].D;
}

double ArticulatedBody::kineticEnergy(const Vec3& v_B) const {
  double twice = 0.0;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const BodyKinematics& k = kinematics_[i];
    const RigidInertia& inertia = bodies_[i].inertia;
    const Vec3 c = k.p_OB + fromFrame(k.R_OB, Vec3::from(inertia.p_Acm));
    const Vec3 w = toFrame(k.R_OB, k.velocity.angular);
    const Vec3 v_cm = v_B + k.velocity.linear + cross(k.velocity.angular, c);
    twice += inertia.mass * squaredNorm(v_cm) + dot(w, Symmetric3::from(inertia.I_cm_A) * w);
  }
  return 0.5 * twice;
}

Spatial ArticulatedBody::momentum(const Vec3& v_B) const {
  Spatial sum;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const BodyKinematics& k = kinematics_[i];
    const RigidInertia& inertia = bodies_[i].inertia;
    const Vec3 c = k.p_OB + fromFrame(k.R_OB, Vec3::from(inertia.p_Acm));
    const Vec3 spin = fromFrame(k.R_OB, Symmetric3::from(inertia.I_cm_A) * toFrame(k.R_OB, k.velocity.angular));
    const Vec3 p = inertia.mass * (v_B + k.velocity.linear + cross(k.velocity.angular, c));
    sum.linear += p;
    sum.angular += spin + cross(c, p);
  }
  return sum;
}

Vec3 ArticulatedBody::massMoment() const {
  Vec3 moment{0.0, 0.0, 0.0};
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const RigidInertia& inertia = bodies_[i].inertia;
    moment += inertia.mass * (kinematics_[i].p_OB + fromFrame(kinematics_[i].R_OB, Vec3::from(inertia.p_Acm)));
  }
  return moment;
}

}  // namespace ellipsoid_vehicle_sim
