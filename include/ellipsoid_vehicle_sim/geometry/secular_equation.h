#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "ellipsoid_vehicle_sim/geometry/small_vector.h"

namespace ellipsoid_vehicle_sim {

/// Local minima of delta(u) = u·t + h(u) over the unit vectors u, in N = 2 or 3 dimensions: the pushes that clear a
/// point. t is the point, seen from the ellipsoid's centre along its axes; r are the semi-axes, the smallest (r_k)
/// last; lengths are divided by the largest semi-axis of the body, so that r is at most 1.
///
/// With g_i = r_i^2 - r_k^2 and a_i = r_i t_i, delta is stationary at u_i ~ -t_i / (r_i^2 - lambda), where lambda is a
/// root of sum_i (a_i / (r_i^2 - lambda))^2 = 1. Of its up to 2 N roots only two belong to minima, one on each side of
/// the thin axis: `nearMinimum` and `farMinimum`.
/// Every t_i must differ from zero (see `withoutZero`): a point on a plane of symmetry has two mirror images for an
/// answer, and the sign of a vanishing coordinate tells them apart.
/// Source: [ContactDefinition] section 2; the third-order step of `nearMinimum` is our own.
template <int N>
struct SupportProblem {
  std::array<double, N> t;
  std::array<double, N> r;
};

/// Steps after which the iterations give up with what they have; 27 is the most one was ever seen to take (far, where
/// two roots merge).
constexpr int kMaxSecularSteps = 40;
/// A relative step below this no longer changes a double by more than its last digits.
constexpr double kSecularStep = 4e-16;
/// Stands for a coordinate of zero, divided by the largest semi-axis: its cube must not underflow.
constexpr double kSecularZero = 1e-80;

/// t, or a tiny number if t vanishes, of the sign that puts the near minimum on the side of n.
inline double withoutZero(double t, double n) {
  return std::abs(t) < kSecularZero ? -std::copysign(kSecularZero, n) : t;
}

/// Where t lies in the ellipsoid: 0 at the centre, 1 on the surface, squared.
template <int N>
double gaugeSquared(const SupportProblem<N>& problem) {
  double sum = 0.0;
  for (int i = 0; i < N; ++i) {
    const double w = problem.t[i] / problem.r[i];
    sum += w * w;
  }
  return sum;
}

/// A lower bound on the square of every stationary delta >= 0 of a point inside, without an iteration: the value of
/// the dual problem to "nearest point of the surface" at lambda = r_k^2 / 2 (its best lambda would give the near
/// depth itself).
template <int N>
double leastDepthSquared(const SupportProblem<N>& problem) {
  const double lambda = 0.5 * problem.r[N - 1] * problem.r[N - 1];
  double sum = 1.0;
  for (int i = 0; i < N; ++i) sum -= problem.t[i] * problem.t[i] / (problem.r[i] * problem.r[i] - lambda);
  return lambda * sum;
}

/// The least of all delta(u): lambda = r_k^2 - x < r_k^2. It always exists. u is not of unit length.
template <int N>
std::array<double, N> nearMinimum(const SupportProblem<N>& problem) {
  constexpr int k = N - 1;
  const auto& t = problem.t;
  const auto& r = problem.r;
  double a[N], g[N];
  // Every term alone is at most 1 at the root, which bounds x from below.
  double x = 0.0;
  for (int i = 0; i < N; ++i) {
    a[i] = r[i] * t[i];
    g[i] = (r[i] - r[k]) * (r[i] + r[k]);
    x = std::max(x, std::abs(a[i]) - g[i]);
  }
  // 1/sqrt(Q) is concave and grows: Newton's steps on 1/sqrt(Q) = 1 from below never pass the root, and one from above
  // lands below it. Each is followed by the share of its curvature (Chebyshev's third order), where that is small.
  double low = x;
  // lambda = 0 is the root of a point on the surface; that of one just inside is near. Deep inside it tells nothing.
  constexpr double kDeep = 0.25;
  x = std::max(x, r[k] * r[k]);
  for (int step = 0; step < kMaxSecularSteps; ++step) {
    double q = 0.0, slope = 0.0, curvature = 0.0;
    for (int i = 0; i < N; ++i) {
      const double inverse = 1.0 / (g[i] + x);
      const double w = a[i] * inverse;
      const double ww = w * w;
      q += ww;
      slope += ww * inverse;
      curvature += ww * inverse * inverse;
    }
    if (step == 0 && q < kDeep) {
      x = low;
      continue;
    }
    const double inverse_slope = 1.0 / slope;
    const double dx = q * (std::sqrt(q) - 1.0) * inverse_slope;
    if (!(std::abs(dx) > kSecularStep * x)) break;
    const double bend = 1.5 * (curvature * inverse_slope - slope / q) * dx;
    if (dx > 0.0) low = x + dx;
    const double newton = x + dx;
    const bool is_straight = std::abs(bend) < 0.3 && newton >= low;
    x = std::max(low, is_straight ? newton + bend * dx : newton);
    // The next step would be of the order bend^2 dx.
    if (is_straight && bend * bend * std::abs(dx) < 1e-2 * kSecularStep * x) break;
  }
  std::array<double, N> u;
  for (int i = 0; i < N; ++i) u[i] = -t[i] / (g[i] + x);
  return u;
}

/// The other minimum, lambda = r_k^2 + x, across the thin axis from the near one; none when t lies outside the evolute.
/// u is not of unit length.
template <int N>
std::optional<std::array<double, N>> farMinimum(const SupportProblem<N>& problem) {
  constexpr int k = N - 1;
  const auto& t = problem.t;
  const auto& r = problem.r;
  double a[k], g[k];
  double rho = 0.0;
  for (int i = 0; i < k; ++i) {
    a[i] = r[i] * t[i];
    g[i] = (r[i] - r[k]) * (r[i] + r[k]);
    if (!(g[i] > 0.0) || !(std::abs(a[i]) < g[i])) return std::nullopt;
    rho += (a[i] / g[i]) * (a[i] / g[i]);
  }
  if (!(rho < 1.0)) return std::nullopt;
  const double a_k = std::abs(r[k] * t[k]);

  // y(x) = x sqrt(1 - rho(x)) - |a_k| is concave: Newton's steps from x = 0 climb to its first root, or pass its top
  // below zero, and then there is none.
  double x = a_k / std::sqrt(1.0 - rho);
  double root = 0.0;
  for (int step = 0;; ++step) {
    double half_slope = 0.0;
    rho = 0.0;
    for (int i = 0; i < k; ++i) {
      if (!(x < g[i])) return std::nullopt;
      const double inverse = 1.0 / (g[i] - x);
      const double w = a[i] * inverse;
      rho += w * w;
      half_slope += w * w * inverse;
    }
    if (!(rho < 1.0)) return std::nullopt;
    root = std::sqrt(1.0 - rho);
    const double y = x * root - a_k;
    if (y >= 0.0 || step == kMaxSecularSteps) break;
    const double dy = root - x * half_slope / root;
    if (!(dy > 0.0)) return std::nullopt;
    const double dx = -y / dy;
    if (dx <= kSecularStep * x) break;
    x += dx;
  }
  std::array<double, N> u;
  for (int i = 0; i < k; ++i) u[i] = -t[i] / (g[i] - x);
  u[k] = std::copysign(root / r[k], t[k]);
  return u;
}

/// Up to six directions, without allocation.
class PushDirections {
 public:
  void add(const Vec3& u) { u_[size_++] = u; }
  const Vec3* begin() const { return u_.data(); }
  const Vec3* end() const { return u_.data() + size_; }

 private:
  std::array<Vec3, 6> u_;
  int size_ = 0;
};

/// Every unit direction at which delta is stationary and lambda > 0 (lambda < 0 would be a pull), in any order of the
/// semi-axes.
PushDirections pushDirections(const SupportProblem<3>& problem);

}  // namespace ellipsoid_vehicle_sim
