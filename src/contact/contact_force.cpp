#include "ellipsoid_vehicle_sim/contact/contact_force.h"

#include <algorithm>
#include <cmath>

#include "ellipsoid_vehicle_sim/geometry/small_vector.h"

namespace ellipsoid_vehicle_sim {
namespace {

// The vector cut to a length; `cut` tells whether it was.
Vec3 clipped(const Vec3& vector, double length, bool& cut) {
  const double squared = squaredNorm(vector);
  cut = squared > length * length;
  return cut ? (length / std::sqrt(squared)) * vector : vector;
}

}  // namespace

double FrictionCoefficients::at(double slip_speed) const {
  if (mu_static == mu_kinetic) return mu_kinetic;
  const double ratio = slip_speed / stribeck_speed;
  return mu_kinetic + (mu_static - mu_kinetic) * std::exp(-ratio * ratio);
}

namespace {

// What the spring and damper push with, and the slip over which friction acts.
struct Normal {
  double force;  // f_n [N]; the damper may lower the push to nothing, never pull.
  Vec3 v_t;      // [m/s].
  double limit;  // mu f_n [N].
};

Normal normalOf(const ContactLaw& law, const FrictionCoefficients& mu, const Vec3& u, double pressed, double share,
                const Vec3& v) {
  const double v_n = dot(u, v);
  Normal normal;
  normal.force = share * std::max(0.0, law.stiffness * pressed - law.damping * v_n);
  normal.v_t = v - v_n * u;
  normal.limit =
      (mu.mu_static == mu.mu_kinetic ? mu.mu_kinetic : mu.at(norm(normal.v_t))) * normal.force;
  return normal;
}

// How the stretch of a contact resists and fades.
struct Stretch {
  double stiffness;  // w k_z [N/m].
  double leaving;    // a [1/s].
};

Stretch stretchOf(const ContactLaw& law, const Vec3& u, double share, const Vec3& v_roll) {
  Stretch stretch{share * law.tangential_stiffness, 0.0};
  if (law.mode != FrictionMode::kBrush) return stretch;
  const double rolling = norm(v_roll - dot(u, v_roll) * u);
  const double knee = law.brush_length / law.relaxation_time;
  stretch.leaving = std::min(rolling, knee) / law.brush_length;
  if (rolling > knee) stretch.stiffness *= knee / rolling;
  return stretch;
}

}  // namespace

ContactForce contactForce(const ContactLaw& law, const FrictionCoefficients& mu, const Eigen::Vector3d& nhat_W,
                          double pressed, double share, const Eigen::Vector3d& v_W, const Eigen::Vector3d& v_roll_W,
                          const Eigen::Vector3d& anchor_W) {
  ContactForce force;
  if (pressed <= 0.0 || share <= 0.0) return force;

  const Vec3 u = Vec3::from(nhat_W);
  const Normal normal = normalOf(law, mu, u, pressed, share, Vec3::from(v_W));
  const Vec3& v_t = normal.v_t;
  const double limit = normal.limit;
  force.normal = normal.force;
  force.friction_limit = limit;

  if (law.mode == FrictionMode::kViscous) {
    force.friction_W = (-clipped(law.viscous_friction * v_t, limit, force.sliding)).toEigen();
    return force;
  }

  const Stretch stretch = stretchOf(law, u, share, Vec3::from(v_roll_W));
  bool stretched = false;
  const Vec3 spring = clipped(stretch.stiffness * Vec3::from(anchor_W), limit, stretched);
  const Vec3 anchor_rate = stretch.leaving > 0.0 ? v_t - (stretch.leaving / stretch.stiffness) * spring : v_t;
  // In a brush the damper acts between the bristles' tips and their roots.
  const Vec3 damped = law.mode == FrictionMode::kBrush ? anchor_rate : v_t;
  force.friction_W = (-clipped(spring + (share * law.tangential_damping) * damped, limit, force.sliding)).toEigen();
  force.anchor_rate_W = anchor_rate.toEigen();
  force.sliding = force.sliding || stretched;
  force.stretch_limit = limit / stretch.stiffness;
  return force;
}

double stretchLimit(const ContactLaw& law, const FrictionCoefficients& mu, const Eigen::Vector3d& nhat_W,
                    double pressed, double share, const Eigen::Vector3d& v_W, const Eigen::Vector3d& v_roll_W) {
  if (pressed <= 0.0 || share <= 0.0 || law.mode == FrictionMode::kViscous) return 0.0;
  const Vec3 u = Vec3::from(nhat_W);
  return normalOf(law, mu, u, pressed, share, Vec3::from(v_W)).limit /
         stretchOf(law, u, share, Vec3::from(v_roll_W)).stiffness;
}

Eigen::Vector3d turnedWithNormal(const Eigen::Vector3d& z_W, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  // Rodrigues with sin and cos from the vectors: v = from x to, c = from . to; exact where both coincide.
  const Vec3 z = Vec3::from(z_W), a = Vec3::from(from), b = Vec3::from(to);
  const Vec3 v = cross(a, b), vz = cross(v, z);
  return (z + vz + (1.0 / (1.0 + dot(a, b))) * cross(v, vz)).toEigen();
}

}  // namespace ellipsoid_vehicle_sim
