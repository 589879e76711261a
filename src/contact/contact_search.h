#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "contact_taking.h"
#include "ellipsoid_vehicle_sim/contact/candidate_filter.h"
#include "ellipsoid_vehicle_sim/contact/shortest_push.h"

namespace ellipsoid_vehicle_sim {

// The inside of find_contacts.cpp.

// Depths this close, in parts of themselves, are worked out before one is called the deeper [-]; above the solver's
// rounding.
constexpr double kTieMargin = 1e-12;
// Normals of one contact seen from two triangles differ by rounding, magnified where the depth hardly depends on them
// [-].
constexpr double kSameNormal = 1e-6;
// What a cheap plane test may be off by before a triangle is left out on its word [m]; the exact test decides on the
// rest.
constexpr double kPruneSlack = 1e-9;
// Depth that arithmetic alone may leave after a push that clears [m], and in parts of the distance from the origin.
constexpr double kLeftByRounding = 1e-12, kRelativeRounding = 1e-15;

inline FilterEllipsoid filterOf(const PosedEllipsoid& ellipsoid) {
  const Vec3 r = Vec3::from(ellipsoid.radii);
  return {Vec3::from(ellipsoid.p_WE),
          columns(ellipsoid.R_WE),
          r,
          {1.0 / r.x, 1.0 / r.y, 1.0 / r.z},
          Vec3::from(ellipsoid.halfBox())};
}

/// One evaluation: the ellipsoid, the lists and what has been taken so far.
class ContactSearch {
 public:
  ContactSearch(const PosedEllipsoid& ellipsoid, const FilterEllipsoid& filter, const ContactMemory& memory,
                const ContactOptions& options, const ContactTaking& taking, const Vec3& way, ContactFinder& finder)
      : ellipsoid_(ellipsoid),
        filter_(filter),
        memory_(memory),
        options_(options),
        taking_(taking),
        way_(way),
        candidates_(finder.cache.candidates()),
        blocks_(finder.cache.blocks()),
        near_(finder.near),
        sole_(finder.sole) {
    near_.resize(blocks_.size());
    std::uint32_t behind = 0;
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      testPlanes(blocks_[i], filter_, kPruneSlack, near_[i].plane);
      near_[i].done = 0;
      behind |= near_[i].plane.behind;
    }
    finder.behind_any = finder.behind_any || behind != 0;
  }

  void run(EllipsoidContacts& result) {
    int winner = likeliest();
    if (winner < 0) return;
    const int expected = winner;
    // Made here, not copied: who reads as pairs what was written number by number waits for it.
    TriangleContact first = meet(ellipsoid_, triangleOf(winner), options_.rule, 0.0);
    winner = deepest(winner, first);
    if (winner >= 0 && !taking_.admitted(candidates_[winner])) winner = nextAdmitted(winner, first);
    if (winner < 0) return;

    const Candidate& candidate = candidates_[winner];
    near_[winner / kWidth].done |= 1u << winner % kWidth;
    taking_.take(result, candidate.index, first, taking_.feltDepth(first, candidate));
    if (options_.contacts == ContactsPerEllipsoid::kValley) addValleyContacts(result, first);
    sole_candidate_ = winner == expected && result.count == 1 ? winner : SoleContact::kNone;
  }

  /// The candidate that is the only contact, and how far it stays so (see LaneTravel); kNone where that was not asked.
  int soleCandidate() const { return travel_ > 0.0 ? sole_candidate_ : SoleContact::kNone; }
  double travel() const { return travel_; }

 private:
  static constexpr int kWidth = CandidateBlock::kWidth;

  /// The outcome of a search of a valley; candidate -1 without any.
  struct Found {
    int candidate = -1;
    TriangleContact contact;  ///< of the pushed ellipsoid.
    TriangleContact at_pose;  ///< with the ellipsoid where it stands.
  };

  const Triangle& triangleOf(int candidate) const { return candidates_[candidate].triangle; }

  /// Near, and neither taken nor turned away.
  std::uint32_t waiting(std::size_t block) const { return near_[block].plane.near & ~near_[block].done; }

  /// Calls use(candidate) for the lanes of lanes(block), lowest first.
  template <typename Lanes, typename Use>
  void forEach(const Lanes& lanes, const Use& use) const {
    for (std::size_t i = 0; i < near_.size(); ++i)
      for (std::uint32_t mask = lanes(i); mask != 0; mask &= mask - 1)
        use(static_cast<int>(i) * kWidth + __builtin_ctz(mask));
  }

  /// The plane depth, h(n) - s > depth, without the root.
  bool isDeeperThan(int candidate, double depth) const {
    const PlaneTest& plane = near_[candidate / kWidth].plane;
    const int lane = candidate % kWidth;
    const double reach = plane.height[lane] + depth;
    return reach < 0.0 || plane.half_width_squared[lane] > reach * reach;
  }

  /// The near triangle that is looked at first; most others are then proved shallower without being worked out. That of
  /// the last pose, or one the centre stands over. -1 when none is near.
  int likeliest() const {
    int any = -1;
    const int last = memory_.count > 0 ? memory_.carried[0].triangle : -1;
    for (std::size_t i = 0; i < near_.size(); ++i) {
      const std::uint32_t near = near_[i].plane.near;
      if (near == 0) continue;
      if (any < 0) any = static_cast<int>(i) * kWidth + __builtin_ctz(near);
      if (last < 0) continue;
      const std::uint32_t same = near & lanesOf(blocks_[i], last);
      if (same != 0) return static_cast<int>(i) * kWidth + __builtin_ctz(same);
    }
    if (any < 0) return any;
    for (std::size_t i = 0; i < near_.size(); ++i) {
      const std::uint32_t below =
          near_[i].plane.near == 0 ? 0 : near_[i].plane.near & lanesBelow(blocks_[i], filter_.c);
      if (below != 0) return static_cast<int>(i) * kWidth + __builtin_ctz(below);
    }
    return any;
  }

  static std::uint32_t lanesOf(const CandidateBlock& block, int triangle) {
    std::uint32_t lanes = 0;
    for (int lane = 0; lane < kWidth; ++lane)
      lanes |= static_cast<std::uint32_t>(block.index[lane] == triangle) << lane;
    return lanes;
  }

  KnownPush knownPush(const TriangleContact& contact) const {
    const Vec3 u = Vec3::from(contact.nhat_W), lowest = Vec3::from(contact.p_WE_lowest);
    return {u, lowest + contact.depth * u, dot(u, filter_.c - lowest), contact.depth};
  }

  /// Whether to find out how far the ellipsoid may go with this contact alone.
  bool isSoleWorthProving(int winner, const TriangleContact& contact) {
    return options_.cache && contact.feature == Feature::kFace && sole_.isWorthProving(candidates_[winner].index, way_);
  }

  /// Holds all that wait, but for `winner`, against its contact: what may be deeper is open, what may hold the
  /// ellipsoid after the push is held, and rises_ tells whether anything rises above the contact's plane.
  bool holdAgainst(int winner, const TriangleContact& contact, bool prove_sole = false) {
    const KnownPush push = knownPush(contact);
    std::uint32_t open = 0, rises = 0;
    PushTest test;
    LaneTravel travel;
    if (prove_sole) {
      travel.direction = sole_.direction();
      travel_ = std::numeric_limits<double>::infinity();
    }
    for (std::size_t i = 0; i < near_.size(); ++i) {
      NearBlock& near = near_[i];
      std::uint32_t rivals = waiting(i);
      if (winner >= 0 && winner / kWidth == static_cast<int>(i)) rivals &= ~(1u << winner % kWidth);
      near.open = near.held = 0;
      if (rivals == 0 && !prove_sole) continue;
      testPush(blocks_[i], near.plane, rivals, filter_, push, kPruneSlack, test, prove_sole ? &travel : nullptr);
      near.open = rivals & test.deep & ~test.shallower;
      near.held = rivals & test.deep_after & ~test.cleared;
      open |= near.open;
      rises |= rivals & test.rises;
      if (!prove_sole) continue;
      for (int lane = 0; lane < kWidth; ++lane)
        if (static_cast<int>(i) * kWidth + lane != winner)
          travel_ = std::min(travel_, travel.travel[lane] > 0.0 ? travel.travel[lane] : -1.0);  // also for NaN
    }
    rises_ = rises != 0;
    held_by_ = winner;
    return open != 0;
  }

  /// The deepest contact among those that wait: `winner` and its contact are one of them, to begin with. -1 without
  /// any.
  int deepest(int winner, TriangleContact& best) {
    held_by_ = -1;
    const int first = winner;
    if (!best) winner = -1;
    // No minimum translation exceeds the depth below the plane; the document's rule may.
    const bool bounded = options_.rule == ContactRule::kMinimumTranslation;
    const bool held_against = bounded && winner >= 0;
    if (held_against && !holdAgainst(winner, best, isSoleWorthProving(winner, best))) return winner;

    forEach([&](std::size_t i) { return held_against ? near_[i].open : waiting(i); },
            [&](int i) {
              if (i == first || (bounded && !isDeeperThan(i, best.depth - kPruneSlack))) return;
              // Lowest index wins a tie, in whatever order they come; a floor at the depth itself would leave ties to
              // rounding.
              const double floor = i < winner ? best.depth * (1.0 - kTieMargin) : best.depth;
              const TriangleContact contact = meet(ellipsoid_, triangleOf(i), options_.rule, floor);
              if (!contact || contact.depth < best.depth || (contact.depth == best.depth && i > winner)) return;
              best = contact;
              winner = i;
            });
    return winner;
  }

  /// The deepest that may push, when that of `winner` may not. Two triangles make the same contact at the edge they
  /// share, and rounding decides which of them is deeper: one that is turned away for coming into front just now is
  /// taken after all when the next makes that contact too.
  int nextAdmitted(int winner, TriangleContact& best) {
    const int turned_away = winner;
    const TriangleContact turned_away_contact = best;
    for (;;) {
      near_[winner / kWidth].done |= 1u << winner % kWidth;
      winner = -1;
      for (std::size_t i = 0; i < near_.size() && winner < 0; ++i)
        if (waiting(i) != 0) winner = static_cast<int>(i) * kWidth + __builtin_ctz(waiting(i));
      if (winner < 0) return -1;
      best = meet(ellipsoid_, triangleOf(winner), options_.rule, 0.0);
      winner = deepest(winner, best);
      if (winner < 0) return -1;
      if (!taking_.admitted(candidates_[winner])) continue;
      if (!isSame(turned_away_contact, best)) return winner;
      // The other made the contact that is taken.
      near_[winner / kWidth].done |= 1u << winner % kWidth;
      held_by_ = -1;
      best = turned_away_contact;
      return turned_away;
    }
  }

  static bool isSame(const TriangleContact& a, const TriangleContact& b) {
    return std::abs(a.depth - b.depth) <= kExplained &&
           (a.nhat_W - b.nhat_W).squaredNorm() <= kSameNormal * kSameNormal;
  }

  /// What still holds the ellipsoid after the push of the first contact: a wall beside the ground, a kerb's edge.
  void addValleyContacts(EllipsoidContacts& result, const TriangleContact& first) {
    const bool bounded = options_.rule == ContactRule::kMinimumTranslation;
    if (held_by_ < 0 || candidates_[held_by_].index != result.contact[0].triangle) holdAgainst(-1, first);
    // On flat and convex ground the first push clears everything.
    if (!rises_) return;

    Eigen::Vector3d push = first.depth * first.nhat_W;
    std::array<Eigen::Vector3d, kMaxContactsPerEllipsoid> nhat;
    std::array<double, kMaxContactsPerEllipsoid> depth{};
    nhat[0] = first.nhat_W;
    depth[0] = first.depth;
    while (result.count < kMaxContactsPerEllipsoid) {
      bool any = !bounded;
      for (std::size_t i = 0; i < near_.size(); ++i) {
        near_[i].open = bounded ? near_[i].held & ~near_[i].done : waiting(i);
        any = any || near_[i].open != 0;
      }
      if (!any) return;
      const PosedEllipsoid pushed = moved(ellipsoid_, push);
      Found found;
      if (!findLeft(pushed, push, found)) return;

      const Candidate& candidate = candidates_[found.candidate];
      const TriangleContact& left = found.contact;
      const double full = left.depth + push.dot(left.nhat_W);
      // What the triangle's own contact owes to a jump is taken off here too.
      const double lost = found.at_pose.depth - taking_.feltDepth(found.at_pose, candidate);
      const int slot = result.count;
      const Eigen::Vector3d lowest = left.p_WE_lowest - push;
      taking_.take(result, candidate.index, left.nhat_W, lowest, full, full - lost);
      nhat[slot] = left.nhat_W;
      depth[slot] = full;
      push = shortestPush(nhat, depth, result.count).p;
      // The next push is another: all that wait are asked again.
      for (std::size_t i = 0; i < near_.size(); ++i) near_[i].held = waiting(i);
    }
  }

  /// The deepest that still holds the pushed ellipsoid and may push; as `nextAdmitted`.
  bool findLeft(const PosedEllipsoid& pushed, const Eigen::Vector3d& push, Found& found) {
    Found turned_away;
    for (;;) {
      found = deepestLeft(pushed, push);
      if (found.candidate < 0) return false;
      near_[found.candidate / kWidth].done |= 1u << found.candidate % kWidth;
      if (taking_.admitted(candidates_[found.candidate])) {
        if (turned_away.candidate >= 0 && isSame(turned_away.contact, found.contact)) found = turned_away;
        return true;
      }
      if (turned_away.candidate < 0) turned_away = found;
      // What was shallower than this one may be the deepest now.
      for (std::size_t i = 0; i < near_.size(); ++i) near_[i].open = waiting(i);
    }
  }

  /// The deepest contact of the pushed ellipsoid with an open triangle that the ellipsoid touches where it stands. What
  /// rounding leaves of a triangle that the push clears, such as the other one at an edge, is none.
  Found deepestLeft(const PosedEllipsoid& pushed, const Eigen::Vector3d& push) const {
    const bool bounded = options_.rule == ContactRule::kMinimumTranslation;
    const double rounding = kLeftByRounding + kRelativeRounding * ellipsoid_.p_WE.cwiseAbs().maxCoeff();
    Found best;
    forEach([&](std::size_t i) { return near_[i].open & ~near_[i].done; },
            [&](int i) {
              const Triangle& triangle = triangleOf(i);
              const double needed = bounded ? best.contact.depth : 0.0;
              if (!isDeeperThan(i, needed + push.dot(triangle.nhat_W) - kPruneSlack)) return;
              const TriangleContact left =
                  meet(pushed, triangle, options_.rule, std::max(best.contact.depth, rounding));
              if (!left) return;
              const TriangleContact at_pose = meet(ellipsoid_, triangle, options_.rule, 0.0);
              if (!at_pose) return;
              best = {i, left, at_pose};
            });
    return best;
  }

  const PosedEllipsoid& ellipsoid_;
  const FilterEllipsoid& filter_;
  const ContactMemory& memory_;
  const ContactOptions& options_;
  const ContactTaking& taking_;
  const Vec3& way_;  ///< since the last accepted pose [m].
  const std::vector<Candidate>& candidates_;
  const std::vector<CandidateBlock>& blocks_;
  std::vector<NearBlock>& near_;
  SoleContact& sole_;
  int sole_candidate_ = SoleContact::kNone;
  double travel_ = -1.0;  ///< with the likeliest's contact alone [m].
  int held_by_ = -1;      ///< the candidate whose contact `holdAgainst` was asked with.
  bool rises_ = false;    ///< some triangle rises above the plane of that contact.
};

}  // namespace ellipsoid_vehicle_sim
