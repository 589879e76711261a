#include "peers.h"

#ifdef WITH_MUJOCO
#include <algorithm>
#include <cstdio>
#include <limits>

#include "mujoco_model.h"
#endif

namespace ellipsoid_vehicle_sim {

#ifdef WITH_MUJOCO

MujocoModel loadMujoco(const std::string& xml, std::string& error) {
  // Its virtual file system is a large structure: on the heap.
  const auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  MujocoModel model(nullptr, mj_deleteModel);
  if (mj_makeEmptyFileVFS(files.get(), "scene.xml", static_cast<int>(xml.size())) != 0) {
    error = "MuJoCo: the scene is too large for its virtual files";
    return model;
  }
  std::copy(xml.begin(), xml.end(), static_cast<char*>(files->filedata[files->nfile - 1]));
  char text[500] = "";
  model.reset(mj_loadXML("scene.xml", files.get(), text, sizeof text));
  mj_deleteVFS(files.get());
  if (!model) error = std::string("MuJoCo: ") + text;
  return model;
}

std::string mujocoNumber(double x) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", x);
  return text;
}

std::string mujocoVector(const Eigen::Vector3d& v) {
  return mujocoNumber(v.x()) + " " + mujocoNumber(v.y()) + " " + mujocoNumber(v.z());
}

std::string mujocoQuaternion(const Eigen::Quaterniond& q) { return mujocoNumber(q.w()) + " " + mujocoVector(q.vec()); }

std::string mujocoOption(double dt, double gravity, const std::string& integrator, const std::string& more) {
  return "<option timestep='" + mujocoNumber(dt) + "' gravity='0 0 " + mujocoNumber(-gravity) + "' integrator='" +
         integrator + "' cone='elliptic' " + more + "/>";
}

std::string mujocoPlane(const Eigen::Vector3d& nhat_W, const Eigen::Vector3d& p_WP, const std::string& attributes) {
  const Eigen::Quaterniond q = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), nhat_W);
  return "<geom type='plane' size='0 0 1' pos='" + mujocoVector(p_WP) + "' quat='" + mujocoQuaternion(q) + "' " +
         attributes + "/>";
}

std::string mujocoContact(double stiffness, double damping, double mass, double mu) {
  return "solref='" + mujocoNumber(-stiffness / mass) + " " + mujocoNumber(-std::max(damping, 1e-9) / mass) +
         "' solimp='0.9999 0.9999 0.001 0.5 2' friction='" + mujocoNumber(std::max(mu, 1e-5)) + " 0 0' condim='" +
         (mu > 0.0 ? "3" : "1") + "'";
}

bool mujocoGaveUp(const mjData& data) {
  return data.warning[mjWARN_BADQPOS].number + data.warning[mjWARN_BADQVEL].number +
             data.warning[mjWARN_BADQACC].number >
         0;
}

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::string xmlOf(const BodyScene& s, const std::string& integrator, double dt) {
  const std::string contact = mujocoContact(s.stiffness, s.damping, s.mass, s.mu);
  return "<mujoco><compiler inertiafromgeom='false'/>" + mujocoOption(dt, s.gravity, integrator) + "<worldbody>" +
         mujocoPlane(s.nhat_W, s.p_WP, contact) + "<body pos='" + mujocoVector(s.X_WB.p) + "' quat='" +
         mujocoQuaternion(s.X_WB.q) + "'><freejoint/><inertial pos='0 0 0' mass='" + mujocoNumber(s.mass) +
         "' diaginertia='" + mujocoVector(s.inertia) + "'/><geom type='ellipsoid' size='" + mujocoVector(s.radii) +
         "' " + contact + "/></body></worldbody></mujoco>";
}

PeerRun runMujoco(const BodyScene& scene, const std::string& integrator, double dt) {
  std::string error;
  const MujocoModel model = loadMujoco(xmlOf(scene, integrator, dt), error);
  if (!model) return {{}, 0.0, error};
  const MujocoData data(mj_makeData(model.get()), mj_deleteData);
  const Eigen::Vector3d w_B = scene.X_WB.q.conjugate() * scene.w_WB;  // a free joint turns in its own axes
  for (int i = 0; i < 3; ++i) {
    data->qvel[i] = scene.v_WB[i];
    data->qvel[3 + i] = w_B[i];
  }
  return runPeer(
      scene.duration, dt, [&] { mj_step(model.get(), data.get()); },
      [&] {
        const mjtNum* q = data->qpos;
        return Pose{{mujocoGaveUp(*data) ? kNaN : q[0], q[1], q[2]}, Eigen::Quaterniond(q[3], q[4], q[5], q[6])};
      });
}

}  // namespace

std::vector<Peer> mujocoPeers() {
  std::vector<Peer> peers;
  for (const std::string method : {"Euler", "RK4"})
    peers.push_back({"MuJoCo", method,
                     [method](const BodyScene& scene, double dt) { return runMujoco(scene, method, dt); },
                     [method](const DriveScene& scene, double dt) { return driveMujoco(scene, method, dt); }});
  return peers;
}

std::string mujocoVersion() { return std::string("MuJoCo ") + mj_versionString(); }

#else

std::vector<Peer> mujocoPeers() { return {}; }
std::string mujocoVersion() { return "MuJoCo: not found when this was built (libmujoco-dev)"; }

#endif

}  // namespace ellipsoid_vehicle_sim
