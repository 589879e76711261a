#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "ellipsoid_vehicle_sim/contact/candidate_filter.h"
#include "ellipsoid_vehicle_sim/geometry/ellipsoid.h"
#include "ellipsoid_vehicle_sim/geometry/small_vector.h"

namespace ellipsoid_vehicle_sim {

/// A face contact that was proved to be an ellipsoid's only one, and around which poses the proof holds: there the
/// contact itself is worked out and nothing else is looked at. Many queries of a wheel that rolls, and all of one that
/// stands, end here. It is a temporal cache that changes no answer; what it remembers is geometry, not state.
class SoleContact {
 public:
  static constexpr int kNone = -1;

  /// Whether the proof holds at this pose; false also for one that is not a number.
  bool covers(const PosedEllipsoid& e) const {
    if (travel_squared_ < 0.0) return false;
    const Vec3 way = Vec3::from(e.p_WE) - c_;
    const Vec3 sides = {e.A(0, 0) - A_diagonal_.x, e.A(1, 1) - A_diagonal_.y, e.A(2, 2) - A_diagonal_.z};
    const Vec3 corners = {e.A(0, 1) - A_beside_.x, e.A(0, 2) - A_beside_.y, e.A(1, 2) - A_beside_.z};
    const double change_squared = squaredNorm(sides) + 2.0 * squaredNorm(corners);
    const double along = dot(way, direction_), across_squared = squaredNorm(way) - along * along;
    const double travel_squared = (along > 0.0 ? 1.0 : kAcross) * along * along + kAcross * across_squared;
    // (a + b)^2 <= 5/4 a^2 + 5 b^2: the sum, without its roots.
    return 1.25 * travel_squared + change_weight_ * change_squared <= travel_squared_ && listed_.contains(e.p_WE);
  }

  /// Its place in the list of candidates; kNone where no triangle is near, so that there is no contact at all.
  int candidate() const { return candidate_; }
  /// Depths up to this are covered [m].
  double deepest() const { return deepest_; }
  void countUse() { ++uses_; }

  /// Whether a proof for this triangle's contact is worth its price: it was that of the last search too, and proofs
  /// have been of use lately. `way` is what the ellipsoid has gone since the last accepted pose, and goes on [m].
  bool isWorthProving(int triangle, const Vec3& way) {
    const bool again = triangle == triangle_;
    triangle_ = triangle;
    if (!again) return false;
    if (waiting_ > 0) return --waiting_, false;
    pause_ = uses_ >= kUsesThatPay ? 0 : std::min(2 * pause_ + 1, kLongestPause);
    waiting_ = pause_;
    uses_ = 0;
    const double length = norm(way);
    direction_ = length > kStanding ? (1.0 / length) * way : Vec3{0.0, 0.0, 0.0};
    return true;
  }
  const Vec3& direction() const { return direction_; }
  /// A search begins.
  void forget() { travel_squared_ = kNowhere; }

  /// What a search has proved: `travel` as LaneTravel's [m], `listed` the box whose triangles are candidates, `deepest`
  /// the depth up to which the proof holds [m].
  void hold(int candidate, const PosedEllipsoid& e, const Eigen::AlignedBox3d& listed, double travel, double deepest) {
    const double r_max = e.radii.maxCoeff(), r_min = e.radii.minCoeff();
    if (!(travel > 0.0)) return;
    candidate_ = candidate;
    c_ = Vec3::from(e.p_WE);
    A_diagonal_ = {e.A(0, 0), e.A(1, 1), e.A(2, 2)};
    A_beside_ = {e.A(0, 1), e.A(0, 2), e.A(1, 2)};
    const double per_change = kTravelPerChange * r_max / (r_min * r_min);
    change_weight_ = 5.0 * per_change * per_change;
    // Not so far that A could change by more than a hundredth of r_min^2, and the sides of its box by half of that.
    const double reached = std::min(travel, std::sqrt(5.0) * kLargestChange * kTravelPerChange * r_max);
    travel_squared_ = reached * reached;
    const Eigen::Vector3d half = (1.0 + kLargestChange) * e.halfBox();
    listed_ = {listed.min() + half, listed.max() - half};
    deepest_ = deepest;
  }

 private:
  static constexpr double kNowhere = -1.0;
  static constexpr double kLargestChange = 0.01;
  static constexpr double kAcross = 1.0 / (kTravelWidth * kTravelWidth);
  static constexpr double kStanding = 1e-9;  ///< [m].
  static constexpr int kUsesThatPay = 3, kLongestPause = 63;

  double travel_squared_ = kNowhere;
  double change_weight_ = 0.0;
  Vec3 direction_{0.0, 0.0, 0.0};
  Vec3 c_{0.0, 0.0, 0.0}, A_diagonal_{0.0, 0.0, 0.0}, A_beside_{0.0, 0.0, 0.0};
  Eigen::AlignedBox3d listed_;  ///< of the centre.
  double deepest_ = 0.0;
  int candidate_ = kNone;
  int triangle_ = -1;            ///< of the last search.
  int uses_ = 0;                 ///< of the last proof.
  int pause_ = 0, waiting_ = 0;  ///< searches without a proof, after one that was of no use.
};

}  // namespace ellipsoid_vehicle_sim
