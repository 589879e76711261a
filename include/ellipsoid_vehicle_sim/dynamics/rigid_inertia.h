#pragma once

#include <Eigen/Core>

#include "ellipsoid_vehicle_sim/geometry/pose.h"

namespace ellipsoid_vehicle_sim {

/// Mass, centre of mass and inertia of a rigid body in a frame A.
struct RigidInertia {
  double mass = 0.0;                                 ///< [kg].
  Eigen::Vector3d p_Acm = Eigen::Vector3d::Zero();   ///< [m].
  Eigen::Matrix3d I_cm_A = Eigen::Matrix3d::Zero();  ///< about the centre of mass, axes of A [kg m^2].

  /// The same body seen from B.
  RigidInertia seenFrom(const Pose& X_BA) const {
    const Eigen::Matrix3d R = X_BA.q.toRotationMatrix();
    return {mass, X_BA * p_Acm, R * I_cm_A * R.transpose()};
  }

  /// Two bodies fixed together, both in A.
  RigidInertia operator+(const RigidInertia& other) const {
    const double total = mass + other.mass;
    if (total <= 0.0) return {0.0, p_Acm, I_cm_A + other.I_cm_A};
    const Eigen::Vector3d d = other.p_Acm - p_Acm;
    // Steiner with the reduced mass: no difference of large numbers.
    const Eigen::Matrix3d steiner =
        (mass * other.mass / total) * (d.squaredNorm() * Eigen::Matrix3d::Identity() - d * d.transpose());
    return {total, p_Acm + (other.mass / total) * d, I_cm_A + other.I_cm_A + steiner};
  }
};

/// Inertia of a solid ellipsoid of even density about its centre, along its axes: m (r_y^2 + r_z^2) / 5, ... [kg m^2].
inline Eigen::Matrix3d solidEllipsoidInertia(double mass, const Eigen::Vector3d& radii) {
  const Eigen::Vector3d s = radii.cwiseAbs2();
  return Eigen::Vector3d(s.y() + s.z(), s.x() + s.z(), s.x() + s.y()).asDiagonal() * (mass / 5.0);
}

}  // namespace ellipsoid_vehicle_sim
