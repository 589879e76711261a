#pragma once

#include <memory>
#include <optional>
#include <string>

#include "ellipsoid_vehicle_sim/geometry/ray.h"
#include "ellipsoid_vehicle_sim/world/terrain.h"

namespace ellipsoid_vehicle_sim {

/// What finds the triangles that a ray may meet.
enum class RayTracer {
  kEmbree,  ///< Intel's Embree, where it was found when this was built.
  kOwnTree  ///< a tree as the contacts use it (MeshTree): several times slower.
};

/// Where a ray first meets the terrain.
struct RayHit {
  double distance;  ///< from its origin [m].
  int triangle;     ///< of several at one distance the first.
};

/// Shoots rays at a terrain, of which it holds the corners side by side for that. Either tracer only proposes
/// triangles; which of them is hit, and where, is said by ShearedRay in doubles on these corners. So both give the same
/// distances and triangles, to the last bit. Both sides of a triangle are seen: light knows no front.
class RayCaster {
 public:
  virtual ~RayCaster() = default;

  /// The nearest triangle within `range` [m]; of several at one distance the first.
  virtual std::optional<RayHit> firstHit(const Ray& ray, double range) const = 0;

  /// Which tracer this is, and why, for the log: one line.
  const std::string& description() const { return description_; }
  RayTracer tracer() const { return tracer_; }

 protected:
  RayCaster(RayTracer tracer, std::string description) : tracer_(tracer), description_(std::move(description)) {}

 private:
  RayTracer tracer_;
  std::string description_;
};

/// Embree where it was built in and fits the world, otherwise the own tree; the description says why.
/// Embree works with boxes of floats. They are made wide enough that none is missed; where that makes them much wider
/// than the triangles (a world of millimetres over a thousand kilometres) the own tree is faster, and is taken.
std::unique_ptr<const RayCaster> makeRayCaster(const Terrain& terrain);
std::unique_ptr<const RayCaster> makeOwnTreeRayCaster(const Terrain& terrain, const std::string& why = "");
/// nullptr, and `why` says the reason: not built in, does not fit the world, or Embree failed.
std::unique_ptr<const RayCaster> makeEmbreeRayCaster(const Terrain& terrain, std::string& why);

}  // namespace ellipsoid_vehicle_sim
