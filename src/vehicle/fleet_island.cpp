#include "fleet_island.h"

#include <algorithm>

#include "ellipsoid_vehicle_sim/dynamics/integrator.h"

namespace ellipsoid_vehicle_sim {

using Eigen::Vector3d;

void FleetIsland::reserve(std::size_t members) {
  members_.reserve(members);
  places_.reserve(members);
  pairs_.reserve(64);
  for (IslandMotion* motion : {&x_, &scratch_}) {
    motion->of.reserve(members);
    motion->anchor.reserve(64);
  }
  for (IslandRate& rate : k_) {
    rate.of.reserve(members);
    rate.anchor.reserve(64);
  }
}

void FleetIsland::clear() {
  members_.clear();
  places_.clear();
  pairs_.clear();
}

void FleetIsland::addMember(FleetMember& member, int place) {
  members_.push_back(&member);
  places_.push_back(place);
}

std::size_t FleetIsland::placeOf(int member) const {
  return static_cast<std::size_t>(std::lower_bound(places_.begin(), places_.end(), member) - places_.begin());
}

void FleetIsland::setUp() {
  x_.of.clear();
  scratch_.of.clear();
  for (IslandRate& rate : k_) rate.of.clear();
  for (std::size_t i = 0; i < members_.size(); ++i) {
    x_.of.push_back(&impl(i).state.motion);
    scratch_.of.push_back(&members_[i]->scratch);
    for (int j = 0; j < 4; ++j) k_[j].of.push_back(&members_[i]->k[j]);
  }
  x_.anchor.clear();
  for (const PairCandidate* pair : pairs_) x_.anchor.push_back(pair->memory.anchor_W);
  scratch_.anchor = x_.anchor;
  for (IslandRate& rate : k_) rate.anchor.assign(pairs_.size(), Vector3d::Zero());
}

PairSide FleetIsland::side(const PairCandidate& pair, int which, const IslandMotion& x) const {
  const std::size_t i = placeOf(pair.member[which]);
  return {impl(i).dynamics.get(), x.of[i], pair.memory.ellipsoid[which]};
}

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
  const SimConfig& config = impl(0).config;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    impl(i).resting = false;
    members_[i]->outcome = TickOutcome{};
    impl(i).dynamics->beginStep(impl(i).state, config.dt);
  }
  switch (config.integrator) {
    case IntegratorKind::kExplicitEuler: explicitEulerStep(*this, x_, config.dt, k_, scratch_); break;
    case IntegratorKind::kSemiImplicitEuler: semiImplicitEulerStep(*this, x_, config.dt, k_, scratch_); break;
    default: rk4Step(*this, x_, config.dt, k_, scratch_); break;
  }
  accept(config.dt);
}

void FleetIsland::rate(const IslandMotion& x, double fraction, IslandRate& k) {
  for (std::size_t i = 0; i < members_.size(); ++i) impl(i).dynamics->beginRate(*x.of[i], fraction, *k.of[i]);
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    PairCandidate& pair = *pairs_[p];
    k.anchor[p].setZero();
    if (!evaluatePair(side(pair, 0, x), side(pair, 1, x), x.anchor[p], pair)) continue;
    // One that is first met within the step has no stretch before its end.
    if (pair.known) k.anchor[p] = pair.force.anchor_rate_W;
    for (int s = 0; s < 2; ++s) {
      const std::size_t i = placeOf(pair.member[s]);
      impl(i).dynamics->addForce(*x.of[i], {pair.memory.ellipsoid[s], pair.p_WC, s == 0 ? pair.f_W : Vector3d(-pair.f_W)});
    }
  }
  for (std::size_t i = 0; i < members_.size(); ++i) impl(i).dynamics->endRate(*x.of[i], *k.of[i]);
}

void FleetIsland::positionRates(const IslandMotion& x, IslandRate& k) {
  for (std::size_t i = 0; i < members_.size(); ++i) impl(i).dynamics->positionRates(*x.of[i], *k.of[i]);
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    PairCandidate& pair = *pairs_[p];
    if (!pair.known || !pair.contact) continue;
    updatePairForce(side(pair, 0, x), side(pair, 1, x), x.anchor[p], pair);
    k.anchor[p] = pair.force.anchor_rate_W;
  }
}

void FleetIsland::advance(const IslandMotion& x, double h, const IslandRate& k, IslandMotion& result) const {
  for (std::size_t i = 0; i < members_.size(); ++i) impl(i).dynamics->advance(*x.of[i], h, *k.of[i], *result.of[i]);
  for (std::size_t p = 0; p < pairs_.size(); ++p) result.anchor[p] = x.anchor[p] + h * k.anchor[p];
}

void FleetIsland::advanceVelocities(IslandMotion& x, double h, const IslandRate& k) const {
  for (std::size_t i = 0; i < members_.size(); ++i) impl(i).dynamics->advanceVelocities(*x.of[i], h, *k.of[i]);
}

void FleetIsland::advancePositions(IslandMotion& x, double h, const IslandRate& k) const {
  for (std::size_t i = 0; i < members_.size(); ++i) impl(i).dynamics->advancePositions(*x.of[i], h, *k.of[i]);
  for (std::size_t p = 0; p < pairs_.size(); ++p) x.anchor[p] += h * k.anchor[p];
}

void FleetIsland::toTangent(double h, const IslandRate& previous, IslandRate& k) const {
  for (std::size_t i = 0; i < members_.size(); ++i) impl(i).dynamics->toTangent(h, *previous.of[i], *k.of[i]);
}

void FleetIsland::combine(IslandRate (&k)[4]) const {
  // The dynamics combine four rates that lie side by side, as the members' do.
  for (std::size_t i = 0; i < members_.size(); ++i) impl(i).dynamics->combine(members_[i]->k);
  for (std::size_t p = 0; p < pairs_.size(); ++p)
    k[0].anchor[p] = (k[0].anchor[p] + 2.0 * k[1].anchor[p] + 2.0 * k[2].anchor[p] + k[3].anchor[p]) / 6.0;
}

void FleetIsland::accept(double h) {
  bool sane = true;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    Simulator::Impl& s = impl(i);
    s.stepper->endStep(s.state, s.state.motion, h, s.previous.memory, members_[i]->outcome);
    sane = sane && members_[i]->outcome.sane;
  }
  if (sane) {
    for (std::size_t p = 0; p < pairs_.size(); ++p) {
      PairCandidate& pair = *pairs_[p];
      const PairSide first = side(pair, 0, x_), second = side(pair, 1, x_);
      const Vector3d before = pair.memory.nhat_W;
      const bool known = pair.known;
      acceptPair(first, second, x_.anchor[p], h, pair);
      if (passedThrough(first.posed(), second.posed(), pair, before, known))
        for (const int member : pair.member) ++members_[placeOf(member)]->outcome.passed_through;
    }
  }
  for (std::size_t i = 0; i < members_.size(); ++i) {
    Simulator::Impl& s = impl(i);
    s.touched.clear();
    s.outside.clear();
    s.endTick(members_[i]->outcome, members_[i]->timed_out);
  }
  if (!sane) return;
  for (const PairCandidate* pair : pairs_) tellPair(*pair);
}

void FleetIsland::tell() {
  setUp();
  for (std::size_t i = 0; i < members_.size(); ++i) {
    Simulator::Impl& s = impl(i);
    s.touched.clear();
    s.outside.clear();
    s.observed_fresh = false;
    s.dynamics->poseAt(s.state);
  }
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    PairCandidate& pair = *pairs_[p];
    if (evaluatePair(side(pair, 0, x_), side(pair, 1, x_), pair.memory.anchor_W, pair)) tellPair(pair);
  }
}

void FleetIsland::tellPair(const PairCandidate& pair) {
  if (!pair.contact) return;
  for (int s = 0; s < 2; ++s) {
    Simulator::Impl& one = impl(placeOf(pair.member[s]));
    const double sign = s == 0 ? 1.0 : -1.0;
    ContactReport report;
    report.ellipsoid = pair.memory.ellipsoid[s];
    report.triangle = -1;
    report.other = pair.memory.vehicle[1 - s];
    report.other_ellipsoid = pair.memory.ellipsoid[1 - s];
    report.p_WC = s == 0 ? pair.contact.p_WE_second : pair.contact.p_WE_first;
    report.nhat_W = sign * pair.contact.nhat_W;
    report.depth = pair.contact.depth;
    report.normal_force = pair.force.normal;
    report.friction_W = sign * pair.force.friction_W;
    report.friction_limit = pair.force.friction_limit;
    report.sliding = pair.force.sliding;
    one.touched.push_back(report);
    one.outside.push_back({pair.memory.ellipsoid[s], pair.p_WC, sign * pair.f_W});
  }
}

}  // namespace ellipsoid_vehicle_sim
