#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace ellipsoid_vehicle_sim {

/// How friction builds up below its cone.
enum class FrictionMode {
  kViscous,   ///< f_t = -f v_t, the seed's law: creeps on a slope.
  kAnchored,  ///< a spring and damper to the point of first touch, slipping at the cone: holds.
  kBrush  ///< the anchor also leaves through the patch of a rolling wheel: cornering stiffness, and an anchor at rest.
};

/// Constants of the contact of one ellipsoid. What it models:
///   normal   f_n = w max(0, k d + c d'), d' = -u . v: a damped spring that never pulls;
///   friction opposes the slip vector v_t inside the cone |f_t| <= mu f_n, continuous through zero:
///     viscous    f_t = -clip(f v_t),
///     anchored   z' = v_t,                 s = clip(w k_t z),      f_t = -clip(s + w c_t v_t),
///     brush      z' = v_t - a z_c,         s = clip(w k_z z),      f_t = -clip(s + w c_t z'),
///                z_c = s / (w k_z),  a = min(|v_roll| / l, 1 / tau),  k_z = k_t min(1, l / (tau |v_roll|)),
///   clip to length mu f_n. In steady rolling z' = 0 and s = k_t l v_t / |v_roll|: the cornering and slip stiffness is
///   C = k_t l at any speed; at rest a = 0 and the brush is the anchor. Its damper acts on z' (not on v_t), or it would
///   add to C in proportion to the speed.
/// d pressed depth [m], u unit normal into the vehicle, v velocity of the ellipsoid's surface at E, v_roll the part of
/// it that comes from the ellipsoid's own turning, w share of the force where contacts overlap. mu falls from static to
/// kinetic with the slip speed: mu = mu_k + (mu_s - mu_k) exp(-(|v_t| / v_s)^2) [Stribeck1902].
struct ContactLaw {
  double stiffness = 0.0;  ///< k [N/m], > 0.
  double damping = 0.0;    ///< c [N s/m], >= 0.
  FrictionMode mode = FrictionMode::kAnchored;
  double tangential_stiffness = 0.0;  ///< k_t [N/m].
  double tangential_damping = 0.0;    ///< c_t [N s/m].
  double brush_length = 0.0;          ///< l [m].
  double relaxation_time = 0.0;       ///< tau [s]: bound on a, or fast rolling would be too stiff to integrate.
  double viscous_friction = 0.0;      ///< f [N s/m].
};

/// Coulomb coefficients of a pair. Pair rule: the surface's own values where it has them, the vehicle's otherwise; at
/// most the ellipsoid's own, where it has one (a slippery ball that stands for a caster is slippery everywhere).
struct FrictionCoefficients {
  double mu_static = 0.0;
  double mu_kinetic = 0.0;
  double stribeck_speed = 1.0;  ///< v_s [m/s], > 0.

  double at(double slip_speed) const;
};

/// What a contact does, and how its memory moves on.
struct ContactForce {
  double normal = 0.0;                                      ///< f_n [N].
  Eigen::Vector3d friction_W = Eigen::Vector3d::Zero();     ///< f_t [N], perpendicular to u.
  Eigen::Vector3d anchor_rate_W = Eigen::Vector3d::Zero();  ///< z' [m/s].
  double friction_limit = 0.0;                              ///< radius of the cone: mu f_n [N].
  double stretch_limit = 0.0;                               ///< longest stretch the cone carries: mu f_n / (w k_z) [m].
  bool sliding = false;                                     ///< the friction is at the edge of its cone.
};

/// Pure: the same arguments give the same force. `anchor_W` is the stretch z [m], already perpendicular to u.
ContactForce contactForce(const ContactLaw& law, const FrictionCoefficients& mu, const Eigen::Vector3d& nhat_W,
                          double pressed, double share, const Eigen::Vector3d& v_W, const Eigen::Vector3d& v_roll_W,
                          const Eigen::Vector3d& anchor_W);

/// The same's `stretch_limit` alone.
double stretchLimit(const ContactLaw& law, const FrictionCoefficients& mu, const Eigen::Vector3d& nhat_W,
                    double pressed, double share, const Eigen::Vector3d& v_W, const Eigen::Vector3d& v_roll_W);

/// z turned by the smallest rotation that takes the unit vector `from` to `to` (not opposite).
Eigen::Vector3d turnedWithNormal(const Eigen::Vector3d& z, const Eigen::Vector3d& from, const Eigen::Vector3d& to);

}  // namespace ellipsoid_vehicle_sim
