// ODE on W1, W2 and building. It has no ellipsoid: spheres of the wheels' radius take their place, so its contacts are
// easier.
#include <benchmark/benchmark.h>
#include <ode/ode.h>

#include "workloads.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

struct Mesh {
  std::vector<double> corners;
  std::vector<dTriIndex> indices;
  dTriMeshDataID data = dGeomTriMeshDataCreate();
  explicit Mesh(const TriangleSoup& soup) {
    for (const Eigen::Vector3d& v : soup.vertices) corners.insert(corners.end(), {v.x(), v.y(), v.z()});
    for (const auto& t : soup.triangles) indices.insert(indices.end(), {t[0], t[1], t[2]});
  }
  ~Mesh() { dGeomTriMeshDataDestroy(data); }
  Mesh(const Mesh&) = delete;
  Mesh& operator=(const Mesh&) = delete;
  void build() {
    dGeomTriMeshDataBuildDouble(data, corners.data(), 3 * sizeof(double), static_cast<int>(corners.size() / 3),
                                indices.data(), static_cast<int>(indices.size()), 3 * sizeof(dTriIndex));
  }
};

/// A world with one mesh as its ground, stepped with ODE's iterative solver.
struct World {
  Mesh mesh;
  dWorldID world = dWorldCreate();
  dSpaceID bodies = dSimpleSpaceCreate(nullptr);
  dGeomID ground;
  dJointGroupID contacts = dJointGroupCreate(0);

  explicit World(const TriangleSoup& soup) : mesh(soup) {
    mesh.build();
    ground = dCreateTriMesh(nullptr, mesh.data, nullptr, nullptr, nullptr);
    dWorldSetGravity(world, 0, 0, -9.80665);
  }
  ~World() {
    dJointGroupDestroy(contacts);
    dGeomDestroy(ground);
    dSpaceDestroy(bodies);
    dWorldDestroy(world);
  }
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  static void near(void* self, dGeomID a, dGeomID b) {
    World& w = *static_cast<World*>(self);
    constexpr int kMost = 4;
    dContact contact[kMost] = {};
    const int count = dCollide(a, b, kMost, &contact[0].geom, sizeof(dContact));
    for (int i = 0; i < count; ++i) {
      // 1e7 N/m, as ours.
      const double k = 1e7, d = 1e4, h = ride::kTick;
      contact[i].surface.mode = dContactSoftERP | dContactSoftCFM | dContactApprox1;
      contact[i].surface.mu = 1.0;
      contact[i].surface.soft_erp = h * k / (h * k + d);
      contact[i].surface.soft_cfm = 1.0 / (h * k + d);
      const dJointID joint = dJointCreateContact(w.world, w.contacts, &contact[i]);
      dJointAttach(joint, dGeomGetBody(contact[i].geom.g1), dGeomGetBody(contact[i].geom.g2));
    }
  }
  void step() {
    dSpaceCollide2(ground, reinterpret_cast<dGeomID>(bodies), this, &World::near);
    dWorldQuickStep(world, ride::kTick);
    dJointGroupEmpty(contacts);
  }
  dBodyID body(const Eigen::Vector3d& p, double mass, const Eigen::Vector3d& inertia) {
    const dBodyID b = dBodyCreate(world);
    dMass m;
    dMassSetParameters(&m, mass, 0, 0, 0, inertia.x(), inertia.y(), inertia.z(), 0, 0, 0);
    dBodySetMass(b, &m);
    dBodySetPosition(b, p.x(), p.y(), p.z());
    dBodySetAutoDisableFlag(b, 0);
    return b;
  }
  void sphere(dBodyID b, const Eigen::Vector3d& at, double radius) {
    const dGeomID g = dCreateSphere(bodies, radius);
    dGeomSetBody(g, b);
    dGeomSetOffsetPosition(g, at.x(), at.y(), at.z());
  }
};

void reportPerStep(benchmark::State& state, std::int64_t steps) {
  state.counters["us_per_step"] = benchmark::Counter(static_cast<double>(state.iterations() * steps) * 1e-6,
                                                     benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void dropBody(benchmark::State& state) {
  World ode(gridSoup(drop::kCells, 1.0, [](double, double) { return 0.0; }, {-10.0, -10.0, 0.0}));
  const Eigen::Vector3d squared = drop::chassis().cwiseAbs2(), start(0.13, 0.07, drop::kStartHeight);
  const dBodyID body =
      ode.body(start, drop::kMass, (Eigen::Vector3d::Constant(squared.sum()) - squared) * (drop::kMass / 5.0));
  ode.sphere(body, {0, 0, 0}, drop::chassis().z());
  for (const Eigen::Vector3d& p : drop::wheels()) ode.sphere(body, p, ride::kWheelRadius);
  const auto steps = std::llround(drop::kSeconds / drop::kTick);
  for (auto _ : state) {
    dBodySetPosition(body, start.x(), start.y(), start.z());
    dBodySetLinearVel(body, 0, 0, 0);
    dBodySetAngularVel(body, 0, 0, 0);
    for (std::int64_t i = 0; i < steps; ++i) ode.step();
  }
  const double z = dBodyGetPosition(body)[2];
  if (z < 0.6 || z > 0.8) state.SkipWithError("the body does not lie on its wheels");
  reportPerStep(state, steps);
}

void driveOverHills(benchmark::State& state) {
  World ode(hills(kHillCells));
  const Eigen::Vector3d start(0.0, -ride::kCircle, hillHeight(0.0, -ride::kCircle) + 0.45);
  const double body_mass = ride::kMass - 4.0 * ride::kWheelMass;
  const dBodyID chassis =
      ode.body(start + Eigen::Vector3d(0, 0, 0.15), body_mass, body_mass * Eigen::Vector3d(0.25, 1.2, 1.35));
  ode.sphere(chassis, {0, 0, 0.25}, 0.4);
  for (const double x : {ride::kAxle, -ride::kAxle})
    for (const double y : {ride::kHalfTrack, -ride::kHalfTrack}) {
      const Eigen::Vector3d p = start + Eigen::Vector3d(x, y, 0.0);
      const dBodyID wheel = ode.body(p, ride::kWheelMass, Eigen::Vector3d(0.55, 0.98, 0.55));
      ode.sphere(wheel, {0, 0, 0}, ride::kWheelRadius);
      const dJointID joint = dJointCreateHinge2(ode.world, nullptr);
      dJointAttach(joint, chassis, wheel);
      dJointSetHinge2Anchor(joint, p.x(), p.y(), p.z());
      const dReal up[3] = {0, 0, 1}, axle[3] = {0, 1, 0};
      dJointSetHinge2Axes(joint, up, axle);
      const double h = ride::kTick;
      dJointSetHinge2Param(joint, dParamSuspensionERP, h * ride::kSpring / (h * ride::kSpring + ride::kDamper));
      dJointSetHinge2Param(joint, dParamSuspensionCFM, 1.0 / (h * ride::kSpring + ride::kDamper));
      const double angle = x > 0.0 ? ride::steeringAngle() : 0.0;
      dJointSetHinge2Param(joint, dParamLoStop, angle);
      dJointSetHinge2Param(joint, dParamHiStop, angle);
      dJointSetHinge2Param(joint, dParamLoStop, angle);  // ODE takes a low stop only below the high one
      if (x < 0.0) {
        dJointSetHinge2Param(joint, dParamVel2, ride::kSpeed / ride::kWheelRadius);
        dJointSetHinge2Param(joint, dParamFMax2, 1500.0);
      }
    }
  const auto steps = std::llround(ride::kSeconds / ride::kTick), run_up = std::llround(ride::kRunUp / ride::kTick);
  for (std::int64_t i = 0; i < run_up; ++i) ode.step();
  double sum = 0.0;
  for (auto _ : state)
    for (std::int64_t i = 0; i < steps; ++i) {
      ode.step();
      const dReal* v = dBodyGetLinearVel(chassis);
      sum += std::hypot(v[0], v[1]);
    }
  const double mean = sum / static_cast<double>(steps * state.iterations());
  state.counters["mean_speed"] = mean;
  const dReal* p = dBodyGetPosition(chassis);
  if (std::abs(p[2] - hillHeight(p[0], p[1])) > 1.5) state.SkipWithError("left the ground");
  if (std::abs(mean - ride::kSpeed) > 0.3 * ride::kSpeed) state.SkipWithError("does not keep its speed");
  reportPerStep(state, steps);
}

void build(benchmark::State& state) {
  const TriangleSoup soup = hills(kManyHillCells);
  for (auto _ : state) {
    state.PauseTiming();
    Mesh mesh(soup);
    state.ResumeTiming();
    mesh.build();
  }
  state.counters["triangles_per_second"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * static_cast<double>(soup.triangles.size()),
                         benchmark::Counter::kIsRate);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test

int main(int argc, char** argv) {
  using namespace ellipsoid_vehicle_sim::test;
  dInitODE2(0);
  const auto add = [](const char* name, void (*function)(benchmark::State&)) {
    benchmark::RegisterBenchmark(name, function)->Unit(benchmark::kMillisecond)->Iterations(1);
  };
  add("W1_semi_implicit/ODE spheres", dropBody);
  add("W2_semi_implicit/ODE spheres", driveOverHills);
  add("build/ODE", build);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  dCloseODE();
}
