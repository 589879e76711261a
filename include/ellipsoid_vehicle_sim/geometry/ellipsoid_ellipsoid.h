#pragma once

#include <Eigen/Core>

#include "ellipsoid_vehicle_sim/geometry/ellipsoid.h"

namespace ellipsoid_vehicle_sim {

/// How one ellipsoid pushes another. nhat_W is u, the unit direction in which the first has to move to clear the second,
/// depth how far. The deepest points are E1 = c1 - A1 u / h1(u) of the first and E2 = c2 + A2 u / h2(u) of the second; at
/// the least depth E2 = E1 + depth u, so that any point between them is on the line of the push. Without contact:
/// depth == 0.
struct EllipsoidPairContact {
  double depth = 0.0;                                       ///< delta [m], > 0 in contact.
  Eigen::Vector3d nhat_W = Eigen::Vector3d::Zero();         ///< u, from the second into the first.
  Eigen::Vector3d p_WE_first = Eigen::Vector3d::Zero();     ///< E1 [m].
  Eigen::Vector3d p_WE_second = Eigen::Vector3d::Zero();    ///< E2 [m].

  explicit operator bool() const { return depth > 0.0; }
};

/// The shortest translation of `first` that clears `second`:
///   delta = min over unit u of  h1(u) + h2(u) - u.(c1 - c2),
/// the distance of c1 - c2 to the surface of the sum of both bodies, taken from inside. It is 1-Lipschitz in the centres,
/// hence depth never jumps; with half k delta^2 as potential, -k delta u is its gradient (envelope theorem).
///
/// Newton's method on the sphere, from the line of centres. A minimum no deeper than rho = r_min^2 / r_max of both
/// together is the least one: a ball of that radius rolls inside the sum of the bodies, so it fits at the minimum's
/// surface point and holds the smaller ball around c1 - c2 that reaches it [Schneider2014, thm 3.2.12]. Deeper ones are
/// searched from both bodies' axes as well. Equally good directions (centres coincide): the one found first, the line of
/// centres, then W's z, then the axes of the first and of the second, each turned upwards.
/// Error of depth 1e-14 of the largest radius down to discs and needles of 1 : 1e4; of u what that curvature leaves.
EllipsoidPairContact minimumTranslation(const PosedEllipsoid& first, const PosedEllipsoid& second);

/// Proof that they do not touch: the plane square to the unit vector u separates them.
inline bool separates(const PosedEllipsoid& first, const PosedEllipsoid& second, const Eigen::Vector3d& u) {
  return first.halfWidth(u) + second.halfWidth(u) <= u.dot(first.p_WE - second.p_WE);
}

}  // namespace ellipsoid_vehicle_sim
