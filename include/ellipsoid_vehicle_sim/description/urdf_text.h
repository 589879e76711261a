#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/geometry/pose.h"
#include "ellipsoid_vehicle_sim/geometry/problem.h"
#include "ellipsoid_vehicle_sim/vehicle/vehicle_description.h"

// A URDF as its text says it: element by element with line numbers, every number read strictly and checked against its
// range, nothing interpreted yet. urdfdom tells neither lines nor what it dropped, and takes a negative mass for a
// mass; this layer does the reading, urdfdom is asked only whether it agrees (urdf_loader.cpp).

namespace ellipsoid_vehicle_sim {

/// A primitive or mesh of a <visual> or <collision>.
struct ShapeText {
  enum class Kind { kBox, kCylinder, kSphere, kMesh };
  Kind kind = Kind::kSphere;
  int line = 0;                                     ///< of the primitive's element.
  Pose X_LS;                                        ///< <origin>: the shape's axes in the link frame.
  Eigen::Vector3d size = Eigen::Vector3d::Zero();   ///< box: edges; cylinder: radius, length; sphere: radius [m].
  std::string filename;                             ///< mesh only.
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();  ///< mesh only.
};

struct InertialText {
  int line = 0;
  double mass = 0.0;                                  ///< [kg]
  Pose X_LI;                                          ///< <origin>: centre of mass and axes of the tensor.
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about the centre of mass, in those axes [kg m^2].
};

struct LinkText {
  std::string name;
  int line = 0;
  std::optional<InertialText> inertial;
  std::vector<ShapeText> visuals, collisions;                     ///< those that could be read.
  int inertial_count = 0, visual_count = 0, collision_count = 0;  ///< elements in the text, read or not.
  bool complete = true;                                           ///< nothing of the link was refused.
};

struct LimitText {
  int line = 0;
  std::optional<double> lower, upper;
  double effort = 0.0, velocity = 0.0;  ///< 0 in many files, for "nobody filled it in".
};

/// A joint: `joint` holds what can be taken over as it stands; axis, limits and type are still the text's.
struct JointText {
  JointDescription joint;
  std::string type;
  std::optional<Eigen::Vector3d> axis;
  int axis_line = 0;
  std::optional<LimitText> limit;
  int mimic_line = 0;
  bool complete = true;
};

/// A <transmission>, a <ros2_control> or the plugin of a drive that names a joint: somebody meant it to be driven.
struct TransmissionText {
  std::string joint;
  int line = 0;
  bool velocity_interface = false;  ///< a hardwareInterface of the velocity kind.
  std::string element = "<transmission>";
};

/// Springs of <gazebo reference="JOINT">.
struct GazeboJointText {
  std::string joint;
  int line = 0;
  std::optional<double> spring_stiffness, spring_reference;
};

/// Surface of <gazebo reference="LINK">: friction in two directions, stiffness and damping of contacts.
struct GazeboLinkText {
  std::string link;
  int line = 0;
  std::optional<double> mu1, mu2, kp, kd;
};

struct UrdfText {
  std::string name;
  std::vector<LinkText> links;
  std::vector<JointText> joints;
  std::vector<TransmissionText> transmissions;
  std::vector<GazeboJointText> gazebo_joints;
  std::vector<GazeboLinkText> gazebo_links;
};

/// Allowed ranges [SI]: wide enough for anything on wheels, narrow enough that no product of them overflows.
constexpr double kLargestLength = 1e6;
constexpr double kSmallestLength = 1e-9;
constexpr double kLargestMass = 1e9;
constexpr double kLargestInertia = 1e15;
constexpr double kLargestNumber = 1e15;
constexpr std::size_t kMostLinks = 1000;
constexpr std::size_t kMostMovingJoints = 100;
constexpr std::size_t kMostCollisionShapes = 1000;

/// Reads `text`; `file` stands in messages only. Without a value nothing could be made of the text at all (not XML, no
/// <robot>); otherwise there is a value and, beside it, every problem found: unlike elsewhere both may be there, so
/// that the caller can go on looking for more. accept_negative_mass: for who repairs it.
std::optional<UrdfText> readUrdfText(const std::string& text, const std::string& file, Problems& problems,
                                     std::vector<std::string>& notes, bool accept_negative_mass = false);

/// "car.urdf:41 link 'wheel'".
std::string placeText(const std::string& file, int line, const std::string& what, const std::string& name);

/// True if the text is a git-LFS pointer: what a checkout without git-lfs leaves where a file should be.
bool isGitLfsPointer(const std::string& text);

}  // namespace ellipsoid_vehicle_sim
