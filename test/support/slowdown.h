#pragma once

#include <cstdlib>

namespace ellipsoid_vehicle_sim {

/// How much longer than usual everything may take: the environment variable ELLIPSOID_VEHICLE_SIM_SLOWDOWN, which
/// scripts/test --sanitize sets; 1 without. For deadlines only: what is simulated does not depend on it.
inline double slowdown() {
  const char* text = std::getenv("ELLIPSOID_VEHICLE_SIM_SLOWDOWN");
  const double factor = text ? std::atof(text) : 1.0;
  return factor >= 1.0 ? factor : 1.0;
}

/// How much more memory than usual is taken: sanitizers keep shadows of it, and what was freed for a while.
inline double memoryFactor() { return slowdown() > 1.0 ? 6.0 : 1.0; }

}  // namespace ellipsoid_vehicle_sim
