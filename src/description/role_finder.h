#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/description/joint_roles.h"
#include "ellipsoid_vehicle_sim/description/vehicle_tree.h"

namespace ellipsoid_vehicle_sim {

/// Works out joint_roles.h for one vehicle. Its steps stand in role_wheels.cpp (forward, ground wheels), role_carriers.cpp
/// (what carries them) and role_drive.cpp (which drive, layout).
class RoleFinder {
 public:
  RoleFinder(VehicleDescription& vehicle, const std::vector<std::vector<CollisionShape>>& shapes, const RoleHints& hints,
             Problems& problems, std::vector<std::string>& notes);

  std::vector<GroundWheel> find();

 private:
  using Vector3d = Eigen::Vector3d;

  // role_wheels.cpp
  void guessAxes();
  void findForward();
  std::optional<double> directionOfAxles() const;
  int forwardSign(double yaw, std::string& why) const;
  void turnTo(double forward_yaw);
  std::optional<GroundWheel> candidate(int j);
  void findWheels();

  // role_carriers.cpp
  void classify(int j);
  void classifyUpright(int j, const std::vector<const GroundWheel*>& wheels);
  void classifyWithoutWheels(int j);
  std::vector<const GroundWheel*> wheelsBelow(int j) const;
  double standOff(int j, const std::vector<const GroundWheel*>& wheels) const;
  bool carries(int j) const;
  double massBelow(int j) const;
  void liftLimits(int j);
  void set(int j, JointRole role, const std::string& reason);

  // role_drive.cpp
  std::set<std::string> drivenByTransmission(std::string& why) const;
  std::set<std::string> drivenByLayout(std::string& why) const;
  void chooseDriven();
  void chooseLayout();

  JointDescription& joint(int j) { return vehicle_.joints[j]; }
  const JointRole* overruled(int j) const;
  bool forcedWheel(int j) const;
  /// The joint above joint j; -1 above the root's own.
  int above(int j) const { return parents_[j + 1] - 1; }
  bool turnsFully(int j) const;
  bool upright(int j) const;
  bool named(int j) const;
  bool hasAbove(int j, JointRole role, bool only_upright) const;
  std::vector<PlacedShape> shapesOf(int j) const;

  VehicleDescription& vehicle_;
  const std::vector<std::vector<CollisionShape>>& shapes_;
  const RoleHints& hints_;
  Problems& problems_;
  std::vector<std::string>& notes_;
  std::vector<int> parents_;
  std::vector<Pose> X_RL_;          ///< of the links in the root link's frame, joints at zero.
  std::vector<Pose> X_FL_;          ///< likewise with x turned to look forward.
  std::vector<Vector3d> axes_F_;
  std::vector<GroundWheel> wheels_;
  std::vector<int> wheel_of_joint_;
};

/// Whether a joint turns.
inline bool isRotary(JointType type) { return type == JointType::kContinuous || type == JointType::kRevolute; }

/// Angles and lengths that tell roles apart; see joint_roles.h.
extern const double kLevel, kLateral, kUpright;

}  // namespace ellipsoid_vehicle_sim
