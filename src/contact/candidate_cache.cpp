#include "ellipsoid_vehicle_sim/contact/candidate_cache.h"

#include <algorithm>

#include "ellipsoid_vehicle_sim/contact/candidate_filter.h"

namespace ellipsoid_vehicle_sim {
namespace {

// The margin that pays: an unneeded candidate costs a few nanoseconds in each evaluation, a new query some hundred.
constexpr double kMarginOfSize = 0.03;

}  // namespace

void CandidateCache::ask(const Eigen::Vector3d& low, const Eigen::Vector3d& high, const Eigen::Vector3d& travel,
                         const Terrain& terrain, bool reuse) {
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
  terrain.candidates(Eigen::AlignedBox3d(low_, high_), indices_);
  terrain.prefetchCorners(indices_);
  std::sort(indices_.begin(), indices_.end());
  candidates_.resize(indices_.size());
  std::size_t count = 0;
  for (const int index : indices_) {
    Candidate& candidate = candidates_[count];
    candidate.index = index;
    auto& v = candidate.triangle.v;
    terrain.corners(index, v);
    const Eigen::Array3d lowest = v[0].cwiseMin(v[1]).cwiseMin(v[2]), highest = v[0].cwiseMax(v[1]).cwiseMax(v[2]);
    count += ((lowest <= high_.array()) && (highest >= low_.array())).all() ? 1 : 0;
  }
  candidates_.resize(count);

  constexpr std::size_t kWidth = CandidateBlock::kWidth;
  blocks_.resize((count + kWidth - 1) / kWidth);
  for (std::size_t begin = 0; begin < count; begin += kWidth) {
    CandidateBlock& block = blocks_[begin / kWidth];
    const std::size_t used = std::min(kWidth, count - begin);
    for (std::size_t lane = 0; lane < used; ++lane) {
      const Candidate& candidate = candidates_[begin + lane];
      block.index[lane] = candidate.index;
      for (std::size_t k = 0; k < 3; ++k)
        for (int axis = 0; axis < 3; ++axis) block.v[k][axis][lane] = candidate.triangle.v[k][axis];
    }
    std::fill(block.index + used, block.index + kWidth, -1);
    fillBlock(block, static_cast<int>(used));
    for (std::size_t lane = 0; lane < used; ++lane)
      candidates_[begin + lane].triangle.nhat_W = {block.nhat[0][lane], block.nhat[1][lane], block.nhat[2][lane]};
  }
  valid_ = reuse;
}

}  // namespace ellipsoid_vehicle_sim
