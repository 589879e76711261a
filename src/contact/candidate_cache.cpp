#include "ellipsoid_vehicle_sim/contact/candidate_cache.h"

#include <algorithm>

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
    const auto& v = candidate.triangle.v;
    candidate.low = v[0].cwiseMin(v[1]).cwiseMin(v[2]);
    candidate.high = v[0].cwiseMax(v[1]).cwiseMax(v[2]);
  }
  valid_ = reuse;
  return candidates_;
}

}  // namespace ellipsoid_vehicle_sim
