#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "ellipsoid_vehicle_sim/geometry/ellipsoid.h"
#include "ellipsoid_vehicle_sim/geometry/triangle.h"

namespace ellipsoid_vehicle_sim::test {

/// The contact definition by enumeration: every critical point of every edge and corner, each found by bisection
/// between its poles, and what is a minimum told by the second derivative. Slow and plain; a few microseconds, where
/// BruteForceContact takes milliseconds, so that it can judge a million cases. Shares no code with the library but the
/// two value types.
///
/// On the border of a region, or where a minimum merges with a saddle, rounding decides whether a feature counts: such
/// a feature is *doubtful*, and the answers with and without it are both right. `explains` knows them all.
class ExhaustiveContact {
 public:
  ExhaustiveContact(const PosedEllipsoid& ellipsoid, const Triangle& triangle) {
    // Everything in the ellipsoid's axes, from its centre, in parts of its largest semi-axis.
    scale_ = ellipsoid.radii.maxCoeff();
    r_ = ellipsoid.radii / scale_;
    for (std::size_t i = 0; i < 3; ++i) t_[i] = ellipsoid.R_WE.transpose() * (triangle.v[i] - ellipsoid.p_WE) / scale_;
    n_ = ellipsoid.R_WE.transpose() * triangle.nhat_W;
    // A few bits of the direction move the lowest point of a disc or needle by its flatness times as much.
    doubt_ = kDoubt + 1e-14 / r_.minCoeff();
    size_ = std::max(1.0, std::sqrt(longestEdgeSquared(triangle.v)) / scale_);
    solve();
  }

  /// The least depth without any doubtful feature [m]; 0 without contact.
  double depth() const { return std::isfinite(certain_) ? std::max(0.0, certain_) * scale_ : 0.0; }

  /// Is this the depth of an answer, to the tolerance [m]?
  bool explains(double depth, double tolerance) const {
    const auto near = [&](double d) { return std::abs(std::max(0.0, d) * scale_ - depth) <= tolerance; };
    if (std::isfinite(certain_) ? near(certain_) : depth <= tolerance) return true;
    if (doubtful_face_ && near(d_n_)) return true;
    // A doubtful one may be the least, or its loss may leave nothing.
    for (int i = 0; i < doubtful_count_; ++i)
      if (doubtful_[i] <= certain_ && near(doubtful_[i])) return true;
    return doubtful_plane_ && depth <= tolerance;
  }
  bool isDoubtful() const { return doubtful_count_ > 0 || doubtful_plane_ || doubtful_face_; }

 private:
  using Vector3d = Eigen::Vector3d;
  static constexpr double kRegion = 1e-10;  ///< the definition's own tolerance for the borders of regions [-].
  static constexpr double kDoubt = 5e-11;   ///< about the tolerance, what rounding may decide [-].
  /// A minimum that merges with a saddle is a double root, whose place is known to the root of the rounding only.
  static constexpr double kMergingDoubt = 1e-6;

  double h(const Vector3d& u) const { return r_.cwiseProduct(u).norm(); }

  void solve() {
    const double s = -n_.dot(t_[0]), half = h(n_), d_n = half - s;
    doubtful_plane_ = std::abs(s) < 1e-14 * size_ || std::abs(d_n) < 1e-14 * size_;
    if (!(s > 0.0) || !(d_n > 0.0)) return;
    const Vector3d T0 = -r_.cwiseAbs2().cwiseProduct(n_) / half + d_n * n_;
    double outermost = -std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3d m = (t_[(k + 1) % 3] - t_[k]).cross(n_).normalized();
      outermost = std::max(outermost, m.dot(T0 - t_[k]));
    }
    if (outermost <= (kRegion - kDoubt) * size_) {
      certain_ = d_n;
      return;
    }
    doubtful_face_ = outermost <= (kRegion + kDoubt) * size_;
    d_n_ = d_n;
    for (std::size_t k = 0; k < 3; ++k) solveEdge(k);
    for (std::size_t k = 0; k < 3; ++k) solveCorner(k);
  }

  void doubt(double depth) {
    if (doubtful_count_ < static_cast<int>(doubtful_.size())) doubtful_[doubtful_count_++] = depth;
  }

  /// A minimum at u of that depth; every slack must be positive for it to count, in parts of the size.
  void offer(const Vector3d& u, double depth, double least_slack) {
    const double slack = std::min({least_slack, u.dot(n_), d_n_ - depth + kRegion});
    if (slack < -doubt_) return;
    if (slack < doubt_)
      doubt(depth);
    else
      certain_ = std::min(certain_, depth);
  }

  void solveEdge(std::size_t k) {
    const std::size_t l = (k + 1) % 3;
    const double length = (t_[l] - t_[k]).norm();
    const Vector3d e = (t_[l] - t_[k]) / length;
    const Vector3d m = e.cross(n_).normalized(), n = m.cross(e);
    const Vector3d& near = t_[k].squaredNorm() <= t_[l].squaredNorm() ? t_[k] : t_[l];
    // The shadow on the plane across the edge: half axes s_i along d_i. The lesser by the area, so that it keeps its
    // digits.
    const Vector3d N = r_.cwiseProduct(n), M = r_.cwiseProduct(m);
    const double a = N.squaredNorm(), b = N.dot(M), c = M.squaredNorm();
    const double angle = 0.5 * std::atan2(2.0 * b, a - c);
    const double major = std::sqrt(0.5 * (a + c) + std::hypot(0.5 * (a - c), b));
    const double area = N.cross(M).norm();
    const std::array<double, 3> axes = {major, area / major, 0.0};
    const Vector3d d0 = std::cos(angle) * n + std::sin(angle) * m, d1 = std::cos(angle) * m - std::sin(angle) * n;
    const std::array<double, 3> at = {near.dot(d0), near.dot(d1), 0.0};
    forEachCritical<2>(axes, at, [&](const std::array<double, 3>& w) {
      Vector3d u = w[0] * d0 + w[1] * d1;
      u.normalize();
      const double half = h(u), depth = u.dot(near) + half;
      const double curvature = std::pow(axes[0] * axes[1], 2) / std::pow(half, 3);  // of the shadow, as a radius
      const Vector3d E = -r_.cwiseAbs2().cwiseProduct(u) / half;
      const double along = e.dot(E - t_[k]);
      const double inside = std::min(along, length - along) / size_ + kRegion;
      const double convex = doubt_ / kMergingDoubt * (curvature - depth) / std::max(curvature, std::abs(depth));
      offer(u, depth, std::min({inside, convex, u.dot(m) + kRegion}));
    });
  }

  void solveCorner(std::size_t k) {
    const std::array<double, 3> axes = {r_[0], r_[1], r_[2]}, at = {t_[k][0], t_[k][1], t_[k][2]};
    forEachCritical<3>(axes, at, [&](const std::array<double, 3>& w) {
      const Vector3d u = Vector3d(w[0], w[1], w[2]).normalized();
      const double half = h(u), depth = u.dot(t_[k]) + half;
      // Radii of curvature there: their sum from the second derivatives of h on the sphere, their product in closed
      // form, so that the lesser keeps its digits on a disc.
      const Vector3d x = u.unitOrthogonal(), y = u.cross(x);
      const Vector3d rx = r_.cwiseProduct(x), ry = r_.cwiseProduct(y), ru = r_.cwiseProduct(u) / half;
      const double gx = rx.dot(ru), gy = ry.dot(ru);
      const double xx = (rx.squaredNorm() - gx * gx) / half, yy = (ry.squaredNorm() - gy * gy) / half;
      const double xy = (rx.dot(ry) - gx * gy) / half;
      const double larger = 0.5 * (xx + yy) + std::hypot(0.5 * (xx - yy), xy);
      const double lesser = std::pow(r_.prod() / (half * half), 2) / larger;
      const double convex = doubt_ / kMergingDoubt * (lesser - depth) / std::max(lesser, std::abs(depth));
      double inside = std::numeric_limits<double>::infinity();
      for (const std::size_t j : {(k + 1) % 3, (k + 2) % 3}) inside = std::min(inside, u.dot(t_[k] - t_[j]) / size_);
      offer(u, depth, std::min(convex, inside + kRegion));
    });
  }

  /// visit(w) for every direction w (not yet unit, and of either sense) along which the ellipse or ellipsoid with these
  /// axes has the point `at` on its normal: w_i = -at_i / (axis_i^2 - L), where sum (axis_i at_i / (axis_i^2 - L))^2
  /// = 1.
  template <int kDimension, typename Visit>
  static void forEachCritical(const std::array<double, 3>& axes, std::array<double, 3> at, Visit&& visit) {
    std::array<int, kDimension> order;
    for (int i = 0; i < kDimension; ++i) order[i] = i;
    std::sort(order.begin(), order.end(), [&](int i, int j) { return axes[i] < axes[j]; });
    // A point on a plane of symmetry is moved off it by less than anything can be resolved: both senses are then found.
    for (int i = 0; i < kDimension; ++i)
      if (std::abs(at[i]) < 1e-40) at[i] = std::copysign(1e-40, at[i]);
    // Distances between the squared axes, by products: squares would cancel.
    const auto gap = [&](int i, int j) { return (axes[i] - axes[j]) * (axes[i] + axes[j]); };
    const auto sumFrom = [&](int pole, double x, bool slope) {  // of L = axis_pole^2 + x, or half its derivative
      double total = 0.0;
      for (int i = 0; i < kDimension; ++i) {
        const double g = gap(i, pole) - x, q = axes[i] * at[i] / g;
        total += slope ? q * q / g : q * q;
      }
      return total;
    };
    // From a pole outwards the sum falls from infinity: the one y in (0, limit) where it is 1.
    const auto visitRoot = [&](int pole, double sense, double limit) {
      const double y = bisect(limit, [&](double x) { return sumFrom(pole, sense * x, false) > 1.0; });
      std::array<double, 3> w{};
      for (int i = 0; i < kDimension; ++i) w[i] = -at[i] / (gap(i, pole) - sense * y);
      visit(w);
    };
    double far = 1.0;
    while (sumFrom(order[0], -far, false) > 1.0) far *= 4.0;
    visitRoot(order[0], -1.0, far);
    for (far = 1.0; sumFrom(order[kDimension - 1], far, false) > 1.0;) far *= 4.0;
    visitRoot(order[kDimension - 1], 1.0, far);
    // Between two poles all terms are convex: the sum falls once and rises once, and is lowest where its slope is zero.
    for (int i = 0; i + 1 < kDimension; ++i) {
      const int low = order[i], high = order[i + 1];
      const double width = gap(high, low);
      if (!(width > 0.0)) continue;
      const double from_low = bisect(width, [&](double y) { return sumFrom(low, y, true) < 0.0; });
      const double from_high = bisect(width, [&](double y) { return sumFrom(high, -y, true) > 0.0; });
      const bool nearer_low = from_low < from_high;
      const double least = nearer_low ? sumFrom(low, from_low, false) : sumFrom(high, -from_high, false);
      if (least > 1.0 + kMergingDoubt * kMergingDoubt) continue;
      visitRoot(low, 1.0, nearer_low ? from_low : width - from_high);
      visitRoot(high, -1.0, nearer_low ? width - from_low : from_high);
    }
  }

  /// The y in (0, limit) up to which isBelow holds; by the exponent first, as it may be 1e-80.
  template <typename IsBelow>
  static double bisect(double limit, const IsBelow& isBelow) {
    double low = 1e-150, high = limit;
    while (high > 4.0 * low) {
      const double middle = std::sqrt(low * high);
      (isBelow(middle) ? low : high) = middle;
    }
    for (;;) {
      const double middle = 0.5 * (low + high);
      if (!(middle > low && middle < high)) return middle;
      (isBelow(middle) ? low : high) = middle;
    }
  }

  double scale_ = 1.0, size_ = 1.0, d_n_ = 0.0, doubt_ = kDoubt;
  Vector3d r_, n_;
  std::array<Vector3d, 3> t_;
  double certain_ = std::numeric_limits<double>::infinity();
  std::array<double, 32> doubtful_{};
  int doubtful_count_ = 0;
  bool doubtful_plane_ = false, doubtful_face_ = false;
};

}  // namespace ellipsoid_vehicle_sim::test
