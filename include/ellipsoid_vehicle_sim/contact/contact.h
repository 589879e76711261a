#pragma once

#include <Eigen/Core>
#include <array>

#include "ellipsoid_vehicle_sim/geometry/ellipsoid.h"
#include "ellipsoid_vehicle_sim/geometry/ellipsoid_triangle.h"

namespace ellipsoid_vehicle_sim {

/// A valley can hold an ellipsoid by three faces at once; more cannot push in new directions.
constexpr int kMaxContactsPerEllipsoid = 3;

/// One triangle that pushes an ellipsoid. Everything in W. Not initialised: lists of them are made in every evaluation.
struct Contact {
  int triangle;                 ///< index into the terrain.
  Eigen::Vector3d nhat_W;       ///< u: unit, from the terrain into the vehicle.
  Eigen::Vector3d p_WE_lowest;  ///< E: the ellipsoid's surface point there, where the force acts [m].
  double depth;                 ///< delta: geometric penetration along u [m].
  double pressed;               ///< d: the part of it that the spring feels [m], 0 <= d <= delta.
  double share;                 ///< w: share of the force where contacts overlap, 0 ... 1.

  Eigen::Vector3d trianglePoint() const { return p_WE_lowest + depth * nhat_W; }
};

/// The contacts of one ellipsoid at one pose, deepest first.
struct EllipsoidContacts {
  int count = 0;
  std::array<Contact, kMaxContactsPerEllipsoid> contact;
};

/// A contact of the last accepted pose, as the memory keeps it. Its point follows from the pose and the normal.
struct CarriedContact {
  int triangle = -1;
  Eigen::Vector3d nhat_W = Eigen::Vector3d::Zero();
  double depth = 0.0;       ///< delta there [m].
  double half_width = 0.0;  ///< h(u) there [m].
};

/// What an ellipsoid remembers of the last accepted step; part of the state, frozen within a step. It decides which
/// triangles may push (one that the ellipsoid comes upon from behind may not) and how much of a sudden depth the spring
/// feels, so that one-sided triangles create no energy. Source: notation.h [ContactDefinition] rule 6.
struct ContactMemory {
  bool fresh = true;     ///< spawned or teleported: nothing is known of the past, all fronts are admitted.
  PosedEllipsoid posed;  ///< (c0, R0).
  int count = 0;
  std::array<CarriedContact, kMaxContactsPerEllipsoid> carried;
  double deepest = 0.0;  ///< g: deepest of carried [m].
  Eigen::Vector3d push =
      Eigen::Vector3d::Zero();  ///< p0: the shortest push that clears all carried, from full depths [m].
  double slack = 0.0;           ///< sigma: depth that is not charged to the spring [m].
};

}  // namespace ellipsoid_vehicle_sim
