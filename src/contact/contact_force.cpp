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

ContactForce contactForce(const ContactLaw& law, const FrictionCoefficients& mu, const Eigen::Vector3d& nhat_W,
                          double pressed, double share, const Eigen::Vector3d& v_W, const Eigen::Vector3d& v_roll_W,
                          const Eigen::Vector3d& anchor_W) {
  ContactForce force;
  if (pressed <= 0.0 || share <= 0.0) return force;

  const Vec3 u = Vec3::from(nhat_W), v = Vec3::from(v_W);

  // Spring and damper; the damper may lower the push to nothing, never pull.
  const double v_n = dot(u, v);
  force.normal = share * std::max(0.0, law.stiffness * pressed - law.damping * v_n);

  const Vec3 v_t = v - v_n * u;
  const double limit = (mu.mu_static == mu.mu_kinetic ? mu.mu_kinetic : mu.at(norm(v_t))) * force.normal;
  force.friction_limit = limit;

  if (law.mode == FrictionMode::kViscous) {
    force.friction_W = (-clipped(law.viscous_friction * v_t, limit, force.sliding)).toEigen();
    return force;
  }

  double k_z = share * law.tangential_stiffness;
  double leaving = 0.0;
  if (law.mode == FrictionMode::kBrush) {
    const Vec3 v_roll = Vec3::from(v_roll_W);
    const double rolling = norm(v_roll - dot(u, v_roll) * u);
    const double knee = law.brush_length / law.relaxation_time;
    leaving = std::min(rolling, knee) / law.brush_length;
    if (rolling > knee) k_z *= knee / rolling;
  }
  bool stretched = false;
  const Vec3 spring = clipped(k_z * Vec3::from(anchor_W), limit, stretched);
  const Vec3 anchor_rate = leaving > 0.0 ? v_t - (leaving / k_z) * spring : v_t;
  // In a brush the damper acts between the bristles' tips and their roots.
  const Vec3 damped = law.mode == FrictionMode::kBrush ? anchor_rate : v_t;
  force.friction_W = (-clipped(spring + (share * law.tangential_damping) * damped, limit, force.sliding)).toEigen();
  force.anchor_rate_W = anchor_rate.toEigen();
  force.sliding = force.sliding || stretched;
  force.stretch_limit = limit / k_z;
  return force;
}

Eigen::Vector3d turnedWithNormal(const Eigen::Vector3d& z_W, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  // Rodrigues with sin and cos from the vectors: v = from x to, c = from . to; exact where both coincide.
  const Vec3 z = Vec3::from(z_W), a = Vec3::from(from), b = Vec3::from(to);
  const Vec3 v = cross(a, b), vz = cross(v, z);
  return (z + vz + (1.0 / (1.0 + dot(a, b))) * cross(v, vz)).toEigen();
}

}  // namespace ellipsoid_vehicle_sim
