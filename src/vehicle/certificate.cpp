#include "ellipsoid_vehicle_sim/vehicle/certificate.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Complex = std::complex<double>;

// Modes slower than this are rigid motions on the plane, whose eigenvalue is zero but for the differences' rounding [rad/s].
constexpr double kNeutralRate = 2.0;
// What rounding of the differences may add to an eigenvalue's modulus.
constexpr double kGrowthTolerance = 1e-6;
// Steps beyond this are not asked for [s].
constexpr double kLongestStep = 0.1;

Complex rk4Factor(Complex z) { return 1.0 + z * (1.0 + z * (0.5 + z * (1.0 / 6.0 + z / 24.0))); }

// Largest h for which RK4 damps exp(h direction), |direction| = 1, at every smaller h too.
double rk4Limit(Complex direction) {
  double low = 0.0;
  constexpr double kScan = 0.005;
  for (double h = kScan; h < 4.0; h += kScan) {
    if (std::abs(rk4Factor(h * direction)) > 1.0 + 1e-13) {
      double high = h;
      for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        (std::abs(rk4Factor(middle * direction)) > 1.0 + 1e-13 ? high : low) = middle;
      }
      return low;
    }
    low = h;
  }
  return low;
}

// Tangent coordinates of a vehicle at rest: position-like first, velocities last.
class Linearisation {
 public:
  Linearisation(const VehicleModel& model, VehicleDynamics& dynamics, const VehicleState& rest)
      : model_(model), dynamics_(dynamics), rest_(rest), rate_(dynamics.makeRate()) {
    joints_ = model.dynamic_joints.size();
    for (std::size_t e = 0; e < rest.memory.size(); ++e)
      for (int s = 0; s < rest.memory[e].count; ++s) slots_.push_back({static_cast<int>(e), s});
    positions_ = 6 + 2 * static_cast<int>(joints_) + 3 * static_cast<int>(slots_.size());
    size_ = positions_ + 6 + static_cast<int>(joints_);
  }

  int size() const { return size_; }
  int positions() const { return positions_; }

  std::string name(int i) const {
    static const char* kBase[] = {"x", "y", "z", "roll", "pitch", "yaw"};
    const int n = static_cast<int>(joints_);
    if (i >= positions_) i -= positions_;
    if (i < 6) return std::string("base ") + kBase[i];
    i -= 6;
    if (i < 2 * n) return "joint '" + model_.description.joints[model_.dynamic_joints[i % n].description].name + "'";
    return "friction of '" + model_.ellipsoids[slots_[(i - 2 * n) / 3].first].name + "'";
  }

  // Central differences of the rate function.
  MatrixXd jacobian() {
    MatrixXd J(size_, size_);
    for (int i = 0; i < size_; ++i) {
      // Steps small against every contact's sag and large against rounding.
      const double h = i < positions_ ? 1e-7 : 1e-6;
      J.col(i) = (rateAt(i, h) - rateAt(i, -h)) / (2.0 * h);
    }
    return J;
  }

 private:
  VectorXd rateAt(int coordinate, double h) {
    MotionRate direction = dynamics_.makeRate();
    component(direction, coordinate) = 1.0;
    Motion x = rest_.motion;
    retract(rest_.motion, h, direction, x);
    dynamics_.beginStep(rest_, 0.0);
    // Not the start of the step: the contacts are to be found anew.
    dynamics_.rate(x, 1.0, rate_);
    VectorXd result(size_);
    for (int i = 0; i < size_; ++i) result[i] = component(rate_, i);
    return result;
  }

  double& component(MotionRate& k, int i) {
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

  const VehicleModel& model_;
  VehicleDynamics& dynamics_;
  const VehicleState& rest_;
  MotionRate rate_;
  std::size_t joints_ = 0;
  std::vector<std::pair<int, int>> slots_;
  int positions_ = 0, size_ = 0;
};

// One step of semi-implicit Euler, linearised: velocities first, positions with the new ones.
MatrixXd semiImplicitMap(const MatrixXd& J, int positions, double dt) {
  const int n = static_cast<int>(J.rows());
  const int velocities = n - positions;
  MatrixXd map = MatrixXd::Identity(n, n);
  map.bottomRows(velocities) += dt * J.bottomRows(velocities);
  map.topLeftCorner(positions, positions) += dt * J.topLeftCorner(positions, positions);
  map.topRows(positions) += dt * J.topRightCorner(positions, velocities) * map.bottomRows(velocities);
  return map;
}

// `growth`: how fast the motion itself grows where it does (a vehicle about to tip) [1/s]; that is not the step's fault.
bool semiImplicitHolds(const MatrixXd& J, int positions, double growth, double dt) {
  const Eigen::VectorXcd values = semiImplicitMap(J, positions, dt).eigenvalues();
  for (const Complex& value : values) {
    if (std::abs(value - 1.0) < kNeutralRate * dt) continue;
    if (std::abs(value) > std::exp(1.1 * growth * dt) + kGrowthTolerance) return false;
  }
  return true;
}

double semiImplicitLimit(const MatrixXd& J, int positions, double growth) {
  double low = 0.0;
  constexpr double kRatio = 1.25;
  for (double dt = 1e-7; dt <= kLongestStep * kRatio; dt *= kRatio) {
    if (semiImplicitHolds(J, positions, growth, dt)) {
      low = dt;
      continue;
    }
    double high = dt;
    for (int i = 0; i < 12; ++i) {
      const double middle = 0.5 * (low + high);
      (semiImplicitHolds(J, positions, growth, middle) ? low : high) = middle;
    }
    return low;
  }
  return std::min(low, kLongestStep);
}

std::string describe(const StabilityMode& mode) {
  char text[160];
  std::snprintf(text, sizeof text, "%s, %.4g rad/s, damping ratio %.3g", mode.name.c_str(), mode.frequency, mode.damping_ratio);
  return text;
}

// Bounds of one state of the drive (braked, or driving) worked into the certificate.
void bound(const MatrixXd& J, const Linearisation& linearisation, StabilityCertificate& certificate) {
  const Eigen::EigenSolver<MatrixXd> solver(J);
  std::array<double, kIntegratorCount> limit;
  limit.fill(kLongestStep);
  std::array<std::string, kIntegratorCount> worst;
  double fastest = 0.0, growth = 0.0;
  for (int i = 0; i < J.rows(); ++i) {
    Complex value = solver.eigenvalues()[i];
    const double rate = std::abs(value);
    if (rate < kNeutralRate || value.imag() < 0.0) continue;
    // Rounding must not turn an undamped mode into a growing one.
    if (std::abs(value.real()) < 1e-7 * rate) value = {0.0, value.imag()};
    StabilityMode mode;
    mode.frequency = rate;
    mode.damping_ratio = -value.real() / rate;
    // Coordinates of the base, joints and anchors have different units: compare speeds only, which dominate fast modes.
    double best = -1.0;
    int coordinate = linearisation.positions();
    for (int c = linearisation.positions(); c < J.rows(); ++c)
      if (std::abs(solver.eigenvectors()(c, i)) > best) {
        best = std::abs(solver.eigenvectors()(c, i));
        coordinate = c;
      }
    mode.name = linearisation.name(coordinate);
    certificate.modes.push_back(mode);
    // A mode that grows by itself (a vehicle about to tip) is physics, not the step's fault.
    if (value.real() > 0.0) {
      growth = std::max(growth, value.real());
      continue;
    }
    const double explicit_limit = -2.0 * value.real() / (rate * rate);
    const double rk4 = rk4Limit(value / rate) / rate;
    if (explicit_limit < limit[0]) {
      limit[0] = explicit_limit;
      worst[0] = describe(mode);
    }
    if (rk4 < limit[2]) {
      limit[2] = rk4;
      worst[2] = describe(mode);
    }
    if (rate > fastest) {
      fastest = rate;
      worst[1] = describe(mode);
    }
  }
  limit[1] = semiImplicitLimit(J, linearisation.positions(), growth);
  for (int i = 0; i < kIntegratorCount; ++i)
    if (limit[i] < certificate.largest_step[i] || certificate.worst[i].empty()) {
      certificate.largest_step[i] = std::min(limit[i], certificate.largest_step[i]);
      certificate.worst[i] = worst[i];
    }
}

}  // namespace

const char* toString(IntegratorKind kind) {
  switch (kind) {
    case IntegratorKind::kExplicitEuler: return "explicit_euler";
    case IntegratorKind::kSemiImplicitEuler: return "semi_implicit_euler";
    case IntegratorKind::kRk4: return "rk4";
  }
  return "unknown";
}

double oscillatorLimit(IntegratorKind kind, double damping_ratio) {
  const double z = damping_ratio;
  switch (kind) {
    case IntegratorKind::kExplicitEuler: return z <= 1.0 ? 2.0 * z : 2.0 / (z + std::sqrt(z * z - 1.0));
    case IntegratorKind::kSemiImplicitEuler: return 2.0 / (std::sqrt(1.0 + z * z) + z);
    case IntegratorKind::kRk4: break;
  }
  if (z >= 1.0) return rk4Limit({-1.0, 0.0}) / (z + std::sqrt(z * z - 1.0));
  return rk4Limit({-z, std::sqrt(1.0 - z * z)});
}

StabilityCertificate certify(const VehicleModel& model, VehicleDynamics& dynamics, const VehicleState& rest) {
  StabilityCertificate certificate;
  certificate.from_rest_pose = true;
  certificate.largest_step.fill(kLongestStep);
  for (const DriveState::Mode mode : {DriveState::Mode::kBrake, DriveState::Mode::kDrive}) {
    VehicleState state = rest;
    state.drive.mode = mode;
    if (mode == DriveState::Mode::kDrive) std::fill(state.motion.stretch.begin(), state.motion.stretch.end(), 0.0);
    Linearisation linearisation(model, dynamics, state);
    bound(linearisation.jacobian(), linearisation, certificate);
  }
  std::sort(certificate.modes.begin(), certificate.modes.end(),
            [](const StabilityMode& a, const StabilityMode& b) { return a.frequency > b.frequency; });
  return certificate;
}

StabilityCertificate certifyContactsAlone(const VehicleModel& model) {
  StabilityCertificate certificate;
  certificate.largest_step.fill(kLongestStep);
  for (const ModelEllipsoid& ellipsoid : model.ellipsoids) {
    const ContactLaw& law = ellipsoid.law;
    const auto add = [&](const std::string& name, double k, double c, double m) {
      if (!(k > 0.0) || !(m > 0.0)) return;
      const double omega = std::sqrt(k / m);
      const StabilityMode mode{name, omega, c / (2.0 * m * omega)};
      certificate.modes.push_back(mode);
      for (int i = 0; i < kIntegratorCount; ++i) {
        const double dt = oscillatorLimit(static_cast<IntegratorKind>(i), mode.damping_ratio) / omega;
        if (dt >= certificate.largest_step[i]) continue;
        certificate.largest_step[i] = dt;
        certificate.worst[i] = describe(mode);
      }
    };
    add("contact of '" + ellipsoid.name + "'", law.stiffness, law.damping, ellipsoid.normal_mass);
    if (law.mode != FrictionMode::kViscous)
      add("friction of '" + ellipsoid.name + "'", law.tangential_stiffness, law.tangential_damping, ellipsoid.tangential_mass);
  }
  return certificate;
}

}  // namespace ellipsoid_vehicle_sim
