#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/contact/contact_force.h"
#include "ellipsoid_vehicle_sim/dynamics/articulated_body.h"
#include "ellipsoid_vehicle_sim/geometry/pose.h"
#include "ellipsoid_vehicle_sim/geometry/problem.h"
#include "ellipsoid_vehicle_sim/vehicle/sim_config.h"
#include "ellipsoid_vehicle_sim/vehicle/vehicle_description.h"

namespace ellipsoid_vehicle_sim {

/// An ellipsoid of the compiled vehicle.
struct ModelEllipsoid {
  std::string name, link;
  int body = 0;
  Pose X_BE;
  Eigen::Matrix3d R_BE = Eigen::Matrix3d::Identity();  ///< of X_BE, at hand.
  Eigen::Vector3d radii = Eigen::Vector3d::Ones();
  ContactLaw law;
  double normal_mass = 0.0;      ///< smallest mass that a push on it feels, joints free [kg].
  double tangential_mass = 0.0;  ///< likewise along the surface [kg].
  int tread = -1;  ///< index of the tread that runs about it, -1 without.
  double mu = std::numeric_limits<double>::infinity();  ///< of its own [-]: the pair's is at most this.
  std::optional<double> file_stiffness, file_damping;   ///< what its file says of its contact [N/m, N s/m].
};

/// An elasto-plastic hold in a joint: spring and damper up to a limit, beyond which it slips. Brakes and dry friction.
struct JointHold {
  double stiffness = 0.0;  ///< [N m/rad] or [N/m].
  double damping = 0.0;    ///< [N m s/rad] or [N s/m].
};

/// A joint whose coordinate integrates.
struct DynamicJoint {
  int description = -1;          ///< index into VehicleDescription::joints.
  int body = -1;
  JointRole role = JointRole::kPassive;
  double damping = 0.0;          ///< viscous.
  double friction = 0.0;         ///< dry.
  double stiffness = 0.0;        ///< spring about `reference`.
  double reference = 0.0;
  double rest = 0.0;             ///< where it stands on flat ground, about: start of a set-down.
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  double stop_stiffness = 0.0;   ///< damped springs beyond the limits.
  double stop_damping = 0.0;
  JointHold hold;
  double reflected_inertia = 0.0; ///< what the coordinate feels with all else free [kg m^2] or [kg].
};

/// A joint on a given path: steering, lift. `body` is -1 where only an axle turns (solid compound).
struct PrescribedJoint {
  int description = -1;
  int body = -1;
  double lower = 0.0, upper = 0.0;
  double max_speed = 1.0;         ///< [rad/s] or [m/s].
  double max_acceleration = 1.0;  ///< [rad/s^2] or [m/s^2].
  double effort_limit = std::numeric_limits<double>::infinity();
  int leader = -1;                ///< the prescribed joint it mimics, -1 for none: position = multiplier leader's + offset.
  double multiplier = 1.0, offset = 0.0;
};

/// The running surface of a wheel ellipsoid that does not turn itself: a solid compound's wheel. Its spin has no mass.
struct Tread {
  int description = -1;           ///< of the wheel joint.
  Eigen::Vector3d axle_B = Eigen::Vector3d::UnitY();  ///< unit, in the base, steering straight.
  int steer = -1;                 ///< index of the prescribed joint that turns the axle, -1 for none.
  Eigen::Vector3d steer_axis_B = Eigen::Vector3d::UnitZ();
};

/// A wheel as the drive sees it. Points with all joints at zero, in F: the root link's frame turned about z to look forward.
struct WheelUnit {
  std::string name;
  int unit = -1;                 ///< its own index.
  int ellipsoid = -1;
  int joint = -1;                ///< index into dynamic_joints, -1 for a tread.
  int tread = -1;
  Eigen::Vector3d p_FW = Eigen::Vector3d::Zero();  ///< its centre [m].
  double radius = 0.0;           ///< rolling radius [m].
  double forward_sign = 1.0;     ///< sign of the joint's speed when the vehicle rolls forward.
  bool driven = false;
  bool braked = false;
  int steer = -1;                ///< index into `steers`, -1 for none.
  double max_torque = 0.0;       ///< of the motor [N m].
  double brake_torque = 0.0;     ///< [N m].
};

/// A steering joint as the drive sees it.
struct SteerUnit {
  int prescribed = -1;
  Eigen::Vector3d p_FS = Eigen::Vector3d::Zero();  ///< a point of its axis [m].
  double sign = 1.0;             ///< of the joint angle when it steers to the left.
  double lower = 0.0, upper = 0.0;  ///< of the steering angle (left positive) [rad].
};

/// The drive train's constants.
struct DriveModel {
  DriveLayout layout = DriveLayout::kNone;
  Differential differential = Differential::kOpen;
  std::vector<WheelUnit> wheels;
  std::vector<SteerUnit> steers;
  double reference_x = 0.0;        ///< where the commanded speed is meant, ahead of the root link [m].
  double wheelbase = 0.0;          ///< steered to unsteered axle [m], 0 without steering.
  double max_curvature_left = 0.0, max_curvature_right = 0.0;  ///< that the steering limits allow [1/m].
  double speed_gain = 0.0;         ///< of a wheel's speed servo [N m s/rad].
  double integral_gain = 0.0;      ///< [N m/rad].
  double lock_gain = 0.0;          ///< coupling of a locked differential [N m s/rad].
};

/// The compiled vehicle: minimal coordinates, constants of every law. Never changes after load.
struct VehicleModel {
  VehicleDescription description;
  std::vector<Body> bodies;
  Pose X_BR;                                   ///< root link in the base's frame (origin at the base's centre of mass).
  std::vector<ModelEllipsoid> ellipsoids;
  std::vector<DynamicJoint> dynamic_joints;
  std::vector<PrescribedJoint> prescribed_joints;
  std::vector<CoordinateCoupling> couplings;   ///< of dynamic joints that mimic others.
  std::vector<Tread> treads;
  DriveModel drive;
  double mass = 0.0;                           ///< total [kg].
  std::vector<double> stoppable_speed;         ///< per ellipsoid, head-on with the whole mass behind it [m/s].
  std::vector<std::string> report;             ///< what was derived and assumed, a line each.
};

/// Compiles a description: fixed and locked joints merged, roles turned into coordinates, every constant derived.
Loaded<VehicleModel> compileVehicle(const VehicleDescription& description, const SimConfig& config);

}  // namespace ellipsoid_vehicle_sim
