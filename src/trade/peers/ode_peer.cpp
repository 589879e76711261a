#include "peers.h"

#ifdef WITH_ODE
#include "ode_world.h"
#endif

namespace ellipsoid_vehicle_sim {

#ifdef WITH_ODE

std::mutex& OdeWorld::mutex() {
  static std::mutex running;
  return running;
}

OdeWorld::OdeWorld(double gravity) {
  static std::once_flag started;
  std::call_once(started, [] { dInitODE2(0); });
  dAllocateODEDataForThread(dAllocateMaskAll);
  world = dWorldCreate();
  dWorldSetGravity(world, 0, 0, -gravity);
  contacts = dJointGroupCreate(0);
}

OdeWorld::~OdeWorld() {
  dJointGroupDestroy(contacts);
  dWorldDestroy(world);
}

dBodyID OdeWorld::addBody(double mass, const Eigen::Vector3d& inertia, const Pose& X_WB, const Eigen::Vector3d& v_WB,
                          const Eigen::Vector3d& w_WB) {
  const dBodyID body = dBodyCreate(world);
  dMass m;
  dMassSetParameters(&m, mass, 0, 0, 0, inertia.x(), inertia.y(), inertia.z(), 0, 0, 0);
  dBodySetMass(body, &m);
  dBodySetPosition(body, X_WB.p.x(), X_WB.p.y(), X_WB.p.z());
  const dQuaternion q = {X_WB.q.w(), X_WB.q.x(), X_WB.q.y(), X_WB.q.z()};
  dBodySetQuaternion(body, q);
  dBodySetLinearVel(body, v_WB.x(), v_WB.y(), v_WB.z());
  dBodySetAngularVel(body, w_WB.x(), w_WB.y(), w_WB.z());
  return body;
}

void OdeWorld::step(double dt) {
  dWorldStep(world, dt);
  dJointGroupEmpty(contacts);
}

Pose odePose(dBodyID body) {
  const dReal *p = dBodyGetPosition(body), *r = dBodyGetQuaternion(body);
  return {{p[0], p[1], p[2]}, Eigen::Quaterniond(r[0], r[1], r[2], r[3])};
}

OdeContact lowestPoint(const Pose& X_WE, const Eigen::Vector3d& radii, const Eigen::Vector3d& nhat_W,
                       const Eigen::Vector3d& p_WP) {
  const Eigen::Vector3d n_E = X_WE.q.conjugate() * nhat_W;
  const Eigen::Vector3d scaled = radii.cwiseProduct(n_E);
  const Eigen::Vector3d p_WC = X_WE.p - X_WE.q * radii.cwiseProduct(scaled / scaled.norm());
  return {nhat_W.dot(p_WP - p_WC), p_WC};
}

dContact odeContact(const OdeContact& contact, const Eigen::Vector3d& nhat_W, double mu, double stiffness,
                    double damping, double dt) {
  dContact c{};
  const double sum = dt * stiffness + damping;
  c.surface.mode = dContactSoftERP | dContactSoftCFM | dContactApprox1;
  c.surface.mu = mu;
  c.surface.soft_erp = dt * stiffness / sum;
  c.surface.soft_cfm = 1.0 / sum;
  for (int i = 0; i < 3; ++i) {
    c.geom.pos[i] = contact.p_WC[i];
    c.geom.normal[i] = nhat_W[i];
  }
  c.geom.depth = contact.depth;
  return c;
}

namespace {

PeerRun runOde(const BodyScene& scene, double dt) {
  OdeWorld ode(scene.gravity);
  const dBodyID body = ode.addBody(scene.mass, scene.inertia, scene.X_WB, scene.v_WB, scene.w_WB);
  const auto step = [&] {
    const OdeContact lowest = lowestPoint(odePose(body), scene.radii, scene.nhat_W, scene.p_WP);
    if (lowest.depth > 0.0) {
      const dContact contact = odeContact(lowest, scene.nhat_W, scene.mu, scene.stiffness, scene.damping, dt);
      dJointAttach(dJointCreateContact(ode.world, ode.contacts, &contact), body, nullptr);
    }
    ode.step(dt);
  };
  return runPeer(scene.duration, dt, step, [body] { return odePose(body); });
}

}  // namespace

std::vector<Peer> odePeers() { return {{"ODE", "step", runOde, driveOde}}; }
std::string odeVersion() { return std::string("ODE, configured as ") + dGetConfiguration(); }

#else

std::vector<Peer> odePeers() { return {}; }
std::string odeVersion() { return "ODE: not found when this was built (libode-dev)"; }

#endif

}  // namespace ellipsoid_vehicle_sim
