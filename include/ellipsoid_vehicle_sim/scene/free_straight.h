#pragma once

#include <optional>
#include <vector>

#include "ellipsoid_vehicle_sim/description/world_file.h"
#include "ellipsoid_vehicle_sim/world/terrain.h"

namespace ellipsoid_vehicle_sim {

/// What a vehicle needs of the way before it.
struct Footprint {
  double front = 0.5, rear = 0.5;   ///< reach from the point it is set down by [m], >= 0.
  double half_width = 0.3;          ///< [m].
  double height = 0.5;              ///< [m].
  double step = 0.02;               ///< that its wheels take [m].
  double clearance = 0.1;           ///< below its body, between its ends [m].
  double hollow = 1e9;              ///< depth that it may stand over with wheels between its ends, which would hang [m].
  double warp = 0.05;               ///< by which its two ends may stand across each other, wheel against wheel [m].
};

/// A place to stand and the way ahead of it.
struct FreeStraight {
  WorldStart start;
  double length = 0.0;  ///< that is free ahead of the vehicle's front [m], at most what was asked for.
};

/// How far the vehicle can go straight on from a start, up to `longest` [m]: ground that faces up below all of it, rising
/// and falling by at most 10 per cent and by no more than a step at once, nowhere between its ends higher than its body has
/// way down, not more warped than its wheels follow, and no front of a triangle in the way. Negative: it has no room to
/// stand there.
double freeStraight(const Terrain& terrain, const Footprint& footprint, const WorldStart& start, double longest);

/// Starts to try, the best first: the preferred one in its own heading, then in others, then those of a grid over the
/// world, by the length of the way ahead. Places without room are left out.
std::vector<FreeStraight> findFreeStraights(const Terrain& terrain, const Footprint& footprint,
                                            const WorldStart& preferred, double longest);

/// Height of the topmost ground that faces up below (x, y); nullopt over a void.
std::optional<double> groundBelow(const Terrain& terrain, double x, double y);

}  // namespace ellipsoid_vehicle_sim
