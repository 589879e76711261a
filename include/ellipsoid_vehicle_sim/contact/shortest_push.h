#pragma once

#include <Eigen/Core>
#include <array>

#include "ellipsoid_vehicle_sim/contact/contact.h"

namespace ellipsoid_vehicle_sim {

/// p = sum a_i u_i: the shortest translation with p . u_i >= d_i for all i, a_i >= 0.
struct ShortestPush {
  Eigen::Vector3d p = Eigen::Vector3d::Zero();            ///< [m].
  std::array<double, kMaxContactsPerEllipsoid> weight{};  ///< a_i [m].
};

/// Solves the little quadratic program over up to three unit normals by going through its active sets. Depths <= 0 ask
/// for nothing. Contradicting normals (no p clears all) give the push of the largest set that can be cleared.
ShortestPush shortestPush(const std::array<Eigen::Vector3d, kMaxContactsPerEllipsoid>& nhat,
                          const std::array<double, kMaxContactsPerEllipsoid>& depth, int count);

}  // namespace ellipsoid_vehicle_sim
