#pragma once

#include "ellipsoid_vehicle_sim/geometry/ellipsoid.h"
#include "ellipsoid_vehicle_sim/geometry/small_vector.h"
#include "ellipsoid_vehicle_sim/geometry/triangle.h"

namespace ellipsoid_vehicle_sim {

/// The borders between face, edge and corner are tested with this tolerance, in parts of the larger of the longest
/// edge and the largest semi-axis: an answer found by two features does no harm, a gap between them would lose the
/// contact.
constexpr double kBorderTolerance = 1e-10;

/// Where an ellipsoid stands towards the plane of a triangle. Source: [ContactDefinition] rules 2 and 3.
struct PlaneContact {
  Vec3 t[3];    ///< the corners, v_i - c [m].
  Frame3 axes;  ///< the ellipsoid's axes.
  Vec3 nhat;    ///< n.
  Vec3 radii;   ///< semi-axes [m].
  Vec3 nhat_E;  ///< n along the ellipsoid's axes.
  Vec3 p_EE0;   ///< E0 - c [m].
  Vec3 p_ET0;   ///< T0 - c [m], T0 = E0 + d_n n.
  double s;     ///< n·(c - v), height of the centre over the plane [m].
  double h;     ///< half width of the ellipsoid along n [m].
  double d_n;   ///< h - s, depth of the lowest point E0 below the plane [m].
};

/// Rule 2: false unless the centre is in front of the plane and the lowest point more than floor_depth >= 0 below it;
/// the plane is then void. The half width comes from the semi-axes, not from A: along the thin axis of a disc, A's
/// digits are those of its wide axes. NaN anywhere counts as not reached.
bool planeContact(const PosedEllipsoid& ellipsoid, const Triangle& triangle, double floor_depth, PlaneContact& plane);

/// On which side of the triangle's edges T0 lies, by more than the tolerance.
struct FaceSides {
  bool outside[3];
  bool inside[3];
  double size_squared;  ///< the larger of the longest edge and the largest semi-axis [m], squared.

  /// Rule 3: T0 lies in the triangle.
  bool isFace() const { return !outside[0] && !outside[1] && !outside[2]; }
};

FaceSides faceSides(const PlaneContact& plane, const Triangle& triangle);

}  // namespace ellipsoid_vehicle_sim
