#include "ellipsoid_vehicle_sim/description/shapes_to_ellipsoids.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "ellipsoid_vehicle_sim/description/number_text.h"
#include "ellipsoid_vehicle_sim/description/vehicle_tree.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string baseName(const std::string& path) { return path.substr(path.find_last_of('/') + 1); }

/// The points whose hull the shape is; none for an ellipsoid, many for a cylinder's rims.
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

double lowest(const CollisionShape& shape, const Pose& X_RS) {
  return X_RS.p.z() - support(shape, X_RS.q.conjugate() * Vector3d(0.0, 0.0, -1.0));
}

double lowest(const EllipsoidDescription& e, const Pose& X_RL) {
  const Pose X_RE = X_RL * e.X_LE;
  return X_RE.p.z() - (X_RE.q.conjugate() * Vector3d::UnitZ()).cwiseProduct(e.radii).norm();
}

/// The wheel's spheroid in its link. Its short axis is the ellipsoid's x, y or z, whichever the joint's axis is next
/// to: an axis along y gives radii r, w, r without any rotation.
EllipsoidDescription wheelEllipsoid(const WheelMeasure& m, const Vector3d& axis, const std::vector<PlacedShape>& shapes,
                                    const std::string& file) {
  EllipsoidDescription e;
  int j = 0;
  axis.cwiseAbs().maxCoeff(&j);
  Vector3d along = Vector3d::Zero();
  along[j] = axis[j] < 0.0 ? -1.0 : 1.0;
  const bool aligned = (axis - along).cwiseAbs().maxCoeff() == 0.0;
  e.X_LE.q = aligned ? Eigen::Quaterniond::Identity() : Eigen::Quaterniond::FromTwoVectors(along, axis).normalized();
  e.X_LE.p = m.axial_centre * axis;
  e.radii.setConstant(m.radius);
  e.radii[j] = m.half_width;
  e.source = m.text + " (" + baseName(file) + ":" + std::to_string(m.line) + ")";
  std::vector<PlacedShape> placed;
  for (const PlacedShape& s : shapes) placed.push_back({s.shape, e.X_LE.inverse() * s.X_GS});
  e.fit_error = fitError(e.radii, placed);
  return e;
}

std::string wheelNote(const std::string& link, const WheelMeasure& m, const EllipsoidDescription& e) {
  return "wheel '" + link + "': " + e.source + " stands as a spheroid of radius " + numberText(m.radius) +
         " m, half width " + numberText(m.half_width) + " m, exactly about its axis; off the axis it was " +
         numberText(m.offset) + " m, tilted " + numberText(m.tilt) + " rad, fit error " + numberText(e.fit_error) +
         " m";
}

EllipsoidDescription bodyEllipsoid(const CollisionShape& shape, const std::string& file) {
  EllipsoidDescription e;
  e.X_LE = shape.X_LS;
  e.radii = shape.half;
  e.source = shape.text + " (" + baseName(file) + ":" + std::to_string(shape.line) + ")";
  if (shape.kind != CollisionShape::Kind::kEllipsoid) e.fit_error = fitError(e.radii, {{&shape, Pose{}}});
  return e;
}

/// Keeps a fit from coming down to the ground before the wheels do.
void keepAboveWheels(EllipsoidDescription& e, const CollisionShape& shape, const Pose& X_RL, double wheel_bottom,
                     const std::string& link, std::vector<std::string>& notes) {
  const double low = lowest(e, X_RL), shape_low = lowest(shape, X_RL * shape.X_LS);
  if (low >= wheel_bottom || shape_low < wheel_bottom) return;
  const double raise = shape_low - low;
  e.X_LE.p += X_RL.q.conjugate() * Vector3d(0.0, 0.0, raise);
  e.fit_error += raise;
  notes.push_back("link '" + link + "': the ellipsoid for " + e.source + " would have reached " +
                  numberText(wheel_bottom - low) + " m below the wheels; raised by " + numberText(raise) +
                  " m, its bottom is now the shape's");
}

}  // namespace

double distanceOutside(const Vector3d& p_EQ, const Vector3d& radii) {
  if (p_EQ.cwiseQuotient(radii).squaredNorm() <= 1.0) return 0.0;
  // The nearest point is r_i^2 p_i / (t + r_i^2) with the one t > 0 that puts it on the surface: the left side falls
  // with t, so bisection cannot miss it.
  const Vector3d r2 = radii.cwiseAbs2();
  double low = 0.0, high = radii.cwiseProduct(p_EQ).norm();
  for (int i = 0; i < 200 && high - low > 1e-15 * high; ++i) {
    const double t = 0.5 * (low + high);
    const Vector3d x = radii.cwiseProduct(p_EQ).cwiseQuotient((r2.array() + t).matrix());
    (x.squaredNorm() > 1.0 ? low : high) = t;
  }
  const Vector3d nearest = r2.cwiseProduct(p_EQ).cwiseQuotient((r2.array() + high).matrix());
  return (p_EQ - nearest).norm();
}

double fitError(const Vector3d& radii, const std::vector<PlacedShape>& shapes_E) {
  // What sticks out of the ellipsoid, exactly ...
  double error = 0.0;
  for (const PlacedShape& s : shapes_E) {
    for (const Vector3d& p : extremePoints(*s.shape)) error = std::max(error, distanceOutside(s.X_GS * p, radii));
  }
  // ... and how far the ellipsoid sticks out of the hull: the largest difference of their supports, over a golden
  // spiral of directions (between two of them it changes by a few per cent of itself, good enough for a report).
  for (const Vector3d& d : evenDirections(200)) {
    double reach = -kInfinity;
    for (const PlacedShape& s : shapes_E) {
      reach = std::max(reach, s.X_GS.p.dot(d) + support(*s.shape, s.X_GS.q.conjugate() * d));
    }
    const double difference = std::abs(radii.cwiseProduct(d).norm() - reach);
    constexpr double kRotationRounding = 1e-9;
    if (difference > kRotationRounding * radii.maxCoeff()) error = std::max(error, difference);
  }
  return error;
}

void addEllipsoids(VehicleDescription& vehicle, const std::vector<std::vector<CollisionShape>>& shapes,
                   const std::vector<GroundWheel>& wheels, std::vector<std::string>& notes) {
  const std::vector<int> parents = parentLinks(vehicle);
  const std::vector<Pose> X_RL = linkPosesAtZero(vehicle);
  std::vector<bool> done(vehicle.links.size(), false);
  double wheel_bottom = kInfinity;
  for (const GroundWheel& wheel : wheels) {
    const JointDescription& joint = vehicle.joints[wheel.joint];
    LinkDescription& link = vehicle.links[wheel.joint + 1];
    std::vector<PlacedShape> placed;
    for (const GroupedLink& g : rigidGroup(vehicle, parents, wheel.joint + 1)) {
      for (const CollisionShape& s : shapes[g.link]) placed.push_back({&s, g.X_GL * s.X_LS});
      done[g.link] = true;
    }
    EllipsoidDescription e = wheelEllipsoid(wheel.measure, joint.axis, placed, vehicle.file);
    e.name = link.name;
    const bool exact =
        placed.size() == 1 && placed.front().shape->kind == CollisionShape::Kind::kEllipsoid && e.fit_error == 0.0;
    if (!exact) notes.push_back(wheelNote(link.name, wheel.measure, e));
    wheel_bottom = std::min(wheel_bottom, wheel.bottom);
    link.ellipsoids.push_back(std::move(e));
  }
  for (std::size_t l = 0; l < vehicle.links.size(); ++l) {
    if (done[l]) continue;
    LinkDescription& link = vehicle.links[l];
    for (const CollisionShape& shape : shapes[l]) {
      EllipsoidDescription e = bodyEllipsoid(shape, vehicle.file);
      e.name = shapes[l].size() == 1 ? link.name : link.name + "/" + std::to_string(link.ellipsoids.size() + 1);
      if (shape.kind != CollisionShape::Kind::kEllipsoid) {
        notes.push_back("link '" + link.name + "': " + e.source + " stands as an ellipsoid of semi-axes " +
                        extentsText(e.radii) + " m, fit error " + numberText(e.fit_error) + " m");
      }
      if (!wheels.empty()) {
        keepAboveWheels(e, shape, X_RL[l], wheel_bottom, link.name, notes);
        const double low = lowest(e, X_RL[l]);
        if (low < wheel_bottom) {
          notes.push_back("link '" + link.name + "': " + e.source + " reaches " + numberText(wheel_bottom - low) +
                          " m below the wheels; the vehicle will stand on it");
        }
      }
      link.ellipsoids.push_back(std::move(e));
    }
  }
}

}  // namespace ellipsoid_vehicle_sim
