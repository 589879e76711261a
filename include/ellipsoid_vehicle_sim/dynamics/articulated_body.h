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

/// A body of the tree. Its frame B is the joint's frame at position zero, turned or shifted along by the coordinate; the
/// base's frame stands in its centre of mass.
struct Body {
  BodyMotion motion = BodyMotion::kFree;
  int parent = -1;
  int coordinate = -1;                                 ///< index among the dynamic, or among the prescribed, coordinates.
  bool prismatic = false;
  Pose X_PB;                                           ///< in the parent's frame, at coordinate zero.
  Eigen::Vector3d axis_B = Eigen::Vector3d::UnitX();   ///< unit.
  RigidInertia inertia;                                ///< in B.
  /// Mass and shape look the same from every angle of the coordinate (a wheel about its axle): the angle is then not worked
  /// out, the body's frame stays at angle zero.
  bool spin_symmetric = false;
};

/// Positions and velocities of all bodies. All velocities are against the frame that moves along with O without turning
/// (the base's own linear part is zero there), so that they stay small and exact however fast the vehicle travels.
struct BodyKinematics {
  Eigen::Matrix3d R_WB;
  Eigen::Vector3d p_OB;      ///< origin of the body's frame from O, in W [m].
  Spatial axis;              ///< motion per unit of the coordinate's speed.
  Spatial velocity;
  Spatial bias;              ///< acceleration that the velocities alone cause.
};

/// Position, speed and acceleration of a prescribed coordinate at the moment of evaluation.
struct PrescribedMotion {
  double position = 0.0;
  double velocity = 0.0;
  double acceleration = 0.0;
};

/// Forward dynamics of a floating tree by the articulated-body algorithm [Featherstone2008, ch. 7, 9.4], all in one frame
/// (axes of W, origin O at the base's centre of mass), so that inertias add up without transforms. O(n), no allocation.
class ArticulatedBody {
 public:
  explicit ArticulatedBody(std::vector<Body> bodies);

  const std::vector<Body>& bodies() const { return bodies_; }

  /// Where every body is. q: dynamic coordinates; prescribed: the prescribed ones, at least as many as there are.
  void positions(const Eigen::Quaterniond& q_WB, const double* q, const PrescribedMotion* prescribed);
  /// How every body moves, after positions().
  void velocities(const Eigen::Vector3d& w_WB, const double* qd, const PrescribedMotion* prescribed);
  const BodyKinematics& kinematics(int body) const { return kinematics_[body]; }

  /// Velocity of the point of `body` at p_OX, against the frame of O; add the base's velocity for that in W [m/s].
  Eigen::Vector3d pointVelocity(int body, const Eigen::Vector3d& p_OX) const {
    const Spatial& v = kinematics_[body].velocity;
    return v.linear + v.angular.cross(p_OX);
  }

  /// External force on a body, acting at p_OX; added up until clearForces().
  void clearForces();
  void addForce(int body, const Eigen::Vector3d& p_OX, const Eigen::Vector3d& f_W) {
    forces_[body].angular += p_OX.cross(f_W);
    forces_[body].linear += f_W;
  }

  /// Accelerations under the forces, joint efforts tau (one per dynamic coordinate) and gravity [m/s^2]. Writes qdd; returns
  /// the base's: angular, and linear of O, in W.
  Spatial accelerations(const double* tau, const PrescribedMotion* prescribed, const Eigen::Vector3d& gravity_W,
                        double* qdd);
  /// Acceleration of a body at O without gravity's share, after accelerations().
  const Spatial& acceleration(int body) const { return work_[body].acceleration; }
  /// Effort that keeps a prescribed body on its path, after accelerations() [N m] or [N].
  double prescribedEffort(int body) const;
  /// Inertia that a dynamic body's coordinate feels with all below it free, after accelerations() [kg m^2] or [kg].
  double articulatedInertia(int body) const { return work_[body].D; }

  double kineticEnergy(const Eigen::Vector3d& v_WB) const;
  /// Sum of m z of all bodies relative to O: potential energy is gravity times it [kg m].
  Eigen::Vector3d massMoment() const;
  double totalMass() const { return total_mass_; }

 private:
  struct Work {
    SpatialInertia I;
    Spatial bias_force;
    Spatial U;
    double D = 0.0, u = 0.0;
    Spatial acceleration;
  };

  // What is known of a body beforehand and saves work in every evaluation.
  struct Shortcut {
    Eigen::Matrix3d R_PB;
    bool aligned = false;    // R_PB is exactly the identity.
    // Inertia the same about every axis square to the body's own: I = across 1 + (along - across) k k'.
    bool axial = false;
    double across = 0.0, along = 0.0;
    // It also turns about that axis, with its centre of mass on it: the turn moves no mass, its inertia is `along`.
    bool balanced = false;
  };
  static Shortcut shortcutOf(const Body& body);

  std::vector<Body> bodies_;
  std::vector<Shortcut> shortcuts_;
  std::vector<BodyKinematics> kinematics_;
  std::vector<Spatial> forces_;
  std::vector<Work> work_;
  double total_mass_ = 0.0;
};

}  // namespace ellipsoid_vehicle_sim
