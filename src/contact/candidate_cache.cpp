#include "ellipsoid_vehicle_sim/contact/candidate_cache.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ellipsoid_vehicle_sim {
namespace {

// The margin that pays: an unneeded candidate costs a few nanoseconds in each evaluation, a new query some hundred.
constexpr double kMarginOfSize = 0.03;

}  // namespace

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
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  blocks_.resize((candidates_.size() + kWidth - 1) / kWidth);
  for (std::size_t i = 0; i < blocks_.size() * kWidth; ++i) {
    CandidateBlock& block = blocks_[i / kWidth];
    const std::size_t lane = i % kWidth;
    // Lanes left over repeat the last triangle in an empty box: nothing meets it, and no lane holds garbage.
    const bool empty = i >= candidates_.size();
    const Triangle& triangle = candidates_[empty ? candidates_.size() - 1 : i].triangle;
    const auto& v = triangle.v;
    for (int axis = 0; axis < 3; ++axis) {
      block.low[axis][lane] = empty ? kInfinity : std::min({v[0][axis], v[1][axis], v[2][axis]});
      block.high[axis][lane] = empty ? -kInfinity : std::max({v[0][axis], v[1][axis], v[2][axis]});
      block.nhat[axis][lane] = triangle.nhat_W[axis];
    }
    double longest_squared = 0.0;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d e = v[(k + 1) % 3] - v[k];
      const double length_squared = e.squaredNorm();
      longest_squared = std::max(longest_squared, length_squared);
      const Eigen::Vector3d m = e.cross(triangle.nhat_W) / std::sqrt(length_squared);
      for (int axis = 0; axis < 3; ++axis) {
        block.v[k][axis][lane] = v[k][axis];
        block.edge[k][axis][lane] = m[axis];
      }
    }
    block.size[lane] = std::sqrt(longest_squared);
  }
}

}  // namespace ellipsoid_vehicle_sim
