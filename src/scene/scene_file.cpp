#include <algorithm>
#include <cmath>
#include <filesystem>

#include "ellipsoid_vehicle_sim/description/number_text.h"
#include "ellipsoid_vehicle_sim/description/parameter_file.h"
#include "ellipsoid_vehicle_sim/description/shapes_to_ellipsoids.h"
#include "ellipsoid_vehicle_sim/description/shipped_files.h"
#include "ellipsoid_vehicle_sim/description/yaml_reader.h"
#include "ellipsoid_vehicle_sim/scene/scene.h"

namespace ellipsoid_vehicle_sim {
namespace {

namespace fs = std::filesystem;

const NumberRange kPlace{0.0, 1e9, "between -1e9 and 1e9"};
const NumberRange kVelocity{0.0, 1e5, "between -1e5 and 1e5"};
const NumberRange kSpeed{0.0, 500.0, "between -500 and 500"};
const NumberRange kAngle{0.0, M_PI, "between -pi and pi"};
const NumberRange kRate{0.0, 100.0, "between -100 and 100"};
const NumberRange kTime{0.0, 1e6, "between 0 and 1e6"};
const NumberRange kDuration{1e-6, 1e6, "between 1e-6 and 1e6"};
const NumberRange kLength{1e-6, 1e6, "between 1e-6 and 1e6"};

const std::vector<std::pair<std::string, ClosedForm>> kClosedForms = {
    {"bounce", ClosedForm::kBounce}, {"torque_free", ClosedForm::kTorqueFree}, {"roll_down", ClosedForm::kRollDown},
    {"slide", ClosedForm::kSlide},   {"circle", ClosedForm::kCircle},          {"stop", ClosedForm::kStop},
    {"rest", ClosedForm::kRest}};

/// What VEHICLE.yaml and a scene may say of the vehicle besides the physics.
const std::vector<std::string> kVehicleKeys = {"package_dirs", "drive_joints", "joint_roles"};

class SceneReader : private YamlReader {
 public:
  SceneReader(const std::string& path, const std::string& share) : YamlReader(path), share_(share) {}

  Loaded<Scene> read() {
    place();
    if (const std::optional<YAML::Node> root = open("scene")) readRoot(*root);
    return finish();
  }

  /// Of a vehicle, whose path the reader was given, and a world.
  Loaded<Scene> readVehicle(const std::string& world) {
    place();
    scene_.vehicle = scene_.file;
    scene_.world = fs::absolute(world).string();
    readVehicleFile();
    for (const Problem& p : scene_.config.validate()) problems.push_back({path(), p.where + " " + p.message});
    return finish();
  }

 private:
  void place() {
    scene_.file = fs::absolute(path()).string();
    scene_.name = fs::path(path()).stem().string();
    folder_ = fs::path(scene_.file).parent_path().string();
  }

  Loaded<Scene> finish() {
    Loaded<Scene> result;
    result.problems = std::move(problems);
    result.notes = std::move(notes_);
    if (result.problems.empty()) result.value = std::move(scene_);
    return result;
  }

  void readRoot(const YAML::Node& root) {
    if (!root.IsMap()) return problem(root, "a scene is a dictionary with the keys vehicle, world and duration");
    const std::vector<std::string> keys = {"description", "vehicle", "world",       "package_dirs", "drive_joints",
                                           "joint_roles", "start",   "commands",    "duration",     "horizon",
                                           "length",      "measure", "closed_form", "parameters",   "headings",     "forward",
                                           "repair_inertia", "body_ellipsoids"};
    YAML::Node parameters;
    std::optional<double> horizon;
    YAML::Node horizon_node;
    forEachKey(root, keys, [&](const std::string& key, const YAML::Node& value) {
      if (key == "description") scene_.description = text(value, key);
      if (key == "vehicle") scene_.vehicle = find(value, key, shippedVehicles(share_));
      if (key == "world") scene_.world = find(value, key, shippedWorlds(share_));
      if (key == "package_dirs") readTexts(value, key, scene_.package_dirs);
      if (key == "drive_joints") readTexts(value, key, scene_.drive_joints);
      if (key == "joint_roles") readTexts(value, key, scene_.joint_roles);
      if (key == "forward") scene_.forward = text(value, key);
      if (key == "repair_inertia") scene_.repair_inertia = flag(value, key).value_or(false);
      if (key == "body_ellipsoids") {
        given_body_ellipsoids_ = true;
        readWhole(value, key, kMostBodyEllipsoids, scene_.body_ellipsoids);
      }
      if (key == "start") readStart(value);
      if (key == "commands") readCommands(value);
      if (key == "duration") scene_.duration = number(value, key, kDuration, false).value_or(0.0);
      if (key == "length") scene_.length = number(value, key, kLength, false);
      if (key == "headings") readHeadings(value);
      if (key == "measure") readMeasures(value);
      if (key == "closed_form") readClosedForm(value);
      if (key == "parameters") parameters = value;
      if (key == "horizon") {
        horizon = number(value, key, kDuration, false);
        horizon_node = value;
      }
    });
    for (const char* key : {"vehicle", "world", "duration"})
      if (!root[key]) problem(root, std::string("no '") + key + "'");
    for (std::string& folder : scene_.package_dirs) folder = (fs::path(folder_) / folder).string();

    scene_.horizon = horizon.value_or(scene_.duration);
    if (horizon && scene_.duration > 0.0 && *horizon > scene_.duration)
      problem(horizon_node, "'horizon' is " + numberText(*horizon) +
                                ", after the end; allowed is up to duration = " + numberText(scene_.duration));
    if (scene_.headings > 1 && !scene_.start.set_down)
      problem(root["headings"], "'headings' with a position; only a set-down can be turned");
    for (std::size_t i = 0; i < command_lines_.size(); ++i)
      if (scene_.duration > 0.0 && scene_.commands[i].time >= scene_.duration)
        problems.push_back(
            {command_lines_[i], "'at' is " + numberText(scene_.commands[i].time) +
                                    ", after the end; allowed is below duration = " + numberText(scene_.duration)});
    readVehicleFile();
    if (parameters && !parameters.IsNull()) readParameters(parameters);
    for (const Problem& p : scene_.config.validate()) problems.push_back({path(), p.where + " " + p.message});
  }

  std::string find(const YAML::Node& value, const std::string& key, const ShippedNames& names) {
    const std::string name = text(value, key);
    if (name.empty()) return {};
    const Loaded<std::string> found = findShipped(names, key, name, where(value), folder_);
    problems.insert(problems.end(), found.problems.begin(), found.problems.end());
    return found.value.value_or("");
  }

  void readTexts(const YAML::Node& value, const std::string& key, std::vector<std::string>& texts) {
    const std::optional<ParameterValue> list = parameterValue(value);
    if (list && std::holds_alternative<std::vector<std::string>>(*list)) {
      texts = std::get<std::vector<std::string>>(*list);
    } else {
      problem(value, "'" + key + "' is not a list of texts");
    }
  }

  void readStart(const YAML::Node& node) {
    if (!node.IsMap()) return problem(node, "'start' is a dictionary with set_down, or with position");
    scene_.start_given = true;
    SceneStart& start = scene_.start;
    bool placed = false, set_down = false;
    forEachKey(node, {"set_down", "position", "rotation", "velocity", "angular_velocity"},
               [&](const std::string& key, const YAML::Node& value) {
                 if (key == "set_down") {
                   set_down = true;
                   if (const auto v = numbers(value, key, 3, kPlace, "[x, y, yaw]")) {
                     start.x = (*v)[0];
                     start.y = (*v)[1];
                     start.yaw = (*v)[2];
                   }
                   return;
                 }
                 placed = true;
                 const auto v = numbers(value, key, 3, key == "position" || key == "rotation" ? kPlace : kVelocity,
                                        key == "rotation" ? "[roll, pitch, yaw]" : "[x, y, z]");
                 if (!v) return;
                 const Eigen::Vector3d vector((*v)[0], (*v)[1], (*v)[2]);
                 if (key == "position") start.X_WR.p = vector;
                 if (key == "rotation") start.X_WR.q = quaternionFromRpy(vector.x(), vector.y(), vector.z());
                 if (key == "velocity") start.v_WR_W = vector;
                 if (key == "angular_velocity") start.w_WR_W = vector;
               });
    if (placed && set_down) problem(node, "'set_down' together with a position or velocity; give one of them");
    if (placed && !node["position"]) problem(node, "a start that is not set down needs a 'position'");
    start.set_down = !placed;
  }

  void readCommands(const YAML::Node& node) {
    if (!node.IsSequence()) return problem(node, "'commands' is a list of {at: TIME, speed: ..., ...}");
    for (const YAML::Node& item : node) {
      if (!item.IsMap()) {
        problem(item, "a command is a dictionary with the key at");
        continue;
      }
      SceneCommand entry;
      bool coast = false;
      forEachKey(item, {"at", "speed", "yaw_rate", "steering_angle", "coast"},
                 [&](const std::string& key, const YAML::Node& value) {
                   DriveCommand& c = entry.command;
                   if (key == "at") entry.time = number(value, key, kTime, false).value_or(0.0);
                   if (key == "speed") c.speed = number(value, key, kSpeed, true).value_or(0.0);
                   if (key == "yaw_rate") c.yaw_rate = number(value, key, kRate, true).value_or(0.0);
                   if (key == "steering_angle") {
                     c.kind = DriveCommand::Kind::kAckermann;
                     c.steering_angle = number(value, key, kAngle, true).value_or(0.0);
                   }
                   if (key == "coast") coast = flag(value, key).value_or(false);
                 });
      if (!item["at"]) problem(item, "a command without 'at', its time");
      if (item["yaw_rate"] && item["steering_angle"]) problem(item, "'yaw_rate' together with 'steering_angle'");
      if (coast && (item["speed"] || item["yaw_rate"] || item["steering_angle"]))
        problem(item, "'coast' together with a speed or a curve");
      if (coast) entry.command.kind = DriveCommand::Kind::kCoast;
      if (!scene_.commands.empty() && entry.time <= scene_.commands.back().time && item["at"])
        problem(item, "'at' is " + numberText(entry.time) + ", not after the command before it at " +
                          numberText(scene_.commands.back().time));
      scene_.commands.push_back(entry);
      command_lines_.push_back(where(item));
    }
  }

  void readHeadings(const YAML::Node& value) { readWhole(value, "headings", 360, scene_.headings); }

  void readWhole(const YAML::Node& value, const std::string& key, int most, int& number_of) {
    const std::string allowed = "a whole number from 1 to " + std::to_string(most);
    const auto n = number(value, key, {1.0, static_cast<double>(most), allowed.c_str()}, false);
    if (n && *n != std::floor(*n))
      return problem(value, "'" + key + "' is " + numberText(*n) + "; allowed is " + allowed);
    number_of = static_cast<int>(n.value_or(1.0));
  }

  void readMeasures(const YAML::Node& node) {
    if (!node.IsSequence()) return problem(node, "'measure' is a list");
    for (const YAML::Node& item : node) {
      const std::string name = text(item, "measure");
      if (name == "energy") {
        scene_.measures.energy = true;
      } else if (name == "momentum") {
        scene_.measures.momentum = true;
      } else if (name == "contact_quality") {
        scene_.measures.contact_quality = true;
      } else if (name == "creep") {
        scene_.measures.creep = true;
      } else if (!name.empty()) {
        problem(item, "unknown measure '" + name + "'; known are energy, momentum, contact_quality, creep");
      }
    }
  }

  void readClosedForm(const YAML::Node& node) {
    const std::string name = text(node, "closed_form");
    std::string known;
    for (const auto& [word, form] : kClosedForms) {
      if (word == name) scene_.measures.closed_form = form;
      known += (known.empty() ? "" : ", ") + word;
    }
    if (scene_.measures.closed_form == ClosedForm::kNone && !name.empty())
      problem(node, "unknown closed form '" + name + "'; known are " + known);
  }

  /// VEHICLE.yaml beside the vehicle: what is special to it. What belongs to the node is left to the node, and told.
  void readVehicleFile() {
    if (scene_.vehicle.empty()) return;
    const fs::path beside = fs::path(scene_.vehicle).replace_extension(".yaml");
    std::error_code error;
    if (!fs::is_regular_file(beside, error)) return;
    Loaded<ParameterValues> values = readParameterFile(beside.string());
    problems.insert(problems.end(), values.problems.begin(), values.problems.end());
    if (!values) return;
    notes_.push_back("parameters of this vehicle are taken from " + beside.string());
    const Problems refused =
        takeParameters(simConfigParameters(), beside.filename().string() + " ", *values.value, scene_.config);
    problems.insert(problems.end(), refused.begin(), refused.end());
    const std::vector<std::vector<std::string>*> lists = {&scene_.package_dirs, &scene_.drive_joints,
                                                          &scene_.joint_roles};
    for (std::size_t i = 0; i < lists.size(); ++i) {
      const auto found = values.value->find(kVehicleKeys[i]);
      if (found == values.value->end()) continue;
      if (const auto* texts = std::get_if<std::vector<std::string>>(&found->second)) {
        if (lists[i]->empty()) *lists[i] = *texts;
      } else {
        problems.push_back({beside.string() + " " + kVehicleKeys[i], "is not a list of texts"});
      }
      values.value->erase(found);
    }
    if (const auto found = values.value->find("forward"); found != values.value->end()) {
      const auto* word = std::get_if<std::string>(&found->second);
      if (!word) problems.push_back({beside.string() + " forward", "is no text"});
      if (word && scene_.forward == "auto") scene_.forward = *word;
      values.value->erase(found);
    }
    if (const auto found = values.value->find("repair_inertia"); found != values.value->end()) {
      const auto* repair = std::get_if<bool>(&found->second);
      if (!repair) problems.push_back({beside.string() + " repair_inertia", "is neither true nor false"});
      if (repair) scene_.repair_inertia = scene_.repair_inertia || *repair;
      values.value->erase(found);
    }
    if (const auto found = values.value->find("body_ellipsoids"); found != values.value->end()) {
      const auto* count = std::get_if<std::int64_t>(&found->second);
      if (!count || *count < 1 || *count > kMostBodyEllipsoids) {
        problems.push_back({beside.string() + " body_ellipsoids",
                            "is no whole number from 1 to " + std::to_string(kMostBodyEllipsoids)});
      } else if (!given_body_ellipsoids_) {
        scene_.body_ellipsoids = static_cast<int>(*count);
      }
      values.value->erase(found);
    }
    for (const auto& left : *values.value)
      notes_.push_back(beside.string() + ": '" + left.first +
                       "' is no parameter of the physics and has no meaning here");
  }

  void readParameters(const YAML::Node& node) {
    if (!node.IsMap()) return problem(node, "'parameters' is a dictionary");
    const auto table = simConfigParameters();
    forEachKey(node, parameterKeys(table), [&](const std::string& key, const YAML::Node& value) {
      const std::optional<ParameterValue> parsed = parameterValue(value);
      if (!parsed) return problem(value, "'" + key + "' is empty, a dictionary or a mixed list, which no parameter is");
      ParameterValues one = {{key, *parsed}};
      const Problems refused = takeParameters(table, where(value) + " ", one, scene_.config);
      problems.insert(problems.end(), refused.begin(), refused.end());
    });
  }

  const std::string& share_;
  std::string folder_;
  bool given_body_ellipsoids_ = false;
  Scene scene_;
  std::vector<std::string> command_lines_, notes_;
};

}  // namespace

Loaded<Scene> loadScene(const std::string& path, const std::string& share) { return SceneReader(path, share).read(); }

Loaded<Scene> sceneOf(const std::string& vehicle, const std::string& world, const std::string& share) {
  return SceneReader(vehicle, share).readVehicle(world);
}

Problems overrideParameter(Scene& scene, const std::string& key, const std::string& yaml_value,
                           const std::string& where) {
  const auto table = simConfigParameters();
  const Loaded<YAML::Node> parsed = parseYaml(yaml_value, where + key);
  if (!parsed) return {{where + key, "'" + yaml_value + "' is no YAML value: " + parsed.problems.front().message}};
  const std::optional<ParameterValue> value = parameterValue(*parsed.value);
  if (!value) return {{where + key, "'" + yaml_value + "' is nothing a parameter can be"}};
  ParameterValues one = {{key, *value}};
  Problems problems = takeParameters(table, where, one, scene.config);
  for (const Problem& p : unknownParameters(one, parameterKeys(table), where)) problems.push_back(p);
  return problems;
}

}  // namespace ellipsoid_vehicle_sim
