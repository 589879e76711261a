// URDF texts, and the vehicles that come of them: on flat ground, driven for a moment.
#include <stdlib.h>
#include <sys/stat.h>

#include "ellipsoid_vehicle_sim/description/joint_roles.h"
#include "ellipsoid_vehicle_sim/description/urdf_loader.h"
#include "fuzz_target.h"
#include "promises.h"
#include "support/temporary_files.h"

namespace ellipsoid_vehicle_sim::fuzz {
namespace {

/// Every mesh that is asked for is a brick.
Loaded<std::vector<Eigen::Vector3d>> brick(const std::string&) {
  Loaded<std::vector<Eigen::Vector3d>> result;
  result.value = cubeSoup().vertices;
  return result;
}

UrdfOptions options() {
  UrdfOptions options;
  options.read_mesh = brick;
  return options;
}

std::optional<std::string> anyStl(const std::string& uri) {
  if (uri.size() > 4 && uri.compare(uri.size() - 4, 4, ".stl") == 0) return uri;
  return std::nullopt;
}

void check(const std::string& input, const Loaded<VehicleDescription>& vehicle) {
  checkLoaded(vehicle);
  if (!vehicle) return;
  promise(vehicle.value->joints.size() + 1 == vehicle.value->links.size(), "links and joints are a tree");
  jointTable(*vehicle.value);
  for (const LinkDescription& link : vehicle.value->links) {
    promise(std::isfinite(link.mass) && link.mass >= 0.0 && link.I_cm_L.allFinite() && link.p_Lcm.allFinite(),
            "a link's mass is finite");
    for (const EllipsoidDescription& e : link.ellipsoids)
      promise(e.radii.allFinite() && e.radii.minCoeff() > 0.0 && e.X_LE.p.allFinite() && e.X_LE.q.coeffs().allFinite(),
              "an ellipsoid is finite and has a size");
  }
  // Compiling a vehicle costs ten times as much as reading it: one in eight, and none of a hundred joints, is enough.
  if (vehicle.value->joints.size() > 20 || std::hash<std::string>()(input) % 8 != 0) return;
  SimConfig config;
  config.allow_no_wheels = true;
  Loaded<Simulator> simulator = Simulator::create(*vehicle.value, flatGround(), config);
  checkLoaded(simulator);
  if (!simulator) return;
  const Problems problems = simulator.value->setDown(0.0, 0.0, 0.0);
  checkProblems(problems);
  if (!problems.empty()) checkProblems(simulator.value->place({}, Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ()));
  DriveCommand command;
  command.speed = 1.0;
  command.yaw_rate = 0.3;
  simulator.value->command(command);
  for (int i = 0; i < 5; ++i) simulator.value->step();
  checkFinite(*simulator.value);
}

}  // namespace

void fuzzUrdf(const std::string& input) { check(input, loadUrdfText(input, "vehicle.urdf", anyStl, options())); }

/// What a program called xacro writes is read as a URDF; this one writes what it is given.
void fuzzXacro(const std::string& input) {
  static const TemporaryFiles* files = [] {
    auto* made = new TemporaryFiles;  // as long as the program
    const std::string program = made->write("bin/xacro", "#!/bin/sh\nexec cat \"$1\"\n");
    chmod(program.c_str(), 0755);
    const char* path = getenv("PATH");
    setenv("PATH", (made->folder("bin") + ":" + (path ? path : "/usr/bin:/bin")).c_str(), 1);
    return made;
  }();
  const std::string path = files->write("vehicle.urdf.xacro", input);
  check(input, loadUrdfFile(path, anyStl, options()));
}

}  // namespace ellipsoid_vehicle_sim::fuzz
