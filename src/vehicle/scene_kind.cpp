#include "ellipsoid_vehicle_sim/vehicle/scene_kind.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

#include "fnv_hash.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

// A bend that a wheel feels as an edge, not as a curve of the ground [rad].
constexpr double kSharp = 20.0 * M_PI / 180.0;
// Below this damping ratio a contact gives back most of what it takes (restitution above 0.53) [-].
constexpr double kHardlyDamped = 0.2;

// Two corners, whichever comes first.
using Edge = std::array<double, 6>;

Edge edgeOf(const Vector3d& a, const Vector3d& b) {
  const bool swap = std::lexicographical_compare(b.data(), b.data() + 3, a.data(), a.data() + 3);
  const Vector3d &p = swap ? b : a, &q = swap ? a : b;
  return {p.x(), p.y(), p.z(), q.x(), q.y(), q.z()};
}

struct EdgeHash {
  std::size_t operator()(const Edge& edge) const {
    FnvHash hash;
    for (const double x : edge) hash.add(x + 0.0);  // of zeros there is one
    return static_cast<std::size_t>(hash.value());
  }
};

}  // namespace

const char* toString(SceneKind kind) {
  switch (kind) {
    case SceneKind::kDrive: return "drive";
    case SceneKind::kRoughDrive: return "rough_drive";
    case SceneKind::kElastic: return "elastic";
    case SceneKind::kDamped: return "damped";
  }
  return "unknown";
}

double sharpestBend(const Terrain& terrain) {
  std::unordered_map<Edge, int, EdgeHash> first;
  first.reserve(2 * static_cast<std::size_t>(terrain.triangleCount()));
  double least = 1.0;
  for (int i = 0; i < terrain.triangleCount(); ++i) {
    const Triangle triangle = terrain.triangle(i);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [found, is_new] = first.try_emplace(edgeOf(triangle.v[k], triangle.v[(k + 1) % 3]), i);
      if (!is_new) least = std::min(least, terrain.triangle(found->second).nhat_W.dot(triangle.nhat_W));
    }
  }
  return std::acos(std::clamp(least, -1.0, 1.0));
}

SceneKind sceneKindOf(const VehicleModel& model, const Terrain& terrain) {
  if (!model.drive.wheels.empty()) return sharpestBend(terrain) > kSharp ? SceneKind::kRoughDrive : SceneKind::kDrive;
  for (const ModelEllipsoid& e : model.ellipsoids)
    if (e.law.damping < 2.0 * kHardlyDamped * std::sqrt(e.law.stiffness * e.normal_mass)) return SceneKind::kElastic;
  return SceneKind::kDamped;
}

}  // namespace ellipsoid_vehicle_sim
