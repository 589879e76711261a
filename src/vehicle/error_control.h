#pragma once

#include <algorithm>
#include <cmath>

#include "ellipsoid_vehicle_sim/dynamics/embedded_pair.h"

namespace ellipsoid_vehicle_sim {

/// The integrator dormand_prince: a tick of what stands in one_vehicle.h, in steps whose error is within the tolerance,
/// or that are the smallest.
template <typename Stepped>
void takeByErrorControl(Stepped& stepped) {
  // Step control [Hairer1993, II.4]: safety, and by how much a step may shrink or grow.
  constexpr double kSafety = 0.9, kShrink = 0.1, kGrow = 5.0;
  // What is left of a tick after its last step, in parts of it, is rounding.
  constexpr double kRounding = 1e-9;

  auto& buffers = stepped.buffers();
  const double T = stepped.tickLength(), floor = dormand_prince::kSmallestPart * T;
  double done = 0.0, h = T;
  while (T - done > kRounding * T) {
    h = std::min(h, T - done);
    // A rest shorter than the floor would be a step of its own for nothing.
    if (T - done - h < floor) h = T - done;
    stepped.beginStep(h);
    dormandPrinceStep(stepped.system(), stepped.start(), h, buffers.stages, buffers.sum, buffers.error, buffers.trial);
    const double error = stepped.errorOf(buffers.error, h);
    const bool finite = std::isfinite(error) && stepped.isSound(buffers.trial);
    const bool held = finite && error <= stepped.tolerance();
    const double factor = error > 0.0 ? kSafety * std::pow(stepped.tolerance() / error, 0.2) : kGrow;
    const double next = h * (finite ? std::clamp(factor, kShrink, kGrow) : kShrink);
    // A step with what would be left of the tick in it may be nearly two floors long: it cannot be cut, either.
    if (!held && h >= 2.0 * floor) {
      h = std::max(floor, std::min(next, 0.5 * h));
      continue;
    }
    if (!held) stepped.countFloorStep();
    done += h;
    if (!stepped.accept(buffers.trial, h, T - done <= kRounding * T)) return;
    h = std::max(floor, next);
  }
}

}  // namespace ellipsoid_vehicle_sim
