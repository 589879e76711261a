#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "ellipsoid_vehicle_sim/contact/contact_force.h"

// How fast a vehicle turns whose wheels cannot all roll along its path: skid-steer, or fixed wheels beside the driven axle.
// Quasi-static balance of the friction under the wheels [WongChiang2001], with this simulator's own brush law
// (contact_force.h): in steady rolling a wheel with load N and rolling speed v_r that slips by v over the ground is pushed by
//
//   f = -v/|v| min(mu N, k_t l |v| / |v_r|),
//
// one that does not roll, or has no brush, by mu N against its slip.
// The body's velocity (v_x, v_y, w) is the one at which all these forces and their moments cancel. Valid at walking speed on
// level ground: no centrifugal force, loads as at rest. Friction that saturates everywhere gives Coulomb's skid steering,
// small slips the turning of a car with soft tyres; k_t and load distribution decide in between.

namespace ellipsoid_vehicle_sim {

/// A wheel on the ground as the balance sees it; x forward, y left, from any common point.
struct SkiddingWheel {
  Eigen::Vector2d p = Eigen::Vector2d::Zero();  ///< its contact [m].
  double rim_speed = 0.0;                       ///< angular speed times rolling radius, forward positive [m/s].
  bool free = false;                            ///< turns as it likes: no force along x.
  double load = 0.0;                            ///< [N].
  double mu = 0.0;                              ///< coefficient of friction [-].
  ContactLaw law;                               ///< of its tread.
};

struct PlanarVelocity {
  Eigen::Vector2d v = Eigen::Vector2d::Zero();  ///< of the point the wheels are measured from [m/s].
  double yaw_rate = 0.0;                        ///< [rad/s].
};

/// Friction on a wheel when the vehicle moves so [N].
Eigen::Vector2d forceOn(const SkiddingWheel& wheel, const PlanarVelocity& velocity);

/// The steady velocity; nullopt if the balance is not found (no wheel carries anything, or nothing holds the vehicle).
std::optional<PlanarVelocity> steadySkid(const std::vector<SkiddingWheel>& wheels);

}  // namespace ellipsoid_vehicle_sim
