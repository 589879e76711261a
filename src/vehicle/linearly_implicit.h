#pragma once

#include <algorithm>
#include <cmath>

#include "ellipsoid_vehicle_sim/dynamics/dense_solve.h"

namespace ellipsoid_vehicle_sim {

/// The integrator linearly_implicit: backward Euler by one step of Newton's method from the motion as it goes on
/// [HairerWanner1996, IV.9], on the speeds alone: positions and stretches follow them. Written out, with v the speeds,
/// p all that is position-like, p' = r(p, v), v' = a(p, v):
///   p* = p + h r(p, v),   (1 - h (da/dv + h da/dp dr/dv)) D = h a(p*, v),   v1 = v + D,   p1 = p + h r(v1).
/// Where that is not yet an end (a contact which p* did not meet, a law at its limit), Newton's method goes on from
/// there; where it does not find one, the step is halved. The derivatives are differences along what a unit of each
/// speed does within the step, one evaluation for each. Takes a tick of what stands in one_vehicle.h.
template <typename Stepped>
class LinearlyImplicit {
 public:
  explicit LinearlyImplicit(Stepped& stepped) : stepped_(stepped), system_(stepped.system()), b_(stepped.buffers()) {}

  void take() {
    const double T = stepped_.tickLength();
    double done = 0.0, h = T;
    while (T - done > kRounding * T) {
      h = std::min(h, T - done);
      const bool found = step(h);
      if (!found && h > kSmallestPart * T) {
        h *= 0.5;
        continue;
      }
      if (!found) stepped_.countFloorStep();
      done += h;
      if (!stepped_.accept(b_.trial, h, T - done <= kRounding * T)) return;
      h *= 2.0;
    }
  }

 private:
  // Differences move positions by this [m, rad]: small against every sag, large against rounding.
  static constexpr double kMoved = 1e-7;
  // And speeds by at least and at most so much [m/s, rad/s].
  static constexpr double kLeastSpeed = 1e-6, kMostSpeed = 1e-3;
  // Newton's steps, where laws reach their limits within the step: the ground, the edge of a cone, a brake that slips.
  static constexpr int kMostIterations = 6;
  // The end is found where what is left is less than this part of what happened [-].
  static constexpr double kResidual = 0.02;
  // Where that fails the step is halved, down to this part of the tick.
  static constexpr double kSmallestPart = 1.0 / 64.0;
  // What is left of a tick after its last step, in parts of it, is rounding.
  static constexpr double kRounding = 1e-9;

  // One step of h from the start into the trial; false: Newton's method did not find its end.
  bool step(double h) {
    stepped_.beginStep(h);
    system_.rate(stepped_.start(), 0.0, b_.k[0]);
    // What a unit of each speed moves: the contacts are those of the start.
    const double delta = std::clamp(kMoved / h, kLeastSpeed, kMostSpeed);
    stepped_.findDirections(h, delta);

    // First guess: the motion goes on by itself, the speeds unchanged.
    b_.trial = stepped_.start();
    system_.advancePositions(b_.trial, h, b_.k[0]);
    for (int iteration = 1;; ++iteration) {
      const bool solved = improve(h, delta);
      system_.positionRates(b_.trial, b_.k[1]);
      system_.advancePositions(b_.trial, h, b_.k[1]);
      if (!solved) return false;
      system_.rate(b_.trial, 1.0, b_.k[1]);
      stepped_.keepWork(h);
      if (stepped_.residual(h) <= kResidual) return true;
      if (iteration == kMostIterations) return false;
    }
  }

  // One step of Newton's method for the speeds; the trial is left with these at the start's positions.
  bool improve(double h, double delta) {
    DenseSystem& matrix = stepped_.matrix();
    const int n = matrix.size();
    stepped_.beginColumns();
    for (int j = 0; j < n; ++j) stepped_.findColumn(j, h * delta);
    system_.rate(b_.trial, 1.0, b_.k[1]);
    for (int i = 0; i < n; ++i) {
      const double rate = stepped_.speed(b_.k[1], i);
      for (int j = 0; j < n; ++j) {
        const double slope = (matrix.at(i, j) - rate) / delta;
        matrix.at(i, j) = (i == j ? 1.0 : 0.0) - h * slope;
      }
      matrix.right(i) = h * rate - (stepped_.speed(b_.trial, i) - stepped_.speed(stepped_.start(), i));
    }
    // No matrix that belongs to a motion is singular: what led here is not finite, and shows in the state.
    const bool solved = matrix.solve();
    for (int i = 0; i < n; ++i) {
      const double gained = stepped_.speed(b_.trial, i) - stepped_.speed(stepped_.start(), i);
      stepped_.speed(b_.sum, i) = solved ? gained + matrix.solution(i) : h * stepped_.speed(b_.k[1], i);
    }
    b_.trial = stepped_.start();
    system_.advanceVelocities(b_.trial, 1.0, b_.sum);
    return solved;
  }

  Stepped& stepped_;
  typename Stepped::System& system_;
  typename Stepped::Buffers& b_;
};

}  // namespace ellipsoid_vehicle_sim
