// Shapes of the body as compounds of ellipsoids, and which shapes add nothing.

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "ellipsoid_vehicle_sim/description/shapes_to_ellipsoids.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

constexpr int kPoints = 5;            // tried along each side of a cell
constexpr double kSame = 1e-6;        // of a shape's size: rounding of files
constexpr int kHullDirections = 200;  // half spaces that stand for a mesh's hull

/// A convex hull as half spaces d . p <= reach.
struct HalfSpaces {
  std::vector<Vector3d> directions;
  std::vector<double> reach;

  explicit HalfSpaces(const CollisionShape& shape) : directions(evenDirections(kHullDirections)) {
    for (int i = 0; i < 3; ++i)
      for (const double sign : {1.0, -1.0}) directions.push_back(sign * Vector3d::Unit(i));
    for (const Vector3d& d : directions) reach.push_back(support(shape, d));
  }
  bool holds(const Vector3d& p, double slack) const {
    for (std::size_t i = 0; i < directions.size(); ++i)
      if (directions[i].dot(p) > reach[i] + slack) return false;
    return true;
  }
};

bool holds(const CollisionShape& shape, const HalfSpaces& hull, const Vector3d& p, double slack) {
  const Vector3d& h = shape.half;
  switch (shape.kind) {
    case CollisionShape::Kind::kBox:
      return ((p.cwiseAbs() - h).array() <= slack).all();
    case CollisionShape::Kind::kCylinder:
      return p.head<2>().norm() <= h.x() + slack && std::abs(p.z()) <= h.z() + slack;
    case CollisionShape::Kind::kEllipsoid:
      return p.cwiseQuotient((h.array() + slack).matrix()).squaredNorm() <= 1.0;
    case CollisionShape::Kind::kMesh:
      break;
  }
  return hull.holds(p, slack);
}

/// How often to cut each side: the longest piece is halved, thirded, ... while the number allows.
std::array<int, 3> cuts(const Vector3d& half, int count) {
  std::array<int, 3> n = {1, 1, 1};
  for (;;) {
    int best = -1;
    for (int i = 0; i < 3; ++i) {
      const int product = n[0] * n[1] * n[2] / n[i] * (n[i] + 1);
      if (product <= count && (best < 0 || half[i] / n[i] > half[best] / n[best] * (1.0 + 1e-9))) best = i;
    }
    if (best < 0) return n;
    ++n[best];
  }
}

/// Points of a shape's surface: its extreme points, or those of an ellipsoid all around.
std::vector<Vector3d> surfacePoints(const CollisionShape& shape) {
  if (shape.kind != CollisionShape::Kind::kEllipsoid) return extremePoints(shape);
  std::vector<Vector3d> points = evenDirections(kHullDirections);
  for (int i = 0; i < 3; ++i)
    for (const double sign : {1.0, -1.0}) points.push_back(sign * Vector3d::Unit(i));
  for (Vector3d& p : points) p = p.cwiseProduct(shape.half);
  return points;
}

}  // namespace

std::vector<Vector3d> extremePoints(const CollisionShape& shape) {
  std::vector<Vector3d> points;
  const Vector3d& h = shape.half;
  if (shape.kind == CollisionShape::Kind::kBox) {
    for (int i = 0; i < 8; ++i) {
      points.emplace_back(i & 1 ? h.x() : -h.x(), i & 2 ? h.y() : -h.y(), i & 4 ? h.z() : -h.z());
    }
  } else if (shape.kind == CollisionShape::Kind::kCylinder) {
    constexpr int kCorners = 48;
    for (int i = 0; i < kCorners; ++i) {
      const double a = 2.0 * M_PI * i / kCorners;
      for (double z : {-h.z(), h.z()}) points.emplace_back(h.x() * std::cos(a), h.y() * std::sin(a), z);
    }
  } else if (shape.kind == CollisionShape::Kind::kMesh && shape.vertices_S) {
    points = *shape.vertices_S;
  }
  return points;
}

std::vector<Cell> compoundOf(const CollisionShape& shape, int count) {
  const std::array<int, 3> n = cuts(shape.half, count);
  const Vector3d size = shape.half.cwiseQuotient(Vector3d(n[0], n[1], n[2]));  // half a cell
  const HalfSpaces hull(shape);
  const double slack = 1e-9 * shape.half.maxCoeff();
  std::vector<Cell> cells;
  for (int i = 0; i < n[0]; ++i)
    for (int j = 0; j < n[1]; ++j)
      for (int k = 0; k < n[2]; ++k) {
        const Vector3d centre = -shape.half + (2.0 * Vector3d(i, j, k) + Vector3d::Ones()).cwiseProduct(size);
        // What the hull fills of the cell, felt at points from side to side.
        Vector3d low = Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
        for (int a = 0; a < kPoints; ++a)
          for (int b = 0; b < kPoints; ++b)
            for (int c = 0; c < kPoints; ++c) {
              const Vector3d at = (2.0 / (kPoints - 1)) * Vector3d(a, b, c) - Vector3d::Ones();
              const Vector3d p = centre + at.cwiseProduct(size);
              if (!holds(shape, hull, p, slack)) continue;
              low = low.cwiseMin(p);
              high = high.cwiseMax(p);
            }
        const Vector3d radii = 0.5 * (high - low);
        // A cell that the hull hardly meets is left to its neighbours.
        if (!(radii.minCoeff() > 0.1 * size.minCoeff())) continue;
        cells.push_back({0.5 * (low + high), radii});
      }
  if (cells.empty()) cells.push_back({Vector3d::Zero(), shape.half});
  return cells;
}

double compoundError(const std::vector<Cell>& cells, const CollisionShape& shape) {
  double error = 0.0;
  for (const Vector3d& p : extremePoints(shape)) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Cell& cell : cells) nearest = std::min(nearest, distanceOutside(p - cell.centre_S, cell.radii));
    error = std::max(error, nearest);
  }
  for (const Vector3d& d : evenDirections(kHullDirections)) {
    double reach = -std::numeric_limits<double>::infinity();
    for (const Cell& cell : cells) reach = std::max(reach, cell.centre_S.dot(d) + cell.radii.cwiseProduct(d).norm());
    error = std::max(error, std::abs(reach - support(shape, d)));
  }
  return error;
}

std::vector<int> coveredBy(const std::vector<PlacedShape>& shapes) {
  std::vector<int> by(shapes.size(), -1);
  for (std::size_t a = 0; a < shapes.size(); ++a) {
    const CollisionShape& outer = *shapes[a].shape;
    if (by[a] >= 0) continue;
    const HalfSpaces hull(outer);
    for (std::size_t b = 0; b < shapes.size(); ++b) {
      const CollisionShape& inner = *shapes[b].shape;
      if (a == b || by[b] >= 0) continue;
      const double slack = kSame * outer.half.maxCoeff();
      // Of two that are the same, the first one stays.
      if (inner.half.maxCoeff() > outer.half.norm() + slack) continue;
      const Pose X_AB = shapes[a].X_GS.inverse() * shapes[b].X_GS;
      bool inside = true;
      for (const Vector3d& p : surfacePoints(inner)) inside = inside && holds(outer, hull, X_AB * p, slack);
      if (inside) by[b] = static_cast<int>(a);
    }
  }
  // What stands for a shape may itself have been dropped for a third.
  for (int& i : by)
    while (i >= 0 && by[i] >= 0) i = by[i];
  return by;
}

}  // namespace ellipsoid_vehicle_sim
