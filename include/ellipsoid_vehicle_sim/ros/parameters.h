#pragma once

#include <ros/node_handle.h>

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/geometry/problem.h"
#include "ellipsoid_vehicle_sim/sensors/lidar_mount.h"
#include "ellipsoid_vehicle_sim/vehicle/imu.h"
#include "ellipsoid_vehicle_sim/vehicle/parameter_table.h"
#include "ellipsoid_vehicle_sim/vehicle/sim_config.h"
#include "ellipsoid_vehicle_sim/vehicle/wheel_odometry.h"

namespace ellipsoid_vehicle_sim {

/// Whose time the messages carry.
enum class ClockMode {
  kPublish,  ///< ours: the node publishes /clock.
  kFollow,   ///< somebody else's /clock: the simulation keeps pace with it.
  kWall      ///< the wall clock's at the start, plus simulated time.
};

/// Where odom comes from.
enum class OdometrySource { kTruth, kEncoders };

/// The commanders' topics; a lockstep topic is one of them.
constexpr std::array<const char*, 3> kCommandTopics = {"cmd_vel", "ackermann_cmd", "joint_commands"};

/// Parameters of the node that are not the physics' own. SI units.
struct NodeOptions {
  std::string vehicle_file;               ///< name of a shipped vehicle, or path of a URDF.
  std::vector<std::string> package_dirs;  ///< searched for package://NAME before ROS is asked.
  std::string world;                      ///< name of a shipped world, or path of a mesh or world YAML.
  std::vector<std::string> drive_joints;  ///< the driven wheels; empty: found out from the URDF.
  std::vector<std::string> vehicles;      ///< names of several vehicles; empty: one, without a name.
  double threads = 0.0;                   ///< several vehicles: 0 = as many as there are cores; whole.
  bool repair_inertia = false;            ///< replace masses and inertias that cannot be.
  double body_ellipsoids = 1.0;           ///< for each shape of the body, at most; whole.
  std::string forward = "auto";           ///< which way of the root link is forward: auto, x, -x, y, -y.
  std::vector<std::string> joint_roles;   ///< "JOINT=ROLE", where the role that is found out is not the right one.
  std::vector<double> start;              ///< x [m], y [m], yaw [rad]; empty: the world file's.

  std::string odom_frame = "odom";
  std::string base_frame;   ///< empty: the URDF's root link.
  std::string tf_prefix;    ///< before odom_frame and the frames of the links.
  std::string world_frame;  ///< empty: odom_frame with true odometry, "map" with the encoders'.
  bool publish_tf = true;
  bool publish_world_tf = false;  ///< world_frame -> odom_frame, where they are two.
  bool publish_link_tf = false;   ///< the links, as robot_state_publisher would.
  bool named = false;             ///< no parameter: one of several vehicles, in a name space of its own.

  OdometrySource odometry = OdometrySource::kTruth;
  OdometryNoise odometry_noise;
  ImuNoise imu_noise;       ///< but for its seed.
  double noise_seed = 0.0;  ///< a whole number.
  std::vector<std::string> lidar_names;
  std::vector<NamedLidar> lidars;  ///< of these names, in their order.

  ClockMode clock = ClockMode::kPublish;
  double clock_rate = 100.0;  ///< [Hz] of simulated time, like all rates.
  double publish_rate = 50.0;
  double marker_rate = 20.0;
  double imu_rate = 100.0;
  double real_time_factor = 1.0;  ///< 0: as fast as possible.
  double friction_scale = 1.0;    ///< every coefficient of friction times this.
  bool lockstep = false;
  std::vector<std::string> lockstep_topics = {"cmd_vel"};
  double lockstep_timeout = 30.0;  ///< [s] of wall time; 0: for ever.
  double duration = 0.0;           ///< [s] simulated, then the node ends; 0: for ever.

  std::optional<double> contact_arrow_scale;  ///< [m/N]
  double marker_scale = 1.0;                  ///< arrows times this.
  double world_marker_limit = 500000;         ///< triangles.
  bool gazebo_services = false;
  std::string summary_file;
  std::string record_folder;  ///< absolute; empty: no record.
  double record_rate = 100.0;
};

/// Defaults of a vehicle with a name: frames of its own below one world frame, links sent by the node.
NodeOptions optionsOfNamed(const std::string& name);
/// Keys that only the node as a whole has.
const std::vector<std::string>& nodeWideKeys();

/// The frame of the world on the wire.
std::string worldFrameOf(const NodeOptions& options);

/// Every parameter of NodeOptions.
ParameterTable<NodeOptions> nodeParameters();

/// All the node's parameters with unit, range, default and meaning, as a YAML file: launch/simulator.yaml.
std::string parameterManual();
/// The same as tables in Markdown: docs/parameters.md.
std::string parameterReference();

struct NodeParameters {
  SimConfig config;
  NodeOptions options;
};

/// Values and the words that stand before each key in messages: "~", or "car.yaml ".
struct ParameterSource {
  std::string where;
  ParameterValues values;
};

/// Everything under the namespace of nh_priv; what stands in a dictionary there has the key "DICTIONARY/key".
Loaded<ParameterValues> readParameterServer(const ros::NodeHandle& nh_priv);

/// What stands below `name` there; nothing if there is nothing.
Loaded<ParameterValues> readParameterServer(const ros::NodeHandle& nh_priv, const std::string& name);

/// Later sources win over earlier ones, and all over `defaults`. Unknown and misspelt keys, wrong types and values out of
/// range are problems, all at once.
Loaded<NodeParameters> parametersFrom(std::vector<ParameterSource> sources, NodeOptions defaults = {});

}  // namespace ellipsoid_vehicle_sim
