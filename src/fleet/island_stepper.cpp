#include "island_stepper.h"

#include <algorithm>
#include <iterator>

namespace ellipsoid_vehicle_sim {

using Eigen::Vector3d;

namespace {

template <typename Buffers, typename Visit>
void forEachRate(Buffers& buffers, const Visit& visit) {
  for (auto& rate : buffers.k) visit(rate);
  for (auto& rate : buffers.stages) visit(rate);
  visit(buffers.sum);
  visit(buffers.error);
}

}  // namespace

void IslandStepper::reserve(std::size_t members) {
  constexpr std::size_t kPairs = 64;
  vehicles_.reserve(members);
  places_.reserve(members);
  pairs_.reserve(kPairs);
  for (IslandMotion* motion : {&x_, &buffers_.trial, &buffers_.scratch}) {
    motion->of.reserve(members);
    motion->anchor.reserve(kPairs);
  }
  forEachRate(buffers_, [&](IslandRate& rate) {
    rate.of.reserve(members);
    rate.anchor.reserve(kPairs);
  });
}

void IslandStepper::clear() {
  vehicles_.clear();
  places_.clear();
  pairs_.clear();
}

void IslandStepper::addVehicle(const SteppedVehicle& vehicle, int place) {
  vehicles_.push_back(vehicle);
  places_.push_back(place);
}

void IslandStepper::addPair(PairCandidate& pair) {
  for (int s = 0; s < 2; ++s) pair.at[s] = static_cast<int>(placeOf(pair.member[s]));
  pairs_.push_back(&pair);
}

std::size_t IslandStepper::placeOf(int member) const {
  return static_cast<std::size_t>(std::lower_bound(places_.begin(), places_.end(), member) - places_.begin());
}

void IslandStepper::setUp() {
  x_.of.clear();
  buffers_.trial.of.clear();
  buffers_.scratch.of.clear();
  forEachRate(buffers_, [this](IslandRate& rate) {
    rate.of.clear();
    rate.anchor.assign(pairs_.size(), Vector3d::Zero());
  });
  for (std::size_t i = 0; i < vehicles_.size(); ++i) {
    TickStepper::Buffers& own = stepper(i).buffers();
    x_.of.push_back(&vehicles_[i].state->motion);
    buffers_.trial.of.push_back(&own.trial);
    buffers_.scratch.of.push_back(&own.scratch);
    for (std::size_t j = 0; j < std::size(own.k); ++j) buffers_.k[j].of.push_back(&own.k[j]);
    for (std::size_t j = 0; j < std::size(own.stages); ++j) buffers_.stages[j].of.push_back(&own.stages[j]);
    buffers_.sum.of.push_back(&own.sum);
    buffers_.error.of.push_back(&own.error);
  }
  x_.anchor.clear();
  for (const PairCandidate* pair : pairs_) x_.anchor.push_back(pair->memory.anchor_W);
  buffers_.trial.anchor = buffers_.scratch.anchor = x_.anchor;
}

PairSide IslandStepper::side(const PairCandidate& pair, int which, const IslandMotion& x) const {
  const auto i = static_cast<std::size_t>(pair.at[which]);
  return {&dynamics(i), x.of[i], pair.memory.ellipsoid[which]};
}

void IslandStepper::addForce(const PairCandidate& pair, int which, const IslandMotion& x, const Vector3d& p_WC,
                           const Vector3d& f_W) {
  const auto i = static_cast<std::size_t>(pair.at[which]);
  dynamics(i).addForce(*x.of[i], {pair.memory.ellipsoid[which], p_WC, which == 0 ? f_W : Vector3d(-f_W)});
}

void IslandStepper::rate(const IslandMotion& x, double fraction, IslandRate& k) {
  for (std::size_t i = 0; i < vehicles_.size(); ++i) dynamics(i).beginRate(*x.of[i], fraction, *k.of[i]);
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    PairCandidate& pair = *pairs_[p];
    k.anchor[p].setZero();
    if (!evaluatePair(side(pair, 0, x), side(pair, 1, x), x.anchor[p], pair)) continue;
    // One that is first met within the step has no stretch before its end.
    if (pair.known) k.anchor[p] = pair.force.anchor_rate_W;
    for (int s = 0; s < 2; ++s) addForce(pair, s, x, pair.p_WC, pair.f_W);
  }
  for (std::size_t i = 0; i < vehicles_.size(); ++i) dynamics(i).endRate(*x.of[i], *k.of[i]);
}

void IslandStepper::positionRates(const IslandMotion& x, IslandRate& k) {
  for (std::size_t i = 0; i < vehicles_.size(); ++i) dynamics(i).positionRates(*x.of[i], *k.of[i]);
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    PairCandidate& pair = *pairs_[p];
    if (!pair.known || !pair.contact) continue;
    updatePairForce(side(pair, 0, x), side(pair, 1, x), x.anchor[p], pair);
    k.anchor[p] = pair.force.anchor_rate_W;
  }
}

void IslandStepper::advance(const IslandMotion& x, double h, const IslandRate& k, IslandMotion& result) const {
  for (std::size_t i = 0; i < vehicles_.size(); ++i) dynamics(i).advance(*x.of[i], h, *k.of[i], *result.of[i]);
  for (std::size_t p = 0; p < pairs_.size(); ++p) result.anchor[p] = x.anchor[p] + h * k.anchor[p];
}

void IslandStepper::advanceVelocities(IslandMotion& x, double h, const IslandRate& k) const {
  for (std::size_t i = 0; i < vehicles_.size(); ++i) dynamics(i).advanceVelocities(*x.of[i], h, *k.of[i]);
}

void IslandStepper::advancePositions(IslandMotion& x, double h, const IslandRate& k) const {
  for (std::size_t i = 0; i < vehicles_.size(); ++i) dynamics(i).advancePositions(*x.of[i], h, *k.of[i]);
  for (std::size_t p = 0; p < pairs_.size(); ++p) x.anchor[p] += h * k.anchor[p];
}

void IslandStepper::toTangent(double h, const IslandRate& previous, IslandRate& k) const {
  for (std::size_t i = 0; i < vehicles_.size(); ++i) dynamics(i).toTangent(h, *previous.of[i], *k.of[i]);
}

void IslandStepper::combine(IslandRate (&k)[4]) const {
  // The dynamics combine four rates that lie side by side, as the members' do.
  for (std::size_t i = 0; i < vehicles_.size(); ++i) dynamics(i).combine(stepper(i).buffers().k);
  for (std::size_t p = 0; p < pairs_.size(); ++p)
    k[0].anchor[p] = (k[0].anchor[p] + 2.0 * k[1].anchor[p] + 2.0 * k[2].anchor[p] + k[3].anchor[p]) / 6.0;
}

void IslandStepper::weightedSum(const double* weights, const IslandRate* k, int n, IslandRate& sum) const {
  for (std::size_t i = 0; i < vehicles_.size(); ++i) dynamics(i).weightedSum(weights, k[0].of[i], n, *sum.of[i]);
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    sum.anchor[p].setZero();
    for (int s = 0; s < n; ++s) sum.anchor[p] += weights[s] * k[s].anchor[p];
  }
}

void IslandStepper::evaluatePairs() {
  setUp();
  for (const SteppedVehicle& vehicle : vehicles_) vehicle.dynamics->poseAt(*vehicle.state);
  for (PairCandidate* pair : pairs_) evaluatePair(side(*pair, 0, x_), side(*pair, 1, x_), pair->memory.anchor_W, *pair);
}

}  // namespace ellipsoid_vehicle_sim
