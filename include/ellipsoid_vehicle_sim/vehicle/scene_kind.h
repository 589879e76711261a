#pragma once

#include "ellipsoid_vehicle_sim/vehicle/vehicle_model.h"
#include "ellipsoid_vehicle_sim/world/terrain.h"

namespace ellipsoid_vehicle_sim {

/// What makes a simulation easy or hard, as far as it can be told at load: scenes of one kind have errors of one order.
enum class SceneKind {
  kDrive,       ///< ground wheels on ground without sharp edges: contacts last.
  kRoughDrive,  ///< ground wheels, and kerbs, steps or walls somewhere.
  kElastic,     ///< no ground wheels, and a contact that hardly damps: it bounces.
  kDamped       ///< no ground wheels, contacts that damp: it slides, rolls or lies.
};
constexpr int kSceneKindCount = 4;

/// "drive", "rough_drive", "elastic", "damped".
const char* toString(SceneKind kind);

SceneKind sceneKindOf(const VehicleModel& model, const Terrain& terrain);

/// Largest angle between the fronts of two triangles that have two corners in common, bit for bit [rad]; 0 where none do.
/// Walks over all triangles: for load time.
double sharpestBend(const Terrain& terrain);

}  // namespace ellipsoid_vehicle_sim
