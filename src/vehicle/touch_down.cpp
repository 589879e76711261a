#include "ellipsoid_vehicle_sim/vehicle/touch_down.h"

#include <algorithm>
#include <cmath>

#include "ellipsoid_vehicle_sim/dynamics/embedded_pair.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr int kPhases = 64;
// A contact lasts half a period, more with damping; later the mass lies still or has gone [in units of 1 / omega].
constexpr double kWatched = 12.0;
// Steps so small add less than a millionth, and would take long to say so.
constexpr double kSmallStep = 0.01;
// Of dormand_prince: a step that cannot be cut is at most two of the smallest.
constexpr double kUncut = 2.0 * dormand_prince::kSmallestPart;

// A mass of one on a spring of one: depth d > 0 presses, v is the speed of the depth.
struct Spring {
  double d, v;
};

double acceleration(double zeta, double d, double v) { return d > 0.0 ? -std::max(0.0, d + 2.0 * zeta * v) : 0.0; }

Spring rk4(Spring s, double h, double zeta) {
  const auto a = [zeta](double d, double v) { return acceleration(zeta, d, v); };
  const double v1 = s.v, a1 = a(s.d, v1);
  const double v2 = s.v + 0.5 * h * a1, a2 = a(s.d + 0.5 * h * v1, v2);
  const double v3 = s.v + 0.5 * h * a2, a3 = a(s.d + 0.5 * h * v2, v3);
  const double v4 = s.v + h * a3, a4 = a(s.d + h * v3, v4);
  return {s.d + h / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4), s.v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)};
}

Spring stepped(IntegratorKind kind, Spring s, double h, double zeta) {
  switch (kind) {
    case IntegratorKind::kExplicitEuler: return {s.d + h * s.v, s.v + h * acceleration(zeta, s.d, s.v)};
    case IntegratorKind::kSemiImplicitEuler: {
      const double v = s.v + h * acceleration(zeta, s.d, s.v);
      return {s.d + h * v, v};
    }
    default: return rk4(s, h, zeta);
  }
}

double gainFrom(IntegratorKind kind, double phase, double h, double zeta) {
  Spring s{-phase * h, 1.0};
  double gain = 0.0;
  for (double t = 0.0; t < kWatched + h; t += h) {
    s = stepped(kind, s, h, zeta);
    const double stored = std::max(0.0, s.d);
    gain = std::max(gain, s.v * s.v + stored * stored - 1.0);
    if (!(gain < kMostTouchDownGain)) return kMostTouchDownGain;
    if (s.d < 0.0 && s.v < 0.0) break;
  }
  return gain;
}

}  // namespace

double touchDownGain(IntegratorKind kind, double omega_dt, double damping_ratio, double substeps) {
  if (kind == IntegratorKind::kLinearlyImplicit) return 0.0;
  double h = omega_dt;
  if (kind == IntegratorKind::kRk4Events) h /= substeps;
  if (kind == IntegratorKind::kDormandPrince) h *= kUncut;
  if (h < kSmallStep) return 0.0;
  if (kind == IntegratorKind::kRk4Events) return gainFrom(kind, 0.0, h, damping_ratio);
  double gain = 0.0;
  for (int i = 0; i < kPhases; ++i)
    gain = std::max(gain, gainFrom(kind, static_cast<double>(i) / kPhases, h, damping_ratio));
  return gain;
}

TouchDown worstTouchDown(const VehicleModel& model, IntegratorKind kind, double dt, double substeps) {
  TouchDown worst;
  for (const ModelEllipsoid& ellipsoid : model.ellipsoids) {
    const ContactLaw& law = ellipsoid.law;
    if (!(law.stiffness > 0.0) || !(ellipsoid.normal_mass > 0.0)) continue;
    const double omega = std::sqrt(law.stiffness / ellipsoid.normal_mass);
    const double gain = touchDownGain(kind, omega * dt, law.damping / (2.0 * ellipsoid.normal_mass * omega), substeps);
    if (worst.ellipsoid.empty() || gain > worst.gain) worst = {gain, ellipsoid.name};
  }
  return worst;
}

}  // namespace ellipsoid_vehicle_sim
