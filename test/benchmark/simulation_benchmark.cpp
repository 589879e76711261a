// Whole steps of the whole simulator, one core, 1 kHz.
//   drop:  one 1000 kg body of five ellipsoids (chassis 2.0 x 0.8 x 0.5 m, wheels 0.35 x 0.12 x 0.35 m at (+-1.3,
//   +-0.75, -0.4))
//          from 1 m onto 800 flat triangles, 5 s.
//   drive: a 1200 kg car, the same wheels, suspension 25 kN/m and 2 kN s/m, steering, wheel spin, friction 1, at 15 m/s
//   over
//          316 x 316 cells of 1 m (199,712 triangles), a sum of sines to 0.5 m, 20 s.
// Loading and set-down are not measured; the run-up to 15 m/s of `drive` neither. Counter us_per_step, in CPU time.
#include <benchmark/benchmark.h>

#include "support/meshes.h"
#include "support/motions.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

constexpr double kTick = 1e-3;

SimConfig configOf(IntegratorKind integrator, ContactsPerEllipsoid contacts) {
  SimConfig config;
  config.dt = kTick;
  config.integrator = integrator;
  config.contacts_per_ellipsoid = contacts;
  config.mu_static = config.mu_kinetic = 1.0;
  return config;
}

VehicleDescription fiveEllipsoids() {
  const Eigen::Vector3d chassis(2.0, 0.8, 0.5), wheel(0.35, 0.12, 0.35);
  VehicleDescription body = solidBody(chassis, 1000.0);
  for (const double x : {-1.3, 1.3})
    for (const double y : {-0.75, 0.75})
      body.links[0].ellipsoids.push_back(
          ellipsoid("wheel" + std::to_string(body.links[0].ellipsoids.size()), Eigen::Vector3d(x, y, -0.4), wheel));
  return body;
}

void reportPerStep(benchmark::State& state, std::int64_t steps) {
  // Iterations times steps, as a time: the inverse of a rate over CPU time.
  state.counters["us_per_step"] = benchmark::Counter(static_cast<double>(state.iterations() * steps) * 1e-6,
                                                     benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void drop(benchmark::State& state, IntegratorKind integrator, ContactsPerEllipsoid contacts) {
  constexpr std::int64_t kSteps = 5000;
  const auto floor = terrainOf(gridSoup(20, 1.0, [](double, double) { return 0.0; }, {-10.0, -10.0, 0.0}));
  Simulator simulator = make(fiveEllipsoids(), floor, configOf(integrator, contacts));
  // Wheels and chassis clear the ground by one metre.
  placeAt(simulator, {0.13, 0.07, 1.0 + 0.75}, Eigen::Vector3d::Zero());
  for (auto _ : state) {
    simulator.reset();
    for (std::int64_t i = 0; i < kSteps; ++i)
      if (simulator.step() != StepStatus::kOk) return state.SkipWithError("diverged");
  }
  const double z = simulator.rootPose().p.z();
  if (z < 0.6 || z > 0.8) return state.SkipWithError("the body does not lie on its wheels");
  reportPerStep(state, kSteps);
}

double sumOfSines(double x, double y) {
  return 0.2 * std::sin(0.21 * x) + 0.15 * std::sin(0.33 * y + 1.0) + 0.1 * std::sin(0.5 * x + 0.3 * y) +
         0.05 * std::sin(0.8 * x - 0.6 * y);
}

void driveOverHills(benchmark::State& state, IntegratorKind integrator, ContactsPerEllipsoid contacts) {
  constexpr std::int64_t kSteps = 20000;
  const auto hills = terrainOf(gridSoup(316, 1.0, sumOfSines, {-158.0, -158.0, 0.0}));
  Simulator simulator = make(car(), hills, configOf(integrator, contacts));
  // A circle of 60 m radius stays on the map, turns the steering and meets every direction.
  const DriveCommand command = twist(15.0, 15.0 / 60.0);
  standAt(simulator, 0.0, -60.0, 0.0);
  double speed = 0.0;
  std::int64_t samples = 0;
  for (auto _ : state) {
    state.PauseTiming();
    simulator.reset();
    drive(simulator, command, 6.0);
    state.ResumeTiming();
    for (std::int64_t i = 0; i < kSteps; ++i) {
      simulator.command(command);
      if (simulator.step() != StepStatus::kOk) return state.SkipWithError("diverged");
      speed += simulator.rootVelocity_W().norm();
      ++samples;
    }
  }
  state.counters["mean_speed"] = speed / static_cast<double>(samples);
  reportPerStep(state, kSteps);
}

#define VARIANTS(function)                                                                                             \
  BENCHMARK_CAPTURE(function, semi_implicit_one, IntegratorKind::kSemiImplicitEuler, ContactsPerEllipsoid::kOne)       \
      ->Unit(benchmark::kMillisecond);                                                                                 \
  BENCHMARK_CAPTURE(function, semi_implicit_valley, IntegratorKind::kSemiImplicitEuler, ContactsPerEllipsoid::kValley) \
      ->Unit(benchmark::kMillisecond);                                                                                 \
  BENCHMARK_CAPTURE(function, rk4_one, IntegratorKind::kRk4, ContactsPerEllipsoid::kOne)                               \
      ->Unit(benchmark::kMillisecond);                                                                                 \
  BENCHMARK_CAPTURE(function, rk4_valley, IntegratorKind::kRk4, ContactsPerEllipsoid::kValley)                         \
      ->Unit(benchmark::kMillisecond)

VARIANTS(drop);
VARIANTS(driveOverHills);

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test

BENCHMARK_MAIN();
