#include "peers.h"

#ifdef WITH_BULLET
#define BT_USE_DOUBLE_PRECISION
#include <btBulletDynamicsCommon.h>

#include <memory>
#endif

namespace ellipsoid_vehicle_sim {

#ifdef WITH_BULLET

namespace {

/// Bullet has no ellipsoid of its own; its support function is all it needs.
class EllipsoidShape : public btConvexInternalShape {
 public:
  explicit EllipsoidShape(const Eigen::Vector3d& radii) : radii_(radii.x(), radii.y(), radii.z()) {
    m_shapeType = CUSTOM_CONVEX_SHAPE_TYPE;
    setMargin(0.0);
  }
  btVector3 localGetSupportingVertexWithoutMargin(const btVector3& direction) const override {
    const btVector3 scaled = radii_ * direction;
    const btScalar length = scaled.length();
    return length > 0.0 ? radii_ * scaled / length : btVector3(radii_.x(), 0, 0);
  }
  btVector3 localGetSupportingVertex(const btVector3& direction) const override {
    return localGetSupportingVertexWithoutMargin(direction);
  }
  void batchedUnitVectorGetSupportingVertexWithoutMargin(const btVector3* directions, btVector3* vertices,
                                                         int count) const override {
    for (int i = 0; i < count; ++i) vertices[i] = localGetSupportingVertexWithoutMargin(directions[i]);
  }
  void calculateLocalInertia(btScalar mass, btVector3& inertia) const override {
    inertia =
        mass / 5.0 *
        btVector3(radii_.y() * radii_.y() + radii_.z() * radii_.z(), radii_.x() * radii_.x() + radii_.z() * radii_.z(),
                  radii_.x() * radii_.x() + radii_.y() * radii_.y());
  }
  const char* getName() const override { return "Ellipsoid"; }

 private:
  btVector3 radii_;
};

btVector3 toBullet(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

PeerRun runBullet(const BodyScene& scene, double dt) {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  world.setGravity({0, 0, -scene.gravity});
  world.getSolverInfo().m_restitutionVelocityThreshold = 0.0;

  btStaticPlaneShape plane(toBullet(scene.nhat_W), scene.nhat_W.dot(scene.p_WP));
  btRigidBody::btRigidBodyConstructionInfo ground_info(0.0, nullptr, &plane);
  btRigidBody ground(ground_info);
  ground.setFriction(1.0);
  EllipsoidShape shape(scene.radii);
  btRigidBody::btRigidBodyConstructionInfo info(scene.mass, nullptr, &shape, toBullet(scene.inertia));
  const Eigen::Quaterniond& q = scene.X_WB.q;
  info.m_startWorldTransform = btTransform(btQuaternion(q.x(), q.y(), q.z(), q.w()), toBullet(scene.X_WB.p));
  info.m_linearDamping = info.m_angularDamping = 0.0;
  btRigidBody body(info);
  body.setFriction(scene.mu);  // a pair has the product
  body.setContactStiffnessAndDamping(scene.stiffness, scene.damping);
  body.setLinearVelocity(toBullet(scene.v_WB));
  body.setAngularVelocity(toBullet(scene.w_WB));
  body.setActivationState(DISABLE_DEACTIVATION);
  body.setFlags(body.getFlags() | BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY);
  world.addRigidBody(&ground);
  world.addRigidBody(&body);
  const PeerRun run = runPeer(
      scene, dt, [&] { world.stepSimulation(dt, 0); },
      [&] {
        const btTransform& X = body.getCenterOfMassTransform();
        const btQuaternion r = X.getRotation();
        return Pose{{X.getOrigin().x(), X.getOrigin().y(), X.getOrigin().z()},
                    Eigen::Quaterniond(r.w(), r.x(), r.y(), r.z())};
      });
  world.removeRigidBody(&body);
  world.removeRigidBody(&ground);
  return run;
}

}  // namespace

std::vector<Peer> bulletPeers() { return {{"Bullet", "f64", runBullet}}; }
std::string bulletVersion() {
  return "Bullet " + std::to_string(btGetVersion() / 100) + "." + std::to_string(btGetVersion() % 100);
}

#else

std::vector<Peer> bulletPeers() { return {}; }
std::string bulletVersion() { return "Bullet: not found when this was built (libbullet-dev)"; }

#endif

}  // namespace ellipsoid_vehicle_sim
