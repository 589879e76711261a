#include "ellipsoid_vehicle_sim/ros/node_setup.h"

#include <ros/console.h>
#include <ros/master.h>
#include <ros/network.h>
#include <ros/param.h>
#include <ros/this_node.h>
#include <xmlrpcpp/XmlRpcClient.h>

#include <algorithm>

#include "ellipsoid_vehicle_sim/ros/resources.h"

namespace ellipsoid_vehicle_sim {
namespace {

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

/// The world and where vehicles start in it; nothing where there are problems.
struct World {
  std::shared_ptr<const Terrain> terrain;
  WorldStart start;
  std::vector<std::string> files;
};

World readWorld(const NodeOptions& options, Problems& problems, std::vector<std::string>& notes) {
  World result;
  if (options.world.empty()) {
    problems.push_back({"~world", "no world: set it to a shipped name or the path of a mesh or world YAML"});
    return result;
  }
  Loaded<std::string> file = findWorld(options.world, "~world");
  append(file.problems, problems);
  if (!file) return result;
  Loaded<WorldDescription> world = loadWorld(*file.value, packageResolver(options.package_dirs, *file.value));
  append(world.problems, problems);
  append(world.notes, notes);
  if (!world) return result;
  result.start = world.value->start;
  if (world.value->files != std::vector<std::string>{*file.value}) result.files.push_back(*file.value);
  append(world.value->files, result.files);
  Loaded<Terrain> built = Terrain::build(std::move(world.value->soup));
  append(built.problems, problems);
  append(built.notes, notes);
  if (built) result.terrain = std::make_shared<const Terrain>(std::move(*built.value));
  return result;
}

/// The vehicles that are asked for; one without a name where none is named.
std::vector<VehicleRequest> requests(const ros::NodeHandle& nh_priv, const ParameterValues& common, Problems& problems) {
  std::vector<VehicleRequest> result;
  std::vector<std::string> names;
  const auto found = common.find("vehicles");
  if (found == common.end()) {
    result.emplace_back();
    result.back().sources = {{"~", common}};
    return result;
  }
  // A word alone is what a list of one becomes in a launch file.
  if (const auto* list = std::get_if<std::vector<std::string>>(&found->second)) names = *list;
  if (const auto* word = std::get_if<std::string>(&found->second)) names = {*word};
  if (names.empty()) problems.push_back({"~vehicles", "is no list of names, such as [red, blue]"});
  std::vector<std::string> taken;
  for (const std::string& name : names) {
    if (const std::string refusal = nameRefusal(name, taken); !refusal.empty()) {
      problems.push_back({"~vehicles", "'" + name + "' " + refusal});
      continue;
    }
    taken.push_back(name);
    result.emplace_back();
    result.back().name = name;
    result.back().sources = {{"~", common}};
    Loaded<ParameterValues> own = readParameterServer(nh_priv, name);
    append(own.problems, problems);
    if (own) result.back().sources.push_back({"~" + name + "/", std::move(*own.value)});
  }
  return result;
}

}  // namespace

Loaded<NodeSetup> loadSetup(const ros::NodeHandle& nh, const ros::NodeHandle& nh_priv) {
  Loaded<NodeSetup> result;
  Problems& problems = result.problems;
  Loaded<ParameterValues> server = readParameterServer(nh_priv);
  append(server.problems, problems);
  ParameterValues common;
  if (server) {
    common = *server.value;
  } else {
    for (const char* key : {"vehicle_file", "world"})
      if (std::string text; nh_priv.getParam(key, text)) common[key] = text;
  }
  const std::vector<VehicleRequest> wanted = requests(nh_priv, common, problems);

  std::vector<DescribedVehicle> described;
  for (const VehicleRequest& request : wanted) {
    const ros::NodeHandle own = request.name.empty() ? nh : ros::NodeHandle(nh, request.name);
    described.push_back(describeVehicle(own, request, problems, result.notes));
  }
  if (described.empty()) return result;
  const NodeOptions& options = described.front().parameters.options;
  // What is wrong with a common parameter is so for each vehicle.
  for (auto i = problems.begin(); i != problems.end();)
    i = std::any_of(problems.begin(), i, [&i](const Problem& p) { return p.text() == i->text(); }) ? problems.erase(i) : i + 1;
  if (described.front().sound_parameters) append(checkClock(options.clock), problems);
  World world = readWorld(options, problems, result.notes);
  if (!world.terrain) return result;

  Fleet fleet(static_cast<int>(options.threads));
  std::vector<VehicleSetup> vehicles;
  for (std::size_t i = 0; i < described.size(); ++i) {
    if (!described[i].complete) continue;
    std::optional<VehicleSetup> vehicle =
        setUpVehicle(wanted[i], std::move(described[i]), world.terrain, world.start, problems, result.notes);
    if (vehicle) vehicles.push_back(std::move(*vehicle));
  }
  for (VehicleSetup& vehicle : vehicles) {
    const Problems refused = addToFleet(vehicle, fleet);
    append(refused, problems);
  }
  if (!problems.empty()) return result;
  NodeSetup setup{options, world.terrain, world.start, std::move(world.files), common, std::move(fleet), {}, {}, {}};
  for (VehicleSetup& vehicle : vehicles) {
    const int place = setup.fleet.find(fleetName(vehicle.name));
    setup.recorders.push_back(
        openRecord(vehicle, setup.fleet.vehicle(static_cast<std::size_t>(place)), setup.world_files, problems));
  }
  if (!problems.empty()) return result;
  setup.vehicles = std::move(vehicles);
  setup.options = setup.vehicles.front().options;
  setup.notes = result.notes;
  result.value.emplace(std::move(setup));
  return result;
}

std::string fleetName(const std::string& name) { return name.empty() ? "vehicle" : name; }

Problems addToFleet(VehicleSetup& vehicle, Fleet& fleet) {
  Problems problems = fleet.add(fleetName(vehicle.name), std::move(vehicle.simulator));
  if (!problems.empty()) return problems;
  const std::size_t place = fleet.size() - 1;
  problems = fleet.setDown(place, vehicle.start.x, vehicle.start.y, vehicle.start.yaw);
  if (!problems.empty()) fleet.remove(fleetName(vehicle.name));
  return problems;
}

void logProblems(const Problems& problems) {
  for (const Problem& problem : problems) ROS_ERROR("%s", problem.text().c_str());
  ROS_ERROR("%zu problem%s, not started", problems.size(), problems.size() == 1 ? "" : "s");
}

}  // namespace ellipsoid_vehicle_sim
