#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "ellipsoid_vehicle_sim/geometry/ellipsoid_triangle.h"

namespace ellipsoid_vehicle_sim::test {

struct ContactCase {
  PosedEllipsoid ellipsoid;
  Triangle triangle;
};

/// Seeded poses of ellipsoids against triangles, most of them in contact with an edge or a corner: the ellipsoid is
/// put so that a random push direction and depth are stationary there. Shapes: wheel, free, disc, needle, sphere,
/// nearly a sphere; triangles: from a hundredth to a hundred times the ellipsoid, slivers down to 1:1e4; depths from
/// 1e-6 of the size to right through.
class RandomContactCases {
 public:
  explicit RandomContactCases(unsigned seed) : engine_(seed) {}

  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  double logUniform(double low, double high) { return std::exp(uniform(std::log(low), std::log(high))); }
  int index(int count) { return std::uniform_int_distribution<int>(0, count - 1)(engine_); }

  Eigen::Vector3d unitVector() {
    std::normal_distribution<double> normal;
    for (;;) {
      const Eigen::Vector3d v(normal(engine_), normal(engine_), normal(engine_));
      if (v.norm() > 1e-3) return v.normalized();
    }
  }

  Eigen::Matrix3d rotation() {
    std::normal_distribution<double> normal;
    const Eigen::Quaterniond q(normal(engine_), normal(engine_), normal(engine_), normal(engine_));
    return q.normalized().toRotationMatrix();
  }

  Eigen::Vector3d wheelRadii() const { return {0.35, 0.12, 0.35}; }

  /// The thinnest shape is `flattest` times as thick as wide.
  Eigen::Vector3d radii(double flattest) {
    const double size = logUniform(0.2, 2.0);
    switch (index(6)) {
      case 0:
        return wheelRadii();
      case 1:
        return size * Eigen::Vector3d(1.0, 1.0, logUniform(flattest, 0.3));
      case 2:
        return size * Eigen::Vector3d(logUniform(flattest, 0.3), 1.0, logUniform(flattest, 0.3));
      case 3:
        return Eigen::Vector3d::Constant(size);
      case 4:
        return size * Eigen::Vector3d(1.0, 1.0 - logUniform(1e-12, 1e-2), 1.0 - logUniform(1e-12, 1e-2));
      default:
        return size * Eigen::Vector3d(1.0, uniform(0.2, 1.0), uniform(0.2, 1.0));
    }
  }

  Triangle triangle(double slimmest) {
    for (;;) {
      const double size = logUniform(0.1, 10.0);
      const Eigen::Vector3d v0 = uniform(0.0, 3.0) * unitVector();
      const Eigen::Vector3d along = unitVector(), across = along.unitOrthogonal();
      const double height = index(4) == 0 ? logUniform(slimmest, 1.0) : uniform(0.3, 1.0);
      const Triangle t =
          makeTriangle(v0, v0 + size * along, v0 + size * (uniform(-0.3, 1.3) * along + height * across));
      if (!hasArea(t)) continue;
      const int shift = index(3);
      return makeTriangle(t.v[shift], t.v[(shift + 1) % 3], t.v[(shift + 2) % 3]);
    }
  }

  /// Stands so that the triangle's point T = E(u) + depth u.
  static PosedEllipsoid placed(const Eigen::Matrix3d& R, const Eigen::Vector3d& radii, const Eigen::Vector3d& T,
                               const Eigen::Vector3d& u, double depth) {
    const PosedEllipsoid centred(Eigen::Vector3d::Zero(), R, radii);
    return {T - depth * u - centred.lowestPointFromCentre(u), R, radii};
  }

  ContactCase next(double flattest = 0.02, double slimmest = 1e-3) {
    return next(radii(flattest), triangle(slimmest), logUniform(1e-6, 2.0));
  }

  /// depth in parts of the smallest semi-axis.
  ContactCase next(const Eigen::Vector3d& r, const Triangle& t, double relative_depth) {
    const Eigen::Matrix3d R = index(5) == 0 ? Eigen::Matrix3d(alignedWith(t.nhat_W)) : rotation();
    const int k = index(3);
    const Eigen::Vector3d e = (t.v[(k + 1) % 3] - t.v[k]).normalized(), m = e.cross(t.nhat_W);
    const double depth = relative_depth * r.minCoeff();
    switch (index(4)) {
      case 0: {  // a corner
        Eigen::Vector3d u = t.nhat_W + uniform(0.0, 2.0) * unitVector();
        if (u.dot(t.nhat_W) < 0.0) u = -u;
        return {placed(R, r, t.v[k], u.normalized(), depth), t};
      }
      case 1: {  // anywhere near
        const Eigen::Vector3d T = (t.v[0] + t.v[1] + t.v[2]) / 3.0;
        return {PosedEllipsoid(T + uniform(0.0, 1.0) * r.maxCoeff() * (t.nhat_W + unitVector()), R, r), t};
      }
      default: {  // an edge
        const double angle = uniform(0.0, 1.6);
        const Eigen::Vector3d u = std::cos(angle) * t.nhat_W + std::sin(angle) * m;
        const double along = uniform(-0.05, 1.05);
        return {placed(R, r, t.v[k] + along * (t.v[(k + 1) % 3] - t.v[k]), u, depth), t};
      }
    }
  }

 private:
  Eigen::Matrix3d alignedWith(const Eigen::Vector3d& n) {
    const Eigen::Quaterniond q = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::Unit(index(3)), n);
    return q.toRotationMatrix() *
           Eigen::AngleAxisd(0.5 * M_PI * index(4), Eigen::Vector3d::Unit(index(3))).toRotationMatrix();
  }

  std::mt19937 engine_;
};

}  // namespace ellipsoid_vehicle_sim::test
