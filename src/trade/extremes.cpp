#include "ellipsoid_vehicle_sim/trade/extremes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ellipsoid_vehicle_sim/dynamics/rigid_inertia.h"
#include "ellipsoid_vehicle_sim/vehicle/touch_down.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

LinkDescription linkOf(const std::string& name, double mass, const Eigen::Matrix3d& I) {
  LinkDescription link;
  link.name = name;
  link.mass = mass;
  link.I_cm_L = I;
  return link;
}

EllipsoidDescription ellipsoidOf(const std::string& name, const Vector3d& p, const Vector3d& radii) {
  EllipsoidDescription e;
  e.name = name;
  e.X_LE.p = p;
  e.radii = radii;
  e.source = "extremes";
  return e;
}

VehicleDescription solid(const Vector3d& radii, double mass) {
  VehicleDescription v;
  v.name = v.root = "body";
  v.links = {linkOf("body", mass, solidEllipsoidInertia(mass, radii))};
  v.links[0].ellipsoids = {ellipsoidOf("body", Vector3d::Zero(), radii)};
  return v;
}

/// Four wheels on axles under a body of 100 kg.
VehicleDescription cart(double wheel_inertia) {
  VehicleDescription v;
  v.name = "cart";
  v.root = "body";
  v.layout = DriveLayout::kDifferential;
  v.links = {linkOf("body", 100.0, Vector3d(5.0, 10.0, 12.0).asDiagonal())};
  for (const double x : {0.5, -0.5})
    for (const double y : {0.4, -0.4}) {
      const std::string name = std::string(x > 0.0 ? "front" : "rear") + (y > 0.0 ? "_left" : "_right");
      LinkDescription wheel = linkOf(name, 5.0, Vector3d::Constant(wheel_inertia).asDiagonal());
      wheel.ellipsoids = {ellipsoidOf(name, Vector3d::Zero(), {0.2, 0.08, 0.2})};
      JointDescription axle;
      axle.name = name + "_axle";
      axle.type = JointType::kContinuous;
      axle.role = JointRole::kDrive;
      axle.parent = "body";
      axle.child = name;
      axle.X_PJ.p = {x, y, -0.1};
      axle.axis = Vector3d::UnitY();
      axle.effort_limit = 100.0;
      v.joints.push_back(axle);
      v.links.push_back(wheel);
    }
  return v;
}

/// A level floor, or one that falls by `slope` along x, of squares of `cell` around (at, at).
Loaded<Terrain> floorOf(double cell, double at, double slope) {
  TriangleSoup soup;
  constexpr int kCells = 24;
  const double half = 0.5 * kCells * cell;
  for (int j = 0; j <= kCells; ++j)
    for (int i = 0; i <= kCells; ++i) {
      const double s = -half + cell * i;
      soup.vertices.push_back({at + s * std::cos(slope), at - half + cell * j, -s * std::sin(slope)});
    }
  const auto index = [](int i, int j) { return static_cast<std::uint32_t>(j * (kCells + 1) + i); };
  for (int j = 0; j < kCells; ++j)
    for (int i = 0; i < kCells; ++i) {
      soup.triangles.push_back({index(i, j), index(i + 1, j), index(i + 1, j + 1)});
      soup.triangles.push_back({index(i, j), index(i + 1, j + 1), index(i, j + 1)});
    }
  soup.surface.assign(soup.triangles.size(), 0);
  soup.surfaces = {Surface{"floor", {}, {}}};
  return Terrain::build(std::move(soup));
}

/// The scene of a cell: the vehicle, the world, and how it starts.
struct Setup {
  VehicleDescription vehicle;
  SimConfig config;
  double cell = 20.0, at = 0.0, slope = 0.0, height = 0.0;
  Vector3d v = {1.0, 0.3, -1.0}, w = {0.5, 2.0, 0.3};
  bool stands = false;
};

Setup setupOf(const ExtremeCell& cell) {
  Setup s;
  const Vector3d radii(0.3, 0.25, 0.2);
  s.vehicle = solid(radii, 10.0);
  s.height = 0.35;
  SimConfig& c = s.config;
  c.integrator = cell.integrator;
  c.dt = cell.dt;
  c.allow_no_wheels = true;
  c.energy_balance = true;
  const auto& axis = cell.axis;
  const double x = cell.value;
  if (axis == "mass") s.vehicle = solid(radii, x);
  if (axis == "wheel_inertia") {
    s.vehicle = cart(x);
    s.height = 0.301;
    s.v = {2.0, 0.0, 0.0};
    s.w.setZero();
    c.allow_no_wheels = false;
  }
  if (axis == "stiffness") c.stiffness = x;
  if (axis == "damping_ratio") {
    c.stiffness = 1e5;
    c.damping = 2.0 * x * std::sqrt(1e5 * 10.0);
  }
  if (axis == "speed") s.v = {x, 0.0, -std::min(x, 20.0)};
  if (axis == "spin") s.w = {0.1 * x, x, 0.0};
  if (axis == "thinness") s.vehicle = solid(x >= 1.0 ? Vector3d(0.3, 0.3 / x, 0.3 / x) : Vector3d(0.3, 0.3, 0.3 * x), 10.0);
  if (axis == "triangle") s.cell = x;
  if (axis == "offset") s.at = x;
  if (axis == "gravity") c.gravity = x;
  if (axis == "friction") c.mu_static = c.mu_kinetic = x;
  if (axis == "slope") {
    // Four feet on a slope that mu = 0.8 just holds, `value` degrees below the last.
    s.vehicle = solid({0.5, 0.4, 0.2}, 50.0);
    s.vehicle.links[0].ellipsoids.clear();
    for (const double fx : {-0.5, 0.5})
      for (const double fy : {-0.4, 0.4})
        s.vehicle.links[0].ellipsoids.push_back(ellipsoidOf("foot" + std::to_string(s.vehicle.links[0].ellipsoids.size()),
                                                            {fx, fy, -0.2}, Vector3d::Constant(0.1)));
    s.slope = std::atan(0.8) - x * M_PI / 180.0;
    c.mu_static = c.mu_kinetic = 0.8;
    s.stands = true;
  }
  return s;
}

// Of a cell: simulated time, and ticks that are made in any case.
constexpr double kLongestTime = 2.0;
constexpr int kFewestTicks = 20;

bool isFinite(const Simulator& simulator) {
  return simulator.state().motion.allFinite() && std::isfinite(simulator.energy());
}

std::vector<double> decades(double from, double to) {
  std::vector<double> values;
  for (double x = from; x <= to * 1.0001; x *= 10.0) values.push_back(x);
  return values;
}

}  // namespace

const std::vector<ExtremeAxis>& extremeAxes() {
  static const std::vector<ExtremeAxis> axes = {
      {"mass", "kg", "an ellipsoid is thrown on the ground", decades(1e-2, 1e5)},
      {"wheel_inertia", "kg m^2", "a cart of 120 kg is let roll, its brakes on", decades(1e-9, 1e3)},
      {"stiffness", "N/m", "the same ellipsoid, 10 kg", decades(1e3, 1e10)},
      {"damping_ratio", "-", "of its contact", {0.0, 0.01, 0.1, 0.3, 1.0, 3.0, 10.0}},
      {"speed", "m/s", "it is shot along the ground", {0.01, 0.1, 1.0, 10.0, 100.0, 500.0}},
      {"spin", "rad/s", "it spins", {0.1, 1.0, 10.0, 100.0, 1e3, 1e4}},
      {"thinness", "-", "a disc (below one) or a needle (above)", decades(1e-4, 1e4)},
      {"triangle", "m", "size of the triangles it falls on", decades(1e-4, 1e4)},
      {"offset", "m", "of the world from the origin, along x and y", {0.0, 1e2, 1e4, 1e6}},
      {"gravity", "m/s^2", "", {0.0, 0.1, 1.0, 9.80665, 100.0}},
      {"friction", "-", "coefficient", {0.0, 0.01, 0.1, 1.0, 10.0}},
      {"slope", "deg", "four feet stand so many degrees below the slope that friction holds", {0.1, 0.2, 0.5, 1.0, 5.0}}};
  return axes;
}

double energyBound(IntegratorKind integrator) {
  switch (integrator) {
    case IntegratorKind::kExplicitEuler:
    case IntegratorKind::kSemiImplicitEuler:
    case IntegratorKind::kRk4:
    case IntegratorKind::kRk4Events: return 0.05;
    case IntegratorKind::kDormandPrince:
    case IntegratorKind::kLinearlyImplicit: return 0.1;
  }
  return 0.0;
}

double turnGain(IntegratorKind integrator, double angle) {
  switch (integrator) {
    case IntegratorKind::kExplicitEuler:
    case IntegratorKind::kSemiImplicitEuler: return 0.02 * angle * angle;
    case IntegratorKind::kRk4:
    case IntegratorKind::kRk4Events: return 1.5e-4 * std::pow(angle, 5);
    // These take smaller steps, or damp.
    case IntegratorKind::kDormandPrince:
    case IntegratorKind::kLinearlyImplicit: return 0.0;
  }
  return 0.0;
}

AccountBound accountBound(IntegratorKind integrator) {
  switch (integrator) {
    case IntegratorKind::kExplicitEuler:
    case IntegratorKind::kSemiImplicitEuler: return {0.05, 0.01};
    case IntegratorKind::kRk4:
    case IntegratorKind::kRk4Events: return {0.01, 0.01};
    // Its steps bear contacts a hundred times stiffer than their size resolves.
    case IntegratorKind::kDormandPrince: return {0.5, 0.01};
    // Damps what it does not resolve, all of it if need be.
    case IntegratorKind::kLinearlyImplicit: return {0.1, std::numeric_limits<double>::infinity()};
  }
  return {0.0, 0.0};
}

const char* toString(ExtremeOutcome outcome) {
  switch (outcome) {
    case ExtremeOutcome::kPassive: return "passive";
    case ExtremeOutcome::kRefused: return "refused";
    case ExtremeOutcome::kStopped: return "stopped";
    case ExtremeOutcome::kReported: return "reported";
    case ExtremeOutcome::kGained: return "gained";
  }
  return "unknown";
}

ExtremeResult runExtreme(const ExtremeCell& cell, int ticks) {
  ExtremeResult result;
  const Setup setup = setupOf(cell);
  const auto refuse = [&result](const Problems& problems) {
    result.outcome = ExtremeOutcome::kRefused;
    result.cause = problems.empty() ? "" : problems.front().text();
    return result;
  };
  Loaded<Terrain> terrain = floorOf(setup.cell, setup.at, setup.slope);
  if (!terrain) return refuse(terrain.problems);
  const auto shared = std::make_shared<const Terrain>(std::move(*terrain.value));
  if (const Problems problems = setup.config.validate(); !problems.empty()) return refuse(problems);
  SimConfig unbounded = setup.config;
  unbounded.allow_unstable = true;
  Loaded<Simulator> loaded = Simulator::create(setup.vehicle, shared, unbounded);
  if (!loaded) return refuse(loaded.problems);
  result.predicted = loaded.value->certificate().largestStep(cell.integrator) / cell.dt;
  if (loaded.value->isBeyondCertificate()) {
    loaded = Simulator::create(setup.vehicle, shared, setup.config);
    if (!loaded) return refuse(loaded.problems);
  }
  Simulator& simulator = *loaded.value;
  const Problems placed =
      setup.stands ? simulator.setDown(setup.at, setup.at, 0.0)
                   : simulator.place({Vector3d(setup.at, setup.at, setup.height), Eigen::Quaterniond::Identity()}, setup.v, setup.w);
  if (!placed.empty()) return refuse(placed);

  // What it has to spend: its motion, and what it falls until it has left the floor behind or lies on it.
  const double start = simulator.energy();
  const double g = simulator.config().gravity, mass = simulator.model().mass;
  double lowest = simulator.state().motion.X_WB.p.z();
  double kinetic = 0.5 * mass * simulator.rootVelocity_W().squaredNorm();
  for (const LinkDescription& link : setup.vehicle.links)
    kinetic += 0.5 * simulator.rootAngularVelocity_W().dot(link.I_cm_L * simulator.rootAngularVelocity_W());
  const double first = lowest;
  // What is coarse need not run for minutes to show what comes of it.
  ticks = std::min(ticks, std::max(kFewestTicks, static_cast<int>(kLongestTime / cell.dt)));
  // This one takes up to a thousand steps to a tick.
  if (cell.integrator == IntegratorKind::kDormandPrince) ticks = std::min(ticks, kFewestTicks);
  double turned = 0.0;
  for (int tick = 0; tick < ticks; ++tick) {
    turned += turnGain(cell.integrator, simulator.rootAngularVelocity_W().norm() * cell.dt);
    if (simulator.step() != StepStatus::kOk) {
      result.outcome = ExtremeOutcome::kStopped;
      result.cause = "the next state would have exploded; frozen at the last good one";
      return result;
    }
    if (!isFinite(simulator)) {
      result.outcome = ExtremeOutcome::kGained;
      result.cause = "not finite";
      return result;
    }
    lowest = std::min(lowest, simulator.state().motion.X_WB.p.z());
    const double spendable = kinetic + mass * g * std::max(first - lowest, 0.01);
    const EnergyBalance balance = simulator.energyBalance();
    result.gain = std::max(result.gain, (balance.energy - start) / spendable);
    const double unaccounted = balance.error() / spendable;
    if (std::abs(unaccounted) > std::abs(result.unaccounted)) result.unaccounted = unaccounted;
    if (simulator.events().passed_through > 0) {
      result.outcome = ExtremeOutcome::kReported;
      result.cause = "an ellipsoid went through the ground";
      return result;
    }
  }
  const AccountBound bound = accountBound(cell.integrator);
  result.bound = energyBound(cell.integrator) + turned +
                 worstTouchDown(simulator.model(), cell.integrator, cell.dt, simulator.config().contact_substeps).gain;
  const bool closed = result.predicted < kAccountMargin ||
                      (result.unaccounted <= bound.gained + turned && result.unaccounted >= -bound.vanished);
  if (result.gain > result.bound || !closed) result.outcome = ExtremeOutcome::kGained;
  return result;
}

}  // namespace ellipsoid_vehicle_sim
