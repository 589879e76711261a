#pragma once

#define BT_USE_DOUBLE_PRECISION
#include <btBulletDynamicsCommon.h>

#include <Eigen/Core>
#include <memory>

#include "ellipsoid_vehicle_sim/geometry/pose.h"

// Included where Bullet was found only.

namespace ellipsoid_vehicle_sim {

inline btVector3 toBullet(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
inline btTransform toBullet(const Pose& X) {
  return btTransform(btQuaternion(X.q.x(), X.q.y(), X.q.z(), X.q.w()), toBullet(X.p));
}
inline Eigen::Vector3d fromBullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }
inline Pose fromBullet(const btTransform& X) {
  const btQuaternion q = X.getRotation();
  return {fromBullet(X.getOrigin()), Eigen::Quaterniond(q.w(), q.x(), q.y(), q.z())};
}

/// Bullet has no ellipsoid of its own; its support function is all it needs.
class BulletEllipsoid : public btConvexInternalShape {
 public:
  explicit BulletEllipsoid(const Eigen::Vector3d& radii) : radii_(radii.x(), radii.y(), radii.z()) {
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

/// A world with a plane as its ground, and the parts that Bullet wants its user to keep.
class BulletWorld {
 public:
  BulletWorld(const Eigen::Vector3d& nhat_W, const Eigen::Vector3d& p_WP, double gravity)
      : plane_(toBullet(nhat_W), nhat_W.dot(p_WP)),
        ground_(btRigidBody::btRigidBodyConstructionInfo(0.0, nullptr, &plane_)) {
    world.setGravity({0, 0, -gravity});
    world.getSolverInfo().m_restitutionVelocityThreshold = 0.0;
    ground_.setFriction(1.0);  // a pair has the product
    world.addRigidBody(&ground_, kGround, kVehicle);
  }
  ~BulletWorld() {
    // The world knows its bodies by address: they leave in the reverse order of their coming.
    for (int i = world.getNumConstraints(); i-- > 0;) world.removeConstraint(world.getConstraint(i));
    for (int i = world.getNumCollisionObjects(); i-- > 0;)
      world.removeCollisionObject(world.getCollisionObjectArray()[i]);
  }
  BulletWorld(const BulletWorld&) = delete;
  BulletWorld& operator=(const BulletWorld&) = delete;

  /// Touches the ground only. `inertia`: principal.
  std::unique_ptr<btRigidBody> addBody(btCollisionShape& shape, double mass, const Eigen::Vector3d& inertia,
                                       const Pose& X_WB, const Eigen::Vector3d& v_WB, const Eigen::Vector3d& w_WB) {
    btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, &shape, toBullet(inertia));
    info.m_startWorldTransform = toBullet(X_WB);
    info.m_linearDamping = info.m_angularDamping = 0.0;
    auto body = std::make_unique<btRigidBody>(info);
    body->setLinearVelocity(toBullet(v_WB));
    body->setAngularVelocity(toBullet(w_WB));
    body->setActivationState(DISABLE_DEACTIVATION);
    body->setFlags(body->getFlags() | BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY);
    world.addRigidBody(body.get(), kVehicle, kGround);
    return body;
  }

 private:
  enum { kGround = 1, kVehicle = 2 };
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;

 public:
  btDiscreteDynamicsWorld world{&dispatcher_, &broadphase_, &solver_, &configuration_};

 private:
  btStaticPlaneShape plane_;
  btRigidBody ground_;
};

}  // namespace ellipsoid_vehicle_sim
