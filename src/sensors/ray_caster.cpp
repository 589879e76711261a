#include "ellipsoid_vehicle_sim/sensors/ray_caster.h"

#include <array>
#include <vector>

#include "ellipsoid_vehicle_sim/world/mesh_tree.h"
#include "ellipsoid_vehicle_sim/world/mesh_tree_rays.h"

namespace ellipsoid_vehicle_sim {
namespace {

class OwnTreeRayCaster : public RayCaster {
 public:
  OwnTreeRayCaster(const Terrain& terrain, std::string description)
      : RayCaster(RayTracer::kOwnTree, std::move(description)) {
    const auto count = static_cast<std::uint32_t>(terrain.triangleCount());
    std::vector<std::array<std::uint32_t, 3>> triangles(count);
    corners_.reserve(3 * static_cast<std::size_t>(count));
    for (std::uint32_t i = 0; i < count; ++i) {
      for (const Eigen::Vector3d& corner : terrain.triangle(static_cast<int>(i)).v) corners_.push_back(corner);
      triangles[i] = {3 * i, 3 * i + 1, 3 * i + 2};
    }
    tree_ = MeshTree(corners_, triangles);
  }

  std::optional<RayHit> firstHit(const Ray& ray, double range) const override {
    std::optional<RayHit> first;
    if (!ray.origin.allFinite() || !ray.direction.allFinite()) return first;
    const ShearedRay sheared(ray);
    double limit = range;
    tree_.visitRay(ray, range, [&](int i) {
      const Eigen::Vector3d* corner = &corners_[3 * static_cast<std::size_t>(i)];
      const std::optional<double> t = sheared.meets(corner[0], corner[1], corner[2]);
      if (t && (*t < limit || (*t == limit && (!first || i < first->triangle)))) {
        first = RayHit{*t, i};
        limit = *t;
      }
      return limit;
    });
    return first;
  }

 private:
  std::vector<Eigen::Vector3d> corners_;  ///< three for each triangle, side by side in memory.
  MeshTree tree_;
};

}  // namespace

std::unique_ptr<const RayCaster> makeOwnTreeRayCaster(const Terrain& terrain, const std::string& why) {
  const std::string description = "the simulator's own tree" + (why.empty() ? "" : ": " + why);
  return std::make_unique<OwnTreeRayCaster>(terrain, description);
}

std::unique_ptr<const RayCaster> makeRayCaster(const Terrain& terrain) {
  std::string why;
  if (auto embree = makeEmbreeRayCaster(terrain, why)) return embree;
  return makeOwnTreeRayCaster(terrain, why);
}

}  // namespace ellipsoid_vehicle_sim
