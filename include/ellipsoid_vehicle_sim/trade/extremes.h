#pragma once

#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/vehicle/simulator.h"

namespace ellipsoid_vehicle_sim {

/// One cell of a map: a small scene with one quantity at an extreme, an integrator, and a tick.
struct ExtremeCell {
  std::string axis;   ///< one of extremeAxes().
  double value = 0.0; ///< in the axis' unit.
  IntegratorKind integrator = IntegratorKind::kRk4;
  double dt = 1e-3;   ///< [s].
};

/// What may come of a cell: nothing else may.
enum class ExtremeOutcome {
  kPassive,   ///< it moved, never had more energy than it began with, and its account closed, but for the integrator's bounds.
  kRefused,   ///< at load, with the reason.
  kStopped,   ///< at run time: the simulator froze at the last good state and says so.
  kReported,  ///< it went through the ground, and the events say so.
  kGained     ///< energy came from nowhere: a failure.
};

struct ExtremeResult {
  ExtremeOutcome outcome = ExtremeOutcome::kPassive;
  std::string cause;         ///< of a refusal or a stop.
  double gain = 0.0;         ///< largest energy over the start's, less one, in units of what the motion had to spend [-].
  double bound = 0.0;        ///< that the gain is held to: energyBound(), touchDownGain() and the turnGain() of its ticks.
  double unaccounted = 0.0;  ///< largest of the energy's account (EnergyBalance::error()), in the same units, with its sign [-].
  double predicted = 0.0;    ///< the step the certificate allows over the cell's [-]; 0: it has none.
};

struct ExtremeAxis {
  std::string name, unit, what;
  std::vector<double> values;
};

/// Every axis with the values of its map, from one end of what is promised to the other.
const std::vector<ExtremeAxis>& extremeAxes();

/// Energy over the start's that an integrator may show, in units of what the motion has to spend (kinetic energy at the start and
/// what it falls through), at any step that its certificate allows, beside touchDownGain() of the cell's contact and turnGain()
/// of every tick.
double energyBound(IntegratorKind integrator);

/// Rotational energy that a free body of three different axes may gain from turning by `angle` [rad] within a tick, in parts of
/// it: bounds of what was measured. Falls with the square of the angle (Euler's methods) or its fifth power (RK4).
double turnGain(IntegratorKind integrator, double angle);

/// What the account (energy and work lost, over the start) may be off by, beside turnGain(), in the same units, at steps of at most a tenth of what
/// the certificate allows; nearer to its edge a touch-down takes one or two steps, and the work in them is not resolved.
struct AccountBound {
  double gained, vanished;  ///< energy from nowhere, and energy gone nowhere: numerical damping.
};
AccountBound accountBound(IntegratorKind integrator);
constexpr double kAccountMargin = 10.0;

/// Runs a cell: thrown or set rolling, then left alone. `ticks`: how many at most.
ExtremeResult runExtreme(const ExtremeCell& cell, int ticks = 2000);

const char* toString(ExtremeOutcome outcome);

}  // namespace ellipsoid_vehicle_sim
