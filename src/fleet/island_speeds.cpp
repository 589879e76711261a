// linearly_implicit for vehicles that may touch each other: what each of their speeds changes. One vehicle's changes
// the rates of its own and of those that it touches, and no others'.
#include <algorithm>

#include "island_stepper.h"

namespace ellipsoid_vehicle_sim {

using Eigen::Vector3d;

void IslandStepper::setUpSpeeds() {
  owner_.clear();
  for (std::size_t i = 0; i < vehicles_.size(); ++i)
    for (int j = 0; j < stepper(i).speeds(); ++j) owner_.push_back({i, j});
  matrix_.resize(static_cast<int>(owner_.size()));
  pair_forces_.resize(pairs_.size());
  std::size_t directions = 0;
  for (std::size_t p = 0; p < pairs_.size(); ++p)
    for (int s = 0; s < 2; ++s) {
      pair_forces_[p].directions[s] = directions;
      directions += static_cast<std::size_t>(stepper(static_cast<std::size_t>(pairs_[p]->at[s])).speeds());
    }
  anchor_directions_.resize(directions);
  moved_.assign(vehicles_.size(), 0);
}

void IslandStepper::findDirections(double h, double delta) {
  for (std::size_t m = 0; m < vehicles_.size(); ++m) {
    stepper(m).beginDirections();
    for (int j = 0; j < stepper(m).speeds(); ++j) {
      stepper(m).findDirection(*x_.of[m], h, delta, j);
      for (std::size_t p = 0; p < pairs_.size(); ++p) {
        PairCandidate& pair = *pairs_[p];
        for (int s = 0; s < 2; ++s) {
          if (static_cast<std::size_t>(pair.at[s]) != m) continue;
          Vector3d& direction = anchorDirection(p, s, j);
          direction.setZero();
          if (!pair.known || !pair.contact) continue;
          PairSide sides[2] = {side(pair, 0, x_), side(pair, 1, x_)};
          sides[s].motion = buffers_.scratch.of[m];
          updatePairForce(sides[0], sides[1], x_.anchor[p], pair);
          direction = (pair.force.anchor_rate_W - buffers_.k[0].anchor[p]) / delta;
        }
      }
    }
    // Its surfaces move as they do, for the directions of those it touches.
    dynamics(m).positionRates(*x_.of[m], *buffers_.k[1].of[m]);
  }
}

// All are left posed at the trial; their rates there are k[3], their forces on each other are kept.
void IslandStepper::beginColumns() {
  rate(buffers_.trial, 1.0, buffers_.k[3]);
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    pair_forces_[p].touches = static_cast<bool>(pairs_[p]->contact);
    pair_forces_[p].p_WC = pairs_[p]->p_WC;
    pair_forces_[p].f_W = pairs_[p]->f_W;
  }
}

void IslandStepper::findColumn(int j, double way) {
  const Owner owner = owner_[static_cast<std::size_t>(j)];
  const std::size_t m = owner.member;
  std::fill(moved_.begin(), moved_.end(), 0);
  moveAlong(m, owner.speed, way);
  for (std::size_t n = 0; n < vehicles_.size(); ++n)
    if (moved_[n] != 0) rateOfNeighbour(n, m);
  moved_[m] = 1;
  for (int i = 0; i < matrix_.size(); ++i)
    matrix_.at(i, j) = speed(buffers_.k[moved_[owner_[static_cast<std::size_t>(i)].member] != 0 ? 1 : 3], i);
  // After the last of its speeds the vehicle stands at the trial again, for its neighbours.
  if (owner.speed + 1 == stepper(m).speeds()) dynamics(m).beginRate(*buffers_.trial.of[m], 1.0, *buffers_.k[1].of[m]);
}

// One vehicle at the trial moved along what a unit of its speed does; marks those that feel it.
void IslandStepper::moveAlong(std::size_t m, int speed, double way) {
  Motion& moved = *buffers_.scratch.of[m];
  dynamics(m).advance(*buffers_.trial.of[m], way, stepper(m).direction(speed), moved);
  dynamics(m).beginRate(moved, 1.0, *buffers_.k[1].of[m]);
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    PairCandidate& pair = *pairs_[p];
    const int s = static_cast<std::size_t>(pair.at[0]) == m ? 0 : 1;
    if (static_cast<std::size_t>(pair.at[s]) != m) continue;
    PairSide sides[2] = {side(pair, 0, buffers_.trial), side(pair, 1, buffers_.trial)};
    sides[s].motion = &moved;
    const Vector3d anchor = buffers_.trial.anchor[p] + way * anchorDirection(p, s, speed);
    const bool touches = evaluatePair(sides[0], sides[1], anchor, pair);
    if (touches) addForce(pair, s, buffers_.scratch, pair.p_WC, pair.f_W);
    if (touches || pair_forces_[p].touches) moved_[static_cast<std::size_t>(pair.at[1 - s])] = 1;
  }
  dynamics(m).endRate(moved, *buffers_.k[1].of[m]);
}

// Of one that stands at the trial, pushed by those that do, and by the one that was moved.
void IslandStepper::rateOfNeighbour(std::size_t n, std::size_t moved) {
  const Motion& x = *buffers_.trial.of[n];
  dynamics(n).beginRate(x, 1.0, *buffers_.k[1].of[n]);
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    const PairCandidate& pair = *pairs_[p];
    const int s = static_cast<std::size_t>(pair.at[0]) == n ? 0 : 1;
    if (static_cast<std::size_t>(pair.at[s]) != n) continue;
    if (static_cast<std::size_t>(pair.at[1 - s]) == moved) {
      if (pair.contact) addForce(pair, s, buffers_.trial, pair.p_WC, pair.f_W);
    } else if (pair_forces_[p].touches) {
      addForce(pair, s, buffers_.trial, pair_forces_[p].p_WC, pair_forces_[p].f_W);
    }
  }
  dynamics(n).endRate(x, *buffers_.k[1].of[n]);
}

void IslandStepper::keepWork(double h) {
  for (std::size_t i = 0; i < vehicles_.size(); ++i)
    buffers_.trial.of[i]->work = x_.of[i]->work + h * buffers_.k[1].of[i]->power;
}

double IslandStepper::residual(double h) const {
  Largest largest;
  for (std::size_t i = 0; i < vehicles_.size(); ++i) largest.add(stepper(i).residual(*x_.of[i], h));
  return largest.value();
}

}  // namespace ellipsoid_vehicle_sim
