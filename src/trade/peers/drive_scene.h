#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/scene/scene.h"

namespace ellipsoid_vehicle_sim {

/// The driver of a scene, the same for every engine: what our drive asked of wheels and steering in a run of its own,
/// every kInterval, and linearly between. Times from the scene's start on [s].
class DriveSeries {
 public:
  static constexpr double kInterval = 1e-3;

  /// Position and speed of a joint on a path.
  struct Path {
    double position = 0.0, velocity = 0.0;
  };

  /// Runs `simulator`, whose tick is kInterval, for `duration`. False: it broke down on the way.
  bool record(const Scene& scene, double duration, Simulator& simulator);

  DriveState::Mode mode(double time) const;
  double wheelSpeed(int wheel, double time) const;  ///< asked of a wheel unit [rad/s].
  double wheelAngle(int wheel, double time) const;  ///< the same summed up since the start [rad].
  Path path(int prescribed, double time) const;

 private:
  struct Moment {
    std::vector<double> wheel_speed, wheel_angle;
    std::vector<Path> paths;
  };
  void add(const VehicleState& state);
  std::size_t tickOf(double time, double& fraction) const;

  std::vector<Moment> moments_;          // one more than ticks
  std::vector<DriveState::Mode> modes_;  // of the tick from the moment of this index on
};

/// A vehicle over one plane, with everything that happens to it: what engines are told of a scene with joints.
struct DriveScene {
  VehicleModel model;
  Motion start;
  DriveSeries series;
  Eigen::Vector3d nhat_W, p_WP;  ///< the plane's normal and a point of it.
  std::vector<double> mu;        ///< of each ellipsoid on the plane [-].
  double gravity = 0.0;          ///< along -z [m/s^2].
  std::optional<double> max_power;
  double duration = 0.0;  ///< the scene's horizon [s].

  /// Where the bodies of the tree are at the start.
  std::vector<Pose> bodyPoses() const;
  /// The root link of a vehicle whose base is at X_WB.
  Pose rootPose(const Pose& X_WB) const { return X_WB * model.X_BR; }
};

/// The scene as other engines can be told it. Problems say what they cannot be told.
Loaded<DriveScene> makeDriveScene(const LoadedScene& loaded);

/// The plane that all triangles of a terrain lie in; nullopt where there is more than one.
struct GroundPlane {
  Eigen::Vector3d nhat_W, p_WP;
};
std::optional<GroundPlane> planeOf(const Terrain& terrain);

}  // namespace ellipsoid_vehicle_sim
