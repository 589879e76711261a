#pragma once

#include <vector>

#include "ellipsoid_vehicle_sim/contact/candidate_cache.h"
#include "ellipsoid_vehicle_sim/contact/candidate_filter.h"
#include "ellipsoid_vehicle_sim/contact/contact.h"
#include "ellipsoid_vehicle_sim/contact/sole_contact.h"
#include "ellipsoid_vehicle_sim/world/terrain.h"

namespace ellipsoid_vehicle_sim {

/// How an ellipsoid meets one triangle, and how many triangles push it at once.
enum class ContactRule { kMinimumTranslation, kClampedPoint };
enum class ContactsPerEllipsoid { kOne, kValley };

struct ContactOptions {
  ContactRule rule = ContactRule::kMinimumTranslation;
  ContactsPerEllipsoid contacts = ContactsPerEllipsoid::kValley;
  bool memory =
      true;           ///< admission and slack; off: every triangle with the centre in front pushes with its full depth.
  bool cache = true;  ///< reuse of candidate lists and of proofs; changes no answer.
};

/// What the evaluation under way knows of a block of candidates; a bit for each lane.
struct NearBlock {
  PlaneTest plane;     ///< who is near, and how far from its plane.
  std::uint32_t done;  ///< near, and taken or turned away.
  std::uint32_t open;  ///< near, and not proved to be of no interest to the search under way.
  std::uint32_t held;  ///< near, and not proved to be clear of the ellipsoid after the first contact's push.
};

/// Buffers of one ellipsoid; no state: two finders give the same answers whatever they were asked before.
struct ContactFinder {
  ContactFinder() { near.reserve(16); }

  CandidateCache cache;
  SoleContact sole;
  std::vector<NearBlock> near;  ///< of the present evaluation, one for each block of the cache.
  bool behind_any = false;      ///< the centre is not in front of some triangle whose box the ellipsoid's meets.
};

/// Each ellipsoid meets the one triangle it would have to be pushed furthest to clear (ties: the lowest index); in
/// `valley` mode up to two more that still hold it after that push. Sources: notation.h [CarPhysics],
/// [ContactDefinition] rules 1-6. `memory` is that of the last accepted pose and is not changed.
void findContacts(const PosedEllipsoid& ellipsoid, const ContactMemory& memory, const Terrain& terrain,
                  const ContactOptions& options, ContactFinder& finder, EllipsoidContacts& result);
inline EllipsoidContacts findContacts(const PosedEllipsoid& ellipsoid, const ContactMemory& memory,
                                      const Terrain& terrain, const ContactOptions& options, ContactFinder& finder) {
  EllipsoidContacts result;
  findContacts(ellipsoid, memory, terrain, options, finder, result);
  return result;
}

/// The contacts of the pose the memory was taken at, as they push at the start of the next step: no search.
void rememberedContacts(const ContactMemory& memory, const ContactOptions& options, EllipsoidContacts& result);
inline EllipsoidContacts rememberedContacts(const ContactMemory& memory, const ContactOptions& options) {
  EllipsoidContacts result;
  rememberedContacts(memory, options, result);
  return result;
}

/// Speed at which depth that a jump added is given back [m/s]: slow enough that a vehicle freed from an overlap rises,
/// and does not fly.
constexpr double kSlackRelease = 0.01;

/// The memory after a step ended at `ellipsoid` with `contacts` (found there with the old memory), dt [s] after the old
/// one. Anchors are not carried over: that is the friction's business. `result`, not the same as `old`, is a memory of
/// whatever past.
void rememberContacts(const PosedEllipsoid& ellipsoid, const EllipsoidContacts& contacts, const ContactMemory& old,
                      const ContactOptions& options, double dt, ContactMemory& result);
inline ContactMemory rememberContacts(const PosedEllipsoid& ellipsoid, const EllipsoidContacts& contacts,
                                      const ContactMemory& old, const ContactOptions& options, double dt) {
  ContactMemory result;
  rememberContacts(ellipsoid, contacts, old, options, dt, result);
  return result;
}

/// Shares of the contacts' forces (field `share`) from their pressed depths; `push` is the shortest push that clears
/// them.
Eigen::Vector3d assignShares(EllipsoidContacts& contacts);

}  // namespace ellipsoid_vehicle_sim
