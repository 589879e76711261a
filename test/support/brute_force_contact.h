#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "ellipsoid_vehicle_sim/geometry/ellipsoid.h"
#include "ellipsoid_vehicle_sim/geometry/triangle.h"

namespace ellipsoid_vehicle_sim::test {

/// The contact definition, by sheer search: the least local minimum of F(u) = max_i u·(v_i - c) + h(u) on the
/// hemisphere u·n > 0. Knows neither roots nor evolutes nor which part of the triangle T lies on: F is sampled over
/// the whole hemisphere and over the circles u ⟂ edge (its creases), each low sample is followed downhill, and what F
/// does around the end decides. Shares no code with the library but the two value types.
class BruteForceContact {
 public:
  BruteForceContact(const PosedEllipsoid& ellipsoid, const Triangle& triangle) : n_(triangle.nhat_W) {
    // All in parts of the largest semi-axis.
    scale_ = ellipsoid.radii.maxCoeff();
    S_ = (ellipsoid.R_WE * ellipsoid.radii.asDiagonal()) / scale_;
    A_ = S_ * S_.transpose();
    R_ = ellipsoid.R_WE;
    r_ = ellipsoid.radii / scale_;
    for (int i = 0; i < 3; ++i) t_[i] = (triangle.v[i] - ellipsoid.p_WE) / scale_;
    size_ = std::max(1.0, std::sqrt(longestEdgeSquared(triangle.v)) / scale_);
    solve();
  }

  bool hit() const { return depth_ > 0.0; }
  double depth() const { return depth_ * scale_; }
  const Eigen::Vector3d& nhat_W() const { return u_; }
  bool isFace() const { return face_; }

 private:
  using Vector3d = Eigen::Vector3d;

  double h(const Vector3d& u) const { return (S_.transpose() * u).norm(); }
  double delta(int i, const Vector3d& u) const { return u.dot(t_[i]) + h(u); }
  double F(const Vector3d& u) const { return std::max({u.dot(t_[0]), u.dot(t_[1]), u.dot(t_[2])}) + h(u); }

  void solve() {
    const double s = -n_.dot(t_[0]);
    d_n_ = h(n_) - s;
    if (!(s > 0.0) || !(d_n_ > 0.0)) return;

    const Vector3d T0 = -A_ * n_ / h(n_) + d_n_ * n_;
    face_ = true;
    for (int k = 0; k < 3; ++k) {
      const Vector3d m = (t_[(k + 1) % 3] - t_[k]).cross(n_).normalized();
      face_ = face_ && m.dot(T0 - t_[k]) <= 1e-10 * size_;
    }
    if (face_) {
      depth_ = d_n_;
      u_ = n_;
      return;
    }
    least_ = d_n_ + 1e-10 * size_;
    for (int k = 0; k < 3; ++k) searchCrease(k);
    searchHemisphere();
    if (found_) depth_ = std::max(0.0, std::min(least_, d_n_));
  }

  void offer(const Vector3d& u) {
    const double f = F(u);
    if (!(u.dot(n_) > 0.0) || !(f <= least_)) return;
    least_ = f;
    u_ = u;
    found_ = true;
  }

  /// F's crease along the circle square to edge k: every local minimum of that corner's delta on it, by the sign of
  /// its slope.
  void searchCrease(int k) {
    const int l = (k + 1) % 3;
    const Vector3d e = (t_[l] - t_[k]).normalized();
    const Vector3d m = e.cross(n_).normalized(), n = m.cross(e);
    // Two sets of angles: even, and even on the ellipsoid's outline; a disc's outline has its whole rim in a hair's
    // breadth.
    const Eigen::Vector2d axes(h(n), h(m));
    std::vector<double> angles;
    constexpr int kCount = 360;
    for (int i = 0; i < kCount; ++i) {
      const double angle = -M_PI + 2.0 * M_PI * i / kCount;
      angles.push_back(angle);
      angles.push_back(std::atan2(std::sin(angle) / axes[1], std::cos(angle) / axes[0]));
    }
    const Eigen::Vector2d t(0.5 * (t_[k] + t_[l]).dot(n), 0.5 * (t_[k] + t_[l]).dot(m));
    // The shadow's own axes, evenly on its outline.
    Eigen::Matrix2d shadow;
    const Vector3d rn = S_.transpose() * n, rm = S_.transpose() * m;
    shadow << rn.dot(rn), rn.dot(rm), rn.dot(rm), rm.dot(rm);
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen;
    eigen.computeDirect(shadow);
    for (int i = 0; i < kCount; ++i) {
      const double angle = -M_PI + 2.0 * M_PI * i / kCount;
      const double thin = std::sqrt(std::max(eigen.eigenvalues()[0], 1e-300)), wide = std::sqrt(eigen.eigenvalues()[1]);
      const Eigen::Vector2d u =
          std::cos(angle) / thin * eigen.eigenvectors().col(0) + std::sin(angle) / wide * eigen.eigenvectors().col(1);
      angles.push_back(std::atan2(u[1], u[0]));
    }
    std::sort(angles.begin(), angles.end());
    const auto same = [](double lower, double upper) { return upper - lower < 1e-9; };
    angles.erase(std::unique(angles.begin(), angles.end(), same), angles.end());
    const auto slope = [&](double angle) {
      const double c = std::cos(angle), sn = std::sin(angle);
      const Vector3d y = c * rn + sn * rm;
      return c * t[1] - sn * t[0] + y.dot(c * rm - sn * rn) / y.norm();
    };
    // A minimum is where the slope turns from falling to rising, between two samples...
    const auto minimumBetween = [&](double low, double high) {
      for (int step = 0; step < 60; ++step) {
        const double middle = 0.5 * (low + high);
        (slope(middle) < 0.0 ? low : high) = middle;
      }
      const Vector3d u = std::cos(low) * n + std::sin(low) * m;
      // The third corner must be lower, and F must rise to both sides of the crease.
      if (F(u) > delta(k, u) + 1e-11 * size_) return;
      for (const double probe : {-1e-6 * r_.minCoeff(), 1e-6 * r_.minCoeff()}) {
        if (F((u + probe * e).normalized()) < F(u) - 1e-15 * size_) return;
      }
      offer(u);
    };
    std::vector<double> slopes;
    angles.push_back(angles[0] + 2.0 * M_PI);
    angles.push_back(angles[1] + 2.0 * M_PI);
    for (const double angle : angles) slopes.push_back(slope(angle));
    for (std::size_t i = 0; i + 2 < angles.size(); ++i) {
      const double low = angles[i], high = angles[i + 2];
      if (slopes[i] < 0.0 && slopes[i + 1] >= 0.0) minimumBetween(low, angles[i + 1]);
      // ...or inside one step, beside the maximum it is about to merge with: the slope's own extremes show it.
      const bool peak = slopes[i + 1] < 0.0 && slopes[i + 1] >= slopes[i] && slopes[i + 1] >= slopes[i + 2];
      const bool dip = slopes[i + 1] > 0.0 && slopes[i + 1] <= slopes[i] && slopes[i + 1] <= slopes[i + 2];
      if (!peak && !dip) continue;
      const double sign = peak ? 1.0 : -1.0;
      const double extreme = goldenMaximum([&](double angle) { return sign * slope(angle); }, low, high);
      if (sign * slope(extreme) > 0.0) peak ? minimumBetween(low, extreme) : minimumBetween(extreme, high);
    }
  }

  template <typename Function>
  static double goldenMaximum(const Function& function, double low, double high) {
    const double golden = 0.5 * (std::sqrt(5.0) - 1.0);
    double a = high - golden * (high - low), b = low + golden * (high - low), fa = function(a), fb = function(b);
    for (int step = 0; step < 40; ++step) {
      if (fa > fb) {
        high = b, b = a, fb = fa;
        a = high - golden * (high - low), fa = function(a);
      } else {
        low = a, a = b, fa = fb;
        b = low + golden * (high - low), fb = function(b);
      }
    }
    return fa > fb ? a : b;
  }

  /// Samples of F on latitudes and longitudes about n and, squeezed by the semi-axes, about each of the ellipsoid's
  /// own axes.
  void searchHemisphere() {
    const Vector3d a = n_.unitOrthogonal();
    Eigen::Matrix3d frame;
    frame << a, n_.cross(a), n_;
    searchGrid([&](const Vector3d& w) { return Vector3d(frame * w); });
    searchGrid([&](const Vector3d& w) { return Vector3d(R_ * w.cwiseQuotient(r_)).normalized(); });
    searchGrid([&](const Vector3d& w) {
      return Vector3d(R_ * Vector3d(w[1], w[2], w[0]).cwiseQuotient(r_.cwiseSqrt())).normalized();
    });
  }

  template <typename Map>
  void searchGrid(const Map& map) {
    constexpr int kLatitudes = 24, kLongitudes = 40;
    std::vector<Vector3d> u;
    std::vector<double> f;
    for (int i = 0; i < kLatitudes; ++i) {
      for (int j = 0; j < kLongitudes; ++j) {
        const double latitude = M_PI * (i + 0.5) / kLatitudes, longitude = 2.0 * M_PI * j / kLongitudes;
        u.push_back(map(
            {std::sin(latitude) * std::cos(longitude), std::sin(latitude) * std::sin(longitude), std::cos(latitude)}));
        f.push_back(F(u.back()));
      }
    }
    for (int i = 0; i < kLatitudes; ++i) {
      for (int j = 0; j < kLongitudes; ++j) {
        const double here = f[i * kLongitudes + j];
        bool low = true;
        for (int di = -1; di <= 1 && low; ++di) {
          for (int dj = -1; dj <= 1; ++dj) {
            const int ni = std::clamp(i + di, 0, kLatitudes - 1), nj = (j + dj + kLongitudes) % kLongitudes;
            low = low && here <= f[ni * kLongitudes + nj];
          }
        }
        if (!low) continue;
        // A corner that is not the highest here may be so at the end of the way, unless it is far too low.
        const Vector3d& start = u[i * kLongitudes + j];
        for (int corner = 0; corner < 3; ++corner) {
          if (delta(corner, start) > here - 0.3 * size_) descend(corner, start);
        }
      }
    }
  }

  /// Newton's method with damping on one corner's delta over the sphere.
  void descend(int i, Vector3d u) {
    double f = delta(i, u), damping = 1e-3, gradient_norm = 0.0, least_eigenvalue = 0.0;
    for (int step = 0; step < 200; ++step) {
      const double half_width = h(u);
      const Vector3d a = u.unitOrthogonal(), b = u.cross(a);
      Eigen::Matrix<double, 3, 2> basis;
      basis << a, b;
      const Vector3d Au = A_ * u;
      const Eigen::Vector2d gradient = basis.transpose() * (t_[i] + Au / half_width);
      gradient_norm = gradient.norm();
      const Eigen::Vector2d BAu = basis.transpose() * Au;
      Eigen::Matrix2d hessian =
          basis.transpose() * A_ * basis / half_width - BAu * BAu.transpose() / std::pow(half_width, 3);
      hessian -= f * Eigen::Matrix2d::Identity();
      least_eigenvalue = 0.5 * hessian.trace() - std::hypot(0.5 * (hessian(0, 0) - hessian(1, 1)), hessian(0, 1));
      const double shift =
          std::max(0.0, -least_eigenvalue) + damping * (std::max(0.0, -least_eigenvalue) + gradient.norm());
      const Eigen::Matrix2d damped = hessian + shift * Eigen::Matrix2d::Identity();
      const Eigen::Vector2d d = damped.inverse() * (-gradient);
      if (!d.allFinite()) return;
      const Vector3d next = (u + basis * d).normalized();
      const double f_next = delta(i, next);
      if (f_next <= f) {
        const double moved = (next - u).norm();
        u = next;
        f = f_next;
        damping *= 0.1;
        if (moved < 1e-14) break;
      } else {
        if (damping > 1e12) break;
        damping = std::max(damping, 1e-8) * 10.0;
      }
    }
    if (gradient_norm < 1e-8 && least_eigenvalue > 0.0 && F(u) <= f + 1e-11 * size_) offer(u);
  }

  Vector3d n_, u_ = Vector3d::Zero(), r_;
  std::array<Vector3d, 3> t_;
  Eigen::Matrix3d S_, A_, R_;
  double scale_ = 1.0, size_ = 1.0, d_n_ = 0.0, least_ = 0.0, depth_ = 0.0;
  bool face_ = false, found_ = false;
};

}  // namespace ellipsoid_vehicle_sim::test
