#include "pair_contact.h"

#include <algorithm>

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

// Slack is given back at this speed [m/s], as with the terrain [ContactDefinition, rule 6].
constexpr double kSlackSpeed = 0.01;

// Two springs and dampers in series, each taking its share of the deflection by its stiffness.
struct Series {
  double stiffness, damping;
};

Series series(double k1, double c1, double k2, double c2) {
  const double a = k2 / (k1 + k2), b = k1 / (k1 + k2);
  return {k1 * a, a * a * c1 + b * b * c2};
}

// How the surfaces slide on each other, and the directions in which a free tread gives way.
struct Sliding {
  Vec3 v;
  Vec3 free_axis[2];
};

Sliding slidingOf(const PairSide& first, const PairSide& second, const PairCandidate& pair) {
  Sliding sliding{{0.0, 0.0, 0.0}, {}};
  const PairSide* sides[2] = {&first, &second};
  Vec3 v[2];
  for (int i = 0; i < 2; ++i) {
    Contact contact{};
    contact.nhat_W = i == 0 ? pair.contact.nhat_W : Vector3d(-pair.contact.nhat_W);
    contact.p_WE_lowest = pair.p_WC;
    ActiveContact active(sides[i]->ellipsoid, contact);
    active.p_OC = pair.p_WC - sides[i]->motion->X_WB.p;
    v[i] = sides[i]->dynamics->surfaceMotion(*sides[i]->motion, active).v;
    sliding.free_axis[i] = Vec3::from(active.roll_axis);
  }
  sliding.v = v[0] - v[1];
  return sliding;
}

Vec3 without(const Vec3& v, const Vec3& axis) {
  return axis.x == 0.0 && axis.y == 0.0 && axis.z == 0.0 ? v : v - dot(axis, v) * axis;
}

ContactLaw lawOf(const PairSide& first, const PairSide& second) {
  return pairLaw(first.dynamics->model().ellipsoids[first.ellipsoid].law,
                 second.dynamics->model().ellipsoids[second.ellipsoid].law);
}

// At which the side's surface moves against the normal that points into it.
double sinkingSpeed(const PairSide& side, const Vector3d& nhat_W, const Vector3d& p_WC) {
  Contact contact{};
  contact.nhat_W = nhat_W;
  ActiveContact active(side.ellipsoid, contact);
  active.p_OC = p_WC - side.motion->X_WB.p;
  return side.dynamics->sinkingSpeed(*side.motion, active);
}

// The stretch turned to the contact's normal.
Vector3d anchorAt(const PairCandidate& pair, const Vector3d& anchor_W, const Sliding& sliding) {
  if (!pair.known || anchor_W.isZero(0.0)) return Vector3d::Zero();
  const Vector3d &from = pair.memory.nhat_W, &to = pair.contact.nhat_W;
  // Turned over, there is no smallest rotation: the contact is another one.
  if (from.dot(to) <= 0.0) return Vector3d::Zero();
  const Vec3 u = Vec3::from(to), z = Vec3::from(from == to ? anchor_W : turnedWithNormal(anchor_W, from, to));
  Vec3 anchor = z - dot(u, z) * u;
  for (const Vec3& axis : sliding.free_axis) anchor = without(anchor, axis);
  return anchor.toEigen();
}

}  // namespace

ContactLaw pairLaw(const ContactLaw& first, const ContactLaw& second) {
  ContactLaw law;
  const Series normal = series(first.stiffness, first.damping, second.stiffness, second.damping);
  const Series along = series(first.tangential_stiffness, first.tangential_damping, second.tangential_stiffness,
                              second.tangential_damping);
  law.stiffness = normal.stiffness;
  law.damping = normal.damping;
  law.tangential_stiffness = along.stiffness;
  law.tangential_damping = along.damping;
  const bool viscous = first.mode == FrictionMode::kViscous && second.mode == FrictionMode::kViscous;
  law.mode = viscous ? FrictionMode::kViscous : FrictionMode::kAnchored;
  law.viscous_friction = 0.5 * std::min(first.viscous_friction, second.viscous_friction);
  return law;
}

FrictionCoefficients pairFriction(const FrictionCoefficients& first, const FrictionCoefficients& second) {
  FrictionCoefficients mu;
  mu.mu_static = std::min(first.mu_static, second.mu_static);
  mu.mu_kinetic = std::min({first.mu_kinetic, second.mu_kinetic, mu.mu_static});
  mu.stribeck_speed = std::min(first.stribeck_speed, second.stribeck_speed);
  return mu;
}

void updatePairForce(const PairSide& first, const PairSide& second, const Vector3d& anchor_W, PairCandidate& pair) {
  const Sliding sliding = slidingOf(first, second, pair);
  const ContactLaw law = lawOf(first, second);
  const FrictionCoefficients mu =
      pairFriction(first.dynamics->ownFriction(first.ellipsoid), second.dynamics->ownFriction(second.ellipsoid));
  const Vector3d& u = pair.contact.nhat_W;
  const Vector3d anchor = anchorAt(pair, anchor_W, sliding);
  pair.force = contactForce(law, mu, u, pair.pressed, 1.0, sliding.v.toEigen(), Vector3d::Zero(), anchor);
  Vec3 rate = Vec3::from(pair.force.anchor_rate_W);
  for (const Vec3& axis : sliding.free_axis) rate = without(rate, axis);
  pair.force.anchor_rate_W = rate.toEigen();
  pair.f_W = pair.force.normal * u + pair.force.friction_W;
}

bool evaluatePair(const PairSide& first, const PairSide& second, const Vector3d& anchor_W, PairCandidate& pair) {
  pair.contact = EllipsoidPairContact{};
  pair.pressed = 0.0;
  pair.force = ContactForce{};
  pair.f_W = Vector3d::Zero();
  const PosedEllipsoid &a = first.posed(), &b = second.posed();
  // Apart by the direction that was the normal, or by the boxes: most candidates are.
  if (pair.known && separates(a, b, pair.memory.nhat_W)) return false;
  const Vector3d apart = (a.p_WE - b.p_WE).cwiseAbs() - a.halfBox() - b.halfBox();
  if (apart.maxCoeff() >= 0.0) return false;
  pair.contact = minimumTranslation(a, b);
  if (!pair.contact) return false;
  const double k1 = first.dynamics->model().ellipsoids[first.ellipsoid].law.stiffness;
  const double k2 = second.dynamics->model().ellipsoids[second.ellipsoid].law.stiffness;
  pair.p_WC = pair.contact.p_WE_first + (k2 / (k1 + k2)) * pair.contact.depth * pair.contact.nhat_W;
  pair.pressed = std::max(0.0, pair.contact.depth - (pair.known ? pair.memory.slack : 0.0));
  updatePairForce(first, second, anchor_W, pair);
  return true;
}

void acceptPair(const PairSide& first, const PairSide& second, const Vector3d& anchor_W, double h, PairCandidate& pair) {
  PairMemory& memory = pair.memory;
  if (!evaluatePair(first, second, anchor_W, pair)) {
    pair.known = false;
    memory.depth = memory.slack = 0.0;
    memory.anchor_W.setZero();
    return;
  }
  const Sliding sliding = slidingOf(first, second, pair);
  const double felt = pair.contact.depth - pair.pressed;
  const double slack = std::max(0.0, felt - kSlackSpeed * h);
  pair.pressed = std::max(0.0, pair.contact.depth - slack);
  Vector3d anchor = anchorAt(pair, anchor_W, sliding);
  const double limit = stretchLimit(
      lawOf(first, second),
      pairFriction(first.dynamics->ownFriction(first.ellipsoid), second.dynamics->ownFriction(second.ellipsoid)),
      pair.contact.nhat_W, pair.pressed, 1.0, sliding.v.toEigen(), Vector3d::Zero());
  const double length = anchor.norm();
  if (length > limit) anchor *= limit / length;
  pair.known = true;
  memory.nhat_W = pair.contact.nhat_W;
  memory.depth = pair.contact.depth;
  memory.slack = slack;
  memory.anchor_W = anchor;
  updatePairForce(first, second, memory.anchor_W, pair);
}

Touch touchOf(const PairSide& first, const PairSide& second, const PairCandidate& pair) {
  Touch touch;
  if (!pair.contact) return touch;
  const ContactLaw law = lawOf(first, second);
  touch.known = true;
  touch.depth = pair.pressed;
  touch.speed = sinkingSpeed(first, pair.contact.nhat_W, pair.p_WC) + sinkingSpeed(second, -pair.contact.nhat_W, pair.p_WC);
  touch.push = touch.depth + law.damping / law.stiffness * touch.speed;
  return touch;
}

void takeWithSlack(const PosedEllipsoid& first, const PosedEllipsoid& second, PairCandidate& pair) {
  const EllipsoidPairContact contact = minimumTranslation(first, second);
  if (!contact) return;
  pair.known = true;
  pair.memory.nhat_W = contact.nhat_W;
  pair.memory.depth = pair.memory.slack = contact.depth;
  pair.memory.anchor_W.setZero();
}

bool passedThrough(const PosedEllipsoid& first, const PosedEllipsoid& second, const PairCandidate& pair,
                   const Vector3d& nhat_before_W, bool known_before) {
  // Pushed back to where it had come from before, to the other side now.
  if (known_before && pair.known) return nhat_before_W.dot(pair.memory.nhat_W) < 0.0;
  const Vector3d end = first.p_WE - second.p_WE, way = end - pair.p_start;
  if (known_before) return nhat_before_W.dot(end) < 0.0;
  if (pair.known) return pair.memory.nhat_W.dot(pair.p_start) < 0.0;
  // Apart before and after, but not on the way.
  if (way.norm() <= first.radii.minCoeff() + second.radii.minCoeff()) return false;
  const double nearest = std::clamp(-pair.p_start.dot(way) / way.squaredNorm(), 0.0, 1.0);
  PosedEllipsoid there = first;
  there.p_WE = second.p_WE + pair.p_start + nearest * way;
  return static_cast<bool>(minimumTranslation(there, second));
}

double pairEnergy(const PairCandidate& pair, const ContactLaw& law) {
  double energy = 0.5 * law.stiffness * pair.pressed * pair.pressed;
  if (law.mode != FrictionMode::kViscous) energy += 0.5 * law.tangential_stiffness * pair.memory.anchor_W.squaredNorm();
  return energy;
}

}  // namespace ellipsoid_vehicle_sim
