#pragma once

#include <btBulletCollisionCommon.h>

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "ellipsoid_vehicle_sim/world/terrain.h"

namespace ellipsoid_vehicle_sim::test {

#ifdef BT_USE_DOUBLE_PRECISION
constexpr const char* kBulletName = "Bullet double";
#else
constexpr const char* kBulletName = "Bullet float";
#endif

inline btVector3 toBullet(const Eigen::Vector3d& v) {
  return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}

inline btMatrix3x3 toBullet(const Eigen::Matrix3d& R) {
  const auto at = [&R](int i, int j) { return static_cast<btScalar>(R(i, j)); };
  return {at(0, 0), at(0, 1), at(0, 2), at(1, 0), at(1, 1), at(1, 2), at(2, 0), at(2, 1), at(2, 2)};
}

/// An ellipsoid by its exact support point, without the margin that Bullet's rounded shapes carry.
class BulletEllipsoid : public btConvexInternalShape {
 public:
  explicit BulletEllipsoid(const btVector3& radii) : radii_(radii) {
    m_shapeType = CUSTOM_CONVEX_SHAPE_TYPE;
    m_collisionMargin = 0;
  }
  btVector3 localGetSupportingVertexWithoutMargin(const btVector3& d) const override {
    const btVector3 scaled = d * radii_;
    const btScalar length = scaled.length();
    return length > 0 ? radii_ * scaled / length : btVector3(0, 0, radii_.z());
  }
  btVector3 localGetSupportingVertex(const btVector3& d) const override {
    return localGetSupportingVertexWithoutMargin(d);
  }
  void batchedUnitVectorGetSupportingVertexWithoutMargin(const btVector3* d, btVector3* out, int count) const override {
    for (int i = 0; i < count; ++i) out[i] = localGetSupportingVertexWithoutMargin(d[i]);
  }
  void calculateLocalInertia(btScalar mass, btVector3& inertia) const override {
    const btVector3 squared = radii_ * radii_;
    const btScalar sum = squared.x() + squared.y() + squared.z();
    inertia = (btVector3(sum, sum, sum) - squared) * (mass / 5);
  }
  void getAabb(const btTransform& pose, btVector3& low, btVector3& high) const override {
    const btMatrix3x3& R = pose.getBasis();
    const btVector3 half((R[0] * radii_).length(), (R[1] * radii_).length(), (R[2] * radii_).length());
    low = pose.getOrigin() - half;
    high = pose.getOrigin() + half;
  }
  void setMargin(btScalar) override {}
  btScalar getMargin() const override { return 0; }
  const char* getName() const override { return "Ellipsoid"; }

 private:
  btVector3 radii_;
};

/// A triangle mesh with Bullet's quantised tree, over arrays of its own scalar.
struct BulletMesh {
  std::vector<btScalar> corners;
  std::vector<int> indices;
  std::unique_ptr<btTriangleIndexVertexArray> arrays;
  std::unique_ptr<btBvhTriangleMeshShape> shape;

  explicit BulletMesh(const TriangleSoup& soup, bool with_tree = true) {
    for (const Eigen::Vector3d& v : soup.vertices)
      for (int k = 0; k < 3; ++k) corners.push_back(static_cast<btScalar>(v[k]));
    for (const auto& t : soup.triangles)
      for (const std::uint32_t v : t) indices.push_back(static_cast<int>(v));
    arrays = std::make_unique<btTriangleIndexVertexArray>(
        static_cast<int>(indices.size() / 3), indices.data(), static_cast<int>(3 * sizeof(int)),
        static_cast<int>(corners.size() / 3), corners.data(), static_cast<int>(3 * sizeof(btScalar)));
    shape = std::make_unique<btBvhTriangleMeshShape>(arrays.get(), true, with_tree);
  }
  std::size_t bytes() const { return corners.size() * sizeof(btScalar) + indices.size() * sizeof(int); }
};

}  // namespace ellipsoid_vehicle_sim::test
