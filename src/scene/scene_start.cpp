#include <algorithm>
#include <cmath>

#include "ellipsoid_vehicle_sim/description/joint_roles.h"
#include "ellipsoid_vehicle_sim/description/shipped_files.h"
#include "ellipsoid_vehicle_sim/description/urdf_loader.h"
#include "ellipsoid_vehicle_sim/description/world_file.h"
#include "ellipsoid_vehicle_sim/scene/scene.h"

namespace ellipsoid_vehicle_sim {
namespace {

void append(const Problems& more, Problems& problems) { problems.insert(problems.end(), more.begin(), more.end()); }

void append(const std::vector<std::string>& more, std::vector<std::string>& texts) {
  texts.insert(texts.end(), more.begin(), more.end());
}

}  // namespace

Loaded<LoadedScene> loadSceneFiles(const Scene& scene, const std::string& share) {
  Loaded<LoadedScene> result;
  LoadedScene loaded;
  loaded.scene = scene;
  loaded.files = {scene.file, scene.vehicle};
  const auto found = std::make_shared<std::vector<std::string>>();

  UrdfOptions options;
  options.drive_joints = scene.drive_joints;
  options.roles = rolesFromWords(scene.joint_roles, scene.file + " joint_roles", result.problems);
  options.repair_inertia = scene.repair_inertia;
  options.body_ellipsoids = scene.body_ellipsoids;
  options.forward_yaw = forwardFromWord(scene.forward, scene.file + " forward", result.problems);
  const UriResolver vehicle_resolver = recordingResolver(shippedResolver(scene.package_dirs, scene.vehicle, share), found);
  Loaded<VehicleDescription> vehicle = loadUrdfFile(scene.vehicle, vehicle_resolver, options);
  append(vehicle.problems, result.problems);
  append(vehicle.notes, loaded.notes);
  append(*found, loaded.files);

  Loaded<WorldDescription> world = loadWorld(scene.world, shippedResolver(scene.package_dirs, scene.world, share));
  append(world.problems, result.problems);
  append(world.notes, loaded.notes);
  if (world) {
    // A mesh that is the world itself is its own only file.
    if (world.value->files != std::vector<std::string>{scene.world}) loaded.files.push_back(scene.world);
    append(world.value->files, loaded.files);
    if (!scene.start_given) {
      loaded.scene.start.x = world.value->start.x;
      loaded.scene.start.y = world.value->start.y;
      loaded.scene.start.yaw = world.value->start.yaw;
    }
    Loaded<Terrain> terrain = Terrain::build(std::move(world.value->soup));
    append(terrain.problems, result.problems);
    append(terrain.notes, loaded.notes);
    if (terrain) loaded.terrain = std::make_shared<const Terrain>(std::move(*terrain.value));
  }
  if (!result.problems.empty()) return result;
  loaded.vehicle = std::move(*vehicle.value);
  result.value = std::move(loaded);
  return result;
}

Loaded<Simulator> startScene(const LoadedScene& loaded, const SimConfig& config) {
  Loaded<Simulator> simulator = Simulator::create(loaded.vehicle, loaded.terrain, config);
  if (!simulator) return simulator;
  const SceneStart& start = loaded.scene.start;
  const Problems problems = start.set_down ? simulator.value->setDown(start.x, start.y, start.yaw)
                                           : simulator.value->place(start.X_WR, start.v_WR_W, start.w_WR_W);
  if (problems.empty()) return simulator;
  Loaded<Simulator> refused;
  refused.problems = problems;
  refused.notes = simulator.notes;
  return refused;
}

void commandScene(const Scene& scene, double time, double dt, Simulator& simulator) {
  const SceneCommand* in_force = nullptr;
  // A tick that begins within half a tick of the entry's time is the first to obey it.
  for (const SceneCommand& entry : scene.commands)
    if (entry.time < time + 0.5 * dt) in_force = &entry;
  if (in_force) simulator.command(in_force->command);
}

std::int64_t sceneTicks(const Scene& scene, double dt) {
  return std::max<std::int64_t>(1, std::llround(scene.duration / dt));
}

}  // namespace ellipsoid_vehicle_sim
