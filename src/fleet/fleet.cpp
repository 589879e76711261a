#include "ellipsoid_vehicle_sim/fleet/fleet.h"

#include <algorithm>
#include <cstdio>
#include <numeric>

#include "../vehicle/fnv_hash.h"
#include "broad_phase.h"
#include "fleet_impl.h"

namespace ellipsoid_vehicle_sim {
namespace {

std::string number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

}  // namespace

// The vehicles were put somewhere, or have just come: what they remember of others is of another place.
void Fleet::Impl::noticePlacements() {
  bool any = false;
  for (FleetMember& member : members) {
    Simulator::Impl& s = *member.simulator->impl_;
    if (s.times_placed == member.times_placed) continue;
    any = true;
    const int id = member.id;
    memories.erase(std::remove_if(memories.begin(), memories.end(),
                                  [id](const PairMemory& m) { return m.vehicle[0] == id || m.vehicle[1] == id; }),
                   memories.end());
  }
  if (!any) return;
  findIslands();
  for (PairCandidate& pair : broad_phase.pairs()) {
    const FleetMember &first = memberAt(pair.member[0]), &second = memberAt(pair.member[1]);
    if (pair.known || (!isFresh(first) && !isFresh(second))) continue;
    takeWithSlack(first.simulator->impl_->dynamics->posedEllipsoids()[pair.memory.ellipsoid[0]],
                  second.simulator->impl_->dynamics->posedEllipsoids()[pair.memory.ellipsoid[1]], pair);
  }
  keepMemories();
  tellAll();
  for (FleetMember& member : members) member.times_placed = member.simulator->impl_->times_placed;
}

// Broad phase, memories and islands of the present states.
void Fleet::Impl::findIslands() {
  for (int i = 0; i < island_count; ++i) islands[i].clear();
  island_count = 0;
  broad_phase.find(members, dt());
  std::vector<PairCandidate>& pairs = broad_phase.pairs();

  // The lowest place among those that hang together stands for all.
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [this](int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (PairCandidate& pair : pairs) {
    const int a = root(pair.member[0]), b = root(pair.member[1]);
    parent[std::max(a, b)] = std::min(a, b);
    const auto found = std::find_if(memories.begin(), memories.end(), [&pair](const PairMemory& m) {
      return m.vehicle[0] == pair.memory.vehicle[0] && m.vehicle[1] == pair.memory.vehicle[1] &&
             m.ellipsoid[0] == pair.memory.ellipsoid[0] && m.ellipsoid[1] == pair.memory.ellipsoid[1];
    });
    if (found == memories.end()) continue;
    pair.known = true;
    pair.memory = *found;
  }
  std::fill(island_of.begin(), island_of.end(), -1);
  for (const PairCandidate& pair : pairs) {
    int& island = island_of[root(pair.member[0])];
    if (island < 0) island = island_count++;
  }
  for (std::size_t i = 0; i < members.size(); ++i) {
    const int place = static_cast<int>(i);
    island_of[i] = island_of[root(place)];
    if (island_of[i] >= 0) islands[island_of[i]].addMember(members[i], place);
  }
  for (PairCandidate& pair : pairs) islands[island_of[pair.member[0]]].addPair(pair);
}

void Fleet::Impl::keepMemories() {
  memories.clear();
  for (const PairCandidate& pair : broad_phase.pairs())
    if (pair.known) memories.push_back(pair.memory);
}

void Fleet::Impl::tellAll() {
  for (FleetMember& member : members) leaveAlone(member);
  for (int i = 0; i < island_count; ++i) islands[i].tell();
}

void Fleet::Impl::leaveAlone(FleetMember& member) {
  Simulator::Impl& s = *member.simulator->impl_;
  if (s.touched.empty()) return;
  s.touched.clear();
  s.outside.clear();
  s.observed_fresh = false;
  s.resting = false;  // what it leant on may be gone
}

StepStatus Fleet::Impl::step() {
  if (status() != StepStatus::kOk) return StepStatus::kDiverged;
  if (members.size() < 2) {
    for (FleetMember& member : members) {
      leaveAlone(member);
      member.simulator->step();
    }
  } else {
    noticePlacements();
    findIslands();
    tasks.clear();
    for (int i = 0; i < island_count; ++i) tasks.push_back(-1 - i);
    for (std::size_t i = 0; i < members.size(); ++i)
      if (island_of[i] < 0) tasks.push_back(static_cast<int>(i));
    auto task = [this](int t) {
      if (tasks[t] < 0) {
        islands[-1 - tasks[t]].tick();
        return;
      }
      FleetMember& member = members[tasks[t]];
      leaveAlone(member);
      member.simulator->step();
    };
    workers->forEach(static_cast<int>(tasks.size()), task);
  }
  if (status() != StepStatus::kOk) {
    takeBack();
    return StepStatus::kDiverged;
  }
  if (members.size() > 1) keepMemories();
  ++step_count;
  return StepStatus::kOk;
}

// One diverged: the others go back to the tick that it is still in.
void Fleet::Impl::takeBack() {
  for (FleetMember& member : members) {
    Simulator::Impl& s = *member.simulator->impl_;
    if (s.step_count == step_count) continue;
    if (!s.resting) s.state = s.previous;
    s.step_count = step_count;
    s.observed_fresh = false;
  }
  if (members.size() > 1) {
    findIslands();
    tellAll();
  }
}

StepStatus Fleet::Impl::status() const {
  for (const FleetMember& member : members)
    if (member.simulator->status() != StepStatus::kOk) return StepStatus::kDiverged;
  return StepStatus::kOk;
}

void Fleet::Impl::resize() {
  const std::size_t n = members.size();
  broad_phase.reserve(n);
  parent.assign(n, 0);
  island_of.assign(n, -1);
  tasks.reserve(2 * n);
  memories.reserve(16 * n);
  island_count = 0;
  islands.resize(n);
  for (FleetIsland& island : islands) {
    island.clear();
    island.reserve(n);
  }
}

Fleet::Fleet(int threads) : impl_(std::make_unique<Impl>()) { impl_->workers = std::make_unique<Workers>(threads); }
Fleet::Fleet(Fleet&&) noexcept = default;
Fleet& Fleet::operator=(Fleet&&) noexcept = default;
Fleet::~Fleet() = default;

bool Fleet::canUseThreads() { return Workers::available(); }
int Fleet::threads() const { return impl_->workers->threads(); }

Problems Fleet::add(const std::string& name, Simulator vehicle) {
  Problems problems;
  const std::string where = "vehicle '" + name + "'";
  if (name.empty()) problems.push_back({"vehicle", "has no name"});
  if (find(name) >= 0) problems.push_back({where, "is there already: names are given once"});
  if (size() > 0) {
    const Simulator& other = this->vehicle(0);
    const SimConfig &mine = vehicle.config(), &theirs = other.config();
    const std::string there = "that of '" + this->name(0) + "', which is there already";
    if (&vehicle.terrain() != &other.terrain()) problems.push_back({where, "stands in another terrain than " + this->name(0)});
    if (mine.dt != theirs.dt)
      problems.push_back({where, "has the step " + number(mine.dt) + " s, allowed is " + there + ": " + number(theirs.dt) + " s"});
    if (mine.gravity != theirs.gravity)
      problems.push_back({where, "has the gravity " + number(mine.gravity) + " m/s^2, allowed is " + there + ": " +
                                     number(theirs.gravity) + " m/s^2"});
    if (mine.integrator != theirs.integrator)
      problems.push_back({where, std::string("has the integrator ") + toString(mine.integrator) + ", allowed is " + there + ": " +
                                     toString(theirs.integrator)});
  }
  if (!problems.empty()) return problems;

  FleetMember member;
  member.name = name;
  member.id = impl_->next_id++;
  member.simulator = std::make_unique<Simulator>(std::move(vehicle));
  Simulator::Impl& s = *member.simulator->impl_;
  if (size() == 0 && impl_->step_count == 0) impl_->step_count = s.step_count;
  s.step_count = impl_->step_count;
  impl_->tick = s.config.dt;
  member.boxes.resize(s.model.ellipsoids.size());
  s.touched.reserve(64);
  s.outside.reserve(64);
  impl_->members.push_back(std::move(member));
  impl_->resize();
  return {};
}

Problems Fleet::remove(const std::string& name) {
  const int index = find(name);
  if (index < 0) {
    std::string known;
    for (std::size_t i = 0; i < size(); ++i) known += (i > 0 ? ", " : "") + this->name(i);
    return {{"vehicle '" + name + "'", "is not there; there " + std::string(size() == 1 ? "is: " : "are: ") + (known.empty() ? "none" : known)}};
  }
  const int id = impl_->members[index].id;
  impl_->memories.erase(std::remove_if(impl_->memories.begin(), impl_->memories.end(),
                                       [id](const PairMemory& m) { return m.vehicle[0] == id || m.vehicle[1] == id; }),
                        impl_->memories.end());
  impl_->members.erase(impl_->members.begin() + index);
  impl_->resize();
  if (size() > 1) {
    impl_->findIslands();
    impl_->tellAll();
  } else {
    for (FleetMember& member : impl_->members) impl_->leaveAlone(member);
  }
  return {};
}

std::size_t Fleet::size() const { return impl_->members.size(); }
Simulator& Fleet::vehicle(std::size_t index) { return *impl_->members[index].simulator; }
const Simulator& Fleet::vehicle(std::size_t index) const { return *impl_->members[index].simulator; }
const std::string& Fleet::name(std::size_t index) const { return impl_->members[index].name; }
int Fleet::id(std::size_t index) const { return impl_->members[index].id; }

int Fleet::find(const std::string& name) const {
  for (std::size_t i = 0; i < size(); ++i)
    if (this->name(i) == name) return static_cast<int>(i);
  return -1;
}

int Fleet::findId(int id) const {
  for (std::size_t i = 0; i < size(); ++i)
    if (this->id(i) == id) return static_cast<int>(i);
  return -1;
}

Problems Fleet::overlaps(std::size_t index) const {
  Problems problems;
  std::vector<PosedEllipsoid> own, others;
  vehicle(index).posedEllipsoids(own);
  for (std::size_t i = 0; i < size(); ++i) {
    // One that was never put anywhere is not in the world yet.
    if (i == index || impl_->members[i].simulator->impl_->times_placed == 0) continue;
    vehicle(i).posedEllipsoids(others);
    double deepest = 0.0;
    std::string which;
    for (std::size_t a = 0; a < own.size(); ++a)
      for (std::size_t b = 0; b < others.size(); ++b)
        if (const EllipsoidPairContact contact = minimumTranslation(own[a], others[b]); contact.depth > deepest) {
          deepest = contact.depth;
          which = "its '" + vehicle(index).ellipsoids()[a].name + "' " + number(1e3 * deepest) + " mm deep in '" +
                  vehicle(i).ellipsoids()[b].name + "'";
        }
    if (deepest > 0.0) problems.push_back({"vehicle '" + name(index) + "'", "would stand in vehicle '" + name(i) + "': " + which});
  }
  return problems;
}

Problems Fleet::setDown(std::size_t index, double x, double y, double yaw) {
  Simulator::Impl& s = *impl_->members[index].simulator->impl_;
  const Snapshot before = vehicle(index).save();
  const ErrorEstimate estimate = s.estimate;
  const StepStatus status = s.status;
  const std::int64_t times_placed = s.times_placed;
  Problems problems = vehicle(index).setDown(x, y, yaw);
  if (!problems.empty()) return problems;
  problems = overlaps(index);
  if (problems.empty()) return problems;
  vehicle(index).restore(before);
  s.estimate = estimate;
  s.status = status;
  s.times_placed = times_placed;
  if (size() > 1 && s.times_placed == impl_->members[index].times_placed) {
    impl_->findIslands();
    impl_->tellAll();
  }
  return problems;
}

void Fleet::reset() {
  for (FleetMember& member : impl_->members) member.simulator->reset();
}

StepStatus Fleet::step() { return impl_->step(); }
StepStatus Fleet::status() const { return impl_->status(); }
std::int64_t Fleet::stepCount() const { return impl_->step_count; }
double Fleet::time() const { return static_cast<double>(impl_->step_count) * impl_->dt(); }
const std::vector<PairMemory>& Fleet::touching() const { return impl_->memories; }

double Fleet::energyBetween() const {
  double energy = 0.0;
  for (const PairMemory& m : impl_->memories) {
    const Simulator &first = vehicle(findId(m.vehicle[0])), &second = vehicle(findId(m.vehicle[1]));
    const ContactLaw law =
        pairLaw(first.model().ellipsoids[m.ellipsoid[0]].law, second.model().ellipsoids[m.ellipsoid[1]].law);
    const double pressed = std::max(0.0, m.depth - m.slack);
    energy += 0.5 * law.stiffness * pressed * pressed;
    if (law.mode != FrictionMode::kViscous) energy += 0.5 * law.tangential_stiffness * m.anchor_W.squaredNorm();
  }
  return energy;
}

std::uint64_t Fleet::stateHash() const {
  if (size() == 1) return vehicle(0).stateHash();
  FnvHash hash;
  for (std::size_t i = 0; i < size(); ++i) {
    hash.add(name(i));
    hash.add(vehicle(i).stateHash());
  }
  for (const PairMemory& m : impl_->memories) {
    for (int side = 0; side < 2; ++side) {
      hash.add(static_cast<std::uint64_t>(findId(m.vehicle[side])));
      hash.add(static_cast<std::uint64_t>(m.ellipsoid[side]));
    }
    for (int k = 0; k < 3; ++k) hash.add(m.nhat_W[k]);
    hash.add(m.depth);
    hash.add(m.slack);
    for (int k = 0; k < 3; ++k) hash.add(m.anchor_W[k]);
  }
  return hash.value();
}

}  // namespace ellipsoid_vehicle_sim
