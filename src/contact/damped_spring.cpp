#include "ellipsoid_vehicle_sim/contact/damped_spring.h"

#include <algorithm>
#include <cmath>

namespace ellipsoid_vehicle_sim {

BounceTime bounceOfDampedSpring(double damping_ratio) {
  const double zeta = damping_ratio;
  double t;
  // Near zeta = 1 both other forms divide zero by zero; the limit is good to 1e-6 there.
  if (std::abs(zeta - 1.0) < 1e-7) {
    t = 2.0;
  } else if (zeta < 1.0) {
    const double omega = std::sqrt(1.0 - zeta * zeta);
    t = (M_PI - std::atan2(2.0 * zeta * omega, omega * omega - zeta * zeta)) / omega;
  } else {
    const double omega = std::sqrt(zeta * zeta - 1.0);
    t = std::log((zeta + omega) / (zeta - omega)) / omega;
  }
  return {t, std::exp(-zeta * t)};
}

double dampingRatioForRestitution(double restitution) {
  // e falls monotonically from 1 at zeta = 0; 1e6 stands for "does not rebound" (e = 1e-12).
  const double e = std::clamp(restitution, 1e-12, 1.0);
  if (e == 1.0) return 0.0;
  double low = 0.0, high = 1.0;
  while (high < 1e6 && bounceOfDampedSpring(high).restitution > e) high *= 2.0;
  for (int i = 0; i < 200 && high - low > 1e-15 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (bounceOfDampedSpring(middle).restitution > e ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace ellipsoid_vehicle_sim
