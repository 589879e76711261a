#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "ellipsoid_vehicle_sim/geometry/ellipsoid.h"
#include "ellipsoid_vehicle_sim/geometry/triangle.h"
#include "ellipsoid_vehicle_sim/world/terrain.h"

namespace ellipsoid_vehicle_sim {

/// A triangle an ellipsoid may touch.
struct Candidate {
  Triangle triangle;
  int index = -1;  ///< in the terrain.
};

/// Eight candidates side by side, for tests of all of them at once; lanes without one repeat the first in an empty box.
struct alignas(64) CandidateBlock {
  static constexpr int kWidth = 8;
  using Lane = double[kWidth];

  Lane v[3][3];          ///< corners: [corner][axis] [m].
  Lane low[3], high[3];  ///< the triangles' boxes [m].
  Lane nhat[3];          ///< unit normals, to the last bit those of `makeTriangle`.
  Lane edge[3][3];       ///< m_k, outward unit normals of the edges in the triangles' planes: [edge][axis].
  Lane size;             ///< longest edge [m].
  int index[kWidth];     ///< in the terrain; -1 without one.
};

/// The triangles around one ellipsoid. The tree is asked with a box fattened by the travel of the next steps; until the
/// ellipsoid leaves that box the answer is reused. Who uses a candidate first checks its own box against the
/// ellipsoid's, so a fresh and a reused list give the same contacts to the last bit.
class CandidateCache {
 public:
  /// How many steps' motion a list is made for: more of them, and it holds more triangles that no step needs.
  static constexpr double kStepsAhead = 40.0;

  CandidateCache() {
    // Ground of ordinary density then never makes a step allocate.
    indices_.reserve(kUsualCandidates);
    candidates_.reserve(kUsualCandidates);
    blocks_.reserve(kUsualCandidates / CandidateBlock::kWidth);
  }

  /// Candidates, lowest triangle index first; a superset of the triangles whose box meets [low, high]. `travel` is the
  /// expected motion over the next evaluations [m]; with `reuse` off the list is made anew for exactly this box.
  const std::vector<Candidate>& around(const Eigen::Vector3d& low, const Eigen::Vector3d& high,
                                       const Eigen::Vector3d& travel, const Terrain& terrain, bool reuse) {
    if (!(reuse && valid_ && low.x() >= low_.x() && low.y() >= low_.y() && low.z() >= low_.z() &&
          high.x() <= high_.x() && high.y() <= high_.y() && high.z() <= high_.z()))
      ask(low, high, travel, terrain, reuse);
    return candidates_;
  }
  const std::vector<Candidate>& candidates() const { return candidates_; }
  /// The box that they are listed for.
  Eigen::AlignedBox3d box() const { return {low_, high_}; }
  /// The same candidates in the same order, eight to a block.
  const std::vector<CandidateBlock>& blocks() const { return blocks_; }
  void invalidate() { valid_ = false; }

 private:
  static constexpr std::size_t kUsualCandidates = 128;
  void ask(const Eigen::Vector3d& low, const Eigen::Vector3d& high, const Eigen::Vector3d& travel,
           const Terrain& terrain, bool reuse);

  bool valid_ = false;
  Eigen::Vector3d low_, high_;  ///< the fattened box.
  std::vector<int> indices_;
  std::vector<Candidate> candidates_;
  std::vector<CandidateBlock> blocks_;
};

}  // namespace ellipsoid_vehicle_sim
