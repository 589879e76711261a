#pragma once

#include <algorithm>
#include <cmath>

#include "base_motion.h"
#include "ellipsoid_vehicle_sim/vehicle/tick_stepper.h"

namespace ellipsoid_vehicle_sim {

/// The integrator rk4_events: RK4 whose steps end where a contact begins or ceases to press, and are smaller while
/// anything presses. Through a touch-down within a step RK4 is of first order like everything else; between touch-downs
/// of fourth. Takes a tick of what stands in one_vehicle.h.
template <typename Stepped>
class ContactEvents {
 public:
  explicit ContactEvents(Stepped& stepped) : stepped_(stepped), system_(stepped.system()), b_(stepped.buffers()) {}

  void take() {
    const double T = stepped_.tickLength();
    double done = 0.0, crossing = 0.0;
    for (bool ends = false; !ends;) {
      const double left = T - done;
      const double h = nextStep(left, crossing);
      // Only what rounding leaves of a tick is left out of it.
      ends = left - h <= 1e-12 * T;
      done += h;
      if (!stepped_.accept(b_.trial, h, ends)) return;
    }
  }

 private:
  // Moments of touch-down and lift-off are found to this part of the tick. A step across is so short that the force's
  // jump in it is of no account.
  static constexpr double kLocated = 1e-6;
  // Trials per event; halving alone needs twenty.
  static constexpr int kMostTrials = 32;
  // So many trials may fail to halve the bracket before one is made to: estimates close in from one side.
  static constexpr int kPatience = 5;
  // Events that are located in one tick, for each vehicle; later ones of the same tick (a body that rattles) are
  // stepped over.
  static constexpr int kMostEvents = 12;
  // Halvings of a step in which a stage met a contact that its end did not.
  static constexpr int kMostHalvings = 5;
  // An estimate from `d` away is off by about this part of d^2 over the step, for that is how the depth bends. A trial
  // is put so far beyond it: on the side where the contact is, for only there it tells the next estimate.
  static constexpr double kBend = 0.15;

  // What a trial step met.
  struct Trial {
    bool smooth = false;  // nothing began or ceased to press on its way
    int changed = -1;     // the first contact that presses at one of its ends only, -1 without

    bool endsAsBegun() const { return changed < 0; }
  };

  // RK4 from the start over h into the trial; k[0] is the rate at the start. True: at no stage did anything begin or
  // cease to press.
  bool rk4From(double h) {
    stepped_.beginStep(h);
    bool smooth = true;
    for (int stage = 1; stage < 4; ++stage) {
      const double fraction = stage < 3 ? 0.5 : 1.0;
      system_.advance(stepped_.start(), fraction * h, b_.k[stage - 1], b_.trial);
      system_.rate(b_.trial, fraction, b_.k[stage]);
      smooth = smooth && stepped_.pressAsNoted();
      system_.toTangent(fraction * h, b_.k[stage - 1], b_.k[stage]);
    }
    system_.weightedSum(kRk4Weights, b_.k, 4, b_.sum);
    system_.advance(stepped_.start(), h, b_.sum, b_.trial);
    trial_length_ = h;
    return smooth;
  }

  Trial tryStep(double h) {
    Trial trial;
    trial.smooth = rk4From(h);
    system_.rate(b_.trial, 1.0, b_.error);
    trial.changed = stepped_.firstChanged();
    return trial;
  }

  // The last moment found before the contact begins or ceases to press, and the first one `after`. At h, the last
  // trial, it has. Where it touches, depth and speed of the depth say when that began; where it comes off, the push of
  // two moments says when it ends, and at the start its depth and speed.
  double locate(int contact, double h, double& after) {
    const double tolerance = kLocated * stepped_.tickLength();
    const bool touches = !stepped_.pressedAtStart(contact);
    const Touch& start = stepped_.touchAtStart(contact);
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
    learn(h, stepped_.touchOf(b_.trial, contact));
    int patience = kPatience;
    for (int i = 0; i < kMostTrials && high - low > tolerance; ++i) {
      const double distance = estimate - from;
      const double beyond = std::max(kBend * distance * distance / h, 0.3 * tolerance);
      // A touch-down from above until that side is closed; a lift-off from below.
      const bool above = touches ? high - estimate > tolerance : estimate - low <= tolerance;
      double at = above ? estimate + beyond : estimate - beyond;
      if (!(at > low && at < high) || patience == 0) at = 0.5 * (low + high);
      const double bracket = high - low;
      (tryStep(at).endsAsBegun() ? low : high) = at;
      patience = high - low <= 0.5 * bracket ? kPatience : patience - 1;
      learn(at, stepped_.touchOf(b_.trial, contact));
    }
    after = high;
    return low;
  }

  // Leaves the end of the next step, at most h long, in the trial and returns its length. `crossing` > 0: an event lies
  // within so many seconds and is to be stepped over; it is set for the step after this one.
  double nextStep(double h, double& crossing) {
    stepped_.beginStep(h);
    system_.rate(stepped_.start(), 0.0, b_.k[0]);
    stepped_.noteContacts();
    if (crossing > 0.0) {
      h = std::min(h, crossing);
      crossing = 0.0;
      rk4From(h);
      return h;
    }
    if (stepped_.anyPressedAtStart() || stepped_.hasJoints()) {
      const double part = stepped_.tickLength() / stepped_.contactSubsteps();
      // What would be left over of the tick is rounding.
      if (h - part > kLocated * stepped_.tickLength()) h = part;
    }
    if (rk4From(h)) return h;
    if (located_ >= kMostEvents * stepped_.vehicles()) {
      stepped_.countFloorStep();
      return h;
    }
    for (int halving = 0;; ++halving) {
      const Trial trial = tryStep(h);
      if (!trial.endsAsBegun()) {
        ++located_;
        double after = h;
        const double before = locate(trial.changed, h, after);
        h = before > 0.0 ? before : after;
        if (before > 0.0) crossing = after - before;
        break;
      }
      if (trial.smooth) break;
      if (halving == kMostHalvings) {
        stepped_.countFloorStep();
        break;
      }
      h *= 0.5;
    }
    // The last trial was that step already, as a rule.
    if (trial_length_ != h) rk4From(h);
    return h;
  }

  Stepped& stepped_;
  typename Stepped::System& system_;
  typename Stepped::Buffers& b_;
  double trial_length_ = 0.0;  // of the step that the trial ends [s]
  int located_ = 0;            // events in this tick
};

}  // namespace ellipsoid_vehicle_sim
