#include "ellipsoid_vehicle_sim/contact/candidate_cache.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ellipsoid_vehicle_sim/geometry/small_vector.h"

namespace ellipsoid_vehicle_sim {
namespace {

// The margin that pays: an unneeded candidate costs a few nanoseconds in each evaluation, a new query some hundred.
constexpr double kMarginOfSize = 0.03;

}  // namespace

void CandidateBlock::repeatLane(int lane) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto repeat = [lane](Lane& values) { std::fill(values + lane + 1, values + kWidth, values[lane]); };
  for (int axis = 0; axis < 3; ++axis) {
    std::fill(low[axis] + lane + 1, low[axis] + kWidth, kInfinity);
    std::fill(high[axis] + lane + 1, high[axis] + kWidth, -kInfinity);
    repeat(nhat[axis]);
    for (int k = 0; k < 3; ++k) repeat(v[k][axis]), repeat(edge[k][axis]);
  }
  repeat(size);
}

const std::vector<Candidate>& CandidateCache::around(const Eigen::Vector3d& low, const Eigen::Vector3d& high,
                                                     const Eigen::Vector3d& travel, const Terrain& terrain,
                                                     bool reuse) {
  if (reuse && valid_ && (low.array() >= low_.array()).all() && (high.array() <= high_.array()).all())
    return candidates_;

  low_ = low;
  high_ = high;
  if (reuse) {
    // Long jumps are not anticipated beyond the ellipsoid's own size: the list would fill with triangles of elsewhere.
    const Eigen::Vector3d size = high - low;
    const Eigen::Vector3d ahead = travel.cwiseMin(size).cwiseMax(-size);
    const Eigen::Vector3d margin = Eigen::Vector3d::Constant(kMarginOfSize * size.maxCoeff());
    low_ += ahead.cwiseMin(0.0) - margin;
    high_ += ahead.cwiseMax(0.0) + margin;
  }
  indices_.clear();
  terrain.query(Eigen::AlignedBox3d(low_, high_), indices_);
  std::sort(indices_.begin(), indices_.end());
  candidates_.resize(indices_.size());
  for (std::size_t i = 0; i < indices_.size(); ++i) {
    Candidate& candidate = candidates_[i];
    candidate.index = indices_[i];
    candidate.triangle = terrain.triangle(indices_[i]);
  }
  fillBlocks();
  valid_ = reuse;
  return candidates_;
}

void CandidateCache::fillBlocks() {
  constexpr std::size_t kWidth = CandidateBlock::kWidth;
  blocks_.resize((candidates_.size() + kWidth - 1) / kWidth);
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    CandidateBlock& block = blocks_[i / kWidth];
    const std::size_t lane = i % kWidth;
    const Triangle& triangle = candidates_[i].triangle;
    const auto& v = triangle.v;
    for (int axis = 0; axis < 3; ++axis) {
      block.low[axis][lane] = std::min({v[0][axis], v[1][axis], v[2][axis]});
      block.high[axis][lane] = std::max({v[0][axis], v[1][axis], v[2][axis]});
      block.nhat[axis][lane] = triangle.nhat_W[axis];
    }
    double longest_squared = 0.0;
    for (int k = 0; k < 3; ++k) {
      const Vec3 e = Vec3::from(v[(k + 1) % 3]) - Vec3::from(v[k]);
      const double length_squared = squaredNorm(e);
      longest_squared = std::max(longest_squared, length_squared);
      const Vec3 m = (1.0 / std::sqrt(length_squared)) * cross(e, Vec3::from(triangle.nhat_W));
      for (int axis = 0; axis < 3; ++axis) block.v[k][axis][lane] = v[k][axis];
      block.edge[k][0][lane] = m.x, block.edge[k][1][lane] = m.y, block.edge[k][2][lane] = m.z;
    }
    block.size[lane] = std::sqrt(longest_squared);
  }
  // Lanes left over repeat the last triangle in an empty box: nothing meets it, and no lane holds garbage.
  const std::size_t used = candidates_.size() % kWidth;
  if (used != 0) blocks_.back().repeatLane(static_cast<int>(used) - 1);
}

}  // namespace ellipsoid_vehicle_sim
