#include "ellipsoid_vehicle_sim/ros/node_setup.h"

#include <ros/console.h>
#include <ros/master.h>
#include <ros/network.h>
#include <ros/param.h>
#include <ros/this_node.h>
#include <xmlrpcpp/XmlRpcClient.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "ellipsoid_vehicle_sim/description/joint_roles.h"
#include "ellipsoid_vehicle_sim/description/parameter_file.h"
#include "ellipsoid_vehicle_sim/description/urdf_loader.h"
#include "ellipsoid_vehicle_sim/description/urdf_text.h"
#include "ellipsoid_vehicle_sim/description/world_file.h"
#include "ellipsoid_vehicle_sim/description/xacro.h"
#include "ellipsoid_vehicle_sim/ros/resources.h"

namespace ellipsoid_vehicle_sim {
namespace {

namespace fs = std::filesystem;

void append(const Problems& more, Problems& problems) { problems.insert(problems.end(), more.begin(), more.end()); }

void append(const std::vector<std::string>& more, std::vector<std::string>& notes) {
  notes.insert(notes.end(), more.begin(), more.end());
}

/// The URDF as text: robot_description where it exists, otherwise the file, which then becomes robot_description.
struct UrdfSource {
  std::string text;
  std::string file;  ///< for messages and as the place of its meshes.
};

Loaded<UrdfSource> findUrdf(const ros::NodeHandle& nh, const NodeOptions& options) {
  Loaded<UrdfSource> result;
  UrdfSource source;
  std::string key, description;
  const bool has_description = nh.searchParam("robot_description", key) && nh.getParam(key, description);

  if (options.vehicle_file.empty()) {
    if (!has_description) {
      result.problems.push_back({"~vehicle_file",
                                 "no vehicle: set it to a shipped name or the path of a URDF, or load a "
                                 "URDF into robot_description"});
      return result;
    }
    source = {description, "robot_description"};
  } else {
    Loaded<std::string> file = findVehicle(options.vehicle_file, "~vehicle_file");
    append(file.problems, result.problems);
    if (!file) return result;
    source.file = *file.value;
    if (has_description) {
      source.text = description;
      result.notes.push_back("the vehicle is the URDF in " + key + ", its files are looked for beside " + source.file);
    } else {
      Loaded<std::string> text = readVehicleText(source.file);
      append(text.problems, result.problems);
      append(text.notes, result.notes);
      if (!text) return result;
      source.text = std::move(*text.value);
      // For robot_state_publisher, RViz and whoever else wants to know the robot.
      nh.setParam("robot_description", source.text);
    }
  }
  result.value = std::move(source);
  return result;
}

/// The parameter server's values, over those of a file VEHICLE.yaml beside the vehicle.
Loaded<NodeParameters> loadParameters(const ros::NodeHandle& nh_priv) {
  Loaded<NodeParameters> result;
  Loaded<ParameterValues> server = readParameterServer(nh_priv);
  std::vector<ParameterSource> sources;
  Problems problems = server.problems;
  std::vector<std::string> notes;
  std::string vehicle;
  if (nh_priv.getParam("vehicle_file", vehicle)) {
    // A vehicle that is not found is reported where it is loaded.
    if (const Loaded<std::string> file = findVehicle(vehicle, ""); file) {
      const fs::path beside = fs::path(*file.value).replace_extension(".yaml");
      std::error_code error;
      if (fs::is_regular_file(beside, error)) {
        Loaded<ParameterValues> values = readParameterFile(beside.string());
        append(values.problems, problems);
        if (values) sources.push_back({beside.filename().string() + " ", std::move(*values.value)});
        notes.push_back("parameters of this vehicle are taken from " + beside.string());
      }
    }
  }
  if (server) sources.push_back({"~", std::move(*server.value)});
  result = parametersFrom(std::move(sources));
  result.notes = notes;
  result.problems.insert(result.problems.begin(), problems.begin(), problems.end());
  if (!result.problems.empty()) result.value.reset();
  return result;
}

/// Whether a node that the master lists is still there; one that crashed stays listed.
bool isAlive(const std::string& node) {
  XmlRpc::XmlRpcValue request, response, payload;
  request[0] = ros::this_node::getName();
  request[1] = node;
  std::string host;
  std::uint32_t port = 0;
  if (!ros::master::execute("lookupNode", request, response, payload, false)) return false;
  if (!ros::network::splitURI(static_cast<std::string>(payload), host, port)) return false;
  XmlRpc::XmlRpcClient client(host.c_str(), static_cast<int>(port), "/");
  XmlRpc::XmlRpcValue caller, pid;
  caller[0] = ros::this_node::getName();
  return client.execute("getPid", caller, pid);
}

/// Only one node may be the source of time; and without use_sim_time nobody would listen to it.
Problems checkClock(ClockMode mode) {
  Problems problems;
  bool use_sim_time = false;
  ros::param::get("/use_sim_time", use_sim_time);
  if (mode == ClockMode::kWall) {
    if (use_sim_time) problems.push_back({"~clock", "'wall' with /use_sim_time true: set one of them otherwise"});
    return problems;
  }
  if (!use_sim_time) {
    problems.push_back(
        {"~clock", std::string("'") + (mode == ClockMode::kPublish ? "publish" : "follow") +
                       "' needs simulated time: <param name=\"/use_sim_time\" value=\"true\"/> before the "
                       "nodes, or 'rosparam set /use_sim_time true'; or set ~clock to wall"});
  }
  if (mode == ClockMode::kFollow) return problems;

  // getSystemState: [[[topic, [node, ...]], ...], subscribers, services].
  XmlRpc::XmlRpcValue request, response, state;
  request[0] = ros::this_node::getName();
  if (!ros::master::execute("getSystemState", request, response, state, false)) return problems;
  for (int i = 0; i < state[0].size(); ++i) {
    if (static_cast<std::string>(state[0][i][0]) != "/clock") continue;
    for (int j = 0; j < state[0][i][1].size(); ++j) {
      const std::string node = state[0][i][1][j];
      if (node == ros::this_node::getName() || !isAlive(node)) continue;
      problems.push_back({"~clock", "'publish', but " + node +
                                        " publishes /clock already: two clocks would make time jump; "
                                        "stop it, or set ~clock to follow"});
    }
  }
  return problems;
}

/// Links with a <visual> that RViz can draw: a primitive, or a mesh that is there.
std::set<std::string> drawnLinks(const UrdfSource& urdf, const UriResolver& resolver) {
  Problems ignored;  // the loader has told them
  std::vector<std::string> notes;
  std::set<std::string> links;
  const auto text = readUrdfText(urdf.text, urdf.file, ignored, notes);
  if (!text) return links;
  for (const LinkText& link : text->links) {
    for (const ShapeText& visual : link.visuals) {
      if (visual.kind != ShapeText::Kind::kMesh || resolver(visual.filename)) links.insert(link.name);
    }
  }
  return links;
}

/// Largest distance across the ellipsoids with all joints at zero.
double vehicleLength(const VehicleDescription& vehicle) {
  std::vector<Pose> X_RL(vehicle.links.size());
  Eigen::AlignedBox3d box;
  for (std::size_t i = 0; i < vehicle.links.size(); ++i) {
    if (i > 0) {
      const JointDescription& joint = vehicle.joints[i - 1];
      const auto parent = std::find_if(vehicle.links.begin(), vehicle.links.end(),
                                       [&joint](const LinkDescription& link) { return link.name == joint.parent; });
      X_RL[i] = X_RL[static_cast<std::size_t>(parent - vehicle.links.begin())] * joint.X_PJ;
    }
    for (const EllipsoidDescription& ellipsoid : vehicle.links[i].ellipsoids) {
      const Pose X_RE = X_RL[i] * ellipsoid.X_LE;
      const Eigen::Vector3d reach = Eigen::Vector3d::Constant(ellipsoid.radii.maxCoeff());
      box.extend(Eigen::AlignedBox3d(Eigen::Vector3d(X_RE.p - reach), Eigen::Vector3d(X_RE.p + reach)));
    }
  }
  return box.isEmpty() ? 1.0 : box.sizes().maxCoeff();
}

/// The record that ~record_folder asks for, if it does.
std::optional<RunRecorder> openRecord(const NodeOptions& options, std::vector<std::string> files,
                                      const Simulator& simulator, Problems& problems) {
  if (options.record_folder.empty()) return std::nullopt;
  RunManifest manifest;
  manifest.program = "ellipsoid_vehicle_sim_node";
  manifest.seed = static_cast<std::uint64_t>(options.noise_seed);
  // Parameters of the vehicle's own beside it.
  std::error_code error;
  const std::string beside = fs::path(options.vehicle_file.empty() ? "" : files.front()).replace_extension(".yaml");
  if (fs::is_regular_file(beside, error)) files.insert(files.begin() + 1, beside);
  for (const std::string& file : files) {
    if (fs::is_regular_file(file, error)) manifest.files.push_back(file);
  }
  for (const auto& row : nodeParameters()) {
    if (const auto value = row.get(options)) manifest.more["~" + row.spec.key] = valueText(*value);
  }
  const auto every = static_cast<std::int64_t>(std::llround(1.0 / (options.record_rate * simulator.config().dt)));
  Loaded<RunRecorder> recorder = RunRecorder::create(options.record_folder, every, std::move(manifest), simulator);
  append(recorder.problems, problems);
  if (!recorder) return std::nullopt;
  return std::move(*recorder.value);
}

}  // namespace

Loaded<NodeSetup> loadSetup(const ros::NodeHandle& nh, const ros::NodeHandle& nh_priv) {
  Loaded<NodeSetup> result;
  Problems& problems = result.problems;
  Loaded<NodeParameters> parameters = loadParameters(nh_priv);
  append(parameters.problems, problems);
  append(parameters.notes, result.notes);
  // Go on with the defaults where a parameter was refused: the files may hold problems of their own.
  NodeOptions options;
  SimConfig config;
  if (parameters) {
    options = parameters.value->options;
    config = parameters.value->config;
    append(checkClock(options.clock), problems);
  } else {
    nh_priv.getParam("vehicle_file", options.vehicle_file);
    nh_priv.getParam("world", options.world);
  }

  // Vehicle.
  Loaded<UrdfSource> urdf = findUrdf(nh, options);
  append(urdf.problems, problems);
  append(urdf.notes, result.notes);
  Loaded<VehicleDescription> vehicle;
  std::set<std::string> drawn_links;
  const auto vehicle_files = std::make_shared<std::vector<std::string>>();
  if (urdf) {
    UrdfOptions urdf_options;
    urdf_options.drive_joints = options.drive_joints;
    urdf_options.roles = rolesFromWords(options.joint_roles, "~joint_roles", problems);
    urdf_options.forward_yaw = forwardFromWord(options.forward, "~forward", problems);
    urdf_options.repair_inertia = options.repair_inertia;
    if (options.body_ellipsoids != std::floor(options.body_ellipsoids))
      problems.push_back({"~body_ellipsoids", "is " + std::to_string(options.body_ellipsoids) + "; allowed is a whole number"});
    urdf_options.body_ellipsoids = static_cast<int>(options.body_ellipsoids);
    const UriResolver resolver = packageResolver(options.package_dirs, urdf.value->file);
    vehicle = loadUrdfText(urdf.value->text, urdf.value->file, recordingResolver(resolver, vehicle_files), urdf_options);
    drawn_links = drawnLinks(*urdf.value, resolver);
    append(vehicle.problems, problems);
    append(vehicle.notes, result.notes);
    if (vehicle) append(jointTable(*vehicle.value), result.notes);
  }

  // World.
  std::shared_ptr<const Terrain> terrain;
  WorldStart start;
  std::vector<std::string> files;  // that the run is made from
  if (urdf) files.push_back(urdf.value->file);
  append(*vehicle_files, files);
  if (options.world.empty()) {
    problems.push_back({"~world", "no world: set it to a shipped name or the path of a mesh or world YAML"});
  } else {
    Loaded<std::string> file = findWorld(options.world, "~world");
    append(file.problems, problems);
    if (file) {
      Loaded<WorldDescription> world = loadWorld(*file.value, packageResolver(options.package_dirs, *file.value));
      append(world.problems, problems);
      append(world.notes, result.notes);
      if (world) {
        start = world.value->start;
        if (world.value->files != std::vector<std::string>{*file.value}) files.push_back(*file.value);
        append(world.value->files, files);
        Loaded<Terrain> built = Terrain::build(std::move(world.value->soup));
        append(built.problems, problems);
        append(built.notes, result.notes);
        if (built) terrain = std::make_shared<const Terrain>(std::move(*built.value));
      }
    }
  }
  if (options.start.size() == 3) start = {options.start[0], options.start[1], options.start[2]};
  if (vehicle && !options.base_frame.empty() && options.base_frame != vehicle.value->root) {
    problems.push_back(
        {"~base_frame", "'" + options.base_frame + "' is not the root link '" + vehicle.value->root +
                            "' of the URDF: tf would give a link two parents; leave it out, or name the root"});
  }
  if (!parameters || !vehicle || !terrain) return result;

  // Simulator.
  Loaded<Simulator> simulator = Simulator::create(*vehicle.value, terrain, config);
  append(simulator.problems, problems);
  append(simulator.notes, result.notes);
  if (simulator) append(simulator.value->setDown(start.x, start.y, start.yaw), problems);
  if (!problems.empty()) return result;

  append(simulator.value->loadReport(), result.notes);
  std::optional<RunRecorder> recorder = openRecord(options, std::move(files), *simulator.value, problems);
  if (!problems.empty()) return result;
  result.value.emplace(NodeSetup{options, terrain, std::move(*simulator.value), vehicle.value->root,
                                 vehicleLength(*vehicle.value), drawn_links, result.notes, std::move(recorder)});
  return result;
}

void logProblems(const Problems& problems) {
  for (const Problem& problem : problems) ROS_ERROR("%s", problem.text().c_str());
  ROS_ERROR("%zu problem%s, not started", problems.size(), problems.size() == 1 ? "" : "s");
}

}  // namespace ellipsoid_vehicle_sim
