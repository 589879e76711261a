#pragma once

#include <vector>

#include "pair_contact.h"
#include "simulator_impl.h"

namespace ellipsoid_vehicle_sim {

/// A vehicle of a fleet, with the buffers of a tick that it takes together with others.
struct FleetMember {
  std::string name;
  int id = 0;
  std::unique_ptr<Simulator> simulator;
  std::int64_t times_placed = -1;  ///< as last seen.

  MotionRate k[4];
  Motion scratch;
  TickOutcome outcome;
  bool timed_out = false;
  std::vector<Eigen::AlignedBox3d> boxes;  ///< of each ellipsoid, on its way through the tick.
  Eigen::AlignedBox3d box;                 ///< of all.
};

/// Motions of an island's vehicles, where they lie, and what integrates of their contacts with each other. Assignment
/// copies the values.
struct IslandMotion {
  std::vector<Motion*> of;
  std::vector<Eigen::Vector3d> anchor;  ///< per candidate.

  IslandMotion() = default;
  IslandMotion(IslandMotion&&) = default;
  IslandMotion& operator=(const IslandMotion& other) {
    for (std::size_t i = 0; i < of.size(); ++i) *of[i] = *other.of[i];
    anchor = other.anchor;
    return *this;
  }
};

struct IslandRate {
  std::vector<MotionRate*> of;
  std::vector<Eigen::Vector3d> anchor;
};

/// Vehicles that could touch each other within the tick, advanced by one rate function. A System of integrator.h.
class FleetIsland {
 public:
  using State = IslandMotion;
  using Rate = IslandRate;

  /// Room for so many vehicles.
  void reserve(std::size_t members);
  void clear();
  /// In ascending order.
  void addMember(FleetMember& member, int place);
  /// Both members are there already.
  void addPair(PairCandidate& pair) { pairs_.push_back(&pair); }
  bool empty() const { return members_.empty(); }

  /// One tick of all. Leaves in the members what came of it, and in the pairs the contacts of its end.
  void tick();
  /// What the members feel of each other now, at the state itself, told to them; for a state that no tick led to.
  void tell();

  // System.
  void rate(const IslandMotion& x, double fraction, IslandRate& k);
  void positionRates(const IslandMotion& x, IslandRate& k);
  void advance(const IslandMotion& x, double h, const IslandRate& k, IslandMotion& result) const;
  void advanceVelocities(IslandMotion& x, double h, const IslandRate& k) const;
  void advancePositions(IslandMotion& x, double h, const IslandRate& k) const;
  void toTangent(double h, const IslandRate& previous, IslandRate& k) const;
  void combine(IslandRate (&k)[4]) const;

 private:
  Simulator::Impl& impl(std::size_t i) const { return *members_[i]->simulator->impl_; }
  PairSide side(const PairCandidate& pair, int which, const IslandMotion& x) const;
  std::size_t placeOf(int member) const;
  void setUp();
  bool rests();
  void accept(double h);
  void tellPair(const PairCandidate& pair);

  std::vector<FleetMember*> members_;
  std::vector<int> places_;  ///< in the fleet, of each.
  std::vector<PairCandidate*> pairs_;
  IslandMotion x_, scratch_;
  IslandRate k_[4];
};

}  // namespace ellipsoid_vehicle_sim
