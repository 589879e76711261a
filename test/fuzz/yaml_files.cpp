// World, scene and parameter files.
#include "ellipsoid_vehicle_sim/description/joint_roles.h"
#include "ellipsoid_vehicle_sim/description/parameter_file.h"
#include "ellipsoid_vehicle_sim/description/world_file.h"
#include "ellipsoid_vehicle_sim/scene/scene.h"
#include "fuzz_target.h"
#include "promises.h"
#include "support/temporary_files.h"

namespace ellipsoid_vehicle_sim::fuzz {
namespace {

/// What the files may name: meshes, a vehicle and a world of the share folder. There as long as the program.
const TemporaryFiles& surroundings() {
  static const TemporaryFiles* files = [] {
    auto* made = new TemporaryFiles;
    made->write("ground.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\n");
    made->write("ground.stl",
                "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 9 0 0\nvertex 0 9 0\nendloop\nendfacet\n"
                "endsolid a\n");
    made->write("broken.obj", "v 0 0 0\nf 1 2 3\n");
    made->write("share/urdf/car.urdf", "<robot/>");
    made->write("share/launch/flat.yaml", "meshes:\n");
    return made;
  }();
  return *files;
}

}  // namespace

void fuzzWorld(const std::string& input) {
  Loaded<WorldDescription> world = loadWorld(surroundings().write("world.yaml", input));
  checkLoaded(world);
  if (!world) return;
  promise(std::isfinite(world.value->start.x + world.value->start.y + world.value->start.yaw), "a start is finite");
  for (const Surface& surface : world.value->soup.surfaces)
    promise(!surface.mu_static || (surface.mu_kinetic && *surface.mu_kinetic <= *surface.mu_static),
            "kinetic friction is not above static friction");
  checkLoaded(Terrain::build(std::move(world.value->soup)));
}

void fuzzScene(const std::string& input) {
  const std::string path = surroundings().write("scene.yaml", input);
  const Loaded<Scene> scene = loadScene(path, surroundings().folder("share"));
  checkLoaded(scene);
  if (!scene) return;
  const Scene& s = *scene.value;
  promise(s.config.validate().empty(), "the parameters of a scene are in range");
  promise(std::isfinite(s.duration) && s.duration > 0.0 && s.horizon <= s.duration, "a duration is one");
  promise(sceneTicks(s, s.config.dt) >= 1, "a scene takes at least a tick");
  promise(s.start.X_WR.p.allFinite() && s.start.X_WR.q.coeffs().allFinite() && s.start.v_WR_W.allFinite() &&
              s.start.w_WR_W.allFinite(),
          "a start is finite");
  for (const SceneCommand& c : s.commands)
    promise(std::isfinite(c.time + c.command.speed + c.command.yaw_rate + c.command.steering_angle), "a command is finite");
  Problems problems;
  rolesFromWords(s.joint_roles, "scene joint_roles", problems);
  forwardFromWord(s.forward, "scene forward", problems);
  checkProblems(problems);
}

void fuzzParameters(const std::string& input) {
  const std::string path = surroundings().write("parameters.yaml", input);
  Loaded<ParameterValues> values = readParameterFile(path);
  checkLoaded(values);
  if (values) {
    static const auto table = simConfigParameters();
    SimConfig config;
    const Problems refused = takeParameters(table, "parameters.yaml ", *values.value, config);
    checkProblems(refused);
    checkProblems(unknownParameters(*values.value, parameterKeys(table), "parameters.yaml "));
    checkProblems(config.validate());
    for (const auto& row : table) {
      const std::optional<ParameterValue> value = row.get(config);
      if (value) promise(!refusal(row.spec, *value), "what was taken for " + row.spec.key + " is in range");
    }
  }
  // As a command line gives it: KEY=VALUE.
  const std::size_t equals = input.find('=');
  if (equals == std::string::npos) return;
  Scene scene;
  checkProblems(overrideParameter(scene, input.substr(0, equals), input.substr(equals + 1), "--set "));
}

}  // namespace ellipsoid_vehicle_sim::fuzz
