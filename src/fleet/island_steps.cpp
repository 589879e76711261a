// A tick of vehicles that may touch each other: the steps within it.
#include <algorithm>

#include "../vehicle/contact_events.h"
#include "../vehicle/error_control.h"
#include "../vehicle/linearly_implicit.h"
#include "../vehicle/whole_step.h"
#include "island_stepper.h"

namespace ellipsoid_vehicle_sim {

using Eigen::Vector3d;

bool IslandStepper::advance(bool ends_tick) {
  setUp();
  sane_ = true;
  ends_tick_ = ends_tick;
  for (SteppedVehicle& vehicle : vehicles_) vehicle.outcome = TickOutcome{};
  const double T = tickLength();
  switch (config(0).integrator) {
    case IntegratorKind::kExplicitEuler:
    case IntegratorKind::kSemiImplicitEuler:
    case IntegratorKind::kRk4:
      beginStep(T);
      wholeStep(*this, config(0).integrator, x_, T, buffers_.k, buffers_.scratch);
      accept(x_, T, true);
      break;
    case IntegratorKind::kRk4Events:
      ContactEvents<IslandStepper>(*this).take();
      break;
    case IntegratorKind::kDormandPrince:
      takeByErrorControl(*this);
      break;
    case IntegratorKind::kLinearlyImplicit:
      setUpSpeeds();
      LinearlyImplicit<IslandStepper>(*this).take();
      break;
  }
  return sane_;
}

void IslandStepper::beginStep(double h) {
  for (std::size_t i = 0; i < vehicles_.size(); ++i) dynamics(i).beginStep(*vehicles_[i].state, h);
}

// The others of one that cannot go on are taken back with it: by the fleet, as the tick is not one then.
bool IslandStepper::accept(const IslandMotion& end, double h, bool last) {
  for (std::size_t i = 0; i < vehicles_.size(); ++i) {
    const SteppedVehicle& v = vehicles_[i];
    TickOutcome& outcome = vehicles_[i].outcome;
    v.stepper->accept(*v.state, *end.of[i], h, last && ends_tick_, *v.before, outcome);
    if (!outcome.sane) TickStepper::giveUp(*v.state, *v.before, outcome);
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
      for (const int member : pair.at) ++vehicles_[static_cast<std::size_t>(member)].outcome.passed_through;
    pair.p_start = first.posed().p_WE - second.posed().p_WE;
    x_.anchor[p] = pair.memory.anchor_W;
  }
  return true;
}

bool IslandStepper::isSound(const IslandMotion& x) const {
  return std::all_of(x.of.begin(), x.of.end(), [](const Motion* motion) { return isSane(*motion); });
}

void IslandStepper::countFloorStep() {
  for (SteppedVehicle& vehicle : vehicles_) ++vehicle.outcome.floor_steps;
}

double IslandStepper::tolerance() const {
  double least = config(0).error_tolerance;
  for (std::size_t i = 1; i < vehicles_.size(); ++i) least = std::min(least, config(i).error_tolerance);
  return least;
}

double IslandStepper::errorOf(const IslandRate& error, double h) const {
  Largest largest;
  for (std::size_t i = 0; i < vehicles_.size(); ++i) largest.add(stepper(i).errorOf(*error.of[i], h));
  for (const Vector3d& z : error.anchor) largest.add(h * z.norm());
  return largest.value();
}

double IslandStepper::contactSubsteps() const {
  double most = 1.0;
  for (std::size_t i = 0; i < vehicles_.size(); ++i) most = std::max(most, config(i).contact_substeps);
  return most;
}

bool IslandStepper::hasJoints() const {
  for (std::size_t i = 0; i < vehicles_.size(); ++i)
    if (stepper(i).hasJoints()) return true;
  return false;
}

std::size_t IslandStepper::placeOfContact(int& contact) const {
  for (std::size_t i = 0; i < vehicles_.size(); ++i) {
    const int own = static_cast<int>(vehicles_[i].model->ellipsoids.size());
    if (contact < own) return i;
    contact -= own;
  }
  return vehicles_.size();
}

void IslandStepper::noteContacts() {
  for (std::size_t i = 0; i < vehicles_.size(); ++i) stepper(i).noteContacts(*x_.of[i]);
  for (PairCandidate* pair : pairs_) {
    pair->pressed_at_start = pair->force.normal > 0.0;
    pair->touch_at_start = ellipsoid_vehicle_sim::touchOf(side(*pair, 0, x_), side(*pair, 1, x_), *pair);
  }
}

bool IslandStepper::anyPressedAtStart() const {
  for (std::size_t i = 0; i < vehicles_.size(); ++i)
    if (stepper(i).anyPressedAtStart()) return true;
  return std::any_of(pairs_.begin(), pairs_.end(), [](const PairCandidate* pair) { return pair->pressed_at_start; });
}

bool IslandStepper::pressedAtStart(int contact) const {
  const std::size_t i = placeOfContact(contact);
  return i < vehicles_.size() ? stepper(i).pressedAtStart(contact)
                             : pairs_[static_cast<std::size_t>(contact)]->pressed_at_start;
}

const Touch& IslandStepper::touchAtStart(int contact) const {
  const std::size_t i = placeOfContact(contact);
  return i < vehicles_.size() ? stepper(i).touchAtStart(contact)
                             : pairs_[static_cast<std::size_t>(contact)]->touch_at_start;
}

int IslandStepper::firstChanged() const {
  int before = 0;
  for (std::size_t i = 0; i < vehicles_.size(); ++i) {
    const int changed = stepper(i).firstChanged();
    if (changed >= 0) return before + changed;
    before += static_cast<int>(vehicles_[i].model->ellipsoids.size());
  }
  for (std::size_t p = 0; p < pairs_.size(); ++p)
    if ((pairs_[p]->force.normal > 0.0) != pairs_[p]->pressed_at_start) return before + static_cast<int>(p);
  return -1;
}

Touch IslandStepper::touchOf(const IslandMotion& x, int contact) const {
  const std::size_t i = placeOfContact(contact);
  if (i < vehicles_.size()) return stepper(i).touchOf(*x.of[i], contact);
  const PairCandidate& pair = *pairs_[static_cast<std::size_t>(contact)];
  return ellipsoid_vehicle_sim::touchOf(side(pair, 0, x), side(pair, 1, x), pair);
}

}  // namespace ellipsoid_vehicle_sim
