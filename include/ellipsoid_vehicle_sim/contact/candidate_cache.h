#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "ellipsoid_vehicle_sim/geometry/ellipsoid.h"
#include "ellipsoid_vehicle_sim/geometry/triangle.h"
#include "ellipsoid_vehicle_sim/world/terrain.h"

namespace ellipsoid_vehicle_sim {

/// A triangle an ellipsoid may touch, with its box and normal at hand.
struct Candidate {
  Triangle triangle;
  Eigen::Vector3d low, high;  ///< the triangle's box [m].
  int index = -1;             ///< in the terrain.
};

/// The triangles around one ellipsoid. The tree is asked with a box fattened by the travel of the next steps; until the
/// ellipsoid leaves that box the answer is reused. Who uses a candidate first checks its own box against the ellipsoid's,
/// so a fresh and a reused list give the same contacts to the last bit.
class CandidateCache {
 public:
  CandidateCache() {
    // Ground of ordinary density then never makes a step allocate.
    indices_.reserve(kUsualCandidates);
    candidates_.reserve(kUsualCandidates);
  }

  /// Candidates, lowest triangle index first; a superset of the triangles whose box meets [low, high]. `travel` is the
  /// expected motion over the next evaluations [m]; with `reuse` off the list is made anew for exactly this box.
  const std::vector<Candidate>& around(const Eigen::Vector3d& low, const Eigen::Vector3d& high,
                                       const Eigen::Vector3d& travel, const Terrain& terrain, bool reuse);
  void invalidate() { valid_ = false; }

 private:
  static constexpr std::size_t kUsualCandidates = 128;

  bool valid_ = false;
  Eigen::Vector3d low_, high_;  ///< the fattened box.
  std::vector<int> indices_;
  std::vector<Candidate> candidates_;
};

}  // namespace ellipsoid_vehicle_sim
