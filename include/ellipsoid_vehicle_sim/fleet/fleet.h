#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/vehicle/simulator.h"
#include "ellipsoid_vehicle_sim/vehicle/snapshot.h"

namespace ellipsoid_vehicle_sim {

/// What two ellipsoids of two vehicles remember of the last accepted step while they touch; part of the state.
struct PairMemory {
  int vehicle[2] = {-1, -1};    ///< ids, the lower first.
  int ellipsoid[2] = {-1, -1};
  Eigen::Vector3d nhat_W = Eigen::Vector3d::Zero();    ///< unit, from the second into the first.
  double depth = 0.0;                                  ///< [m].
  double slack = 0.0;                                  ///< depth that the spring does not feel [m].
  Eigen::Vector3d anchor_W = Eigen::Vector3d::Zero();  ///< stretch of the friction, of the first against the second [m].
};

/// Everything of a fleet but the clock.
struct FleetSnapshot {
  std::vector<std::string> names;
  std::vector<Snapshot> vehicles;
  std::vector<PairMemory> touching;  ///< vehicle[]: places in `names`.
  std::vector<std::uint8_t> extra;   ///< for whoever keeps a state beside it.
};

/// Several vehicles in one terrain, with one tick and one integrator. Vehicles that could touch another within the tick form
/// islands; the vehicles of an island are advanced together, stage by stage, by one rate function, in which
///   depth     is that of ellipsoid against ellipsoid, one contact for each pair, additional to those with the terrain;
///   stiffness is that of both springs in series, k = k1 k2 / (k1 + k2), and each side gives way by its share of the depth,
///             k / k_i; damping is what both dampers then dissipate, c = c1 (k/k1)^2 + c2 (k/k2)^2, for the friction likewise;
///   friction  is anchored (viscous where both sides are), mu the lower of the two vehicles';
///   forces    are equal and opposite and act at one point, where both springs meet: momentum is conserved to rounding.
/// The depth of two convex bodies never jumps, so that there is no admission; slack there is where one was put into another.
/// All other vehicles take their tick alone, to the last bit as a Simulator of their own would. Islands and single vehicles
/// are spread over `threads`; the results do not depend on their number by a bit.
///
/// All have one integrator. Those that size their steps within the tick (rk4_events, dormand_prince, linearly_implicit) size
/// them for an island as a whole, by the contacts of any of its vehicles, the largest error, the strictest error_tolerance and
/// the most contact_substeps; so a vehicle that is near another has other steps than alone, whether they touch or not.
/// linearly_implicit conserves linear momentum of rigid bodies too, to what rounding makes of its differences.
///
/// A vehicle near another is left at rest only if all of its island are. What one of an island asks for beside its ticks, an
/// estimate of the local error or exact_savings: checked, is worked out for the island as a whole, and told to who asked.
class Fleet {
 public:
  /// `threads`: 0 = as many as there are cores. Without oneTBB there is one.
  explicit Fleet(int threads = 1);
  Fleet(Fleet&&) noexcept;
  Fleet& operator=(Fleet&&) noexcept;
  ~Fleet();

  /// Built with a threading library.
  static bool canUseThreads();

  /// Takes a vehicle in, at its place, from the next tick on. Problems, and nothing changed: the name is taken or empty, or
  /// the vehicle has another terrain, tick, integrator or gravity than those already there.
  Problems add(const std::string& name, Simulator vehicle);
  /// Problems: there is none of that name.
  Problems remove(const std::string& name);

  std::size_t size() const;
  Simulator& vehicle(std::size_t index);
  const Simulator& vehicle(std::size_t index) const;
  const std::string& name(std::size_t index) const;
  /// Number of the vehicle for good: it is never given again. ContactReport::other names vehicles by it.
  int id(std::size_t index) const;
  /// Place of a vehicle; -1: there is none.
  int find(const std::string& name) const;
  int findId(int id) const;

  /// Simulator::setDown, refused where the vehicle would stand in another one.
  Problems setDown(std::size_t index, double x, double y, double yaw);
  /// In which other vehicle it stands now; empty: in none.
  Problems overlaps(std::size_t index) const;
  /// All vehicles back to where they were put last; the clock goes on.
  void reset();

  /// Advances all by one tick. When one diverges, all stay at the last good tick; it goes on once that one is put
  /// somewhere else, reset or removed.
  StepStatus step();
  StepStatus status() const;
  std::int64_t stepCount() const;
  double time() const;  ///< [s].

  /// Pairs that touch, as they were at the last accepted tick.
  const std::vector<PairMemory>& touching() const;
  /// In the springs between vehicles [J]: what the vehicles' own energies do not contain.
  double energyBetween() const;
  /// Of a single vehicle: its own.
  std::uint64_t stateHash() const;
  int threads() const;

  FleetSnapshot save() const;
  /// Problems, and nothing changed: other vehicles than the snapshot's.
  Problems restore(const FleetSnapshot& snapshot);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Bytes for a file or a message, and back: see snapshot.h.
std::vector<std::uint8_t> toBytes(const FleetSnapshot& snapshot, const Fleet& fleet);
Loaded<FleetSnapshot> fromBytes(const std::vector<std::uint8_t>& bytes, const Fleet& fleet, const std::string& where);

}  // namespace ellipsoid_vehicle_sim
