#include "peers.h"

#ifdef WITH_MUJOCO
#include <mujoco/mujoco.h>

#include <cstdio>
#include <memory>
#endif

namespace ellipsoid_vehicle_sim {

#ifdef WITH_MUJOCO

namespace {

std::string vector(const Eigen::Vector3d& v) {
  char text[120];
  std::snprintf(text, sizeof text, "%.17g %.17g %.17g", v.x(), v.y(), v.z());
  return text;
}

std::string quaternion(const Eigen::Quaterniond& q) {
  char text[160];
  std::snprintf(text, sizeof text, "%.17g %.17g %.17g %.17g", q.w(), q.x(), q.y(), q.z());
  return text;
}

/// The scene in MuJoCo's own language. A negative solref is stiffness and damping per unit of the contact's mass;
/// impedance near one makes the contact as good as a spring of its own.
std::string xmlOf(const BodyScene& s, const std::string& integrator, double dt) {
  char numbers[400];
  std::snprintf(numbers, sizeof numbers,
                "solref='%.17g %.17g' solimp='0.9999 0.9999 0.001 0.5 2' friction='%.17g 0 0' condim='%d'",
                -s.stiffness / s.mass, -std::max(s.damping, 1e-9) / s.mass, std::max(s.mu, 1e-5), s.mu > 0.0 ? 3 : 1);
  char option[300];
  std::snprintf(option, sizeof option, "<option timestep='%.17g' gravity='0 0 %.17g' integrator='%s' cone='elliptic'/>",
                dt, -s.gravity, integrator.c_str());
  const Eigen::Quaterniond plane = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), s.nhat_W);
  char mass[60];
  std::snprintf(mass, sizeof mass, "%.17g", s.mass);
  return std::string("<mujoco><compiler inertiafromgeom='false'/>") + option + "<worldbody>" +
         "<geom type='plane' size='0 0 1' pos='" + vector(s.p_WP) + "' quat='" + quaternion(plane) + "' " + numbers +
         "/>" + "<body pos='" + vector(s.X_WB.p) + "' quat='" + quaternion(s.X_WB.q) +
         "'><freejoint/><inertial pos='0 0 0' mass='" + mass + "' diaginertia='" + vector(s.inertia) +
         "'/><geom type='ellipsoid' size='" + vector(s.radii) + "' " + numbers + "/></body></worldbody></mujoco>";
}

PeerRun runMujoco(const BodyScene& scene, const std::string& integrator, double dt) {
  const std::string xml = xmlOf(scene, integrator, dt);
  // Its virtual file system is a large structure: on the heap.
  const auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  if (mj_makeEmptyFileVFS(files.get(), "scene.xml", static_cast<int>(xml.size())) != 0) return {};
  std::copy(xml.begin(), xml.end(), static_cast<char*>(files->filedata[files->nfile - 1]));
  char error[500] = "";
  const std::unique_ptr<mjModel, decltype(&mj_deleteModel)> model(
      mj_loadXML("scene.xml", files.get(), error, sizeof error), mj_deleteModel);
  mj_deleteVFS(files.get());
  if (!model) {
    std::fprintf(stderr, "MuJoCo: %s\n", error);
    return {};
  }
  const std::unique_ptr<mjData, decltype(&mj_deleteData)> data(mj_makeData(model.get()), mj_deleteData);
  const Eigen::Vector3d w_B = scene.X_WB.q.conjugate() * scene.w_WB;  // a free joint turns in its own axes
  for (int i = 0; i < 3; ++i) {
    data->qvel[i] = scene.v_WB[i];
    data->qvel[3 + i] = w_B[i];
  }
  return runPeer(
      scene, dt, [&] { mj_step(model.get(), data.get()); },
      [&] {
        const mjtNum* q = data->qpos;
        return Pose{{q[0], q[1], q[2]}, Eigen::Quaterniond(q[3], q[4], q[5], q[6])};
      });
}

}  // namespace

std::vector<Peer> mujocoPeers() {
  return {{"MuJoCo", "Euler", [](const BodyScene& scene, double dt) { return runMujoco(scene, "Euler", dt); }},
          {"MuJoCo", "RK4", [](const BodyScene& scene, double dt) { return runMujoco(scene, "RK4", dt); }}};
}

std::string mujocoVersion() { return std::string("MuJoCo ") + mj_versionString(); }

#else

std::vector<Peer> mujocoPeers() { return {}; }
std::string mujocoVersion() { return "MuJoCo: not found when this was built (libmujoco-dev)"; }

#endif

}  // namespace ellipsoid_vehicle_sim
