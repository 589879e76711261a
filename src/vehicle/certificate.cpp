#include "ellipsoid_vehicle_sim/vehicle/certificate.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <limits>

#include "ellipsoid_vehicle_sim/dynamics/embedded_pair.h"
#include "ellipsoid_vehicle_sim/vehicle/linearisation.h"

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

// linearly_implicit holds every linear motion. Through touch-downs its steps are far from linear: beyond this it has been
// seen to gain energy [s].
constexpr double kLongestImplicitStep = 0.02;

Complex rk4Factor(Complex z) { return 1.0 + z * (1.0 + z * (0.5 + z * (1.0 / 6.0 + z / 24.0))); }
Complex dormandPrinceFactor(Complex z) {
  return 1.0 + z * (1.0 + z * (0.5 + z * (1.0 / 6.0 + z * (1.0 / 24.0 + z * (1.0 / 120.0 + z / 600.0)))));
}

// Largest h for which the method damps exp(h direction), |direction| = 1, at every smaller h too.
double limitAlong(Complex (*factor)(Complex), Complex direction) {
  double low = 0.0;
  constexpr double kScan = 0.005;
  for (double h = kScan; h < 4.0; h += kScan) {
    if (std::abs(factor(h * direction)) > 1.0 + 1e-13) {
      double high = h;
      for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        (std::abs(factor(middle * direction)) > 1.0 + 1e-13 ? high : low) = middle;
      }
      return low;
    }
    low = h;
  }
  return low;
}

// Largest step with which an explicit method holds exp(direction omega t) with omega = 1.
double explicitLimit(IntegratorKind kind, Complex direction, double substeps) {
  switch (kind) {
    case IntegratorKind::kExplicitEuler: return -2.0 * direction.real();
    case IntegratorKind::kRk4: return limitAlong(rk4Factor, direction);
    case IntegratorKind::kRk4Events: return substeps * limitAlong(rk4Factor, direction);
    case IntegratorKind::kDormandPrince: return limitAlong(dormandPrinceFactor, direction) / dormand_prince::kSmallestPart;
    default: return 0.0;
  }
}

constexpr IntegratorKind kExplicitMethods[] = {IntegratorKind::kExplicitEuler, IntegratorKind::kRk4,
                                               IntegratorKind::kRk4Events, IntegratorKind::kDormandPrince};

// `growth`: how fast the motion itself grows where it does (a vehicle about to tip) [1/s]; that is not the step's fault.
bool mapHolds(IntegratorKind kind, const MatrixXd& J, int positions, double growth, double dt) {
  const Eigen::VectorXcd values = stepMap(kind, J, positions, dt, 1.0).eigenvalues();
  for (Eigen::Index i = 0; i < values.size(); ++i) {  // Eigen 3.3 has no iterators
    const Complex& value = values[i];
    if (std::abs(value - 1.0) < kNeutralRate * dt) continue;
    if (std::abs(value) > std::exp(1.1 * growth * dt) + kGrowthTolerance) return false;
  }
  return true;
}

// Of semi-implicit Euler. Steps far below the fastest mode's time are not tried: every mode is followed there.
double semiImplicitLimit(const MatrixXd& J, int positions, double growth, double fastest) {
  constexpr IntegratorKind kind = IntegratorKind::kSemiImplicitEuler;
  double low = 0.0;
  constexpr double kRatio = 1.25;
  const double first = std::clamp(0.05 / std::max(fastest, 1.0), 1e-9, kLongestStep);
  for (double dt = first; dt <= kLongestStep * kRatio; dt *= kRatio) {
    if (mapHolds(kind, J, positions, growth, dt)) {
      low = dt;
      continue;
    }
    double high = dt;
    for (int i = 0; i < 12; ++i) {
      const double middle = 0.5 * (low + high);
      (mapHolds(kind, J, positions, growth, middle) ? low : high) = middle;
    }
    return low;
  }
  return std::min(low, kLongestStep);
}

// Of linearly_implicit: from above, for as a rule it holds everything.
double linearlyImplicitLimit(const MatrixXd& J, int positions, double growth) {
  for (double dt = kLongestImplicitStep; dt > 1e-7; dt *= 0.8)
    if (mapHolds(IntegratorKind::kLinearlyImplicit, J, positions, growth, dt)) return dt;
  return 0.0;
}

std::string describe(const StabilityMode& mode) {
  char text[160];
  std::snprintf(text, sizeof text, "%s, %.4g rad/s, damping ratio %.3g", mode.name.c_str(), mode.frequency, mode.damping_ratio);
  return text;
}

// A mode with what each integrator holds of it when it is an oscillator of its own.
StabilityMode modeOf(Complex value, double substeps) {
  StabilityMode mode;
  mode.frequency = std::abs(value);
  mode.damping_ratio = -value.real() / mode.frequency;
  const double zeta = std::clamp(mode.damping_ratio, 0.0, 1.0);
  for (int i = 0; i < kIntegratorCount; ++i) {
    const auto kind = static_cast<IntegratorKind>(i);
    const bool euler = kind == IntegratorKind::kSemiImplicitEuler, implicit = kind == IntegratorKind::kLinearlyImplicit;
    double h = explicitLimit(kind, value / mode.frequency, substeps);
    // A real mode of semi-implicit Euler is one of a pair that the map as a whole decides on; alone, it is Euler's.
    if (euler) h = value.imag() == 0.0 ? 2.0 : oscillatorLimit(kind, zeta);
    mode.largest_step[i] = std::min(implicit ? kLongestImplicitStep : h / mode.frequency, kLongestStep);
  }
  return mode;
}

// Bounds of one state of the drive (braked, or driving) worked into the certificate.
void bound(const MatrixXd& J, const Linearisation& linearisation, double substeps, bool braked,
           StabilityCertificate& certificate) {
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
    StabilityMode mode = modeOf(value, substeps);
    mode.name = linearisation.modeName(solver.eigenvectors().col(i));
    mode.braked = braked;
    certificate.modes.push_back(mode);
    // A mode that grows by itself (a vehicle about to tip) is physics, not the step's fault.
    if (value.real() > 0.0) {
      growth = std::max(growth, value.real());
      continue;
    }
    for (const IntegratorKind kind : kExplicitMethods) {
      const auto m = static_cast<std::size_t>(kind);
      if (mode.largest_step[m] >= limit[m]) continue;
      limit[m] = mode.largest_step[m];
      worst[m] = describe(mode);
    }
    if (rate > fastest) {
      fastest = rate;
      worst[static_cast<std::size_t>(IntegratorKind::kSemiImplicitEuler)] = describe(mode);
      worst[static_cast<std::size_t>(IntegratorKind::kLinearlyImplicit)] = describe(mode);
    }
  }
  for (const IntegratorKind kind : {IntegratorKind::kSemiImplicitEuler, IntegratorKind::kLinearlyImplicit}) {
    const bool implicit = kind == IntegratorKind::kLinearlyImplicit;
    limit[static_cast<std::size_t>(kind)] =
        implicit ? linearlyImplicitLimit(J, linearisation.positions(), growth)
                 : semiImplicitLimit(J, linearisation.positions(), growth, fastest);
    if (implicit && limit[static_cast<std::size_t>(kind)] == kLongestImplicitStep)
      worst[static_cast<std::size_t>(kind)] = "touch-downs within a step";
  }
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
    case IntegratorKind::kRk4Events: return "rk4_events";
    case IntegratorKind::kDormandPrince: return "dormand_prince";
    case IntegratorKind::kLinearlyImplicit: return "linearly_implicit";
  }
  return "unknown";
}

double oscillatorLimit(IntegratorKind kind, double damping_ratio, double substeps) {
  const double z = damping_ratio;
  switch (kind) {
    case IntegratorKind::kExplicitEuler: return z <= 1.0 ? 2.0 * z : 2.0 / (z + std::sqrt(z * z - 1.0));
    case IntegratorKind::kSemiImplicitEuler: return 2.0 / (std::sqrt(1.0 + z * z) + z);
    case IntegratorKind::kLinearlyImplicit: return std::numeric_limits<double>::infinity();
    default: break;
  }
  if (z >= 1.0) return explicitLimit(kind, {-1.0, 0.0}, substeps) / (z + std::sqrt(z * z - 1.0));
  return explicitLimit(kind, {-z, std::sqrt(1.0 - z * z)}, substeps);
}

StabilityCertificate certify(const VehicleModel& model, VehicleDynamics& dynamics, const VehicleState& rest,
                             double substeps) {
  StabilityCertificate certificate;
  certificate.from_rest_pose = true;
  certificate.largest_step.fill(kLongestStep);
  for (const DriveState::Mode mode : {DriveState::Mode::kBrake, DriveState::Mode::kDrive}) {
    VehicleState state = rest;
    state.drive.mode = mode;
    if (mode == DriveState::Mode::kDrive) std::fill(state.motion.stretch.begin(), state.motion.stretch.end(), 0.0);
    Linearisation linearisation(model, dynamics, state);
    const MatrixXd& J = linearisation.jacobian();
    bound(J, linearisation, substeps, mode == DriveState::Mode::kBrake, certificate);
  }
  std::sort(certificate.modes.begin(), certificate.modes.end(),
            [](const StabilityMode& a, const StabilityMode& b) { return a.frequency > b.frequency; });
  return certificate;
}

std::vector<std::string> describeModes(const StabilityCertificate& certificate, double dt, IntegratorKind kind,
                                       std::size_t most) {
  std::vector<std::string> lines;
  std::vector<const StabilityMode*> told;
  for (const StabilityMode& mode : certificate.modes) {
    // Braked and driving, and left and right, have most modes in common.
    const bool known = std::any_of(told.begin(), told.end(), [&mode](const StabilityMode* other) {
      return std::abs(other->frequency - mode.frequency) < 0.01 * mode.frequency &&
             std::abs(other->damping_ratio - mode.damping_ratio) < 0.01;
    });
    if (known || told.size() >= most) continue;
    told.push_back(&mode);
    std::string steps;
    for (int i = 0; i < kIntegratorCount; ++i) {
      char step[60];
      std::snprintf(step, sizeof step, "%s%s %.3g", i > 0 ? ", " : "", toString(static_cast<IntegratorKind>(i)),
                    1e3 * mode.largest_step[i]);
      steps += step;
    }
    char line[400];
    std::snprintf(line, sizeof line, "mode: %s: %.4g rad/s (%.3g Hz), damping ratio %.3g; margin %.3g; steps in ms: ",
                  mode.name.c_str(), mode.frequency, mode.frequency / (2.0 * M_PI), mode.damping_ratio,
                  mode.largest_step[static_cast<std::size_t>(kind)] / dt);
    lines.push_back(line + steps);
  }
  return lines;
}

StabilityCertificate certifyContactsAlone(const VehicleModel& model, double substeps) {
  StabilityCertificate certificate;
  certificate.largest_step.fill(kLongestStep);
  certificate.largest_step[static_cast<std::size_t>(IntegratorKind::kLinearlyImplicit)] = kLongestImplicitStep;
  certificate.worst[static_cast<std::size_t>(IntegratorKind::kLinearlyImplicit)] = "touch-downs within a step";
  for (const ModelEllipsoid& ellipsoid : model.ellipsoids) {
    const ContactLaw& law = ellipsoid.law;
    const auto add = [&](const std::string& name, double k, double c, double m) {
      if (!(k > 0.0) || !(m > 0.0)) return;
      const double omega = std::sqrt(k / m);
      StabilityMode mode;
      mode.name = name;
      mode.frequency = omega;
      mode.damping_ratio = c / (2.0 * m * omega);
      for (int i = 0; i < kIntegratorCount; ++i) {
        const double dt = oscillatorLimit(static_cast<IntegratorKind>(i), mode.damping_ratio, substeps) / omega;
        mode.largest_step[i] = std::min(dt, kLongestStep);
        if (dt >= certificate.largest_step[i]) continue;
        certificate.largest_step[i] = dt;
        certificate.worst[i] = describe(mode);
      }
      certificate.modes.push_back(mode);
    };
    add("contact of '" + ellipsoid.name + "'", law.stiffness, law.damping, ellipsoid.normal_mass);
    if (law.mode != FrictionMode::kViscous)
      add("friction of '" + ellipsoid.name + "'", law.tangential_stiffness, law.tangential_damping, ellipsoid.tangential_mass);
  }
  return certificate;
}

}  // namespace ellipsoid_vehicle_sim
