#pragma once

#include <Eigen/Core>

#include "ellipsoid_vehicle_sim/geometry/pose.h"
#include "ellipsoid_vehicle_sim/geometry/small_vector.h"

namespace ellipsoid_vehicle_sim {

/// An ellipsoid standing somewhere: centre, axes and semi-axes, with its shape matrix at hand.
/// Everything is expressed in W, lengths in [m]. For a unit vector u the half width is h(u) = sqrt(u'A u) and the
/// surface point that lies lowest along u is E(u) = c - A u / h(u).
struct PosedEllipsoid {
  Eigen::Vector3d p_WE;   ///< centre c.
  Eigen::Matrix3d R_WE;   ///< columns: the ellipsoid's axes.
  Eigen::Vector3d radii;  ///< semi-axes, > 0.
  Eigen::Matrix3d A;      ///< R diag(radii^2) R'.

  PosedEllipsoid() = default;
  PosedEllipsoid(const Eigen::Vector3d& p_WE_in, const Eigen::Matrix3d& R_WE_in, const Eigen::Vector3d& radii_in)
      : PosedEllipsoid(p_WE_in, columns(R_WE_in), radii_in) {}
  PosedEllipsoid(const Eigen::Vector3d& p_WE_in, const Frame3& axes, const Eigen::Vector3d& radii_in)
      : p_WE(p_WE_in), R_WE(axes.toEigen()), radii(radii_in) {
    const Vec3 x = radii[0] * axes.x, y = radii[1] * axes.y, z = radii[2] * axes.z;
    const auto entry = [&](double Vec3::*i, double Vec3::*j) { return x.*i * x.*j + y.*i * y.*j + z.*i * z.*j; };
    const double xy = entry(&Vec3::x, &Vec3::y), xz = entry(&Vec3::x, &Vec3::z), yz = entry(&Vec3::y, &Vec3::z);
    A << entry(&Vec3::x, &Vec3::x), xy, xz, xy, entry(&Vec3::y, &Vec3::y), yz, xz, yz, entry(&Vec3::z, &Vec3::z);
  }

  double halfWidth(const Eigen::Vector3d& u) const { return std::sqrt(dot(Vec3::from(u), timesA(u))); }
  /// E(u) - c [m].
  Eigen::Vector3d lowestPointFromCentre(const Eigen::Vector3d& u) const {
    const Vec3 Au = timesA(u);
    return ((-1.0 / std::sqrt(dot(Vec3::from(u), Au))) * Au).toEigen();
  }
  /// Half size of the smallest box with sides along W that holds it [m].
  Eigen::Vector3d halfBox() const { return {std::sqrt(A(0, 0)), std::sqrt(A(1, 1)), std::sqrt(A(2, 2))}; }

 private:
  Vec3 timesA(const Eigen::Vector3d& u) const {
    return {A(0, 0) * u.x() + A(0, 1) * u.y() + A(0, 2) * u.z(), A(1, 0) * u.x() + A(1, 1) * u.y() + A(1, 2) * u.z(),
            A(2, 0) * u.x() + A(2, 1) * u.y() + A(2, 2) * u.z()};
  }
};

}  // namespace ellipsoid_vehicle_sim
