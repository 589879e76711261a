#pragma once

#include <Eigen/Core>

#include "ellipsoid_vehicle_sim/geometry/pose.h"

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
      : p_WE(p_WE_in), R_WE(R_WE_in), radii(radii_in) {
    const Eigen::Matrix3d S = R_WE * radii.asDiagonal();
    A.noalias() = S * S.transpose();
  }

  double halfWidth(const Eigen::Vector3d& u) const { return std::sqrt(u.dot(A * u)); }
  /// E(u) - c [m].
  Eigen::Vector3d lowestPointFromCentre(const Eigen::Vector3d& u) const {
    const Eigen::Vector3d Au = A * u;
    return Au * (-1.0 / std::sqrt(u.dot(Au)));
  }
  /// Half size of the smallest box with sides along W that holds it [m].
  Eigen::Vector3d halfBox() const { return A.diagonal().cwiseSqrt(); }
};

}  // namespace ellipsoid_vehicle_sim
