#include "fleet_island.h"

namespace ellipsoid_vehicle_sim {

void FleetIsland::reserve(std::size_t members) {
  constexpr std::size_t kPairs = 64;
  members_.reserve(members);
  pairs_.reserve(kPairs);
  stepper_.reserve(members);
}

void FleetIsland::clear() {
  members_.clear();
  pairs_.clear();
  stepper_.clear();
}

void FleetIsland::addMember(FleetMember& member, int place) {
  Simulator::Impl& s = *member.simulator->impl_;
  members_.push_back(&member);
  stepper_.addVehicle({&s.model, &s.config, s.dynamics.get(), s.stepper.get(), &s.state, &s.previous.memory}, place);
}

void FleetIsland::addPair(PairCandidate& pair) {
  pairs_.push_back(&pair);
  stepper_.addPair(pair);
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
  for (std::size_t i = 0; i < members_.size(); ++i) impl(i).resting = false;
  beginShadows();
  const bool sane = stepper_.advance();
  if (sane) endShadows();
  endTick(sane);
}

void FleetIsland::beginShadows() {
  estimates_ = checks_ = false;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    estimates_ = estimates_ || impl(i).estimatesNow();
    checks_ = checks_ || impl(i).checksSavings();
  }
  if (!estimates_ && !checks_) return;
  halves_.clear();
  whole_.clear();
  for (std::size_t i = 0; i < members_.size(); ++i) {
    Simulator::Impl& s = impl(i);
    if (estimates_) halves_.addVehicle(s.needEstimator().run(), s.state, stepper_.place(i));
    if (checks_) whole_.addVehicle(s.needSavingsCheck().run(), s.state, stepper_.place(i));
  }
  if (estimates_) halves_.addPairs(pairs_);
  if (checks_) whole_.addPairs(pairs_);
}

void FleetIsland::endShadows() {
  const bool estimated = estimates_ && halves_.advance(false) && halves_.advance();
  const bool agrees = checks_ && whole_.advance() && whole_.agrees(pairs_);
  for (std::size_t i = 0; i < members_.size(); ++i) {
    Simulator::Impl& s = impl(i);
    if (estimated && s.estimatesNow()) {
      s.estimator->compare(s.state, s.estimate);
      s.estimate.step = s.step_count + 1;
    }
    if (s.checksSavings() && !(agrees && s.savings_check->isAt(s.state))) ++s.events.savings_differences;
  }
}

void FleetIsland::endTick(bool sane) {
  for (std::size_t i = 0; i < members_.size(); ++i) {
    Simulator::Impl& s = impl(i);
    s.touched.clear();
    s.outside.clear();
    s.endTick(stepper_.outcome(i), members_[i]->timed_out);
  }
  if (sane) tellPairs();
}

void FleetIsland::tell() {
  for (std::size_t i = 0; i < members_.size(); ++i) {
    Simulator::Impl& s = impl(i);
    s.touched.clear();
    s.outside.clear();
    s.observed_fresh = false;
  }
  stepper_.evaluatePairs();
  tellPairs();
}

void FleetIsland::tellPairs() {
  for (const PairCandidate* pair : pairs_) {
    if (!pair->contact) continue;
    for (int s = 0; s < 2; ++s) {
      Simulator::Impl& one = impl(static_cast<std::size_t>(pair->at[s]));
      const double sign = s == 0 ? 1.0 : -1.0;
      ContactReport report;
      report.ellipsoid = pair->memory.ellipsoid[s];
      report.triangle = -1;
      report.other = pair->memory.vehicle[1 - s];
      report.other_ellipsoid = pair->memory.ellipsoid[1 - s];
      report.p_WC = s == 0 ? pair->contact.p_WE_second : pair->contact.p_WE_first;
      report.nhat_W = sign * pair->contact.nhat_W;
      report.depth = pair->contact.depth;
      report.normal_force = pair->force.normal;
      report.friction_W = sign * pair->force.friction_W;
      report.friction_limit = pair->force.friction_limit;
      report.sliding = pair->force.sliding;
      one.touched.push_back(report);
      one.outside.push_back({pair->memory.ellipsoid[s], pair->p_WC, sign * pair->f_W});
    }
  }
}

}  // namespace ellipsoid_vehicle_sim
