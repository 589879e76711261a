// Whole steps of the whole simulator, one core, 1 kHz: W1 and W2 of workloads.h. Loading and set-down are not measured,
// nor the run-up of W2. Counter us_per_step, in CPU time.
#include <benchmark/benchmark.h>

#include "ellipsoid_vehicle_sim/fleet/fleet.h"
#include "support/motions.h"
#include "vehicles.h"
#include "workloads.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

SimConfig configOf(IntegratorKind integrator, ContactsPerEllipsoid contacts) {
  SimConfig config;
  config.rest_detection = false;  // what a step costs; that one at rest costs next to nothing is another figure
  config.dt = ride::kTick;
  config.integrator = integrator;
  config.contacts_per_ellipsoid = contacts;
  config.mu_static = config.mu_kinetic = 1.0;
  return config;
}

void reportPerStep(benchmark::State& state, std::int64_t steps) {
  // Iterations times steps, as a time: the inverse of a rate over CPU time.
  state.counters["us_per_step"] = benchmark::Counter(static_cast<double>(state.iterations() * steps) * 1e-6,
                                                     benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void dropBody(benchmark::State& state, SimConfig config) {
  const auto steps = std::llround(drop::kSeconds / drop::kTick);
  const auto floor = terrainOf(gridSoup(drop::kCells, 1.0, [](double, double) { return 0.0; }, {-10.0, -10.0, 0.0}));
  Simulator simulator = make(fiveEllipsoids(), floor, config);
  // Wheels and chassis clear the ground by one metre.
  placeAt(simulator, {0.13, 0.07, drop::kStartHeight}, Eigen::Vector3d::Zero());
  for (auto _ : state) {
    simulator.reset();
    for (std::int64_t i = 0; i < steps; ++i)
      if (simulator.step() != StepStatus::kOk) return state.SkipWithError("diverged");
  }
  const double z = simulator.rootPose().p.z();
  if (z < 0.6 || z > 0.8) return state.SkipWithError("the body does not lie on its wheels");
  reportPerStep(state, steps);
}

/// A drive on a circle: it turns the steering and meets every direction.
void driveOverHills(benchmark::State& state, int cells, IntegratorKind integrator, ContactsPerEllipsoid contacts,
                    double radius, double speed, double seconds) {
  const auto steps = std::llround(seconds / ride::kTick);
  Simulator simulator = make(car(), terrainOf(hills(cells)), configOf(integrator, contacts));
  const DriveCommand command = twist(speed, speed / radius);
  standAt(simulator, 0.0, -radius, 0.0);
  double sum = 0.0;
  std::int64_t samples = 0;
  for (auto _ : state) {
    state.PauseTiming();
    simulator.reset();
    drive(simulator, command, ride::kRunUp);
    state.ResumeTiming();
    for (std::int64_t i = 0; i < steps; ++i) {
      simulator.command(command);
      if (simulator.step() != StepStatus::kOk) return state.SkipWithError("diverged");
      sum += simulator.rootVelocity_W().norm();
      ++samples;
    }
  }
  const double mean = sum / static_cast<double>(samples);
  state.counters["mean_speed"] = mean;
  if (std::abs(mean - speed) > 0.1 * speed) return state.SkipWithError("does not keep its speed");
  reportPerStep(state, steps);
}

/// Twenty cars of five ellipsoids, one after the other on a hilly circle, RK4 at 1 kHz: a step of the whole fleet.
/// Counter real_time_factor: simulated time over CPU time, or over wall time on several threads. `real_time_factor`: simulated over wall time.
void driveFleet(benchmark::State& state, int threads) {
  constexpr int kVehicles = 20;
  constexpr double kRadius = 40.0, kSpeed = 6.0, kSeconds = 2.0;
  const auto terrain = terrainOf(hills(kHillCells));
  const SimConfig config = configOf(IntegratorKind::kRk4, ContactsPerEllipsoid::kValley);
  const auto steps = std::llround(kSeconds / config.dt);
  Fleet fleet(threads);
  for (int i = 0; i < kVehicles; ++i) {
    const double angle = 2.0 * M_PI * i / kVehicles;
    const Problems refused = fleet.add("car" + std::to_string(i), make(car(), terrain, config));
    if (!refused.empty()) return state.SkipWithError(refused.front().text().c_str());
    if (!fleet.setDown(static_cast<std::size_t>(i), kRadius * std::sin(angle), -kRadius * std::cos(angle), angle).empty())
      return state.SkipWithError("cannot be set down");
  }
  for (auto _ : state) {
    for (std::int64_t i = 0; i < steps; ++i) {
      for (std::size_t k = 0; k < fleet.size(); ++k) fleet.vehicle(k).command(twist(kSpeed, kSpeed / kRadius));
      if (fleet.step() != StepStatus::kOk) return state.SkipWithError("diverged");
    }
  }
  state.counters["real_time_factor"] =
      benchmark::Counter(kSeconds * static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
  reportPerStep(state, steps);
}

/// Twenty cars in two rows of ten on hills; the foremost of each brakes, the others push. A step of the whole fleet, 1 kHz.
void pushFleet(benchmark::State& state, IntegratorKind integrator) {
  constexpr std::size_t kRows = 2, kInRow = 10;
  constexpr int kStepsToMeet = 2500, kSteps = 100;
  constexpr std::size_t kFewestTouching = 6;
  const auto terrain = terrainOf(hills(kHillCells));
  const SimConfig config = configOf(integrator, ContactsPerEllipsoid::kValley);
  Fleet fleet(1);
  for (std::size_t i = 0; i < kRows * kInRow; ++i) {
    const Problems refused = fleet.add("car" + std::to_string(i), make(car(), terrain, config));
    if (!refused.empty()) return state.SkipWithError(refused.front().text().c_str());
    if (!fleet.setDown(i, 4.3 * static_cast<double>(i % kInRow), 6.0 * static_cast<double>(i / kInRow), 0.0).empty())
      return state.SkipWithError("cannot be set down");
  }
  const auto step = [&fleet] {
    for (std::size_t k = 0; k < fleet.size(); ++k)
      if (k % kInRow + 1 < kInRow) fleet.vehicle(k).command(twist(3.0));
    return fleet.step() == StepStatus::kOk;
  };
  for (int i = 0; i < kStepsToMeet; ++i)
    if (!step()) return state.SkipWithError("diverged");
  for (auto _ : state)
    for (int i = 0; i < kSteps; ++i)
      if (!step()) return state.SkipWithError("diverged");
  if (fleet.touching().size() < kFewestTouching) return state.SkipWithError("they do not push");
  reportPerStep(state, kSteps);
}

void registerAll() {
  const std::pair<const char*, IntegratorKind> integrators[] = {{"semi_implicit", IntegratorKind::kSemiImplicitEuler},
                                                                {"rk4", IntegratorKind::kRk4}};
  const auto add = [](const std::string& name, auto&& function) {
    benchmark::RegisterBenchmark(name.c_str(), function)->Unit(benchmark::kMillisecond);
  };
  for (const auto& [integrator_name, integrator_kind] : integrators) {
    const std::string name = integrator_name;
    const IntegratorKind integrator = integrator_kind;
    for (const auto contacts : {ContactsPerEllipsoid::kValley, ContactsPerEllipsoid::kOne}) {
      const std::string who = contacts == ContactsPerEllipsoid::kValley ? "/ours" : "/ours, one contact an ellipsoid";
      add("W1_" + name + who, [=](benchmark::State& s) { dropBody(s, configOf(integrator, contacts)); });
      add("W2_" + name + who, [=](benchmark::State& s) {
        driveOverHills(s, kHillCells, integrator, contacts, ride::kCircle, ride::kSpeed, ride::kSeconds);
      });
    }
    SimConfig rests = configOf(integrator, ContactsPerEllipsoid::kValley);
    rests.rest_detection = true;
    add("W1_" + name + "/ours, rest detected", [=](benchmark::State& s) { dropBody(s, rests); });
  }
  add("fleet_20_rk4/ours", [](benchmark::State& s) { driveFleet(s, 1); });
  // On several cores the time that counts is the wall's.
  benchmark::RegisterBenchmark("fleet_20_rk4/ours, 2 threads", [](benchmark::State& s) { driveFleet(s, 2); })
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime();
  for (const IntegratorKind kind : allIntegrators())
    if (kind != IntegratorKind::kExplicitEuler)
      add(std::string("fleet_20_pushing_") + toString(kind) + "/ours", [=](benchmark::State& s) { pushFleet(s, kind); });
  // A circle that fits the smallest world: the same steps to the last bit in all of them.
  const std::pair<const char*, int> worlds[] = {{"2k", 32}, {"20k", 100}, {"200k", kHillCells}, {"2M", kManyHillCells}};
  for (const auto& [size, cell_count] : worlds) {
    const int cells = cell_count;
    add(std::string("W2_world_") + size + "/ours", [=](benchmark::State& s) {
      driveOverHills(s, cells, IntegratorKind::kSemiImplicitEuler, ContactsPerEllipsoid::kValley, 12.0, 6.0, 10.0);
    });
  }
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test

int main(int argc, char** argv) {
  ellipsoid_vehicle_sim::test::registerAll();
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
