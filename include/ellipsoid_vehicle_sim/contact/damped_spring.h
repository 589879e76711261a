#pragma once

namespace ellipsoid_vehicle_sim {

/// The touch of a mass on a damped spring that cannot pull, f = max(0, k d + c d'), without gravity: how long it lasts
/// and how much speed it gives back. Source: notation.h [BounceClosedForm].
struct BounceTime {
  double contact_time;  ///< omega_0 t_c [-], from touch to release.
  double restitution;   ///< e = exp(-zeta omega_0 t_c) [-].
};

/// Closed form for the damping ratio zeta >= 0.
BounceTime bounceOfDampedSpring(double damping_ratio);

/// Damping ratio whose bounce gives back the fraction `restitution` of the speed, 0 < restitution <= 1 (clamped to
/// that).
double dampingRatioForRestitution(double restitution);

}  // namespace ellipsoid_vehicle_sim
