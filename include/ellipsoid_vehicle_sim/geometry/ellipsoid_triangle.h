#pragma once

#include <Eigen/Core>

#include "ellipsoid_vehicle_sim/geometry/ellipsoid.h"
#include "ellipsoid_vehicle_sim/geometry/triangle.h"

namespace ellipsoid_vehicle_sim {

/// Which part of a triangle a contact is with; edge k runs from corner k to corner k + 1.
enum class Feature : unsigned char { kNone, kFace, kEdge0, kEdge1, kEdge2, kVertex0, kVertex1, kVertex2 };

/// How a triangle pushes an ellipsoid out. nhat_W is u, the unit direction of the push on the ellipsoid; depth is how
/// far it has to move along u to clear the triangle; p_WE_lowest is E, the ellipsoid's surface point there. The point
/// of the triangle is T = E + depth u; at the end of an edge it may lie past the corner by 1e-10 of the size. Without
/// contact: feature == kNone and depth == 0.
struct TriangleContact {
  Feature feature = Feature::kNone;
  double depth = 0.0;                                     ///< delta [m], > 0 in contact.
  Eigen::Vector3d nhat_W = Eigen::Vector3d::Zero();       ///< u.
  Eigen::Vector3d p_WE_lowest = Eigen::Vector3d::Zero();  ///< E [m].

  explicit operator bool() const { return feature != Feature::kNone; }
  Eigen::Vector3d trianglePoint() const { return p_WE_lowest + depth * nhat_W; }
};

/// Contact rule "minimum_translation": the shortest of the locally shortest pushes off the face, the edges or the
/// corners. The caller may give the depth that a contact must exceed to be of interest: when the answer is proved not
/// to exceed it, none is returned without working it out. An answer above it is the same to the last bit whatever the
/// floor; `floor_depth` = 0 gives the definition itself.
/// Source: see notation.h, [ContactDefinition] rules 1-4.
TriangleContact minimumTranslation(const PosedEllipsoid& ellipsoid, const Triangle& triangle, double floor_depth = 0.0);

/// True only if it is proved that the depth of `minimumTranslation` does not exceed `depth` >= 0 (no contact counts as
/// 0). A few products and at most three roots, nothing is solved. u is a unit vector, best the direction of a contact
/// nearby. With t_i = v_i - c let F(u) = max_i u·t_i + h(u), the push along u that clears the triangle. It is proved
/// when
///   (a) T0 lies outside the triangle, so that the contact, if any, is with an edge or a corner;
///   (b) u·n > 0 and F(u) <= depth;
///   (c) s^2 > h(n)^2 - 1 / (n'A^-1 n): no extreme point E(u') with u' ⟂ n lies below the plane;
/// or when the plane alone says so, h(n) - s <= depth or s <= 0.
///
/// Proof. The largest n·A u' / h(u') over u' ⟂ n is the A-length of n's A-projection on that plane. The plane's
/// A-normal is A^-1 n, so its square is n'A n - (n·n)^2 / (n'A^-1 n), and (c) says that s > n·A u' / h(u') for all u' ⟂
/// n. All t_i have n·t_i = -s. Turning u from u' towards n, every u·t_i + h(u) changes at the rate -s + n·A u' / h(u')
/// < 0 per angle, so F falls inwards all along the border of the hemisphere u·n >= 0, and its least value there is a
/// local minimum u* with u*·n > 0. If one corner attains the maximum at u*, it is that corner's minimum in its region.
/// If two do, u* is square to their edge, on the side of m (the third corner is lower), least on the edge's circle, and
/// stationary: the line E(u*) + R u* meets the segment, which is the edge's condition. If all three do, u* = n and T0
/// lies in the triangle, against (a). So u* is among the minima that rule 4 collects, F(u*) <= F(n) = d_n, and the
/// least of those is at most F(u*) <= F(u) <= depth.
bool cannotExceed(const PosedEllipsoid& ellipsoid, const Triangle& triangle, const Eigen::Vector3d& u, double depth);

/// Contact rule "clamped_point" of the seed document [CarPhysics]: T is the point of the triangle nearest to T0; of
/// the up to six ellipsoid points whose normal passes through T, those above the triangle's plane or on the wrong
/// side of the edges through T are left out, and the shortest push wins. Kept complete, as a named baseline.
TriangleContact clampedPoint(const PosedEllipsoid& ellipsoid, const Triangle& triangle);

}  // namespace ellipsoid_vehicle_sim
