#include "ellipsoid_vehicle_sim/contact/find_contacts.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "contact_search.h"

namespace ellipsoid_vehicle_sim {

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

// Past these parts of that depth a search is made in any case: the radii are those of the proof to within a few parts
// in a hundred.
constexpr double kCoveredDepth = 0.9;

/// Takes the contact that is proved to be the only one, or none; false where a search has to tell.
bool takeSole(const PosedEllipsoid& ellipsoid, const ContactOptions& options, const ContactTaking& taking,
              ContactFinder& finder, EllipsoidContacts& result) {
  if (!options.cache || options.rule != ContactRule::kMinimumTranslation || !finder.sole.covers(ellipsoid))
    return false;
  if (finder.sole.candidate() == SoleContact::kNone) return true;
  const Candidate& candidate = finder.cache.candidates()[static_cast<std::size_t>(finder.sole.candidate())];
  const TriangleContact contact = minimumTranslation(ellipsoid, candidate.triangle, 0.0);
  if (contact.feature != Feature::kFace || contact.depth > finder.sole.deepest() || !taking.admitted(candidate))
    return false;
  taking.take(result, candidate.index, contact, taking.feltDepth(contact, candidate));
  finder.sole.countUse();
  return true;
}

}  // namespace

void findContacts(const PosedEllipsoid& ellipsoid, const ContactMemory& memory, const Terrain& terrain,
                  const ContactOptions& options, ContactFinder& finder, EllipsoidContacts& result) {
  const ContactTaking taking(ellipsoid, memory, options);
  finder.behind_any = false;
  result.count = 0;
  if (takeSole(ellipsoid, options, taking, finder, result)) return;
  finder.sole.forget();

  FilterEllipsoid filter = filterOf(ellipsoid);
  const Vec3 moved = memory.fresh ? Vec3{0.0, 0.0, 0.0} : filter.c - Vec3::from(memory.posed.p_WE);
  const Eigen::Vector3d travel = (CandidateCache::kStepsAhead * moved).toEigen();
  int sole = SoleContact::kNone;
  double sole_travel = 0.0;
  const auto search = [&]() {
    const Vec3 low = filter.c - filter.half_box, high = filter.c + filter.half_box;
    const std::vector<Candidate>& candidates =
        finder.cache.around(low.toEigen(), high.toEigen(), travel, terrain, options.cache);
    result.count = 0;
    if (candidates.empty()) {
      constexpr double kAnywhere = std::numeric_limits<double>::infinity();
      finder.sole.hold(SoleContact::kNone, ellipsoid, finder.cache.box(), kAnywhere, kAnywhere);
      return;
    }
    ContactSearch contact_search(ellipsoid, filter, memory, options, taking, moved, finder);
    contact_search.run(result);
    sole = contact_search.soleCandidate();
    sole_travel = contact_search.travel();
  };
  search();
  if (result.count > 0) {
    const double touched = touchedDepth(ellipsoid.radii);
    if (result.contact[0].depth > touched && options.rule == ContactRule::kMinimumTranslation) {
      // T is never further from the centre than the lowest point is.
      const double reach = ellipsoid.radii.maxCoeff();
      filter.half_box = {reach, reach, reach};
      search();
    } else if (sole != SoleContact::kNone) {
      finder.sole.hold(sole, ellipsoid, finder.cache.box(), sole_travel, kCoveredDepth * touched);
    }
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
