// The integrator linearly_implicit: backward Euler by one step of Newton's method from the motion as it goes on
// [HairerWanner1996, IV.9], on the speeds alone: positions and stretches follow them. Written out, with v the speeds, p all
// that is position-like, p' = r(p, v), v' = a(p, v):
//   p* = p + h r(p, v),   (1 - h (da/dv + h da/dp dr/dv)) D = h a(p*, v),   v1 = v + D,   p1 = p + h r(v1).
// Where that is not yet an end (a contact which p* did not meet, a law at its limit), Newton's method goes on from there; where
// it does not find one, the step is halved.
// The derivatives are differences along what a unit of each speed does within the step, one evaluation for each.
#include <algorithm>
#include <cmath>

#include "ellipsoid_vehicle_sim/vehicle/tick_stepper.h"

namespace ellipsoid_vehicle_sim {
namespace {

// Differences move positions by this [m, rad]: small against every sag, large against rounding.
constexpr double kMoved = 1e-7;
// And speeds by at least and at most so much [m/s, rad/s].
constexpr double kLeastSpeed = 1e-6, kMostSpeed = 1e-3;

// Newton's steps, where laws reach their limits within the step: the ground, the edge of a cone, a brake that slips.
constexpr int kMostIterations = 6;
// The end is found where what is left is less than this part of what happened [-], or of this [m/s].
constexpr double kResidual = 0.02, kLeastChange = 1e-6;
// Where that fails the step is halved, down to this part of the tick.
constexpr double kSmallestPart = 1.0 / 64.0;
// What is left of a tick after its last step, in parts of it, is rounding.
constexpr double kRounding = 1e-9;

double& speedOf(MotionRate& k, int i) {
  if (i < 3) return k.a[i];
  if (i < 6) return k.alpha[i - 3];
  return k.qd[static_cast<std::size_t>(i - 6)];
}

double speedOf(const MotionRate& k, int i) {
  if (i < 3) return k.a[i];
  if (i < 6) return k.alpha[i - 3];
  return k.qd[static_cast<std::size_t>(i - 6)];
}

double speedOf(const Motion& x, int i) {
  if (i < 3) return x.v_WB[i];
  if (i < 6) return x.w_WB[i - 3];
  return x.qd[static_cast<std::size_t>(i - 6)];
}

void clear(MotionRate& k) {
  k.v.setZero();
  k.w.setZero();
  k.a.setZero();
  k.alpha.setZero();
  k.power = Work{};
  std::fill(k.q.begin(), k.q.end(), 0.0);
  std::fill(k.qd.begin(), k.qd.end(), 0.0);
  std::fill(k.stretch.begin(), k.stretch.end(), 0.0);
  for (Anchors& anchors : k.anchor)
    for (Eigen::Vector3d& z : anchors) z.setZero();
}

}  // namespace

// What is left of v1 - v0 = h a(p1, v1) at the end that k_[1] is the rate of, over the largest change of a speed: both as
// speeds of points of the vehicle.
double TickStepper::implicitResidual(const VehicleState& state, double h) const {
  double left = 0.0, change = kLeastChange;
  for (int i = 0; i < implicit_.size(); ++i) {
    const double arm = i < 3 ? 1.0 : i < 6 ? reach_ : joint_arm_[static_cast<std::size_t>(i - 6)];
    const double gained = speedOf(trial_, i) - speedOf(state.motion, i);
    left = std::max(left, arm * std::abs(gained - h * speedOf(k_[1], i)));
    change = std::max(change, arm * std::abs(gained));
  }
  return left / change;
}

// One step of h from the state into trial_; false: Newton's method did not find its end.
bool TickStepper::implicitStep(const VehicleState& state, double h) {
  const int n = implicit_.size();
  dynamics_.beginStep(state, h);
  dynamics_.rate(state.motion, 0.0, k_[0]);

  // What a unit of each speed moves: the contacts are those of the start.
  const double step = std::clamp(kMoved / h, kLeastSpeed, kMostSpeed);
  const double difference[2] = {1.0 / step, -1.0 / step};
  k_[2] = k_[0];
  for (int j = 0; j < n; ++j) {
    clear(sum_);
    speedOf(sum_, j) = 1.0;
    scratch_ = state.motion;
    dynamics_.advanceVelocities(scratch_, step, sum_);
    dynamics_.positionRates(scratch_, k_[1]);
    MotionRate& direction = directions_[static_cast<std::size_t>(j)];
    dynamics_.weightedSum(difference, k_ + 1, 2, direction);
    // Within the step a unit of speed stays one: as a rate, it comes about over h.
    direction.a = sum_.a / h;
    direction.alpha = sum_.alpha / h;
    for (std::size_t i = 0; i < direction.qd.size(); ++i) direction.qd[i] = sum_.qd[i] / h;
  }

  // First guess: the motion goes on by itself, the speeds unchanged.
  trial_ = state.motion;
  dynamics_.advancePositions(trial_, h, k_[0]);
  for (int iteration = 1;; ++iteration) {
    for (int j = 0; j < n; ++j) {
      dynamics_.advance(trial_, h * step, directions_[static_cast<std::size_t>(j)], scratch_);
      dynamics_.rate(scratch_, 1.0, k_[1]);
      for (int i = 0; i < n; ++i) implicit_.at(i, j) = speedOf(k_[1], i);
    }
    dynamics_.rate(trial_, 1.0, k_[1]);
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        const double slope = (implicit_.at(i, j) - speedOf(k_[1], i)) / step;
        implicit_.at(i, j) = (i == j ? 1.0 : 0.0) - h * slope;
      }
      implicit_.right(i) = h * speedOf(k_[1], i) - (speedOf(trial_, i) - speedOf(state.motion, i));
    }
    // No matrix that belongs to a motion is singular: what led here is not finite, and shows in the state.
    const bool solved = implicit_.solve();
    clear(sum_);
    for (int i = 0; i < n; ++i)
      speedOf(sum_, i) = solved ? speedOf(trial_, i) - speedOf(state.motion, i) + implicit_.solution(i) : h * speedOf(k_[1], i);
    trial_ = state.motion;
    dynamics_.advanceVelocities(trial_, 1.0, sum_);
    dynamics_.positionRates(trial_, k_[1]);
    dynamics_.advancePositions(trial_, h, k_[1]);
    if (!solved) return false;
    dynamics_.rate(trial_, 1.0, k_[1]);
    trial_.work = state.motion.work + h * k_[1].power;
    if (implicitResidual(state, h) <= kResidual) return true;
    if (iteration == kMostIterations) return false;
  }
}

void TickStepper::takeLinearlyImplicit(VehicleState& state, TickOutcome& outcome) {
  const double T = config_.dt;
  double done = 0.0, h = T;
  while (outcome.sane && T - done > kRounding * T) {
    h = std::min(h, T - done);
    const bool found = implicitStep(state, h);
    if (!found && h > kSmallestPart * T) {
      h *= 0.5;
      continue;
    }
    if (!found) ++outcome.floor_steps;
    done += h;
    accept(state, trial_, h, T - done <= kRounding * T, outcome);
    h *= 2.0;
  }
}

}  // namespace ellipsoid_vehicle_sim
