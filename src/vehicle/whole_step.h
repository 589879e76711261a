#pragma once

#include "ellipsoid_vehicle_sim/dynamics/integrator.h"
#include "ellipsoid_vehicle_sim/vehicle/sim_config.h"

namespace ellipsoid_vehicle_sim {

/// A step of h seconds from and into x by one of the methods that take a tick as a whole: explicit_euler,
/// semi_implicit_euler or rk4. The step has begun.
template <typename System>
void wholeStep(System& system, IntegratorKind kind, typename System::State& x, double h, typename System::Rate (&k)[4],
               typename System::State& scratch) {
  switch (kind) {
    case IntegratorKind::kExplicitEuler: explicitEulerStep(system, x, h, k, scratch); break;
    case IntegratorKind::kSemiImplicitEuler: semiImplicitEulerStep(system, x, h, k, scratch); break;
    default: rk4Step(system, x, h, k, scratch); break;
  }
}

}  // namespace ellipsoid_vehicle_sim
