#pragma once

#include "../vehicle/simulator_impl.h"
#include "island_shadow.h"

namespace ellipsoid_vehicle_sim {

/// A vehicle of a fleet, with what a tick leaves that it takes together with others.
struct FleetMember {
  std::string name;
  int id = 0;
  std::unique_ptr<Simulator> simulator;
  std::int64_t times_placed = -1;  ///< as last seen.

  bool timed_out = false;
  std::vector<Eigen::AlignedBox3d> boxes;  ///< of each ellipsoid, on its way through the tick.
  Eigen::AlignedBox3d box;                 ///< of all.
};

/// Vehicles that could touch each other within the tick: takes them over it together, and tells each what it feels.
class FleetIsland {
 public:
  /// Room for so many vehicles.
  void reserve(std::size_t members);
  void clear();
  /// In ascending order.
  void addMember(FleetMember& member, int place);
  /// Both members are there already.
  void addPair(PairCandidate& pair);

  /// One tick of all. Leaves in the members what came of it, and in the pairs the contacts of its end.
  void tick();
  /// What the members feel of each other now, at the state itself, told to them; for a state that no tick led to.
  void tell();

 private:
  Simulator::Impl& impl(std::size_t i) const { return *members_[i]->simulator->impl_; }
  bool rests();
  void beginShadows();
  void endShadows();
  void endTick(bool sane);
  void tellPairs();

  std::vector<FleetMember*> members_;
  std::vector<PairCandidate*> pairs_;
  IslandStepper stepper_;

  // What one of them asks for beside the tick, all take part in.
  IslandShadow halves_, whole_;
  bool estimates_ = false, checks_ = false;
};

}  // namespace ellipsoid_vehicle_sim
