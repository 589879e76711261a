#include "ellipsoid_vehicle_sim/contact/find_contacts.h"

#include <algorithm>
#include <cmath>

#include "ellipsoid_vehicle_sim/contact/candidate_filter.h"
#include "ellipsoid_vehicle_sim/contact/shortest_push.h"

namespace ellipsoid_vehicle_sim {
namespace {

// Depths that differ by less are the same push seen from two poses [m]; a nanometre is far below any contact's sag.
constexpr double kSameDepth = 1e-9;
// Rounding allowance when a depth is compared with its explanation [m].
constexpr double kExplained = 1e-12;
// Depths this close, in parts of themselves, are worked out before one is called the deeper [-]; above the solver's
// rounding.
constexpr double kTieMargin = 1e-12;
// Normals of one contact seen from two triangles differ by rounding, magnified where the depth hardly depends on them
// [-].
constexpr double kSameNormal = 1e-6;
// h(u) changes by at most this times r_max per radian of turn when the axes' ratio is unbounded; [ContactDefinition] 6.
constexpr double kTurnReach = 1.12;

// What a cheap plane test may be off by before a triangle is left out on its word [m]; the exact test decides on the
// rest.
constexpr double kPruneSlack = 1e-9;
// Depth that arithmetic alone may leave after a push that clears [m], and in parts of the distance from the origin.
constexpr double kLeftByRounding = 1e-12, kRelativeRounding = 1e-15;

TriangleContact meet(const PosedEllipsoid& ellipsoid, const Triangle& triangle, ContactRule rule, double floor_depth) {
  if (rule == ContactRule::kMinimumTranslation) return minimumTranslation(ellipsoid, triangle, floor_depth);
  const TriangleContact contact = clampedPoint(ellipsoid, triangle);
  return contact.depth > floor_depth ? contact : TriangleContact{};
}

PosedEllipsoid moved(const PosedEllipsoid& ellipsoid, const Eigen::Vector3d& push) {
  PosedEllipsoid result = ellipsoid;
  result.p_WE += push;
  return result;
}

bool centreInFront(const PosedEllipsoid& ellipsoid, const Triangle& triangle) {
  return triangle.nhat_W.dot(ellipsoid.p_WE - triangle.v[0]) > 0.0;
}

// W(u): how far the supporting plane along the fixed u has moved in since the remembered pose; half_width is h0(u)
// there.
double advance(const PosedEllipsoid& ellipsoid, const ContactMemory& memory, const Eigen::Vector3d& u,
               double half_width) {
  return u.dot(memory.posed.p_WE - ellipsoid.p_WE) - half_width + ellipsoid.halfWidth(u);
}

// Angle between the remembered and the present axes [rad].
double angleTurned(const Eigen::Matrix3d& R0, const Eigen::Matrix3d& R1) {
  // |R0 - R1|_F = 2 sqrt(2) sin(angle / 2): keeps its digits for small angles, where the trace loses them.
  return 2.0 * std::asin(std::min(1.0, (R0 - R1).norm() / (2.0 * std::sqrt(2.0))));
}

FilterEllipsoid filterOf(const PosedEllipsoid& ellipsoid) {
  const Vec3 r = Vec3::from(ellipsoid.radii);
  return {Vec3::from(ellipsoid.p_WE),
          columns(ellipsoid.R_WE),
          r,
          {1.0 / r.x, 1.0 / r.y, 1.0 / r.z},
          Vec3::from(ellipsoid.halfBox())};
}

// One evaluation: the ellipsoid, the lists and what has been taken so far.
class Evaluation {
 public:
  Evaluation(const PosedEllipsoid& ellipsoid, const FilterEllipsoid& filter, const ContactMemory& memory,
             const ContactOptions& options, const std::vector<Candidate>& candidates, ContactFinder& finder)
      : ellipsoid_(ellipsoid),
        filter_(filter),
        memory_(memory),
        options_(options),
        candidates_(candidates),
        blocks_(finder.cache.blocks()),
        near_(finder.near) {
    near_.clear();
    constexpr int kWidth = CandidateBlock::kWidth;
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      PlaneTest test;
      testPlanes(blocks_[i], filter_, kPruneSlack, test);
      finder.behind_any = finder.behind_any || test.behind != 0;
      for (std::uint32_t mask = test.near; mask != 0; mask &= mask - 1) {
        const int lane = __builtin_ctz(mask);
        near_.push_back(
            {static_cast<int>(i) * kWidth + lane, test.height[lane], test.half_width_squared[lane], false, false});
      }
    }
  }

  void run(EllipsoidContacts& result) {
    const Found first = deepestAdmitted([this] { return deepest(); });
    if (first.candidate < 0) return;

    const Candidate& candidate = candidates_[near_[first.candidate].candidate];
    take(result, candidate.index, first.contact.nhat_W, first.contact.p_WE_lowest, first.contact.depth,
         feltDepth(first.contact, candidate));
    if (options_.contacts == ContactsPerEllipsoid::kValley) addValleyContacts(result, first.contact);
  }

 private:
  // The outcome of a search; candidate -1 without any.
  struct Found {
    int candidate = -1;
    TriangleContact contact;
    TriangleContact at_pose;  ///< valley: with the ellipsoid where it stands, not pushed.
  };

  // The deepest that may push. Two triangles make the same contact at the edge they share, and rounding decides which
  // of them is deeper: one that is turned away for coming into front just now is taken after all when the next makes
  // that contact too.
  template <typename Search>
  Found deepestAdmitted(const Search& search) {
    Found turned_away;
    for (;;) {
      const Found found = search();
      if (found.candidate < 0) return found;
      near_[found.candidate].done = true;
      if (admitted(candidates_[near_[found.candidate].candidate]))
        return turned_away.candidate >= 0 && isSame(turned_away.contact, found.contact) ? turned_away : found;
      if (turned_away.candidate < 0) turned_away = found;
      // What was shallower than this one may be the deepest now.
      forgetCleared();
    }
  }

  void forgetCleared() {
    for (NearTriangle& near : near_) near.cleared = false;
  }

  // Calls use(block, wanted, set) for each block with near triangles that `chosen` takes: their lanes, and set(bits) to
  // be told of which of them something holds.
  template <typename Chosen, typename Use>
  void forBlocks(const Chosen& chosen, const Use& use) {
    constexpr int kWidth = CandidateBlock::kWidth;
    for (std::size_t i = 0; i < near_.size();) {
      const int block = near_[i].candidate / kWidth;
      const std::size_t begin = i;
      std::uint32_t wanted = 0;
      for (; i < near_.size() && near_[i].candidate / kWidth == block; ++i)
        if (chosen(near_[i])) wanted |= 1u << near_[i].candidate % kWidth;
      if (wanted == 0) continue;
      if (use(blocks_[block], wanted, begin, i)) return;
    }
  }

  // Marks what is not cleared yet and a push proves to be of no interest, to the ellipsoid as `filter` has it.
  void clear(const FilterEllipsoid& filter, const KnownPush& push) {
    forBlocks([](const NearTriangle& near) { return !near.done && !near.cleared; },
              [&](const CandidateBlock& block, std::uint32_t wanted, std::size_t begin, std::size_t end) {
                const std::uint32_t cleared = testPush(block, wanted, filter, push);
                for (std::size_t i = begin; i < end; ++i)
                  if ((cleared >> near_[i].candidate % CandidateBlock::kWidth & 1u) != 0) near_[i].cleared = true;
                return false;
              });
  }

  // Does any triangle that was not taken rise above the plane of a contact?
  bool anyRises(const KnownPush& push) {
    bool found = false;
    forBlocks([](const NearTriangle& near) { return !near.done; },
              [&](const CandidateBlock& block, std::uint32_t wanted, std::size_t, std::size_t) {
                return found = testRise(block, wanted, filter_, push) != 0;
              });
    return found;
  }

  // Leaves out what is no deeper below its plane than `depth` (of the triangle's normal); tells whether any is left.
  template <typename Depth>
  bool keepDeeper(const Depth& depth) {
    bool any = false;
    for (NearTriangle& near : near_) {
      near.cleared = near.done || !near.isDeeperThan(depth(near) - kPruneSlack);
      any = any || !near.cleared;
    }
    return any;
  }

  KnownPush knownPush(const TriangleContact& contact, double depth) const {
    return {Vec3::from(contact.nhat_W), Vec3::from(contact.trianglePoint()), ellipsoid_.halfWidth(contact.nhat_W),
            depth};
  }

  static bool isSame(const TriangleContact& a, const TriangleContact& b) {
    return std::abs(a.depth - b.depth) <= kExplained &&
           (a.nhat_W - b.nhat_W).squaredNorm() <= kSameNormal * kSameNormal;
  }

  void take(EllipsoidContacts& result, int triangle, const Eigen::Vector3d& u, const Eigen::Vector3d& lowest,
            double depth, double felt) const {
    Contact& contact = result.contact[result.count++];
    contact.triangle = triangle;
    contact.nhat_W = u;
    contact.p_WE_lowest = lowest;
    contact.depth = depth;
    contact.pressed = std::max(0.0, felt - (options_.memory ? memory_.slack : 0.0));
    contact.share = 1.0;
  }

  // The near triangle that is looked at first; most others are then proved shallower without being worked out. That of
  // the last pose, or one the centre stands over.
  int likeliest() const {
    const int count = static_cast<int>(near_.size());
    for (int i = 0; i < count && memory_.count > 0; ++i)
      if (candidates_[near_[i].candidate].index == memory_.carried[0].triangle) return i;
    for (int i = 0; i < count; ++i) {
      const CandidateBlock& block = blocks_[near_[i].candidate / CandidateBlock::kWidth];
      const int lane = near_[i].candidate % CandidateBlock::kWidth;
      bool inside = !near_[i].done;
      for (int k = 0; k < 3 && inside; ++k) {
        double beyond = 0.0;
        for (int axis = 0; axis < 3; ++axis)
          beyond += block.edge[k][axis][lane] * (ellipsoid_.p_WE[axis] - block.v[k][axis][lane]);
        inside = beyond <= 0.0;
      }
      if (inside) return i;
    }
    return 0;
  }

  // The deepest contact among the candidates that are not left out.
  Found deepest() {
    TriangleContact best;
    int winner = -1;
    // No minimum translation exceeds the depth below the plane; the document's rule may.
    const bool bounded = options_.rule == ContactRule::kMinimumTranslation;
    const auto consider = [&](int i) {
      const NearTriangle& near = near_[i];
      if (near.done || near.cleared || (bounded && !near.isDeeperThan(best.depth - kPruneSlack))) return;
      // Lowest index wins a tie, in whatever order they come; a floor at the depth itself would leave ties to rounding.
      const double floor = i < winner ? best.depth * (1.0 - kTieMargin) : best.depth;
      const TriangleContact contact = meet(ellipsoid_, candidates_[near.candidate].triangle, options_.rule, floor);
      if (!contact || contact.depth < best.depth || (contact.depth == best.depth && i > winner)) return;
      best = contact;
      winner = i;
    };
    const int count = static_cast<int>(near_.size());
    const int warm = likeliest();
    if (count > 0) consider(warm);
    if (bounded && winner >= 0) {
      // The winner is asked no more in this search.
      const bool done = near_[winner].done;
      near_[winner].done = true;
      const bool rivals = keepDeeper([&](const NearTriangle&) { return best.depth; });
      if (rivals) clear(filter_, knownPush(best, best.depth));
      near_[winner].done = done;
      if (!rivals) return {winner, best, {}};
    }
    for (int i = 0; i < count; ++i)
      if (i != warm) consider(i);
    return {winner, best, {}};
  }

  bool carried(int triangle) const {
    for (int i = 0; i < memory_.count; ++i)
      if (memory_.carried[i].triangle == triangle) return true;
    return false;
  }

  // May this triangle push? It must have been known, or have had the centre in front and been no deeper than the
  // others.
  bool admitted(const Candidate& candidate) const {
    const Triangle& triangle = candidate.triangle;
    if (!options_.memory || memory_.fresh || carried(candidate.index)) return true;
    if (!centreInFront(memory_.posed, triangle)) return false;
    const TriangleContact before = meet(memory_.posed, triangle, options_.rule, 0.0);
    if (!before) return true;
    if (options_.contacts == ContactsPerEllipsoid::kOne || memory_.count == kMaxContactsPerEllipsoid)
      return before.depth <= memory_.deepest + kSameDepth;
    return meet(moved(memory_.posed, memory_.push), triangle, options_.rule, 0.0).depth <= kSameDepth;
  }

  // The part of a contact's depth that motion since the remembered pose explains; the rest is a jump.
  double feltDepth(const TriangleContact& contact, const Candidate& candidate) const {
    if (!options_.memory || memory_.fresh) return contact.depth;
    const double depth = contact.depth;

    double reached = -1.0, base_depth = 0.0, base_advance = 0.0;
    const auto explain = [&](double delta, double advanced) {
      if (delta + advanced <= reached) return;
      reached = delta + advanced;
      base_depth = delta;
      base_advance = advanced;
    };
    for (int i = 0; i < memory_.count; ++i) {
      const CarriedContact& base = memory_.carried[i];
      explain(base.depth, advance(ellipsoid_, memory_, base.nhat_W, base.half_width));
    }
    if (depth <= reached + kExplained) return depth;

    // Only now the triangle's own past is worked out: it is needed once in many steps.
    const TriangleContact before = meet(memory_.posed, candidate.triangle, options_.rule, 0.0);
    double bound = reached;
    if (before) {
      explain(before.depth, advance(ellipsoid_, memory_, before.nhat_W, memory_.posed.halfWidth(before.nhat_W)));
      bound = reached;
    } else {
      const double travel = (ellipsoid_.p_WE - memory_.posed.p_WE).norm();
      const double turn = angleTurned(memory_.posed.R_WE, ellipsoid_.R_WE);
      bound = std::max(reached, travel + kTurnReach * turn * ellipsoid_.radii.maxCoeff());
    }
    if (depth <= bound + kExplained) return depth;

    const double along = advance(ellipsoid_, memory_, contact.nhat_W, memory_.posed.halfWidth(contact.nhat_W));
    if (memory_.count == 0 && !before) return std::min(depth, std::max(0.0, along));
    return std::min(depth, std::max(0.0, base_depth + std::min(base_advance, along)));
  }

  // What still holds the ellipsoid after the push of the first contact: a wall beside the ground, a kerb's edge.
  void addValleyContacts(EllipsoidContacts& result, const TriangleContact& first) {
    // On flat and convex ground the first push clears everything.
    const KnownPush known = knownPush(first, 0.0);
    if (!anyRises(known)) return;

    Eigen::Vector3d push = first.depth * first.nhat_W;
    std::array<Eigen::Vector3d, kMaxContactsPerEllipsoid> nhat;
    std::array<double, kMaxContactsPerEllipsoid> depth{};
    nhat[0] = first.nhat_W;
    depth[0] = first.depth;
    while (result.count < kMaxContactsPerEllipsoid) {
      const PosedEllipsoid pushed = moved(ellipsoid_, push);
      if (options_.rule == ContactRule::kMinimumTranslation) {
        const auto planeDepth = [&](const NearTriangle& near) {
          return push.dot(candidates_[near.candidate].triangle.nhat_W);
        };
        if (!keepDeeper(planeDepth)) return;
        FilterEllipsoid filter = filter_;
        filter.c = Vec3::from(pushed.p_WE);
        clear(filter, known);
      } else {
        forgetCleared();
      }
      const Found found = deepestAdmitted([&] { return deepestLeft(pushed, push); });
      if (found.candidate < 0) return;

      const Candidate& candidate = candidates_[near_[found.candidate].candidate];
      const TriangleContact& left = found.contact;
      const double full = left.depth + push.dot(left.nhat_W);
      // What the triangle's own contact owes to a jump is taken off here too.
      const double lost = found.at_pose.depth - feltDepth(found.at_pose, candidate);
      const int slot = result.count;
      take(result, candidate.index, left.nhat_W, left.p_WE_lowest - push, full, full - lost);
      nhat[slot] = left.nhat_W;
      depth[slot] = full;
      push = shortestPush(nhat, depth, result.count).p;
    }
  }

  // The deepest contact of the pushed ellipsoid with a triangle that the ellipsoid touches where it stands. What rounding leaves
  // of a triangle that the push clears, such as the other one at an edge, is none.
  Found deepestLeft(const PosedEllipsoid& pushed, const Eigen::Vector3d& push) const {
    const bool bounded = options_.rule == ContactRule::kMinimumTranslation;
    const double rounding = kLeftByRounding + kRelativeRounding * ellipsoid_.p_WE.cwiseAbs().maxCoeff();
    Found best;
    for (int i = 0; i < static_cast<int>(near_.size()); ++i) {
      if (near_[i].done || near_[i].cleared) continue;
      const Triangle& triangle = candidates_[near_[i].candidate].triangle;
      const double needed = bounded ? best.contact.depth : 0.0;
      if (!near_[i].isDeeperThan(needed + push.dot(triangle.nhat_W) - kPruneSlack)) continue;
      const TriangleContact left = meet(pushed, triangle, options_.rule, std::max(best.contact.depth, rounding));
      if (!left) continue;
      const TriangleContact at_pose = meet(ellipsoid_, triangle, options_.rule, 0.0);
      if (!at_pose) continue;
      best = {i, left, at_pose};
    }
    return best;
  }

  const PosedEllipsoid& ellipsoid_;
  const FilterEllipsoid& filter_;
  const ContactMemory& memory_;
  const ContactOptions& options_;
  const std::vector<Candidate>& candidates_;
  const std::vector<CandidateBlock>& blocks_;
  std::vector<NearTriangle>& near_;
};

}  // namespace

Eigen::Vector3d assignShares(EllipsoidContacts& contacts) {
  if (contacts.count == 0) return Eigen::Vector3d::Zero();
  if (contacts.count == 1) {
    contacts.contact[0].share = 1.0;
    return contacts.contact[0].pressed * contacts.contact[0].nhat_W;
  }
  std::array<Eigen::Vector3d, kMaxContactsPerEllipsoid> nhat;
  std::array<double, kMaxContactsPerEllipsoid> depth{};
  for (int i = 0; i < contacts.count; ++i) {
    nhat[i] = contacts.contact[i].nhat_W;
    depth[i] = contacts.contact[i].pressed;
  }
  const ShortestPush push = shortestPush(nhat, depth, contacts.count);
  for (int i = 0; i < contacts.count; ++i)
    contacts.contact[i].share = depth[i] > 0.0 ? std::min(1.0, push.weight[i] / depth[i]) : 0.0;
  return push.p;
}

namespace {

// Up to this depth every contact's triangle is touched by the ellipsoid itself: a ball of this diameter fits inside it
// at every point of its surface, so T = E + depth u lies in it. Deeper, the point of a plane above the lowest point of
// a thin body may lie in a triangle beside it.
double touchedDepth(const Eigen::Vector3d& radii) {
  const double thinnest = radii.minCoeff();
  return 2.0 * thinnest * thinnest / radii.maxCoeff();
}

}  // namespace

void findContacts(const PosedEllipsoid& ellipsoid, const ContactMemory& memory, const Terrain& terrain,
                  const ContactOptions& options, ContactFinder& finder, EllipsoidContacts& result) {
  FilterEllipsoid filter = filterOf(ellipsoid);
  // The motion since the last accepted pose is at most one step's; twenty of them ahead is a good guess to be queried
  // once.
  constexpr double kStepsAhead = 20.0;
  const Eigen::Vector3d travel =
      memory.fresh ? Eigen::Vector3d::Zero().eval() : (kStepsAhead * (ellipsoid.p_WE - memory.posed.p_WE)).eval();
  finder.behind_any = false;
  const auto search = [&]() {
    const Eigen::Vector3d half = filter.half_box.toEigen();
    const std::vector<Candidate>& candidates =
        finder.cache.around(ellipsoid.p_WE - half, ellipsoid.p_WE + half, travel, terrain, options.cache);
    result.count = 0;
    if (!candidates.empty()) Evaluation(ellipsoid, filter, memory, options, candidates, finder).run(result);
  };
  search();
  if (result.count > 0 && result.contact[0].depth > touchedDepth(ellipsoid.radii) &&
      options.rule == ContactRule::kMinimumTranslation) {
    // T is never further from the centre than the lowest point is.
    const double reach = ellipsoid.radii.maxCoeff();
    filter.half_box = {reach, reach, reach};
    search();
  }
  // The share of a contact by itself is 1 from the start.
  if (result.count > 1) assignShares(result);
}

void rememberedContacts(const ContactMemory& memory, const ContactOptions& options, EllipsoidContacts& result) {
  result.count = memory.count;
  for (int i = 0; i < memory.count; ++i) {
    const CarriedContact& carried = memory.carried[i];
    Contact& contact = result.contact[i];
    contact.triangle = carried.triangle;
    contact.nhat_W = carried.nhat_W;
    contact.p_WE_lowest = memory.posed.p_WE + memory.posed.lowestPointFromCentre(carried.nhat_W);
    contact.depth = carried.depth;
    contact.pressed = std::max(0.0, carried.depth - (options.memory ? memory.slack : 0.0));
    contact.share = 1.0;
  }
  if (result.count > 1) assignShares(result);
}

void rememberContacts(const PosedEllipsoid& ellipsoid, const EllipsoidContacts& contacts, const ContactMemory& old,
                      const ContactOptions& options, double dt, ContactMemory& result) {
  result.fresh = false;
  result.posed = ellipsoid;
  // Beyond its count a memory holds nothing: equal memories are equal to the last bit.
  for (int i = contacts.count; i < result.count; ++i) result.carried[i] = CarriedContact{};
  result.count = contacts.count;
  result.deepest = 0.0;
  result.slack = 0.0;
  double not_charged = 0.0;
  for (int i = 0; i < contacts.count; ++i) {
    const Contact& contact = contacts.contact[i];
    result.carried[i] = {contact.triangle, contact.nhat_W, contact.depth, ellipsoid.halfWidth(contact.nhat_W)};
    result.deepest = std::max(result.deepest, contact.depth);
    not_charged = std::max(not_charged, contact.depth - contact.pressed);
  }
  if (contacts.count == 0) {
    result.push.setZero();
  } else if (contacts.count == 1) {
    result.push = contacts.contact[0].depth * contacts.contact[0].nhat_W;
  } else {
    std::array<Eigen::Vector3d, kMaxContactsPerEllipsoid> nhat;
    std::array<double, kMaxContactsPerEllipsoid> depth{};
    for (int i = 0; i < contacts.count; ++i) {
      nhat[i] = contacts.contact[i].nhat_W;
      depth[i] = contacts.contact[i].depth;
    }
    result.push = shortestPush(nhat, depth, contacts.count).p;
  }
  if (!options.memory || contacts.count == 0) return;
  // Spawned in an overlap: none of it is charged.
  result.slack = old.fresh ? result.deepest : std::max(0.0, not_charged - kSlackRelease * dt);
}

}  // namespace ellipsoid_vehicle_sim
