#include "ellipsoid_vehicle_sim/vehicle/linearisation.h"

#include <Eigen/LU>
#include <cmath>

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Steps of the differences: small against every contact's sag and large against rounding.
constexpr double kPositionStep = 1e-7, kSpeedStep = 1e-6;

// One step of semi-implicit Euler: velocities first, positions with the new ones.
MatrixXd semiImplicitMap(const MatrixXd& J, int positions, double dt) {
  const int n = static_cast<int>(J.rows());
  const int velocities = n - positions;
  MatrixXd map = MatrixXd::Identity(n, n);
  map.bottomRows(velocities) += dt * J.bottomRows(velocities);
  map.topLeftCorner(positions, positions) += dt * J.topLeftCorner(positions, positions);
  map.topRows(positions) += dt * J.topRightCorner(positions, velocities) * map.bottomRows(velocities);
  return map;
}

// One step of linearly_implicit; see linearly_implicit.cpp.
MatrixXd linearlyImplicitMap(const MatrixXd& J, int positions, double dt) {
  const int n = static_cast<int>(J.rows());
  const int velocities = n - positions;
  const auto A = J.bottomLeftCorner(velocities, positions), B = J.bottomRightCorner(velocities, velocities);
  const auto Q = J.topLeftCorner(positions, positions), P = J.topRightCorner(positions, velocities);
  MatrixXd ahead = MatrixXd::Zero(positions, n);  // p*
  ahead.leftCols(positions) = MatrixXd::Identity(positions, positions) + dt * Q;
  ahead.rightCols(velocities) = dt * P;
  MatrixXd right = A * ahead;
  right.rightCols(velocities) += B;
  const MatrixXd system = MatrixXd::Identity(velocities, velocities) - dt * (B + dt * A * P);
  MatrixXd map = MatrixXd::Identity(n, n);
  map.bottomRows(velocities) += dt * system.partialPivLu().solve(right);
  map.topLeftCorner(positions, positions) += dt * Q;
  map.topRows(positions) += dt * P * map.bottomRows(velocities);
  return map;
}

// 1 + z + z^2 / 2 + ...: by Horner's rule.
MatrixXd polynomial(const MatrixXd& z, std::initializer_list<double> coefficients) {
  const MatrixXd one = MatrixXd::Identity(z.rows(), z.cols());
  MatrixXd sum = MatrixXd::Zero(z.rows(), z.cols());
  for (auto c = std::rbegin(coefficients); c != std::rend(coefficients); ++c) sum = *c * one + z * sum;
  return sum;
}

const char* roleText(JointRole role, bool held) {
  if (role == JointRole::kSuspension) return "suspension joint";
  if (role == JointRole::kDrive) return held ? "brake of" : "servo of";
  return held ? "brake of" : "joint";
}

}  // namespace

Linearisation::Linearisation(const VehicleModel& model, VehicleDynamics& dynamics, const VehicleState& rest)
    : model_(model), dynamics_(dynamics), rest_(rest), rate_(dynamics.makeRate()) {
  joints_ = model.dynamic_joints.size();
  for (std::size_t e = 0; e < rest.memory.size(); ++e)
    for (int s = 0; s < rest.memory[e].count; ++s) slots_.push_back({static_cast<int>(e), s});
  positions_ = 6 + 2 * static_cast<int>(joints_) + 3 * static_cast<int>(slots_.size());
  size_ = positions_ + 6 + static_cast<int>(joints_);
}

std::string Linearisation::coordinateName(int i) const {
  static const char* kBase[] = {"x", "y", "z", "roll", "pitch", "yaw"};
  const int n = static_cast<int>(joints_);
  if (i >= positions_) i -= positions_;
  if (i < 6) return std::string("base ") + kBase[i];
  i -= 6;
  if (i < 2 * n) return "joint '" + model_.description.joints[model_.dynamic_joints[i % n].description].name + "'";
  return "friction of '" + model_.ellipsoids[slots_[(i - 2 * n) / 3].first].name + "'";
}

double& Linearisation::component(MotionRate& k, int i) const {
  const int n = static_cast<int>(joints_);
  if (i < 3) return k.v[i];
  if (i < 6) return k.w[i - 3];
  if (i < 6 + n) return k.q[i - 6];
  if (i < 6 + 2 * n) return k.stretch[i - 6 - n];
  if (i < positions_) {
    const int s = i - 6 - 2 * n;
    return k.anchor[slots_[s / 3].first][slots_[s / 3].second][s % 3];
  }
  i -= positions_;
  if (i < 3) return k.a[i];
  if (i < 6) return k.alpha[i - 3];
  return k.qd[i - 6];
}

Motion Linearisation::moved(const Motion& x, int coordinate, double h) const {
  MotionRate direction = dynamics_.makeRate();
  component(direction, coordinate) = 1.0;
  Motion result = x;
  dynamics_.advance(x, h, direction, result);  // joints that mimic others stay with them
  return result;
}

VectorXd Linearisation::tangent(const Motion& x) const {
  MotionRate k = dynamics_.makeRate();
  const Motion& o = rest_.motion;
  k.v = x.X_WB.p - o.X_WB.p;
  const Eigen::AngleAxisd turned(x.X_WB.q * o.X_WB.q.conjugate());
  // The shorter way round.
  const double angle = turned.angle() > M_PI ? turned.angle() - 2.0 * M_PI : turned.angle();
  k.w = angle * turned.axis();
  k.a = x.v_WB - o.v_WB;
  k.alpha = x.w_WB - o.w_WB;
  for (std::size_t i = 0; i < joints_; ++i) {
    k.q[i] = x.q[i] - o.q[i];
    k.qd[i] = x.qd[i] - o.qd[i];
    k.stretch[i] = x.stretch[i] - o.stretch[i];
  }
  for (std::size_t e = 0; e < x.anchor.size(); ++e)
    for (int s = 0; s < kMaxContactsPerEllipsoid; ++s) k.anchor[e][s] = x.anchor[e][s] - o.anchor[e][s];
  VectorXd result(size_);
  for (int i = 0; i < size_; ++i) result[i] = component(k, i);
  return result;
}

VectorXd Linearisation::rateAt(const Motion& x) {
  dynamics_.beginStep(rest_, 0.0);
  // Not the start of the step: the contacts are to be found anew.
  dynamics_.rate(x, 1.0, rate_);
  VectorXd result(size_);
  for (int i = 0; i < size_; ++i) result[i] = component(rate_, i);
  return result;
}

// Forces of all elements at the state last evaluated, and the speeds they work against: contacts' normals, contacts'
// friction (three components), joints.
Linearisation::Forces Linearisation::forcesAt(const Motion& x) const {
  Forces result;
  for (const auto& [ellipsoid, slot] : slots_) {
    double normal = 0.0, sinking = 0.0;
    Vector3d friction = Vector3d::Zero(), sliding = Vector3d::Zero();
    for (const ActiveContact& active : dynamics_.activeContacts()) {
      if (active.ellipsoid != ellipsoid || active.slot != slot) continue;
      normal = active.force.normal;
      sinking = dynamics_.sinkingSpeed(x, active);
      friction = active.force.friction_W;
      sliding = active.force.anchor_rate_W;
    }
    result.force.push_back(normal);
    result.speed.push_back(sinking);
    for (int i = 0; i < 3; ++i) {
      result.force.push_back(friction[i]);
      result.speed.push_back(sliding[i]);
    }
  }
  for (std::size_t j = 0; j < joints_; ++j) {
    result.force.push_back(dynamics_.jointEfforts()[j]);
    result.speed.push_back(x.qd[j]);
  }
  return result;
}

void Linearisation::nameElements() {
  elements_.clear();
  const auto add = [this](const std::string& name, int rows) {
    elements_.push_back({name, MatrixXd::Zero(rows, size_), MatrixXd::Zero(rows, size_)});
  };
  for (const auto& slot : slots_) {
    const std::string& ellipsoid = model_.ellipsoids[slot.first].name;
    add("contact of '" + ellipsoid + "'", 1);
    add("friction of '" + ellipsoid + "'", 3);
  }
  for (std::size_t j = 0; j < joints_; ++j) {
    const DynamicJoint& joint = model_.dynamic_joints[j];
    const bool held = rest_.drive.mode == DriveState::Mode::kBrake && joint.hold.stiffness > 0.0;
    add(std::string(roleText(joint.role, held)) + " '" + model_.description.joints[joint.description].name + "'", 1);
  }
}

const MatrixXd& Linearisation::jacobian() {
  J_.resize(size_, size_);
  nameElements();
  for (int i = 0; i < size_; ++i) {
    const double h = i < positions_ ? kPositionStep : kSpeedStep;
    Forces forces[2];
    VectorXd rates[2];
    for (const int side : {0, 1}) {
      const Motion x = moved(rest_.motion, i, side == 0 ? -h : h);
      rates[side] = rateAt(x);
      forces[side] = forcesAt(x);
    }
    J_.col(i) = (rates[1] - rates[0]) / (2.0 * h);
    std::size_t row = 0;
    for (ForceElement& element : elements_)
      for (int r = 0; r < element.force.rows(); ++r, ++row) {
        element.force(r, i) = (forces[1].force[row] - forces[0].force[row]) / (2.0 * h);
        element.speed(r, i) = (forces[1].speed[row] - forces[0].speed[row]) / (2.0 * h);
      }
  }
  return J_;
}

std::string Linearisation::modeName(const Eigen::VectorXcd& mode) const {
  // Coordinates of base and joints have different units, and so have their speeds: work compares them.
  std::string name = "no force";
  double most = 0.0;
  for (const ForceElement& element : elements_) {
    const double power = ((element.force * mode).cwiseAbs().array() * (element.speed * mode).cwiseAbs().array()).sum();
    // The first of equals, but for rounding: a car's four wheels.
    if (power <= most * (1.0 + 1e-3)) continue;
    most = power;
    name = element.name;
  }
  int coordinate = positions_;
  for (int c = positions_; c < size_; ++c)
    if (std::abs(mode[c]) > std::abs(mode[coordinate]) * (1.0 + 1e-3)) coordinate = c;
  return name + ", moving " + coordinateName(coordinate);
}

MatrixXd stepMap(IntegratorKind kind, const MatrixXd& J, int positions, double dt, double substeps) {
  switch (kind) {
    case IntegratorKind::kExplicitEuler: return polynomial(dt * J, {1.0, 1.0});
    case IntegratorKind::kSemiImplicitEuler: return semiImplicitMap(J, positions, dt);
    case IntegratorKind::kRk4: return polynomial(dt * J, {1.0, 1.0, 1.0 / 2.0, 1.0 / 6.0, 1.0 / 24.0});
    case IntegratorKind::kRk4Events: {
      const MatrixXd part = stepMap(IntegratorKind::kRk4, J, positions, dt / substeps, 1.0);
      MatrixXd map = part;
      for (int i = 1; i < static_cast<int>(substeps); ++i) map = part * map;
      return map;
    }
    case IntegratorKind::kDormandPrince:
      return polynomial(dt * J, {1.0, 1.0, 1.0 / 2.0, 1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0, 1.0 / 600.0});
    case IntegratorKind::kLinearlyImplicit: return linearlyImplicitMap(J, positions, dt);
  }
  return MatrixXd::Identity(J.rows(), J.cols());
}

}  // namespace ellipsoid_vehicle_sim
