#pragma once

#include "ellipsoid_vehicle_sim/geometry/ellipsoid_triangle.h"

namespace ellipsoid_vehicle_sim {

/// `minimumTranslation` rule by rule: face, then every edge and corner that may hold the answer. The definition, and
/// what the faster kernels leave to it.
TriangleContact searchFeatures(const PosedEllipsoid& ellipsoid, const Triangle& triangle, double floor_depth);

/// On the horizon, u ⟂ n, no extreme point E(u) lies below the plane: see `cannotExceed`. b = n'A^-1 n.
inline bool isHorizonClear(double s, double h, double b) { return s * s * b > h * h * b * (1.0 + 1e-12) - 1.0; }

}  // namespace ellipsoid_vehicle_sim
