#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/geometry/pose.h"
#include "ellipsoid_vehicle_sim/geometry/problem.h"
#include "ellipsoid_vehicle_sim/vehicle/drive_command.h"
#include "ellipsoid_vehicle_sim/vehicle/parameter_table.h"
#include "ellipsoid_vehicle_sim/vehicle/simulator.h"

namespace ellipsoid_vehicle_sim {

/// From `time` on this is commanded, in every tick, until the next entry.
struct SceneCommand {
  double time = 0.0;  ///< [s].
  DriveCommand command;
};

/// How the vehicle comes into the world: at rest on the ground, or as given, moving.
struct SceneStart {
  bool set_down = true;
  double x = 0.0, y = 0.0, yaw = 0.0;                ///< set-down [m, m, rad].
  Pose X_WR;                                         ///< otherwise: the root link's pose,
  Eigen::Vector3d v_WR_W = Eigen::Vector3d::Zero();  ///< velocity [m/s]
  Eigen::Vector3d w_WR_W = Eigen::Vector3d::Zero();  ///< and angular velocity [rad/s].
};

/// A closed form that the end of a scene is compared with; see scene/closed_forms.h.
enum class ClosedForm { kNone, kBounce, kTorqueFree, kRollDown, kSlide, kCircle, kStop, kRest };

/// What is looked at besides the self-consistency of the path, which is always measured.
struct SceneMeasures {
  bool energy = false;           ///< the scene conserves energy: its drift is an error.
  bool momentum = false;         ///< horizontal momentum is conserved.
  bool contact_quality = false;  ///< penetration, ripple of the ground's force, cone.
  bool creep = false;            ///< the vehicle stands at the end: how far it moves in the last half.
  ClosedForm closed_form = ClosedForm::kNone;
};

/// A run, described: everything that has to be known to repeat it. Files are absolute paths.
struct Scene {
  std::string name;  ///< stem of the file.
  std::string file;
  std::string description;
  std::string vehicle, world;
  std::vector<std::string> package_dirs, drive_joints, joint_roles;
  std::string forward = "auto";  ///< as the node's parameters of these names.
  bool repair_inertia = false;
  int body_ellipsoids = 1;
  SimConfig config;  ///< defaults, then the vehicle's own file, then the scene's parameters.
  SceneStart start;
  int headings = 1;          ///< what is measured is the worst of so many set-downs, the yaw turned between them.
  bool start_given = false;  ///< false: set down where the world says.
  std::vector<SceneCommand> commands;  ///< by time; none: nothing is commanded.
  double duration = 0.0;               ///< [s].
  double horizon = 0.0;                ///< up to here the motion can be predicted [s]; later two correct runs may part.
  std::optional<double>
      length;  ///< characteristic length [m] of a scene that does not travel; not given: the vehicle's.
  SceneMeasures measures;
};

/// Reads a scene:
///
///     description: what it shows
///     vehicle: car                       # shipped name, or path of a URDF (relative to this file)
///     world: flat                        # shipped name, or path of a mesh or world YAML
///     package_dirs: [..]                 # folders searched for package://NAME/..., relative to this file
///     drive_joints: [..]                 # as the node's parameters of these names
///     joint_roles: [JOINT=ROLE]
///     forward: auto                      # x, -x, y, -y of the root link
///     repair_inertia: false
///     body_ellipsoids: 1
///     parameters: {gravity: 9.81, ...}   # of the physics (launch/simulator.yaml), over VEHICLE.yaml beside the
///     vehicle start: {set_down: [x, y, yaw]}     # at rest on the ground; default: where the world says. Or as given:
///     start: {position: [x, y, z], rotation: [roll, pitch, yaw], velocity: [..], angular_velocity: [..]}
///     headings: 12                       # what is measured is the worst of so many set-downs, turned by equal angles
///     commands:                          # each in force until the next
///       - {at: 0, speed: 5, yaw_rate: 0.1}
///       - {at: 2, speed: 5, steering_angle: 0.1}
///       - {at: 4, coast: true}
///     duration: 6
///     horizon: 6                         # default: duration
///     length: 0.3                        # [m], for errors of scenes that do not travel
///     measure: [energy, momentum, contact_quality, creep]
///     closed_form: torque_free           # bounce, torque_free, roll_down, slide, circle, stop, rest
///
/// Problems, all at once, with file and line: unknown or repeated keys, wrong types, values out of range, files that
/// are not found. `share`: the package's folder, for shipped names.
Loaded<Scene> loadScene(const std::string& path, const std::string& share);

/// A scene without commands, made of a vehicle and a world: paths of files, with what VEHICLE.yaml beside the vehicle says.
/// Set down where the world says; no duration.
Loaded<Scene> sceneOf(const std::string& vehicle, const std::string& world, const std::string& share);

/// A scene's parameter by name, as a command line gives it; over everything the files say. Problems as for the file.
Problems overrideParameter(Scene& scene, const std::string& key, const std::string& yaml_value,
                           const std::string& where);

/// A scene with its files read, ready to make simulators from.
struct LoadedScene {
  Scene scene;
  VehicleDescription vehicle;
  std::shared_ptr<const Terrain> terrain;
  std::vector<std::string> files;  ///< every file that was read, for the manifest.
  std::vector<std::string> notes;
};

Loaded<LoadedScene> loadSceneFiles(const Scene& scene, const std::string& share);

/// The vehicle in the world at the scene's start. `config` may differ from the scene's own.
Loaded<Simulator> startScene(const LoadedScene& scene, const SimConfig& config);

/// Commands what the scene says for the tick that begins `time` after the start. Times are met to a tick.
void commandScene(const Scene& scene, double time, double dt, Simulator& simulator);

/// Ticks of the whole scene at this step, at least one.
std::int64_t sceneTicks(const Scene& scene, double dt);

}  // namespace ellipsoid_vehicle_sim
