#include "ellipsoid_vehicle_sim/geometry/ray.h"

#include <cmath>

namespace ellipsoid_vehicle_sim {

using Eigen::Vector3d;

ShearedRay::ShearedRay(const Ray& ray) : origin_(ray.origin) {
  ray.direction.cwiseAbs().maxCoeff(&z_);
  x_ = (z_ + 1) % 3;
  y_ = (z_ + 2) % 3;
  scale_ = 1.0 / ray.direction[z_];
  shear_x_ = ray.direction[x_] * scale_;
  shear_y_ = ray.direction[y_] * scale_;
}

std::optional<double> ShearedRay::meets(const Vector3d& v0, const Vector3d& v1, const Vector3d& v2) const {
  const double z0 = v0[z_] - origin_[z_], z1 = v1[z_] - origin_[z_], z2 = v2[z_] - origin_[z_];
  const double x0 = v0[x_] - origin_[x_] - shear_x_ * z0, y0 = v0[y_] - origin_[y_] - shear_y_ * z0;
  const double x1 = v1[x_] - origin_[x_] - shear_x_ * z1, y1 = v1[y_] - origin_[y_] - shear_y_ * z1;
  const double x2 = v2[x_] - origin_[x_] - shear_x_ * z2, y2 = v2[y_] - origin_[y_] - shear_y_ * z2;
  // Twice the areas between the ray and each edge: the weights of the corners.
  const double w0 = x1 * y2 - y1 * x2, w1 = x2 * y0 - y2 * x0, w2 = x0 * y1 - y0 * x1;
  const bool one_side = w0 >= 0.0 && w1 >= 0.0 && w2 >= 0.0, other_side = w0 <= 0.0 && w1 <= 0.0 && w2 <= 0.0;
  const double sum = w0 + w1 + w2;
  if (!(one_side || other_side) || sum == 0.0) return std::nullopt;
  const double t = scale_ * ((w0 * z0 + w1 * z1 + w2 * z2) / sum);
  // Written so that an overflow far out is no hit.
  if (t >= 0.0 && std::isfinite(t)) return t;
  return std::nullopt;
}

std::optional<double> rayEllipsoid(const Ray& ray, const PosedEllipsoid& ellipsoid) {
  const Eigen::Array3d inverse = ellipsoid.radii.array().inverse();
  const Vector3d q = ((ellipsoid.R_WE.transpose() * (ray.origin - ellipsoid.p_WE)).array() * inverse).matrix();
  const Vector3d e = ((ellipsoid.R_WE.transpose() * ray.direction).array() * inverse).matrix();
  const double a = e.squaredNorm(), nearest = -q.dot(e) / a;
  const double gap = 1.0 - (q + nearest * e).squaredNorm();
  if (!(gap >= 0.0)) return std::nullopt;
  const double half = std::sqrt(gap / a);
  const double t = nearest - half >= 0.0 ? nearest - half : nearest + half;
  if (t >= 0.0 && std::isfinite(t)) return t;
  return std::nullopt;
}

}  // namespace ellipsoid_vehicle_sim
