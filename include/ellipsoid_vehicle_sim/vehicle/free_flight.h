#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "ellipsoid_vehicle_sim/dynamics/spatial_inertia.h"
#include "ellipsoid_vehicle_sim/vehicle/sim_config.h"
#include "ellipsoid_vehicle_sim/vehicle/vehicle_model.h"
#include "ellipsoid_vehicle_sim/vehicle/vehicle_state.h"
#include "ellipsoid_vehicle_sim/world/terrain.h"

namespace ellipsoid_vehicle_sim {

/// Turning of a rigid body that nothing pushes: Euler's equations, the inertia's factors worked out once.
class FreeTurning {
 public:
  /// I: about the centre of mass, along the base's axes [kg m^2], positive definite.
  explicit FreeTurning(const Symmetric3& I);

  /// Angular acceleration in W [rad/s^2] of a body with axes R_WB that turns with w_W [rad/s].
  Vec3 acceleration(const Frame3& R_WB, const Vec3& w_W) const;

 private:
  Symmetric3 I_;
  bool principal_;  // the base's axes are the principal ones: Euler's equations as they are
  Vec3 ratio_;      // (I_y - I_z) / I_x and so on, then
  double lyx_, lzx_, lzy_, inverse_x_, inverse_y_, inverse_z_;  // I = L D L'
};

/// A tick of one rigid body that no triangle can reach in it: the configured one-step method on the base's motion alone, no
/// search, no forces. Same bits as the whole model (which does this arithmetic where nothing touches), so it is a matter of
/// time only.
class FreeFlight {
 public:
  /// Whether the vehicle and the integrator have such ticks at all.
  FreeFlight(const VehicleModel& model, const SimConfig& config, const Terrain& terrain);
  bool isPossible() const { return possible_; }

  /// Advances the motion by config.dt and returns true, or returns false and leaves it: when something touches, or the air
  /// around is not known to be free. Contact memory, treads and paths are the caller's.
  bool advance(VehicleState& state);

 private:
  bool isFree(const Motion& x, double dt);

  const SimConfig& config_;
  const Terrain& terrain_;
  bool possible_ = false;
  double reach_ = 0.0;   // from the centre of mass to the farthest point of an ellipsoid [m]
  FreeTurning turning_;
  Eigen::AlignedBox3d empty_;  // known to hold no triangle
  int patience_ = 0;           // ticks until it is worth asking again
};

}  // namespace ellipsoid_vehicle_sim
