#include "peers.h"

#ifdef WITH_ODE
#include <ode/ode.h>

#include <mutex>
#endif

namespace ellipsoid_vehicle_sim {

#ifdef WITH_ODE

namespace {

PeerRun runOde(const BodyScene& scene, double dt) {
  // One run at a time: all worlds share one pool of jobs, which two threads at once break.
  static std::mutex running;
  const std::lock_guard<std::mutex> alone(running);
  static std::once_flag started;
  std::call_once(started, [] { dInitODE2(0); });
  dAllocateODEDataForThread(dAllocateMaskAll);
  const dWorldID world = dWorldCreate();
  dWorldSetGravity(world, 0, 0, -scene.gravity);
  const dJointGroupID joints = dJointGroupCreate(0);
  const dBodyID body = dBodyCreate(world);
  dMass mass;
  dMassSetParameters(&mass, scene.mass, 0, 0, 0, scene.inertia.x(), scene.inertia.y(), scene.inertia.z(), 0, 0, 0);
  dBodySetMass(body, &mass);
  dBodySetPosition(body, scene.X_WB.p.x(), scene.X_WB.p.y(), scene.X_WB.p.z());
  const dQuaternion q = {scene.X_WB.q.w(), scene.X_WB.q.x(), scene.X_WB.q.y(), scene.X_WB.q.z()};
  dBodySetQuaternion(body, q);
  dBodySetLinearVel(body, scene.v_WB.x(), scene.v_WB.y(), scene.v_WB.z());
  dBodySetAngularVel(body, scene.w_WB.x(), scene.w_WB.y(), scene.w_WB.z());

  const auto pose = [body] {
    const dReal* p = dBodyGetPosition(body);
    const dReal* r = dBodyGetQuaternion(body);
    return Pose{{p[0], p[1], p[2]}, Eigen::Quaterniond(r[0], r[1], r[2], r[3])};
  };
  // ODE has no ellipsoid: its contact joint is told the lowest point over the plane, with the spring and damper as its
  // manual gives them in terms of ERP and CFM.
  const double sum = dt * scene.stiffness + scene.damping;
  const auto step = [&] {
    const Pose X_WB = pose();
    const Eigen::Vector3d n_B = X_WB.q.conjugate() * scene.nhat_W;
    const Eigen::Vector3d scaled = scene.radii.cwiseProduct(n_B);
    const Eigen::Vector3d lowest = X_WB.p - X_WB.q * scene.radii.cwiseProduct(scaled / scaled.norm());
    const double depth = scene.nhat_W.dot(scene.p_WP - lowest);
    if (depth > 0.0) {
      dContact contact{};
      contact.surface.mode = dContactSoftERP | dContactSoftCFM | dContactApprox1;
      contact.surface.mu = scene.mu;
      contact.surface.soft_erp = dt * scene.stiffness / sum;
      contact.surface.soft_cfm = 1.0 / sum;
      for (int i = 0; i < 3; ++i) {
        contact.geom.pos[i] = lowest[i];
        contact.geom.normal[i] = scene.nhat_W[i];
      }
      contact.geom.depth = depth;
      dJointAttach(dJointCreateContact(world, joints, &contact), body, nullptr);
    }
    dWorldStep(world, dt);
    dJointGroupEmpty(joints);
  };
  const PeerRun run = runPeer(scene, dt, step, pose);
  dJointGroupDestroy(joints);
  dWorldDestroy(world);
  return run;
}

}  // namespace

std::vector<Peer> odePeers() { return {{"ODE", "step", runOde}}; }
std::string odeVersion() { return std::string("ODE, configured as ") + dGetConfiguration(); }

#else

std::vector<Peer> odePeers() { return {}; }
std::string odeVersion() { return "ODE: not found when this was built (libode-dev)"; }

#endif

}  // namespace ellipsoid_vehicle_sim
