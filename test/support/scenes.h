#pragma once

#include <Eigen/Core>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/dynamics/rigid_inertia.h"
#include "ellipsoid_vehicle_sim/vehicle/simulator.h"

/// Small worlds and vehicles made in code, for tests that state their physics in a formula.
namespace ellipsoid_vehicle_sim::test {

inline std::shared_ptr<const Terrain> terrainOf(TriangleSoup soup) {
  if (soup.surfaces.empty()) soup.surfaces = {Surface{"ground", {}, {}}};
  soup.surface.resize(soup.triangles.size(), 0);
  Loaded<Terrain> terrain = Terrain::build(std::move(soup));
  if (!terrain) throw std::runtime_error(problemText(terrain.problems));
  return std::make_shared<const Terrain>(std::move(*terrain.value));
}

/// Adds a quadrilateral a b c d, counter-clockwise seen from its front.
inline void addQuad(TriangleSoup& soup, const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                    const Eigen::Vector3d& d) {
  const auto i = static_cast<std::uint32_t>(soup.vertices.size());
  soup.vertices.insert(soup.vertices.end(), {a, b, c, d});
  soup.triangles.push_back({i, i + 1, i + 2});
  soup.triangles.push_back({i, i + 2, i + 3});
}

/// A square floor through the origin, of `cells` x `cells` quadrilaterals, tilted about y by `slope` [rad]: it rises along +x
/// for a negative slope.
inline TriangleSoup floorSoup(double half_size, int cells, double slope = 0.0) {
  TriangleSoup soup;
  const double step = 2.0 * half_size / cells;
  const auto point = [&](int i, int j) {
    const double s = -half_size + step * i, y = -half_size + step * j;
    return Eigen::Vector3d(s * std::cos(slope), y, -s * std::sin(slope));
  };
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i) soup.vertices.push_back(point(i, j));
  const auto index = [&](int i, int j) { return static_cast<std::uint32_t>(j * (cells + 1) + i); };
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      soup.triangles.push_back({index(i, j), index(i + 1, j), index(i + 1, j + 1)});
      soup.triangles.push_back({index(i, j), index(i + 1, j + 1), index(i, j + 1)});
    }
  return soup;
}

inline std::shared_ptr<const Terrain> flatFloor(double half_size = 500.0, int cells = 1) {
  return terrainOf(floorSoup(half_size, cells));
}

/// A floor far below everything: a world without contact.
inline std::shared_ptr<const Terrain> emptySpace() {
  TriangleSoup soup = floorSoup(1.0, 1);
  for (Eigen::Vector3d& v : soup.vertices) v.z() -= 1e8;
  return terrainOf(std::move(soup));
}

inline LinkDescription link(const std::string& name, double mass, const Eigen::Vector3d& p_cm, const Eigen::Matrix3d& I) {
  LinkDescription result;
  result.name = name;
  result.mass = mass;
  result.p_Lcm = p_cm;
  result.I_cm_L = I;
  return result;
}

inline EllipsoidDescription ellipsoid(const std::string& name, const Eigen::Vector3d& p, const Eigen::Vector3d& radii) {
  EllipsoidDescription result;
  result.name = name;
  result.X_LE.p = p;
  result.radii = radii;
  result.source = "made by a test";
  return result;
}

/// One solid ellipsoid.
inline VehicleDescription solidBody(const Eigen::Vector3d& radii, double mass) {
  VehicleDescription body;
  body.name = "body";
  body.root = "body";
  body.links = {link("body", mass, Eigen::Vector3d::Zero(), solidEllipsoidInertia(mass, radii))};
  body.links[0].ellipsoids = {ellipsoid("body", Eigen::Vector3d::Zero(), radii)};
  return body;
}

/// A block on four little spheres, one rigid body.
inline VehicleDescription fourFeet(double mass, double half_length = 0.5, double half_width = 0.4, double foot = 0.1) {
  VehicleDescription body;
  body.name = "block";
  body.root = "block";
  body.links = {link("block", mass, Eigen::Vector3d::Zero(), solidEllipsoidInertia(mass, {half_length, half_width, 0.2}))};
  int i = 0;
  for (const double x : {-half_length, half_length})
    for (const double y : {-half_width, half_width})
      body.links[0].ellipsoids.push_back(
          ellipsoid("foot" + std::to_string(i++), Eigen::Vector3d(x, y, 0.0), Eigen::Vector3d::Constant(foot)));
  return body;
}

struct CarShape {
  double mass = 1200.0, wheel_mass = 20.0;
  double front = 1.3, rear = -1.3, half_track = 0.75;
  Eigen::Vector3d wheel = {0.35, 0.12, 0.35};
  double spring = 25e3, damper = 2e3, height = 0.15;
  bool suspension = true, steering = true, body_shape = true;
};

/// A car with suspension, Ackermann steering in front and rear drive; the root link at wheel height, amidships.
inline VehicleDescription car(const CarShape& shape = {}) {
  VehicleDescription v;
  v.name = "car";
  v.root = "base_link";
  v.layout = shape.steering ? DriveLayout::kAckermann : DriveLayout::kDifferential;
  const double body_mass =
      shape.mass - 4.0 * (shape.wheel_mass + (shape.suspension ? 5.0 : 0.0)) - (shape.steering ? 2.0 * 0.5 : 0.0);
  v.links.push_back(link("base_link", body_mass, {0, 0, shape.height},
                         Eigen::Vector3d(0.25 * body_mass, 1.2 * body_mass, 1.35 * body_mass).asDiagonal()));
  if (shape.body_shape)
    v.links[0].ellipsoids.push_back(ellipsoid("chassis", {0, 0, shape.height + 0.25}, {2.0, 0.8, 0.4}));
  const double carried = 0.25 * body_mass * 9.80665;
  for (const bool front : {true, false})
    for (const bool left : {true, false}) {
      const std::string name = std::string(front ? "front" : "rear") + (left ? "_left" : "_right");
      std::string parent = "base_link";
      const auto add = [&](const std::string& suffix, JointType type, JointRole role, const Eigen::Vector3d& axis,
                           const LinkDescription& child) {
        JointDescription joint;
        joint.name = name + suffix;
        joint.type = type;
        joint.role = role;
        joint.parent = parent;
        joint.child = child.name;
        if (parent == "base_link")
          joint.X_PJ.p = {front ? shape.front : shape.rear, left ? shape.half_track : -shape.half_track, 0.0};
        joint.axis = axis;
        v.joints.push_back(joint);
        v.links.push_back(child);
        parent = child.name;
        return &v.joints.back();
      };
      if (shape.suspension) {
        JointDescription* joint =
            add("_suspension", JointType::kPrismatic, JointRole::kSuspension, {0, 0, 1},
                link(name + "_upright", 5.0, Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity() * 0.05));
        joint->lower = -0.1;
        joint->upper = 0.1;
        joint->spring_stiffness = shape.spring;
        joint->damping = shape.damper;
        joint->spring_reference = -carried / shape.spring;
      }
      if (shape.steering && front) {
        JointDescription* joint =
            add("_steer", JointType::kRevolute, JointRole::kSteer, {0, 0, 1},
                link(name + "_knuckle", 0.5, Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity() * 0.01));
        joint->lower = -0.6;
        joint->upper = 0.6;
      }
      LinkDescription wheel = link(name + "_wheel", shape.wheel_mass, Eigen::Vector3d::Zero(),
                                   solidEllipsoidInertia(shape.wheel_mass, shape.wheel));
      wheel.ellipsoids = {ellipsoid(name + "_wheel", Eigen::Vector3d::Zero(), shape.wheel)};
      const bool driven = !front || !shape.steering;
      JointDescription* joint = add("_axle", JointType::kContinuous, driven ? JointRole::kDrive : JointRole::kFreeWheel, {0, 1, 0}, wheel);
      joint->effort_limit = 1500.0;
    }
  return v;
}

inline Simulator make(const VehicleDescription& vehicle, std::shared_ptr<const Terrain> terrain, SimConfig config) {
  if (vehicle.layout == DriveLayout::kNone) config.allow_no_wheels = true;
  Loaded<Simulator> simulator = Simulator::create(vehicle, std::move(terrain), config);
  if (!simulator) throw std::runtime_error(problemText(simulator.problems));
  return std::move(*simulator.value);
}

inline void run(Simulator& simulator, double seconds) {
  const auto steps = static_cast<std::int64_t>(std::llround(seconds / simulator.config().dt));
  for (std::int64_t i = 0; i < steps; ++i)
    if (simulator.step() != StepStatus::kOk) throw std::runtime_error("the simulation diverged");
}

/// Those that take the tick as a whole, in one formula.
inline std::vector<IntegratorKind> oneStepIntegrators() {
  return {IntegratorKind::kExplicitEuler, IntegratorKind::kSemiImplicitEuler, IntegratorKind::kRk4};
}

inline std::vector<IntegratorKind> allIntegrators() {
  return {IntegratorKind::kExplicitEuler, IntegratorKind::kSemiImplicitEuler, IntegratorKind::kRk4,
          IntegratorKind::kRk4Events,     IntegratorKind::kDormandPrince,     IntegratorKind::kLinearlyImplicit};
}

}  // namespace ellipsoid_vehicle_sim::test
