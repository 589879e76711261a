// A tick of vehicles that may touch each other, and the steps within it.
#include <algorithm>

#include "contact_events.h"
#include "error_control.h"
#include "fleet_island.h"
#include "linearly_implicit.h"
#include "whole_step.h"

namespace ellipsoid_vehicle_sim {

using Eigen::Vector3d;

// All or none: one that moves may touch those that stand.
bool FleetIsland::rests() {
  bool resting = true;
  for (std::size_t i = 0; i < members_.size(); ++i) resting = resting && impl(i).resting;
  for (const PairCandidate* pair : pairs_) resting = resting && pair->memory.slack == 0.0;
  if (!resting)
    for (std::size_t i = 0; i < members_.size(); ++i) impl(i).resting = false;
  resting = true;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    members_[i]->timed_out = impl(i).beginTick();
    resting = resting && impl(i).resting;
  }
  for (const PairCandidate* pair : pairs_) resting = resting && pair->memory.slack == 0.0;
  return resting;
}

void FleetIsland::tick() {
  if (rests()) {
    for (std::size_t i = 0; i < members_.size(); ++i) impl(i).restTick(members_[i]->timed_out);
    return;
  }
  setUp();
  sane_ = true;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    impl(i).resting = false;
    members_[i]->outcome = TickOutcome{};
  }
  const double T = tickLength();
  switch (impl(0).config.integrator) {
    case IntegratorKind::kExplicitEuler:
    case IntegratorKind::kSemiImplicitEuler:
    case IntegratorKind::kRk4:
      beginStep(T);
      wholeStep(*this, impl(0).config.integrator, x_, T, buffers_.k, buffers_.scratch);
      accept(x_, T, true);
      break;
    case IntegratorKind::kRk4Events:
      ContactEvents<FleetIsland>(*this).take();
      break;
    case IntegratorKind::kDormandPrince:
      takeByErrorControl(*this);
      break;
    case IntegratorKind::kLinearlyImplicit:
      setUpSpeeds();
      LinearlyImplicit<FleetIsland>(*this).take();
      break;
  }
  endTick();
}

void FleetIsland::beginStep(double h) {
  for (std::size_t i = 0; i < members_.size(); ++i) dynamics(i).beginStep(impl(i).state, h);
}

// The others of one that cannot go on are taken back with it: by the fleet, as the tick is not one then.
bool FleetIsland::accept(const IslandMotion& end, double h, bool last) {
  for (std::size_t i = 0; i < members_.size(); ++i) {
    Simulator::Impl& s = impl(i);
    TickOutcome& outcome = members_[i]->outcome;
    s.stepper->accept(s.state, *end.of[i], h, last, s.previous.memory, outcome);
    if (!outcome.sane) TickStepper::giveUp(s.state, s.previous.memory, outcome);
    sane_ = sane_ && outcome.sane;
  }
  if (!sane_) return false;
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    PairCandidate& pair = *pairs_[p];
    const PairSide first = side(pair, 0, x_), second = side(pair, 1, x_);
    const Vector3d before = pair.memory.nhat_W;
    const bool known = pair.known;
    acceptPair(first, second, end.anchor[p], h, pair);
    if (passedThrough(first.posed(), second.posed(), pair, before, known))
      for (const int member : pair.at) ++members_[static_cast<std::size_t>(member)]->outcome.passed_through;
    pair.p_start = first.posed().p_WE - second.posed().p_WE;
    x_.anchor[p] = pair.memory.anchor_W;
  }
  return true;
}

void FleetIsland::endTick() {
  for (std::size_t i = 0; i < members_.size(); ++i) {
    Simulator::Impl& s = impl(i);
    s.touched.clear();
    s.outside.clear();
    s.endTick(members_[i]->outcome, members_[i]->timed_out);
  }
  if (!sane_) return;
  for (const PairCandidate* pair : pairs_) tellPair(*pair);
}

bool FleetIsland::isSound(const IslandMotion& x) const {
  return std::all_of(x.of.begin(), x.of.end(), [](const Motion* motion) { return isSane(*motion); });
}

void FleetIsland::countFloorStep() {
  for (FleetMember* member : members_) ++member->outcome.floor_steps;
}

double FleetIsland::tolerance() const {
  double least = impl(0).config.error_tolerance;
  for (std::size_t i = 1; i < members_.size(); ++i) least = std::min(least, impl(i).config.error_tolerance);
  return least;
}

double FleetIsland::errorOf(const IslandRate& error, double h) const {
  Largest largest;
  for (std::size_t i = 0; i < members_.size(); ++i) largest.add(stepper(i).errorOf(*error.of[i], h));
  for (const Vector3d& z : error.anchor) largest.add(h * z.norm());
  return largest.value();
}

double FleetIsland::contactSubsteps() const {
  double most = 1.0;
  for (std::size_t i = 0; i < members_.size(); ++i) most = std::max(most, impl(i).config.contact_substeps);
  return most;
}

bool FleetIsland::hasJoints() const {
  for (std::size_t i = 0; i < members_.size(); ++i)
    if (stepper(i).hasJoints()) return true;
  return false;
}

std::size_t FleetIsland::placeOfContact(int& contact) const {
  for (std::size_t i = 0; i < members_.size(); ++i) {
    const int own = static_cast<int>(impl(i).model.ellipsoids.size());
    if (contact < own) return i;
    contact -= own;
  }
  return members_.size();
}

void FleetIsland::noteContacts() {
  for (std::size_t i = 0; i < members_.size(); ++i) stepper(i).noteContacts(*x_.of[i]);
  for (PairCandidate* pair : pairs_) {
    pair->pressed_at_start = pair->force.normal > 0.0;
    pair->touch_at_start = ellipsoid_vehicle_sim::touchOf(side(*pair, 0, x_), side(*pair, 1, x_), *pair);
  }
}

bool FleetIsland::anyPressedAtStart() const {
  for (std::size_t i = 0; i < members_.size(); ++i)
    if (stepper(i).anyPressedAtStart()) return true;
  return std::any_of(pairs_.begin(), pairs_.end(), [](const PairCandidate* pair) { return pair->pressed_at_start; });
}

bool FleetIsland::pressedAtStart(int contact) const {
  const std::size_t i = placeOfContact(contact);
  return i < members_.size() ? stepper(i).pressedAtStart(contact)
                             : pairs_[static_cast<std::size_t>(contact)]->pressed_at_start;
}

const Touch& FleetIsland::touchAtStart(int contact) const {
  const std::size_t i = placeOfContact(contact);
  return i < members_.size() ? stepper(i).touchAtStart(contact)
                             : pairs_[static_cast<std::size_t>(contact)]->touch_at_start;
}

int FleetIsland::firstChanged() const {
  int before = 0;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    const int changed = stepper(i).firstChanged();
    if (changed >= 0) return before + changed;
    before += static_cast<int>(impl(i).model.ellipsoids.size());
  }
  for (std::size_t p = 0; p < pairs_.size(); ++p)
    if ((pairs_[p]->force.normal > 0.0) != pairs_[p]->pressed_at_start) return before + static_cast<int>(p);
  return -1;
}

Touch FleetIsland::touchOf(const IslandMotion& x, int contact) const {
  const std::size_t i = placeOfContact(contact);
  if (i < members_.size()) return stepper(i).touchOf(*x.of[i], contact);
  const PairCandidate& pair = *pairs_[static_cast<std::size_t>(contact)];
  return ellipsoid_vehicle_sim::touchOf(side(pair, 0, x), side(pair, 1, x), pair);
}

}  // namespace ellipsoid_vehicle_sim
