#include "ellipsoid_vehicle_sim/vehicle/accuracy.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace ellipsoid_vehicle_sim {
namespace {

constexpr double kFast = 1e-2, kBalanced = 1e-3, kExact = 1e-5;
constexpr double kLeast = 1e-9, kMost = 1.0;
// Of the step that the certificate allows.
constexpr double kMargin = 0.9;
constexpr double kLongestStep = 0.02, kShortestStep = 1e-6;
// Where nothing is so exact as asked, what is nearly as exact as the best may be far cheaper [-].
constexpr double kNearly = 3.0;

const AccuracyPoint kCurves[] = {
#include "accuracy_curves.inc"
};

// The largest of 1, 2, 2.5, 4, 5 (below a millisecond 8, too) times a power of ten that is not above the step: all divide
// the 20 ms that state is published in.
double roundStep(double step) {
  double best = kShortestStep;
  for (double decade = kShortestStep; decade < 0.1; decade *= 10.0)
    for (const double mantissa : {1.0, 2.0, 2.5, 4.0, 5.0, 8.0}) {
      if (mantissa == 8.0 && decade > 0.5e-3) continue;
      if (mantissa * decade <= step * (1.0 + 1e-9)) best = std::max(best, mantissa * decade);
    }
  // Without the products' last digits.
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", best);
  return std::strtod(text, nullptr);
}

IntegratorKind kindOf(const std::string& name) {
  for (int i = 0; i < kIntegratorCount; ++i)
    if (name == toString(static_cast<IntegratorKind>(i))) return static_cast<IntegratorKind>(i);
  return IntegratorKind::kRk4;
}

// That the certificate allows: of rk4_events what it says of RK4, times the sub-steps.
double largestStep(const StabilityCertificate& certificate, IntegratorKind integrator, double substeps) {
  if (substeps == 0.0) return certificate.largestStep(integrator);
  return substeps * certificate.largestStep(IntegratorKind::kRk4);
}

double fastestMode(const StabilityCertificate& certificate) {
  double fastest = 0.0;
  for (const StabilityMode& mode : certificate.modes) fastest = std::max(fastest, mode.frequency);
  return fastest;
}

}  // namespace

const std::vector<AccuracyPoint>& accuracyCurves() {
  static const std::vector<AccuracyPoint> curves(std::begin(kCurves), std::end(kCurves));
  return curves;
}

std::optional<double> accuracyTarget(const std::string& accuracy) {
  if (accuracy == "fast") return kFast;
  if (accuracy == "balanced") return kBalanced;
  if (accuracy == "exact") return kExact;
  char* end = nullptr;
  const double number = std::strtod(accuracy.c_str(), &end);
  if (accuracy.empty() || *end != '\0' || !(number >= kLeast && number <= kMost)) return std::nullopt;
  return number;
}

AccuracyChoice chooseAccuracy(double target, SceneKind kind, const StabilityCertificate& certificate,
                              const std::vector<AccuracyPoint>& curves) {
  const double fastest = fastestMode(certificate);
  // The cheapest whose error is at most `error`; cost infinite without any.
  struct Offer {
    AccuracyChoice choice;
    double cost = INFINITY;
    const char* bound = "";
  };
  double least_error = INFINITY;
  const auto cheapest = [&](double error) {
    Offer best;
    for (const AccuracyPoint& point : curves) {
      if (point.kind != kind) continue;
      const IntegratorKind integrator = kindOf(point.integrator);
      const double held = kMargin * largestStep(certificate, integrator, point.substeps);
      const double asked = fastest > 0.0 ? point.omega_dt / fastest : kLongestStep;
      const double dt = roundStep(std::min({asked, held, kLongestStep}));
      if (dt > held) continue;
      least_error = std::min(least_error, point.error);
      const double cost = point.tick_cost / dt;
      if (point.error > error || cost >= best.cost) continue;
      best.cost = cost;
      best.choice = {integrator, dt, point.substeps, point.error, true, ""};
      best.bound = asked <= held ? "by its measured error" : "by the stability certificate";
    }
    return best;
  };
  Offer best = cheapest(target);
  if (!std::isfinite(best.cost)) {
    best = cheapest(kNearly * least_error);
    best.choice.reached = false;
  }
  char text[360], substeps[60] = "";
  if (best.choice.substeps > 0.0) std::snprintf(substeps, sizeof substeps, " with %g contact sub-steps", best.choice.substeps);
  std::snprintf(text, sizeof text,
                "%s%s at %.4g s, the step bounded %s (fastest mode %.4g rad/s); scenes measured of this kind (%s) stay "
                "below %.2g m per metre%s",
                toString(best.choice.integrator), substeps, best.choice.dt, best.bound, fastest, toString(kind),
                best.choice.expected_error, best.choice.reached ? "" : ": no measured setting reaches what was asked, this is nearly the most exact");
  best.choice.reason = text;
  return best.choice;
}

}  // namespace ellipsoid_vehicle_sim
