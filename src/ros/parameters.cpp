#include "ellipsoid_vehicle_sim/ros/parameters.h"

#include <ros/param.h>

#include <algorithm>
#include <cmath>

namespace ellipsoid_vehicle_sim {
namespace {

/// nullopt for what no parameter can be: a dictionary, binary data, a mixed list.
std::optional<ParameterValue> fromXmlRpc(XmlRpc::XmlRpcValue& value) {
  using V = XmlRpc::XmlRpcValue;
  switch (value.getType()) {
    case V::TypeBoolean:
      return ParameterValue(static_cast<bool>(value));
    case V::TypeInt:
      return ParameterValue(static_cast<std::int64_t>(static_cast<int>(value)));
    case V::TypeDouble:
      return ParameterValue(static_cast<double>(value));
    case V::TypeString:
      return ParameterValue(static_cast<std::string>(value));
    case V::TypeArray:
      break;
    default:
      return std::nullopt;
  }
  std::vector<double> numbers;
  std::vector<std::string> texts;
  for (int i = 0; i < value.size(); ++i) {
    if (value[i].getType() == V::TypeInt) numbers.push_back(static_cast<int>(value[i]));
    if (value[i].getType() == V::TypeDouble) numbers.push_back(static_cast<double>(value[i]));
    if (value[i].getType() == V::TypeString) texts.push_back(static_cast<std::string>(value[i]));
  }
  const auto size = static_cast<std::size_t>(value.size());
  if (texts.size() == size && size > 0) return ParameterValue(texts);
  if (numbers.size() == size) return ParameterValue(numbers);
  return std::nullopt;
}

/// What only several values together can get wrong.
void checkTogether(const NodeParameters& parameters, Problems& problems) {
  const NodeOptions& options = parameters.options;
  std::vector<std::string> topics;
  for (const std::string& topic : options.lockstep_topics) {
    const bool known = std::find(kCommandTopics.begin(), kCommandTopics.end(), topic) != kCommandTopics.end();
    const bool twice = std::find(topics.begin(), topics.end(), topic) != topics.end();
    if (!known) {
      problems.push_back(
          {"~lockstep_topics",
           "'" + topic + "' is no topic of commands, allowed are cmd_vel, ackermann_cmd, joint_commands"});
    }
    if (twice) problems.push_back({"~lockstep_topics", "'" + topic + "' stands there twice"});
    topics.push_back(topic);
  }
  if (options.lockstep && topics.empty()) problems.push_back({"~lockstep_topics", "is empty: nothing to wait for"});
  if (!options.named && options.odometry == OdometrySource::kTruth && !options.world_frame.empty() &&
      options.world_frame != options.odom_frame) {
    problems.push_back({"~world_frame", "'" + options.world_frame + "' is not odom_frame '" + options.odom_frame +
                                            "': with odometry: truth they are one frame"});
  }
  if (options.odometry == OdometrySource::kEncoders && worldFrameOf(options) == options.odom_frame) {
    problems.push_back(
        {"~world_frame",
         "'" + options.odom_frame + "' is odom_frame too: with odometry: encoders they are two, which drift apart"});
  }
  if (options.threads != std::floor(options.threads)) {
    problems.push_back({"~threads", "'" + valueText(options.threads) + "' is no whole number"});
  }
  if (options.noise_seed != std::floor(options.noise_seed)) {
    problems.push_back({"~noise_seed", "'" + valueText(options.noise_seed) + "' is no whole number"});
  }
  for (const Problem& problem : checkLidars(options.lidar_names, options.lidars)) problems.push_back(problem);
  for (const std::string& name : options.lidar_names) {
    const auto keys = parameterKeys(nodeParameters()), more = parameterKeys(simConfigParameters());
    if (std::count(keys.begin(), keys.end(), name) + std::count(more.begin(), more.end(), name) > 0)
      problems.push_back({"~lidars", "'" + name + "' is the name of a parameter: call the lidar otherwise"});
  }
  if (options.clock != ClockMode::kPublish && options.lockstep) {
    problems.push_back({"~lockstep", "'true' needs clock: publish, or nobody could wait for anybody"});
  }
  if (options.clock != ClockMode::kPublish && options.real_time_factor != 1.0) {
    problems.push_back({"~real_time_factor",
                        "'" + valueText(options.real_time_factor) + "' needs clock: publish, allowed otherwise is 1"});
  }
}

}  // namespace

NodeOptions optionsOfNamed(const std::string& name) {
  NodeOptions options;
  options.named = true;
  options.tf_prefix = name + "/";
  options.world_frame = "map";
  options.publish_link_tf = true;
  options.publish_world_tf = true;
  return options;
}

const std::vector<std::string>& nodeWideKeys() {
  static const std::vector<std::string> keys = {
      "vehicles",  "threads",   "world",       "clock",           "clock_rate",       "publish_rate", "imu_rate",
      "marker_rate", "marker_scale", "real_time_factor", "friction_scale", "lockstep", "lockstep_timeout", "duration",
      "world_marker_limit", "gazebo_services", "summary_file", "record_folder", "record_rate"};
  return keys;
}

std::string worldFrameOf(const NodeOptions& options) {
  if (!options.world_frame.empty()) return options.world_frame;
  return options.odometry == OdometrySource::kTruth ? options.odom_frame : "map";
}

ParameterTable<NodeOptions> nodeParameters() {
  using O = NodeOptions;
  return {
      textParameter(
          "vehicle_file", &O::vehicle_file,
          "Name of a shipped vehicle or path of a URDF. Where the parameter robot_description exists, the URDF is "
          "that text, and this path only finds its meshes; otherwise robot_description is set from this file."),
      listParameter("package_dirs", "", 0, &O::package_dirs,
                    "Folders searched for NAME of package://NAME/... before ROS is asked. Not given: the vehicle's."),
      textParameter("world", &O::world,
                    "Name of a shipped world, or path of a mesh (STL, OBJ, DAE) or of a world YAML."),
      listParameter("vehicles", "", 0, &O::vehicles,
                    "Names of several vehicles: each has its topics, services and frames under its name, and its own "
                    "parameters under ~NAME, over the common ones. Not given: one vehicle, without a name."),
      numberParameter("threads", "-", 0.0, 256.0, &O::threads,
                      "Cores that several vehicles are spread over, whole; 0: all. Changes no result by a bit."),
      listParameter("drive_joints", "", 0, &O::drive_joints,
                    "The driven wheels, all of them. Not given: found out from the URDF, and logged."),
      listParameter(
          "joint_roles", "", 0, &O::joint_roles,
          "JOINT=ROLE for joints whose role is not what the log says; roles: locked, drive, free_wheel, steer, "
          "suspension, passive, prescribed."),
      choiceParameter<O, std::string>("forward", {{"auto", "auto"}, {"x", "x"}, {"-x", "-x"}, {"y", "y"}, {"-y", "-y"}},
                                      &O::forward,
                                      "Which way of the root link is forward. auto: across the axles, to the end that "
                                      "the wheels' names call the front, else x (or y); the log says which."),
      flagParameter("repair_inertia", &O::repair_inertia,
                    "Replace masses and inertias that no body has, or that do not go with the shapes beside them, by "
                    "what urdf_doctor suggests; each is logged. Without it they are refused, or told."),
      numberParameter("body_ellipsoids", "-", 1.0, 64.0, &O::body_ellipsoids,
                      "Ellipsoids that stand for each box, cylinder or mesh of the body, at most: more fit better, and "
                      "cost as much as so many wheels."),
      listParameter("start", "m, m, rad", 3, &O::start,
                    "x, y and yaw at which the vehicle is set down. Not given: the world's."),
      textParameter("odom_frame", &O::odom_frame,
                    "Frame of odom (REP-105). With odometry: truth it is the world's; nothing drifts."),
      textParameter("world_frame", &O::world_frame,
                    "Frame of world, contacts and ground_truth. Not given: odom_frame with odometry: truth, map with "
                    "odometry: encoders."),
      textParameter("base_frame", &O::base_frame,
                    "Frame of the vehicle; only the URDF's root link can be it. Not given: that link."),
      textParameter("tf_prefix", &O::tf_prefix,
                    "Stands before odom_frame and the frames of all links. Not given: NAME/ with vehicles, else nothing."),
      flagParameter("publish_tf", &O::publish_tf, "Send odom_frame -> base_frame to tf, as odom says."),
      flagParameter("publish_link_tf", &O::publish_link_tf,
                    "Send the links too, as robot_state_publisher would. Not given: true with vehicles, else false."),
      flagParameter("publish_world_tf", &O::publish_world_tf,
                    "With odometry: encoders, send world_frame -> odom_frame too, so that the sum is true: what a "
                    "perfect localisation would do. With vehicles: true unless given."),
      choiceParameter<O, OdometrySource>(
          "odometry", {{"truth", OdometrySource::kTruth}, {"encoders", OdometrySource::kEncoders}}, &O::odometry,
          "truth: odom is where the vehicle is. encoders: dead reckoning on a plane from wheel speeds and steering, "
          "which slip and slopes lead astray; it starts at zero, and its covariance grows with the way."),
      nestedParameter("odometry_position_noise", "m/sqrt(m)", 0.0, 10.0, &O::odometry_noise, &OdometryNoise::position,
                      "Standard deviation that odom from encoders claims for the distance after one metre; it grows "
                      "with the root of the way."),
      nestedParameter("odometry_yaw_noise", "rad/sqrt(m)", 0.0, 10.0, &O::odometry_noise, &OdometryNoise::yaw,
                      "Likewise for the heading, after one metre."),
      nestedParameter("odometry_turn_noise", "rad/sqrt(rad)", 0.0, 10.0, &O::odometry_noise, &OdometryNoise::turn,
                      "Likewise for the heading, after turning by one radian."),
      nestedParameter("imu_orientation_noise", "rad", 0.0, 1.0, &O::imu_noise, &ImuNoise::orientation,
                      "White noise on the orientation of imu: standard deviation on each axis, also its covariance."),
      nestedParameter("imu_angular_velocity_noise", "rad/s", 0.0, 10.0, &O::imu_noise, &ImuNoise::angular_velocity,
                      "Likewise on the angular velocity."),
      nestedParameter("imu_acceleration_noise", "m/s^2", 0.0, 100.0, &O::imu_noise, &ImuNoise::acceleration,
                      "Likewise on the linear acceleration."),
      numberParameter("noise_seed", "-", 0.0, 9007199254740992.0, &O::noise_seed,
                      "Whole number that the noise is made from: the same seed gives the same noise at the same step "
                      "after a reset."),
      listParameter("lidars", "", 0, &O::lidar_names,
                    "Names of the lidars that the vehicle carries. The parameters of lidar NAME stand below ~NAME/; "
                    "see the table of a lidar."),
      choiceParameter<O, ClockMode>(
          "clock", {{"publish", ClockMode::kPublish}, {"follow", ClockMode::kFollow}, {"wall", ClockMode::kWall}},
          &O::clock,
          "publish: this node is the source of /clock (needs /use_sim_time). follow: another node is. wall: stamps are "
          "wall "
          "time."),
      running(numberParameter("clock_rate", "Hz", 1.0, 1e6, &O::clock_rate,
                              "Of /clock, in simulated time, like all rates here; at most one message a tick.")),
      running(numberParameter(
          "publish_rate", "Hz", 0.1, 1e6, &O::publish_rate,
          "Of odom, ground_truth, tf, joint_states and contacts. In lockstep one command is awaited after "
          "each.")),
      running(numberParameter("imu_rate", "Hz", 0.1, 1e6, &O::imu_rate, "Of imu.")),
      running(numberParameter("marker_rate", "Hz", 0.1, 1e6, &O::marker_rate, "Of contact_markers.")),
      running(numberParameter("real_time_factor", "-", 0.0, 1e6, &O::real_time_factor,
                              "Simulated time over wall time; 0: as fast as possible. Falling behind is reported.")),
      flagParameter("lockstep", &O::lockstep,
                    "Simulated time waits for the commander: after each odom the next command must come. Free-running "
                    "commands reach a fast simulation at random times; these do not."),
      listParameter("lockstep_topics", "", 0, &O::lockstep_topics,
                    "The topics a command is awaited on, one of each: of cmd_vel, ackermann_cmd, joint_commands."),
      numberParameter("lockstep_timeout", "s", 0.0, 1e6, &O::lockstep_timeout,
                      "Wall time to wait for that command before giving up with an error; 0: for ever."),
      numberParameter("duration", "s", 0.0, 1e9, &O::duration, "Simulated time after which the node ends; 0: never."),
      numberParameter(
          "contact_arrow_scale", "m/N", 1e-9, 1e3, &O::contact_arrow_scale,
          "Length of contact arrows. Not given: the weight of the vehicle is twice as long as the vehicle."),
      running(
          numberParameter("marker_scale", "-", 0.01, 100.0, &O::marker_scale, "Length of contact arrows, times this.")),
      running(numberParameter("friction_scale", "-", 0.0, 10.0, &O::friction_scale,
                              "Every coefficient of friction, times this: rain, while it runs.")),
      numberParameter("world_marker_limit", "-", 1000.0, 1e8, &O::world_marker_limit,
                      "Triangles shown at most; of a larger world only the part around the vehicle."),
      flagParameter("gazebo_services", &O::gazebo_services,
                    "Offer /gazebo/reset_simulation, reset_world, pause_physics and unpause_physics (std_srvs/Empty) "
                    "for programs that know these names. The clock goes on over a reset here."),
      textParameter("summary_file", &O::summary_file, "File for the report that is also logged at the end."),
      textParameter(
          "record_folder", &O::record_folder,
          "Folder, absolute, for run.csv and manifest.yaml of the run; made if it is not there. Not given: none."),
      numberParameter("record_rate", "Hz", 0.1, 1e6, &O::record_rate,
                      "Of the lines in run.csv, in simulated time; at most one a tick."),
  };
}

std::string parameterManual() {
  std::string manual =
      "# Parameters of ellipsoid_vehicle_sim_node: all of them, with meaning, range, unit and default. Take away the "
      "'#' of a\n"
      "# line to set it; one without a value is derived from vehicle and step unless given. A file VEHICLE.yaml "
      "beside\n"
      "# VEHICLE.urdf sets what is special to that vehicle; this file wins over it.\n"
      "# Written from the tables in the code: parameters_test compares, and ELLIPSOID_VEHICLE_SIM_UPDATE=1 writes it "
      "anew.\n";
  manual += "\n# --- The node ---\n";
  for (const auto& row : nodeParameters()) manual += manualEntry(row.spec, row.get(NodeOptions{}));
  manual += "\n# --- The physics ---\n";
  for (const auto& row : simConfigParameters()) manual += manualEntry(row.spec, row.get(SimConfig{}));
  manual +=
      "\n# --- A lidar. Each name in `lidars` has a dictionary of its own with these keys, for instance\n"
      "#     lidars: [front]\n"
      "#     front: {link: base_link, pose: [0.5, 0, 0.8, 0, 0, 0], samples: 541}\n"
      "# ---\n";
  for (const auto& row : lidarParameters()) {
    // Two columns to the right, as the keys of a dictionary stand.
    std::string entry = manualEntry(row.spec, row.get(LidarSpec{}));
    const std::size_t key = entry.rfind("\n#") + 2;
    manual += entry.substr(0, key) + "  " + entry.substr(key);
  }
  return manual;
}

std::string parameterReference() {
  std::string text =
      "# Parameters\n\nAll parameters of `ellipsoid_vehicle_sim_node`, private to the node. Written from the tables in "
      "the code, like `launch/simulator.yaml`:\n`parameters_test` compares, and `ELLIPSOID_VEHICLE_SIM_UPDATE=1` "
      "writes "
      "it anew. *Derived*: from vehicle and step, and logged. Those marked\n(running) may change while the node runs, "
      "by "
      "dynamic_reconfigure; all others are fixed at the start.\n";
  const auto add = [&text](const auto& table, const auto& defaults, const char* title) {
    text +=
        std::string("\n## ") + title + "\n\n| parameter | default | range | unit | meaning |\n|---|---|---|---|---|\n";
    for (const auto& row : table) text += referenceRow(row.spec, row.get(defaults));
  };
  add(nodeParameters(), NodeOptions{}, "The node");
  add(simConfigParameters(), SimConfig{}, "The physics");
  add(lidarParameters(), LidarSpec{}, "A lidar, below `~NAME/` for each NAME in `lidars` ([lidar.md](lidar.md))");
  return text;
}

Loaded<ParameterValues> readParameterServer(const ros::NodeHandle& nh_priv) {
  Loaded<ParameterValues> result;
  ParameterValues values;
  XmlRpc::XmlRpcValue all;
  if (ros::param::get(nh_priv.getNamespace(), all) && all.getType() == XmlRpc::XmlRpcValue::TypeStruct) {
    // Below the names of vehicles stands what is theirs.
    std::vector<std::string> names;
    if (all.hasMember("vehicles")) {
      const auto list = fromXmlRpc(all["vehicles"]);
      if (list && std::holds_alternative<std::vector<std::string>>(*list)) names = std::get<std::vector<std::string>>(*list);
    }
    for (auto& [key, value] : all) {
      const bool theirs = std::find(names.begin(), names.end(), key) != names.end();
      if (theirs && value.getType() == XmlRpc::XmlRpcValue::TypeStruct) continue;
      if (auto known = fromXmlRpc(value)) {
        values.emplace(key, std::move(*known));
      } else if (value.getType() == XmlRpc::XmlRpcValue::TypeStruct) {
        for (auto& [inner_key, inner] : value) {
          if (auto inner_known = fromXmlRpc(inner)) {
            values.emplace(key + "/" + inner_key, std::move(*inner_known));
          } else {
            result.problems.push_back({"~" + key + "/" + inner_key,
                                       "is a dictionary or a mixed list, which no parameter of this node is"});
          }
        }
      } else {
        result.problems.push_back({"~" + key, "is a dictionary or a mixed list, which no parameter of this node is"});
      }
    }
  }
  if (result.problems.empty()) result.value = std::move(values);
  return result;
}

Loaded<ParameterValues> readParameterServer(const ros::NodeHandle& nh_priv, const std::string& name) {
  Loaded<ParameterValues> result = readParameterServer(ros::NodeHandle(nh_priv, name));
  for (Problem& problem : result.problems) problem.where.insert(1, name + "/");
  return result;
}

Loaded<NodeParameters> parametersFrom(std::vector<ParameterSource> sources, NodeOptions defaults) {
  const auto config_table = simConfigParameters();
  const auto node_table = nodeParameters();
  std::vector<std::string> known = parameterKeys(node_table);
  const std::vector<std::string> config_keys = parameterKeys(config_table);
  known.insert(known.end(), config_keys.begin(), config_keys.end());

  NodeParameters parameters{SimConfig{}, std::move(defaults)};
  Loaded<NodeParameters> result;
  const auto add = [&result](const Problems& more) {
    result.problems.insert(result.problems.end(), more.begin(), more.end());
  };
  for (ParameterSource& source : sources) {
    add(takeParameters(node_table, source.where, source.values, parameters.options));
    add(takeParameters(config_table, source.where, source.values, parameters.config));
  }
  // Which names are lidars' is known only now.
  for (ParameterSource& source : sources) {
    add(takeLidars(parameters.options.lidar_names, source.where, source.values, parameters.options.lidars));
    add(unknownParameters(source.values, known, source.where));
  }
  checkTogether(parameters, result.problems);
  add(parameters.config.validate());
  if (result.problems.empty()) result.value = std::move(parameters);
  return result;
}

}  // namespace ellipsoid_vehicle_sim
