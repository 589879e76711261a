#include "ellipsoid_vehicle_sim/contact/contact_force.h"

#include <algorithm>
#include <cmath>

namespace ellipsoid_vehicle_sim {
namespace {

// The vector cut to a length; `cut` tells whether it was.
Eigen::Vector3d clipped(const Eigen::Vector3d& vector, double length, bool& cut) {
  const double squared = vector.squaredNorm();
  cut = squared > length * length;
  return cut ? Eigen::Vector3d(vector * (length / std::sqrt(squared))) : vector;
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

  // Spring and damper; the damper may lower the push to nothing, never pull.
  const double v_n = nhat_W.dot(v_W);
  force.normal = share * std::max(0.0, law.stiffness * pressed - law.damping * v_n);

  const Eigen::Vector3d v_t = v_W - v_n * nhat_W;
  const double limit = (mu.mu_static == mu.mu_kinetic ? mu.mu_kinetic : mu.at(v_t.norm())) * force.normal;

  if (law.mode == FrictionMode::kViscous) {
    force.friction_W = -clipped(law.viscous_friction * v_t, limit, force.sliding);
    return force;
  }

  double k_z = share * law.tangential_stiffness;
  double leaving = 0.0;
  if (law.mode == FrictionMode::kBrush) {
    const double rolling = (v_roll_W - nhat_W.dot(v_roll_W) * nhat_W).norm();
    const double knee = law.brush_length / law.relaxation_time;
    leaving = std::min(rolling, knee) / law.brush_length;
    if (rolling > knee) k_z *= knee / rolling;
  }
  bool stretched = false;
  const Eigen::Vector3d spring = clipped(k_z * anchor_W, limit, stretched);
  force.anchor_rate_W = v_t;
  if (leaving > 0.0) force.anchor_rate_W -= (leaving / k_z) * spring;
  // In a brush the damper acts between the bristles' tips and their roots.
  const Eigen::Vector3d damped = law.mode == FrictionMode::kBrush ? force.anchor_rate_W : v_t;
  force.friction_W = -clipped(spring + share * law.tangential_damping * damped, limit, force.sliding);
  force.sliding = force.sliding || stretched;
  force.stretch_limit = limit / k_z;
  return force;
}

Eigen::Vector3d turnedWithNormal(const Eigen::Vector3d& z, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  // Rodrigues with sin and cos from the vectors: v = from x to, c = from . to; exact where both coincide.
  const Eigen::Vector3d v = from.cross(to);
  const double c = from.dot(to);
  return z + v.cross(z) + v.cross(v.cross(z)) / (1.0 + c);
}

}  // namespace ellipsoid_vehicle_sim
