#include "ellipsoid_vehicle_sim/ros/vehicle_setup.h"

#include <ros/names.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "ellipsoid_vehicle_sim/description/joint_roles.h"
#include "ellipsoid_vehicle_sim/description/parameter_file.h"
#include "ellipsoid_vehicle_sim/description/urdf_loader.h"
#include "ellipsoid_vehicle_sim/description/urdf_text.h"
#include "ellipsoid_vehicle_sim/description/xacro.h"
#include "ellipsoid_vehicle_sim/ros/resources.h"

namespace ellipsoid_vehicle_sim {
namespace {

namespace fs = std::filesystem;

/// The URDF as text: robot_description where it exists, otherwise the file, which then becomes robot_description.
struct UrdfSource {
  std::string text;
  std::string file;  ///< for messages and as the place of its meshes.
};

Loaded<UrdfSource> findUrdf(const ros::NodeHandle& nh, const NodeOptions& options, const std::string& where,
                            const std::string& given) {
  Loaded<UrdfSource> result;
  UrdfSource source;
  std::string key = "robot_description", description = given;
  // A vehicle among several has its own; that of the name spaces above is another's.
  bool has_description = !given.empty() || (options.named ? nh.getParam(key, description)
                                                          : nh.searchParam("robot_description", key) && nh.getParam(key, description));
  if (!given.empty()) key = "the request";

  if (options.vehicle_file.empty()) {
    if (!has_description) {
      result.problems.push_back({where + "vehicle_file",
                                 "no vehicle: set it to a shipped name or the path of a URDF, or load a "
                                 "URDF into robot_description"});
      return result;
    }
    source = {description, given.empty() ? "robot_description" : "the request's URDF"};
  } else {
    Loaded<std::string> file = findVehicle(options.vehicle_file, where + "vehicle_file");
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
    }
  }
  // For robot_state_publisher, RViz and whoever else wants to know the robot.
  if (!has_description || !given.empty()) nh.setParam("robot_description", source.text);
  result.value = std::move(source);
  return result;
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

/// What is the node's as a whole cannot be a vehicle's.
void checkOwnKeys(const VehicleRequest& request, Problems& problems) {
  if (request.name.empty()) return;
  // The common ones come first.
  for (std::size_t i = 0; i < request.sources.size(); ++i) {
    if (request.sources[i].where == "~") continue;
    for (const std::string& key : nodeWideKeys())
      if (request.sources[i].values.count(key) > 0)
        problems.push_back({request.sources[i].where + key, "is one for the whole node: set ~" + key});
  }
}

}  // namespace

void append(const Problems& more, Problems& problems) { problems.insert(problems.end(), more.begin(), more.end()); }

void append(const std::vector<std::string>& more, std::vector<std::string>& notes) {
  notes.insert(notes.end(), more.begin(), more.end());
}

std::string parametersOf(const std::string& name) { return name.empty() ? "~" : "~" + name + "/"; }

std::string nameRefusal(const std::string& name, const std::vector<std::string>& taken) {
  std::string why;
  if (name.empty()) return "is empty";
  if (name.find('/') != std::string::npos || name.front() == '~' || !ros::names::validate(name, why))
    return "is no name of ROS: letters, digits and '_', a letter first";
  if (std::find(taken.begin(), taken.end(), name) != taken.end()) return "is taken already";
  std::vector<std::string> reserved = {"reset", "pause", "resume", "step", "set_pose", "save_state", "restore_state",
                                       "explain_contact", "state_hash", "spawn", "remove", "set_parameters"};
  for (const auto& row : nodeParameters()) reserved.push_back(row.spec.key);
  for (const auto& row : simConfigParameters()) reserved.push_back(row.spec.key);
  if (std::find(reserved.begin(), reserved.end(), name) != reserved.end())
    return "is the name of a parameter or service of the node";
  return "";
}

void addParametersBeside(const std::string& vehicle_file, std::vector<ParameterSource>& sources, Problems& problems,
                         std::vector<std::string>& notes) {
  // A vehicle that is not found is reported where it is loaded.
  const Loaded<std::string> file = findVehicle(vehicle_file, "");
  if (!file) return;
  const fs::path beside = fs::path(*file.value).replace_extension(".yaml");
  std::error_code error;
  if (!fs::is_regular_file(beside, error)) return;
  Loaded<ParameterValues> values = readParameterFile(beside.string());
  append(values.problems, problems);
  if (values) sources.insert(sources.begin(), {beside.filename().string() + " ", std::move(*values.value)});
  notes.push_back("parameters of this vehicle are taken from " + beside.string());
}

DescribedVehicle describeVehicle(const ros::NodeHandle& nh, VehicleRequest request, Problems& problems,
                                 std::vector<std::string>& notes) {
  DescribedVehicle result;
  const std::string where = parametersOf(request.name);
  const std::size_t before = problems.size();
  std::string vehicle_file, world;
  for (const ParameterSource& source : request.sources)
    for (const auto& [key, text] : {std::make_pair("vehicle_file", &vehicle_file), std::make_pair("world", &world)})
      if (const auto found = source.values.find(key);
          found != source.values.end() && std::holds_alternative<std::string>(found->second))
        *text = std::get<std::string>(found->second);
  checkOwnKeys(request, problems);
  if (!vehicle_file.empty()) addParametersBeside(vehicle_file, request.sources, problems, notes);
  Loaded<NodeParameters> parameters =
      parametersFrom(std::move(request.sources), request.name.empty() ? NodeOptions{} : optionsOfNamed(request.name));
  append(parameters.problems, problems);
  append(parameters.notes, notes);
  // Go on with the defaults where a parameter was refused: the files may hold problems of their own.
  NodeOptions& options = result.parameters.options;
  if (parameters) {
    result.parameters = std::move(*parameters.value);
  } else {
    options.named = !request.name.empty();
    options.vehicle_file = vehicle_file;
    options.world = world;
  }
  const bool sound = result.sound_parameters = problems.size() == before;

  Loaded<UrdfSource> urdf = findUrdf(nh, options, where, request.urdf);
  append(urdf.problems, problems);
  append(urdf.notes, notes);
  if (!urdf) return result;
  UrdfOptions urdf_options;
  urdf_options.drive_joints = options.drive_joints;
  urdf_options.roles = rolesFromWords(options.joint_roles, where + "joint_roles", problems);
  urdf_options.forward_yaw = forwardFromWord(options.forward, where + "forward", problems);
  urdf_options.repair_inertia = options.repair_inertia;
  if (options.body_ellipsoids != std::floor(options.body_ellipsoids))
    problems.push_back({where + "body_ellipsoids", "is " + std::to_string(options.body_ellipsoids) + "; allowed is a whole number"});
  urdf_options.body_ellipsoids = static_cast<int>(options.body_ellipsoids);
  const UriResolver resolver = packageResolver(options.package_dirs, urdf.value->file);
  const auto vehicle_files = std::make_shared<std::vector<std::string>>();
  Loaded<VehicleDescription> vehicle =
      loadUrdfText(urdf.value->text, urdf.value->file, recordingResolver(resolver, vehicle_files), urdf_options);
  result.drawn_links = drawnLinks(*urdf.value, resolver);
  append(vehicle.problems, problems);
  append(vehicle.notes, notes);
  result.urdf = urdf.value->text;
  result.files.push_back(urdf.value->file);
  append(*vehicle_files, result.files);
  if (!vehicle) return result;
  append(jointTable(*vehicle.value), notes);
  if (!options.base_frame.empty() && options.base_frame != vehicle.value->root)
    problems.push_back(
        {where + "base_frame", "'" + options.base_frame + "' is not the root link '" + vehicle.value->root +
                                   "' of the URDF: tf would give a link two parents; leave it out, or name the root"});
  append(checkMounts(options.lidars, *vehicle.value), problems);
  for (const NamedLidar& lidar : options.lidars) notes.push_back(lidarReport(lidar, *vehicle.value));
  result.description = std::move(*vehicle.value);
  result.complete = sound;
  return result;
}

std::optional<VehicleSetup> setUpVehicle(const VehicleRequest& request, DescribedVehicle described,
                                         std::shared_ptr<const Terrain> terrain, const WorldStart& world_start,
                                         Problems& problems, std::vector<std::string>& notes) {
  Loaded<Simulator> simulator = Simulator::create(*described.description, std::move(terrain), described.parameters.config);
  append(simulator.problems, problems);
  append(simulator.notes, notes);
  if (!simulator) return std::nullopt;
  append(simulator.value->loadReport(), notes);
  NodeOptions& options = described.parameters.options;
  WorldStart start = world_start;
  if (options.start.size() == 3) start = {options.start[0], options.start[1], options.start[2]};
  if (request.start) start = *request.start;
  options.odom_frame = options.tf_prefix + options.odom_frame;
  return VehicleSetup{request.name,
                      options,
                      std::move(*simulator.value),
                      start,
                      options.tf_prefix + described.description->root,
                      vehicleLength(*described.description),
                      std::move(described.drawn_links),
                      std::move(described.files)};
}

std::optional<RunRecorder> openRecord(const VehicleSetup& setup, const Simulator& simulator,
                                      const std::vector<std::string>& world_files, Problems& problems) {
  const NodeOptions& options = setup.options;
  std::vector<std::string> files = setup.files;
  append(world_files, files);
  if (options.record_folder.empty()) return std::nullopt;
  const std::string folder =
      setup.name.empty() ? options.record_folder : (fs::path(options.record_folder) / setup.name).string();
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
  Loaded<RunRecorder> recorder = RunRecorder::create(folder, every, std::move(manifest), simulator);
  append(recorder.problems, problems);
  if (!recorder) return std::nullopt;
  return std::move(*recorder.value);
}

}  // namespace ellipsoid_vehicle_sim
