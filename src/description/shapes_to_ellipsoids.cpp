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
constexpr double kLeans = 0.3;           // radii above the wheels' bottoms: a vehicle on two wheels tips onto what is lower
constexpr int kLeaningEllipsoids = 8;    // at least, for a shape that is leant on

std::string baseName(const std::string& path) { return path.substr(path.find_last_of('/') + 1); }

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

/// The ellipsoids of a shape of the body, in its link.
std::vector<EllipsoidDescription> bodyEllipsoids(const CollisionShape& shape, int count, const std::string& file) {
  EllipsoidDescription e;
  e.X_LE = shape.X_LS;
  e.radii = shape.half;
  e.source = shape.text + " (" + baseName(file) + ":" + std::to_string(shape.line) + ")";
  if (shape.kind == CollisionShape::Kind::kEllipsoid) return {e};
  if (count <= 1) {
    e.fit_error = fitError(e.radii, {{&shape, Pose{}}});
    return {e};
  }
  const std::vector<Cell> cells = compoundOf(shape, count);
  e.fit_error = compoundError(cells, shape);
  std::vector<EllipsoidDescription> compound;
  for (const Cell& cell : cells) {
    e.X_LE = shape.X_LS * Pose{cell.centre_S, Eigen::Quaterniond::Identity()};
    e.radii = cell.radii;
    compound.push_back(e);
  }
  return compound;
}

/// Per link and shape, whether another shape of the same rigid body has it inside; told in notes.
std::vector<std::vector<bool>> coveredShapes(const VehicleDescription& vehicle,
                                             const std::vector<std::vector<CollisionShape>>& shapes,
                                             const std::vector<int>& parents, const std::vector<bool>& wheel_links,
                                             std::vector<std::string>& notes) {
  std::vector<std::vector<bool>> dropped;
  for (const auto& of_link : shapes) dropped.emplace_back(of_link.size(), false);
  for (std::size_t l = 0; l < vehicle.links.size(); ++l) {
    const bool starts_group = l == 0 || vehicle.joints[l - 1].type != JointType::kFixed;
    if (!starts_group || wheel_links[l]) continue;
    std::vector<PlacedShape> placed;
    std::vector<std::pair<int, std::size_t>> owner;
    for (const GroupedLink& g : rigidGroup(vehicle, parents, static_cast<int>(l)))
      for (std::size_t i = 0; i < shapes[g.link].size(); ++i) {
        placed.push_back({&shapes[g.link][i], g.X_GL * shapes[g.link][i].X_LS});
        owner.emplace_back(g.link, i);
      }
    const std::vector<int> by = coveredBy(placed);
    for (std::size_t i = 0; i < by.size(); ++i) {
      if (by[i] < 0) continue;
      dropped[owner[i].first][owner[i].second] = true;
      notes.push_back(placeText(vehicle.file, placed[i].shape->line, "link", vehicle.links[owner[i].first].name) + ": " +
                      placed[i].shape->text + " lies inside " + placed[by[i]].shape->text + " of link '" +
                      vehicle.links[owner[by[i]].first].name + "' (line " + std::to_string(placed[by[i]].shape->line) +
                      "): one stands for both");
    }
  }
  return dropped;
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
                   const std::vector<GroundWheel>& wheels, const ShapeRules& rules, std::vector<std::string>& notes) {
  const std::vector<int> parents = parentLinks(vehicle);
  const std::vector<Pose> X_RL = linkPosesAtZero(vehicle);
  std::vector<bool> done(vehicle.links.size(), false);
  double wheel_bottom = kInfinity, wheel_radius = 0.0;
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
    wheel_radius = std::max(wheel_radius, wheel.measure.radius);
    link.ellipsoids.push_back(std::move(e));
  }
  const std::vector<std::vector<bool>> dropped = coveredShapes(vehicle, shapes, parents, done, notes);
  for (std::size_t l = 0; l < vehicle.links.size(); ++l) {
    if (done[l]) continue;
    LinkDescription& link = vehicle.links[l];
    std::size_t kept = 0;
    for (std::size_t i = 0; i < shapes[l].size(); ++i) kept += dropped[l][i] ? 0 : 1;
    for (std::size_t i = 0; i < shapes[l].size(); ++i) {
      if (dropped[l][i]) continue;
      const CollisionShape& shape = shapes[l][i];
      const double shape_low = lowest(shape, X_RL[l] * shape.X_LS);
      const bool leans = wheels.size() < 3 && !wheels.empty() && shape_low < wheel_bottom + kLeans * wheel_radius;
      const int count = leans ? std::max(rules.body_ellipsoids, kLeaningEllipsoids) : rules.body_ellipsoids;
      std::vector<EllipsoidDescription> compound = bodyEllipsoids(shape, count, vehicle.file);
      if (shape.kind != CollisionShape::Kind::kEllipsoid) {
        notes.push_back("link '" + link.name + "': " + compound.front().source + " stands as " +
                        (compound.size() == 1 ? "an ellipsoid of semi-axes " + extentsText(compound.front().radii) + " m"
                                              : std::to_string(compound.size()) + " ellipsoids") +
                        ", fit error " + numberText(compound.front().fit_error) + " m");
      }
      const bool single = kept == 1 && compound.size() == 1;
      double low = kInfinity;
      for (EllipsoidDescription& e : compound) {
        e.name = single ? link.name : link.name + "/" + std::to_string(link.ellipsoids.size() + 1);
        if (!wheels.empty()) keepAboveWheels(e, shape, X_RL[l], wheel_bottom, link.name, notes);
        low = std::min(low, lowest(e, X_RL[l]));
        link.ellipsoids.push_back(std::move(e));
      }
      if (!wheels.empty() && low < wheel_bottom) {
        notes.push_back("link '" + link.name + "': " + link.ellipsoids.back().source + " reaches " +
                        numberText(wheel_bottom - low) + " m below the wheels; the vehicle will stand on it");
      }
    }
  }
}

}  // namespace ellipsoid_vehicle_sim
