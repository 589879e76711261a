#pragma once

#include <array>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/vehicle/sim_config.h"
#include "ellipsoid_vehicle_sim/vehicle/vehicle_dynamics.h"
#include "ellipsoid_vehicle_sim/vehicle/vehicle_state.h"

namespace ellipsoid_vehicle_sim {

/// One mode of the loaded vehicle at rest.
struct StabilityMode {
  std::string name;            ///< the force that does most of the work in it, and the coordinate that moves most.
  double frequency = 0.0;      ///< |lambda| [rad/s].
  double damping_ratio = 0.0;  ///< -Re(lambda) / |lambda| [-].
  bool braked = true;          ///< brakes on; false: driving.
  /// That each integrator holds of it, were it alone [s], by IntegratorKind. Over the step in use: the mode's margin.
  std::array<double, kIntegratorCount> largest_step{};
};

/// Which step each integrator can hold for a vehicle at loaded rest, from the rate function's linearisation there.
struct StabilityCertificate {
  bool from_rest_pose = false;  ///< false: the vehicle does not stand by itself; the bounds come from its contacts alone.
  std::vector<StabilityMode> modes;                       ///< fastest first.
  std::array<double, kIntegratorCount> largest_step{};    ///< [s], by IntegratorKind; 0: no step holds.
  std::array<std::string, kIntegratorCount> worst;        ///< what bounds it, in words.

  double largestStep(IntegratorKind kind) const { return largest_step[static_cast<int>(kind)]; }
};

const char* toString(IntegratorKind kind);

/// Largest h = omega dt with which an integrator holds x'' = -omega^2 x - 2 zeta omega x' (semi-implicit Euler with the
/// damping from the old velocity). Closed forms, the Runge-Kutta methods from their stability polynomials; infinite for
/// linearly_implicit. `substeps`: those of rk4_events. Source: notation.h [OscillatorLimits].
double oscillatorLimit(IntegratorKind kind, double damping_ratio, double substeps = 1.0);

/// Linearises the rate function at `rest` (brakes on, and driving) by central differences, and bounds the steps by the
/// spectral radius of each integrator's one-step map. Modes slower than 2 rad/s (rolling, drifting) are left out.
StabilityCertificate certify(const VehicleModel& model, VehicleDynamics& dynamics, const VehicleState& rest,
                             double substeps = 1.0);

/// The fastest distinct modes in words, a line each: name, frequency, damping ratio, margin at the step `dt` of `kind`,
/// and the step that each integrator holds.
std::vector<std::string> describeModes(const StabilityCertificate& certificate, double dt, IntegratorKind kind,
                                       std::size_t most);

/// The bound when there is no rest pose: each ellipsoid's contact as an oscillator of its own.
StabilityCertificate certifyContactsAlone(const VehicleModel& model, double substeps = 1.0);

}  // namespace ellipsoid_vehicle_sim
