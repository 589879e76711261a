#pragma once

#include "broad_phase.h"
#include "workers.h"

namespace ellipsoid_vehicle_sim {

struct Fleet::Impl {
  std::vector<FleetMember> members;
  std::vector<PairMemory> memories;
  std::unique_ptr<Workers> workers;
  std::int64_t step_count = 0;
  int next_id = 0;

  // Of the tick under way.
  BroadPhase broad_phase;
  std::vector<int> parent;        // union-find over the members
  std::vector<int> island_of;     // of each member; -1: alone
  std::vector<FleetIsland> islands;
  int island_count = 0;
  std::vector<int> tasks;         // a member's place, or -1 - an island's

  double tick = 0.0;              // that of the last vehicle that came [s]

  double dt() const { return tick; }
  FleetMember& memberAt(int place) { return members[static_cast<std::size_t>(place)]; }
  static bool isFresh(const FleetMember& member) {
    return member.times_placed != member.simulator->impl_->times_placed;
  }

  StepStatus step();
  StepStatus status() const;
  void noticePlacements();
  void findIslands();
  void keepMemories();
  void tellAll();
  static void leaveAlone(FleetMember& member);
  void takeBack();
  void resize();
};

}  // namespace ellipsoid_vehicle_sim
