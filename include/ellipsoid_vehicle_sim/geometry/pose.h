#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace ellipsoid_vehicle_sim {

/// Rigid transform X_AB: where frame B stands, seen from frame A.
/// p is p_AB [m], in A; q is q_AB, a unit quaternion. A vector turns by q, a point by p + q * point.
struct Pose {
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();

  /// X_AC = X_AB * X_BC.
  Pose operator*(const Pose& X_BC) const { return {p + q * X_BC.p, (q * X_BC.q).normalized()}; }
  /// The point p_BQ, seen from A.
  Eigen::Vector3d operator*(const Eigen::Vector3d& p_BQ) const { return p + q * p_BQ; }
  /// X_BA.
  Pose inverse() const { return {q.conjugate() * (-p), q.conjugate()}; }

  bool allFinite() const { return p.allFinite() && q.coeffs().allFinite(); }
};

/// Rotation of URDF and of REP-103: fixed axes, first roll about x, then pitch about y, then yaw about z [rad].
inline Eigen::Quaterniond quaternionFromRpy(double roll, double pitch, double yaw) {
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  return AngleAxisd(yaw, Vector3d::UnitZ()) * AngleAxisd(pitch, Vector3d::UnitY()) * AngleAxisd(roll, Vector3d::UnitX());
}

/// Unit quaternion of the rotation vector r (axis times angle [rad]); exact at zero.
inline Eigen::Quaterniond quaternionFromRotationVector(const Eigen::Vector3d& r) {
  const double a2 = r.squaredNorm();
  double cosine, s;  // cos(a/2), sin(a/2)/a
  if (a2 < 0.01) {
    // The turn of a step: the series' next terms are below rounding. Written without divisions, which no compiler may replace.
    constexpr double c1 = 1.0 / 8.0, c2 = 1.0 / 384.0, c3 = 1.0 / 46080.0, c4 = 1.0 / 10321920.0;
    constexpr double s0 = 0.5, s1 = 1.0 / 48.0, s2 = 1.0 / 3840.0, s3 = 1.0 / 645120.0, s4 = 1.0 / 185794560.0;
    cosine = 1.0 - a2 * (c1 - a2 * (c2 - a2 * (c3 - a2 * c4)));
    s = s0 - a2 * (s1 - a2 * (s2 - a2 * (s3 - a2 * s4)));
  } else {
    const double angle = std::sqrt(a2);
    cosine = std::cos(0.5 * angle);
    s = std::sin(0.5 * angle) / angle;
  }
  return {cosine, s * r.x(), s * r.y(), s * r.z()};
}

}  // namespace ellipsoid_vehicle_sim
