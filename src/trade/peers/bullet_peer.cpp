#include "peers.h"

#ifdef WITH_BULLET
#include "bullet_world.h"
#endif

namespace ellipsoid_vehicle_sim {

#ifdef WITH_BULLET

namespace {

PeerRun runBullet(const BodyScene& scene, double dt) {
  BulletEllipsoid shape(scene.radii);
  std::unique_ptr<btRigidBody> body;  // outlives the world that knows it
  BulletWorld bullet(scene.nhat_W, scene.p_WP, scene.gravity);
  body = bullet.addBody(shape, scene.mass, scene.inertia, scene.X_WB, scene.v_WB, scene.w_WB);
  body->setFriction(scene.mu);
  body->setContactStiffnessAndDamping(scene.stiffness, scene.damping);
  return runPeer(
      scene.duration, dt, [&] { bullet.world.stepSimulation(dt, 0); },
      [&] { return fromBullet(body->getCenterOfMassTransform()); });
}

}  // namespace

std::vector<Peer> bulletPeers() { return {{"Bullet", "f64", runBullet, driveBullet}}; }
std::string bulletVersion() {
  return "Bullet " + std::to_string(btGetVersion() / 100) + "." + std::to_string(btGetVersion() % 100);
}

#else

std::vector<Peer> bulletPeers() { return {}; }
std::string bulletVersion() { return "Bullet: not found when this was built (libbullet-dev)"; }

#endif

}  // namespace ellipsoid_vehicle_sim
