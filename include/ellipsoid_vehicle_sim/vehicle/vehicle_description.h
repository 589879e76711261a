#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/geometry/pose.h"

namespace ellipsoid_vehicle_sim {

/// A collision ellipsoid fixed in a link.
struct EllipsoidDescription {
  std::string name;         ///< unique in the vehicle, e.g. "front_left_wheel" or "base_link/1".
  Pose X_LE;                ///< its centre and axes in the link frame.
  Eigen::Vector3d radii;    ///< semi-axes [m], > 0.
  std::string source;       ///< what it was made from and where, e.g. "cylinder r=0.1651 l=0.1143 (husky.urdf:88)".
  double fit_error = 0.0;   ///< largest distance between its surface, or its compound's, and the shape it stands for [m].
  std::optional<double> mu;         ///< of its own, where the file has one [-]: no pair grips better than this.
  std::optional<double> stiffness;  ///< of its contact, where the file has one (kp) [N/m].
  std::optional<double> damping;    ///< likewise (kd) [N s/m].
};

/// A rigid link as the file describes it.
struct LinkDescription {
  std::string name;
  int line = 0;                                          ///< in the file, 0 if unknown.
  int inertial_line = 0;                                 ///< of its <inertial>, 0 without.
  std::string inertia_fault;                             ///< why no body has what the file says; empty if one can.
  double mass = 0.0;                                     ///< [kg], >= 0.
  Eigen::Vector3d p_Lcm = Eigen::Vector3d::Zero();       ///< centre of mass [m].
  Eigen::Matrix3d I_cm_L = Eigen::Matrix3d::Zero();      ///< inertia about the centre of mass, link axes [kg m^2].
  std::vector<EllipsoidDescription> ellipsoids;
};

enum class JointType { kFixed, kContinuous, kRevolute, kPrismatic };

/// What the simulator does with a joint.
enum class JointRole {
  kLocked,      ///< does not move: merged into its parent.
  kDrive,       ///< wheel axle with a motor (and brake).
  kFreeWheel,   ///< wheel axle without a motor; braked only if it belongs to the braked wheels.
  kSteer,       ///< prescribed by the steering command.
  kSuspension,  ///< spring and damper.
  kPassive,     ///< free within its limits: caster swivel, rocker, hitch.
  kPrescribed   ///< follows a commanded position (lift, mast): holds until told otherwise.
};

const char* toString(JointRole role);

struct JointMimic {
  std::string joint;
  double multiplier = 1.0;
  double offset = 0.0;
};

/// A joint as the file describes it. Angles [rad], lengths [m], efforts [N m] or [N].
struct JointDescription {
  std::string name;
  int line = 0;
  JointType type = JointType::kFixed;
  std::string parent, child;
  Pose X_PJ;                                             ///< joint frame in the parent link, at position zero.
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();       ///< unit, in the joint frame (= child link frame).
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  double effort_limit = std::numeric_limits<double>::infinity();
  double velocity_limit = std::numeric_limits<double>::infinity();
  double damping = 0.0;                                  ///< viscous, [N m s/rad] or [N s/m].
  double friction = 0.0;                                 ///< dry, [N m] or [N].
  std::optional<double> spring_stiffness;                ///< [N m/rad] or [N/m].
  std::optional<double> spring_reference;                ///< position at which the spring is slack.
  std::optional<JointMimic> mimic;

  JointRole role = JointRole::kLocked;
  std::string role_reason;                               ///< why, for the table in the log.
};

/// How body commands become wheel commands.
enum class DriveLayout {
  kNone,          ///< nothing drives: a ball, a trailer.
  kAckermann,     ///< steered wheels on one or both ends.
  kDifferential   ///< left and right wheels driven apart: differential drive or skid-steer.
};

const char* toString(DriveLayout layout);

/// A vehicle as described: a tree of links, shapes already turned into ellipsoids, each joint with its role.
/// Conventions: the root link's x points forward, y left, z up (REP-103), but for forward_yaw.
struct VehicleDescription {
  std::string name;
  std::string file;
  std::string root;                          ///< name of the root link.
  std::vector<LinkDescription> links;        ///< parents before children, root first.
  std::vector<JointDescription> joints;      ///< in the order of their child links: joints[i].child == links[i + 1].name.
  DriveLayout layout = DriveLayout::kNone;
  std::string layout_text;                   ///< in more words: "skid-steer on 4 wheels, on rockers".
  double forward_yaw = 0.0;                  ///< where forward is, turned from the root link's x about its z [rad].
};

}  // namespace ellipsoid_vehicle_sim
