#pragma once

#include <Eigen/Core>
#include <vector>

#include "ellipsoid_vehicle_sim/dynamics/rigid_inertia.h"
#include "ellipsoid_vehicle_sim/dynamics/spatial_inertia.h"
#include "ellipsoid_vehicle_sim/geometry/pose.h"

namespace ellipsoid_vehicle_sim {

/// How a body moves against its parent.
enum class BodyMotion {
  kFree,       ///< the base.
  kDynamic,    ///< one coordinate that integrates.
  kPrescribed  ///< one coordinate that is a given function of time.
};

/// A body of the tree. Its frame B is the joint's frame at position zero, turned or shifted along by the coordinate;
/// the base's frame stands in its centre of mass.
struct Body {
  BodyMotion motion = BodyMotion::kFree;
  int parent = -1;
  int coordinate = -1;  ///< index among the dynamic, or among the prescribed, coordinates.
  bool prismatic = false;
  Pose X_PB;                                          ///< in the parent's frame, at coordinate zero.
  Eigen::Vector3d axis_B = Eigen::Vector3d::UnitX();  ///< unit.
  RigidInertia inertia;                               ///< in B.
  /// Mass and shape look the same from every angle of the coordinate (a wheel about its axle): the angle is then not
  /// worked out, the body's frame stays at angle zero.
  bool spin_symmetric = false;
};

/// Where a body is and how it moves, along the base's axes. Velocities are against the frame that moves along with O
/// without turning (the base's own linear part is zero there), so that they stay small and exact however fast the
/// vehicle travels.
struct BodyKinematics {
  Frame3 R_OB{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
  Vec3 p_OB{0.0, 0.0, 0.0};  ///< origin of the body's frame from O [m].
  Spatial axis;              ///< motion per unit of the coordinate's speed.
  Spatial velocity;
  Spatial bias;  ///< acceleration that the velocities alone cause; not of rotors.
};

/// Position, speed and acceleration of a prescribed coordinate at the moment of evaluation.
struct PrescribedMotion {
  double position = 0.0;
  double velocity = 0.0;
  double acceleration = 0.0;
};

/// One dynamic coordinate that follows another, q = multiplier q_leader + offset: a gear, a pair of coupled rockers. The
/// leader follows nobody.
struct CoordinateCoupling {
  int coordinate = -1;
  int leader = -1;
  double multiplier = 1.0;
  double offset = 0.0;
};

/// Forward dynamics of a floating tree by the articulated-body algorithm [Featherstone2008, ch. 7, 9.4], O(n), no
/// allocation. All is told in one frame O: at the base's centre of mass, with the base's axes as they stand at this
/// moment (an inertial frame, so that no term for its turning appears). Inertias then add without transforms, and
/// whatever the joints cannot turn against the base (a wheel carrier on its slide) has a constant orientation and
/// inertia.
///
/// A balanced wheel (leaf, its mass even about the axis it turns on) is a rotor: its spin moves no mass. Its mass and
/// its inertia across the axis are added to the parent's once and for all; what is left of it is the equation of its
/// spin and the gyroscopic moment h (w x k) of its momentum h k, w being the parent's angular velocity
/// [Featherstone2008, 9.7].
///
/// Coupled coordinates, q = G q_independent, make the tree a closed mechanism: the efforts lambda in the couplings, which do
/// no work, are those with which qdd = G qdd_independent. qdd is linear in them, so that one pass more for each coupling
/// tells their effect, and a last one has the result; without couplings nothing of this is done [Featherstone2008, ch. 8].
/// Positions and velocities are the caller's to couple.
class ArticulatedBody {
 public:
  explicit ArticulatedBody(std::vector<Body> bodies, std::vector<CoordinateCoupling> couplings = {});

  const std::vector<Body>& bodies() const { return bodies_; }

  /// Where every body is. q: dynamic coordinates; prescribed: the prescribed ones, at least as many as there are.
  void positions(const double* q, const PrescribedMotion* prescribed);
  /// How every body moves, after positions(). w_B: the base's angular velocity along its own axes [rad/s].
  void velocities(const Vec3& w_B, const double* qd, const PrescribedMotion* prescribed);
  const BodyKinematics& kinematics(int body) const { return kinematics_[body]; }
  /// No joint turns this body against the base: its R_OB never changes.
  bool isSteady(int body) const { return constants_[body].steady; }

  /// Velocity of the point of `body` at p_OX, against the frame of O; add the base's velocity for that in W [m/s].
  Vec3 pointVelocity(int body, const Vec3& p_OX) const {
    const Spatial& v = kinematics_[body].velocity;
    return v.linear + cross(v.angular, p_OX);
  }

  /// External force on a body, acting at p_OX; added up until clearForces().
  void clearForces();
  void addForce(int body, const Vec3& p_OX, const Vec3& f) {
    forces_[body].angular += cross(p_OX, f);
    forces_[body].linear += f;
  }
  /// Likewise a moment.
  void addMoment(int body, const Vec3& m) { forces_[body].angular += m; }

  /// Accelerations under the forces, joint efforts tau (one per dynamic coordinate) and gravity [m/s^2], all along the
  /// base's axes. Writes qdd; returns the base's: angular, and linear of O.
  Spatial accelerations(const double* tau, const PrescribedMotion* prescribed, const Vec3& gravity, double* qdd);
  /// Acceleration of a body at O without gravity's share, after accelerations().
  Spatial acceleration(int body) const;
  /// Effort that keeps a prescribed body on its path, after accelerations() [N m] or [N].
  double prescribedEffort(int body) const;
  /// Inertia that a dynamic body's coordinate feels with all below it free, after accelerations() [kg m^2] or [kg].
  double articulatedInertia(int body) const;

  /// v_B: velocity of O along the base's axes [m/s].
  double kineticEnergy(const Vec3& v_B) const;
  /// Linear momentum [N s], and angular momentum about O [N m s], along the base's axes; v_B as above.
  Spatial momentum(const Vec3& v_B) const;
  /// Sum of m c of all bodies relative to O, along the base's axes [kg m].
  Vec3 massMoment() const;
  double totalMass() const { return total_mass_; }

 private:
  // What is known of a body beforehand.
  struct Constants {
    Frame3 R_PB;
    Vec3 p_PB, axis_B;
    Vec3 p_Bcm;  // with the rotors it carries, like the two below
    double mass = 0.0;
    Symmetric3 I_cm_B;
    // Orientation against the base never changes: it and what follows from it stands in kinematics_ and below.
    bool steady = false;
    Vec3 p_PB_O, p_cm_O;  // p_PB and p_Bcm along the base's axes
    Symmetric3 I_cm_O;
    bool rotor = false;
    double spin_inertia = 0.0;  // of a rotor
  };
  struct Work {
    SpatialInertia I;
    Spatial bias_force;
    Spatial U;
    double D = 0.0, u = 0.0;
    Spatial acceleration;
  };

  Spatial uncoupledAccelerations(const double* tau, const PrescribedMotion* prescribed, const Vec3& gravity, double* qdd);
  Spatial coupledAccelerations(const double* tau, const PrescribedMotion* prescribed, const Vec3& gravity, double* qdd);
  double couplingGap(std::size_t coupling, const double* qdd) const;
  void addCouplingEffort(std::size_t coupling, double effort);
  void solveCouplings();
  Constants constantsOf(std::size_t body) const;
  void carryRotors();
  void settleOrientations();
  void setOwnInertia(std::size_t body);
  void releaseRotor(std::size_t body, const double* tau);
  void passToParent(std::size_t body, const double* tau, const PrescribedMotion* prescribed);

  std::vector<Body> bodies_;
  std::vector<Constants> constants_;
  std::vector<int> branches_, rotors_;  ///< bodies with an inertia of their own, base first; the others.
  std::vector<BodyKinematics> kinematics_;
  std::vector<Spatial> forces_;
  std::vector<Work> work_;
  std::vector<double> spin_acceleration_;  ///< of a rotor's coordinate, per body.
  double total_mass_ = 0.0;
  std::vector<CoordinateCoupling> couplings_;
  std::vector<double> coupled_tau_;             ///< efforts, those of the couplings included.
  std::vector<double> coupling_matrix_, gaps_;  ///< of the equations for lambda, row by row; their right side.
};

}  // namespace ellipsoid_vehicle_sim
