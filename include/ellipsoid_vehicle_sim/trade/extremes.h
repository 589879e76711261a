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
  kPassive,   ///< it moved, and never had more energy than it began with, but for the integrator's bound.
  kRefused,   ///< at load, with the reason.
  kStopped,   ///< at run time: the simulator froze at the last good state and says so.
  kReported,  ///< it went through the ground, and the events say so.
  kGained     ///< energy came from nowhere: a failure.
};

struct ExtremeResult {
  ExtremeOutcome outcome = ExtremeOutcome::kPassive;
  std::string cause;         ///< of a refusal or a stop.
  double gain = 0.0;         ///< largest energy over the start's, less one, in units of what the motion had to spend [-].
  double predicted = 0.0;    ///< the step the certificate allows over the cell's [-]; 0: it has none.
};

struct ExtremeAxis {
  std::string name, unit, what;
  std::vector<double> values;
};

/// Every axis with the values of its map, from one end of what is promised to the other.
const std::vector<ExtremeAxis>& extremeAxes();

/// Energy that an integrator may add, in units of what the motion has to spend: kinetic energy at the start and what it
/// falls through. Of the first-order methods and RK4 it is what a touch-down within a step makes at the edge of their
/// certificate; of linearly_implicit and dormand_prince it is what a
/// turn of a radian within the smallest step makes.
double energyBound(IntegratorKind integrator);

/// Runs a cell: thrown or set rolling, then left alone. `ticks`: how many at most.
ExtremeResult runExtreme(const ExtremeCell& cell, int ticks = 2000);

const char* toString(ExtremeOutcome outcome);

}  // namespace ellipsoid_vehicle_sim
