#pragma once

#include <vector>

#include "ellipsoid_vehicle_sim/geometry/ellipsoid_triangle.h"

namespace ellipsoid_vehicle_sim {

/// The ways to work `minimumTranslation` out. kDefinition goes through rules 1-4 feature by feature. The others answer
/// a face, and an edge or a corner met shallowly, by shorter ways, and leave the rest to it; they differ in the
/// processor they are compiled for alone, and give the same bits.
enum class TriangleKernel { kDefinition, kPlain, kAvx2, kAvx512 };

/// Those that this machine has; the last is the one `minimumTranslation` takes.
std::vector<TriangleKernel> triangleKernels();

/// `minimumTranslation` by a given one, to hold them against each other; the machine must have it.
TriangleContact minimumTranslation(TriangleKernel kernel, const PosedEllipsoid& ellipsoid, const Triangle& triangle,
                                   double floor_depth = 0.0);

}  // namespace ellipsoid_vehicle_sim
