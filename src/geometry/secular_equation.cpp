#include "ellipsoid_vehicle_sim/geometry/secular_equation.h"

#include <limits>

namespace ellipsoid_vehicle_sim {
namespace {

/// Searches for the root next to pole p_i = r_i^2 on one of its sides, where lambda = p_i + side * x, x > 0.
/// Q(lambda) = sum_j (a_j / (p_j - lambda))^2 has infinite poles and is convex between them, so every gap between
/// neighbouring poles holds no root or two, and each outer side one. Every term alone is at most 1 at a root, which
/// keeps lambda |a_j| away from every pole; from that bound Newton's steps go downhill to the root and, Q being
/// convex, never pass it.
struct RootSearch {
  const std::array<double, 3>& t;
  const std::array<double, 3>& r;

  /// p_j - p_i, seen along `side`.
  double gap(int i, int j, double side) const { return side * (r[j] - r[i]) * (r[j] + r[i]); }

  void addRoot(int i, double side, PushDirections& found) const {
    double a[3], g[3];
    double x = 0.0, end = std::numeric_limits<double>::infinity();
    for (int j = 0; j < 3; ++j) {
      a[j] = std::abs(r[j] * t[j]);
      g[j] = gap(i, j, side);
      if (g[j] <= 0.0) {
        x = std::max(x, a[j] + g[j]);
      } else {
        end = std::min(end, g[j] - a[j]);
      }
    }
    for (int step = 0; step < kMaxRootSteps; ++step) {
      if (!(x < end)) return;
      double q = 0.0, half_slope = 0.0;
      for (int j = 0; j < 3; ++j) {
        const double inverse = 1.0 / (g[j] - x);
        const double w = a[j] * inverse;
        q += w * w;
        half_slope += w * w * inverse;
      }
      if (!(q > 1.0)) break;
      // Uphill again and still above 1: the gap holds no root.
      if (!(half_slope < 0.0)) return;
      const double dx = 0.5 * (q - 1.0) / -half_slope;
      if (dx <= kSecularStep * x) break;
      x += dx;
    }
    if (!(r[i] * r[i] + side * x > 0.0)) return;
    double u[3];
    for (int j = 0; j < 3; ++j) u[j] = -t[j] / (side * (g[j] - x));
    const Vec3 direction{u[0], u[1], u[2]};
    found.add((1.0 / norm(direction)) * direction);
  }

  /// Convergence is quadratic but for two roots that merge, where every step halves the distance to them: 1e-16 after
  /// 53.
  static constexpr int kMaxRootSteps = 60;
};

}  // namespace

PushDirections pushDirections(const SupportProblem<3>& problem) {
  PushDirections found;
  const RootSearch search{problem.t, problem.r};
  for (int i = 0; i < 3; ++i) {
    // Of equal poles only the first is a pole of its own; the gap between them is empty.
    bool repeated = false;
    for (int j = 0; j < i; ++j) repeated = repeated || problem.r[j] == problem.r[i];
    if (repeated) continue;
    search.addRoot(i, -1.0, found);
    search.addRoot(i, 1.0, found);
  }
  return found;
}

}  // namespace ellipsoid_vehicle_sim
