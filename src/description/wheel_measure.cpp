#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "ellipsoid_vehicle_sim/description/shapes_to_ellipsoids.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

constexpr double kRoundWithin = 0.1;                  // of the radius: out of round, and off the axis
constexpr double kLargestTilt = 20.0 * M_PI / 180.0;  // of a wheel's own axis against the joint's
constexpr double kTread = 0.8;                        // of the rolling radius: what lies beyond is tread
constexpr int kAround = 24;                           // directions in which a mesh is felt about the axis

/// One shape about the axis.
struct ShapeMeasure {
  double radius = 0.0;
  double axial_low = 0.0, axial_high = 0.0;
  double offset = 0.0, tilt = 0.0;
  bool round = false;
};

/// Boxes, cylinders and ellipsoids: the axis of the shape that is next to the joint's counts as its own.
ShapeMeasure measurePrimitive(const CollisionShape& shape, const Pose& X_GS, const Vector3d& axis) {
  ShapeMeasure m;
  const Vector3d& h = shape.half;
  const double axial = X_GS.p.dot(axis);
  m.offset = (X_GS.p - axial * axis).norm();
  const Vector3d axis_S = X_GS.q.conjugate() * axis;
  const bool sphere =
      shape.kind == CollisionShape::Kind::kEllipsoid && h.maxCoeff() - h.minCoeff() <= 1e-9 * h.maxCoeff();
  int j = 0;
  axis_S.cwiseAbs().maxCoeff(&j);
  // From the cross product: the cosine alone would lose a tilt below 1e-8.
  m.tilt = sphere ? 0.0 : std::atan2(axis_S.cross(Vector3d::Unit(j)).norm(), std::abs(axis_S[j]));
  const double r1 = h[(j + 1) % 3], r2 = h[(j + 2) % 3];
  m.radius = std::max(r1, r2);
  m.axial_low = axial - h[j];
  m.axial_high = axial + h[j];
  const bool lies = shape.kind == CollisionShape::Kind::kCylinder && j != 2;
  m.round = !lies && std::min(r1, r2) >= (1.0 - kRoundWithin) * m.radius && m.tilt <= kLargestTilt &&
            m.offset <= kRoundWithin * m.radius;
  return m;
}

ShapeMeasure measureMesh(const CollisionShape& shape, const Pose& X_GS, const Vector3d& axis) {
  ShapeMeasure m;
  const Vector3d u = axis.unitOrthogonal(), v = axis.cross(u);
  std::vector<Vector3d> points;  // across the axis (2), along it
  for (const Vector3d& p_S : *shape.vertices_S) {
    const Vector3d p = X_GS * p_S;
    points.emplace_back(p.dot(u), p.dot(v), p.dot(axis));
    m.radius = std::max(m.radius, points.back().head<2>().norm());
  }
  double reach[kAround] = {};
  for (int i = 0; i < kAround; ++i) {
    const double a = 2.0 * M_PI * i / kAround;
    const Eigen::Vector2d d(std::cos(a), std::sin(a));
    for (const Vector3d& p : points) reach[i] = std::max(reach[i], p.head<2>().dot(d));
  }
  m.round = true;
  for (int i = 0; i < kAround; ++i) {
    if (reach[i] < (1.0 - kRoundWithin) * m.radius) m.round = false;
    m.offset = std::max(m.offset, 0.5 * (reach[i] - reach[(i + kAround / 2) % kAround]));
  }
  m.axial_low = std::numeric_limits<double>::infinity();
  m.axial_high = -m.axial_low;
  for (const Vector3d& p : points) {
    if (p.head<2>().norm() < kTread * m.radius) continue;
    m.axial_low = std::min(m.axial_low, p.z());
    m.axial_high = std::max(m.axial_high, p.z());
  }
  return m;
}

}  // namespace

WheelMeasure measureWheel(const std::vector<PlacedShape>& shapes, const Vector3d& axis_G) {
  std::vector<ShapeMeasure> measures;
  std::size_t largest = 0;
  for (const PlacedShape& s : shapes) {
    const bool mesh = s.shape->kind == CollisionShape::Kind::kMesh && s.shape->vertices_S;
    measures.push_back(mesh ? measureMesh(*s.shape, s.X_GS, axis_G) : measurePrimitive(*s.shape, s.X_GS, axis_G));
    const ShapeMeasure& last = measures.back();
    if (last.radius + last.offset > measures[largest].radius + measures[largest].offset) largest = measures.size() - 1;
  }
  WheelMeasure wheel;
  wheel.radius = measures[largest].radius;
  wheel.round = measures[largest].round;
  wheel.line = shapes[largest].shape->line;
  double low = measures[largest].axial_low, high = measures[largest].axial_high;
  for (const ShapeMeasure& m : measures) {
    if (m.radius < kTread * wheel.radius) continue;
    low = std::min(low, m.axial_low);
    high = std::max(high, m.axial_high);
    wheel.offset = std::max(wheel.offset, m.offset);
    wheel.tilt = std::max(wheel.tilt, m.tilt);
  }
  wheel.text = shapes[largest].shape->text;
  if (shapes.size() > 1) wheel.text += " with " + std::to_string(shapes.size() - 1) + " more";
  // A wheel drawn as a sheet still has to roll: not thinner than a hundredth of its radius.
  wheel.half_width = std::max(0.5 * (high - low), 0.01 * wheel.radius);
  wheel.axial_centre = 0.5 * (low + high);
  return wheel;
}

}  // namespace ellipsoid_vehicle_sim
