// The integrator rk4_events: RK4 whose steps end where a contact begins or ceases to press, and are smaller while anything
// presses. Through a touch-down within a step RK4 is of first order like everything else; between touch-downs of fourth.
#include <algorithm>
#include <cmath>

#include "base_motion.h"
#include "ellipsoid_vehicle_sim/vehicle/tick_stepper.h"

namespace ellipsoid_vehicle_sim {
namespace {

// Moments of touch-down and lift-off are found to this part of the tick. A step across is so short that the force's jump
// in it is of no account.
constexpr double kLocated = 1e-6;
// Trials per event; halving alone needs twenty.
constexpr int kMostTrials = 32;
// So many trials may fail to halve the bracket before one is made to: estimates close in from one side.
constexpr int kPatience = 5;
// Events that are located in one tick; later ones of the same tick (a body that rattles) are stepped over.
constexpr int kMostEvents = 12;
// Halvings of a step in which a stage met a contact that its end did not.
constexpr int kMostHalvings = 5;
// An estimate from `d` away is off by about this part of d^2 over the step, for that is how the depth bends. A trial is put so
// far beyond it: on the side where the ellipsoid touches, for only there it tells the next estimate.
constexpr double kBend = 0.15;

std::uint64_t bitOf(int ellipsoid) { return std::uint64_t{1} << (ellipsoid & 63); }

}  // namespace

// A bit for each ellipsoid; more than 64 share bits, and a change of one may then hide that of another.
std::uint64_t TickStepper::pressing() const {
  std::uint64_t mask = 0;
  for (const ActiveContact& active : dynamics_.activeContacts())
    if (active.force.normal > 0.0) mask |= bitOf(active.ellipsoid);
  return mask;
}

// Of the ellipsoid's deepest contact at the state last evaluated.
TickStepper::Touch TickStepper::touchOf(const Motion& x, int ellipsoid) const {
  Touch touch;
  for (const ActiveContact& active : dynamics_.activeContacts()) {
    if (active.ellipsoid != ellipsoid || (touch.known && active.contact.pressed <= touch.depth)) continue;
    const ContactLaw& law = model_.ellipsoids[ellipsoid].law;
    touch.known = true;
    touch.depth = active.contact.pressed;
    touch.speed = dynamics_.sinkingSpeed(x, active);
    touch.push = touch.depth + law.damping / law.stiffness * touch.speed;
  }
  return touch;
}

// RK4 from the state over h into trial_; k_[0] is the rate at the start. True: at no stage did anything begin or cease to
// press.
bool TickStepper::rk4From(const VehicleState& state, double h) {
  dynamics_.beginStep(state, h);
  bool smooth = true;
  for (int stage = 1; stage < 4; ++stage) {
    const double fraction = stage < 3 ? 0.5 : 1.0;
    dynamics_.advance(state.motion, fraction * h, k_[stage - 1], trial_);
    dynamics_.rate(trial_, fraction, k_[stage]);
    smooth = smooth && pressing() == pressed_;
    dynamics_.toTangent(fraction * h, k_[stage - 1], k_[stage]);
  }
  dynamics_.weightedSum(kRk4Weights, k_, 4, sum_);
  dynamics_.advance(state.motion, h, sum_, trial_);
  trial_length_ = h;
  return smooth;
}

TickStepper::Trial TickStepper::tryStep(const VehicleState& state, double h) {
  Trial trial;
  trial.smooth = rk4From(state, h);
  dynamics_.rate(trial_, 1.0, error_);
  const std::uint64_t changed = pressing() ^ pressed_;
  trial.ends_as_begun = changed == 0;
  for (int e = 0; e < static_cast<int>(model_.ellipsoids.size()) && trial.changed < 0; ++e)
    if ((changed & bitOf(e)) != 0) trial.changed = e;
  return trial;
}

// The last moment found before the ellipsoid begins or ceases to press, and the first one `after`. At h, the last trial,
// it has. Where it touches, depth and speed of the depth say when that began; where it comes off, the push of two moments
// says when it ends, and at the start its depth and speed.
double TickStepper::locate(const VehicleState& state, int ellipsoid, double h, double& after) {
  const double tolerance = kLocated * config_.dt;
  const bool touches = (pressed_ & bitOf(ellipsoid)) == 0;
  const Touch& start = start_touch_[static_cast<std::size_t>(ellipsoid)];
  double low = 0.0, high = h, estimate = 0.5 * h, from = 0.0;
  double known_at = 0.0, known_push = start.push;
  if (!touches && start.speed < 0.0) estimate = -start.push / start.speed;
  const auto learn = [&](double at, const Touch& touch) {
    if (!touch.known) return;
    if (touches) {
      if (touch.depth > 0.0 && touch.speed > 0.0) estimate = at - touch.depth / touch.speed;
    } else {
      const double slope = (known_push - touch.push) / (at - known_at);
      if (at != known_at && slope > 0.0) estimate = at + touch.push / slope;
      known_at = at;
      known_push = touch.push;
    }
    from = at;
  };
  learn(h, touchOf(trial_, ellipsoid));
  int patience = kPatience;
  for (int i = 0; i < kMostTrials && high - low > tolerance; ++i) {
    const double distance = estimate - from;
    const double beyond = std::max(kBend * distance * distance / h, 0.3 * tolerance);
    // A touch-down from above until that side is closed; a lift-off from below.
    const bool above = touches ? high - estimate > tolerance : estimate - low <= tolerance;
    double at = above ? estimate + beyond : estimate - beyond;
    if (!(at > low && at < high) || patience == 0) at = 0.5 * (low + high);
    const double bracket = high - low;
    (tryStep(state, at).ends_as_begun ? low : high) = at;
    patience = high - low <= 0.5 * bracket ? kPatience : patience - 1;
    learn(at, touchOf(trial_, ellipsoid));
  }
  after = high;
  return low;
}

// Leaves the end of the next step, at most h long, in trial_ and returns its length. `crossing` > 0: an event lies within
// so many seconds and is to be stepped over; it is set for the step after this one.
double TickStepper::nextStep(const VehicleState& state, double h, double& crossing, TickOutcome& outcome) {
  dynamics_.beginStep(state, h);
  dynamics_.rate(state.motion, 0.0, k_[0]);
  pressed_ = pressing();
  for (const ActiveContact& active : dynamics_.activeContacts())
    start_touch_[static_cast<std::size_t>(active.ellipsoid)] = touchOf(state.motion, active.ellipsoid);
  if (crossing > 0.0) {
    h = std::min(h, crossing);
    crossing = 0.0;
    rk4From(state, h);
    return h;
  }
  if (pressed_ != 0 || always_substep_) {
    const double part = config_.dt / config_.contact_substeps;
    // What would be left over of the tick is rounding.
    if (h - part > kLocated * config_.dt) h = part;
  }
  if (rk4From(state, h)) return h;
  if (located_ >= kMostEvents) {
    ++outcome.floor_steps;
    return h;
  }
  for (int halving = 0;; ++halving) {
    const Trial trial = tryStep(state, h);
    if (!trial.ends_as_begun) {
      ++located_;
      double after = h;
      const double before = locate(state, trial.changed, h, after);
      h = before > 0.0 ? before : after;
      if (before > 0.0) crossing = after - before;
      break;
    }
    if (trial.smooth) break;
    if (halving == kMostHalvings) {
      ++outcome.floor_steps;
      break;
    }
    h *= 0.5;
  }
  // The last trial was that step already, as a rule.
  if (trial_length_ != h) rk4From(state, h);
  return h;
}

void TickStepper::takeRk4Events(VehicleState& state, TickOutcome& outcome) {
  const double T = config_.dt;
  double done = 0.0, crossing = 0.0;
  located_ = 0;
  for (bool ends = false; outcome.sane && !ends;) {
    const double left = T - done;
    const double h = nextStep(state, left, crossing, outcome);
    // Only what rounding leaves of a tick is left out of it.
    ends = left - h <= 1e-12 * T;
    done += h;
    accept(state, trial_, h, ends, outcome);
  }
}

}  // namespace ellipsoid_vehicle_sim
