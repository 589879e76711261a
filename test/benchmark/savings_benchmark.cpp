// What is left out, and what that is worth: ticks of 1 ms with and without. Counter ns_per_tick, in CPU time. Loading and
// set-down are not measured.
#include <benchmark/benchmark.h>

#include <functional>
#include <string>

#include "support/motions.h"
#include "vehicles.h"
#include "workloads.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Vector3d;
using Change = std::function<void(SimConfig&)>;
using Start = std::function<void(Simulator&)>;

SimConfig plain(IntegratorKind integrator) {
  SimConfig config;
  config.integrator = integrator;
  config.rest_detection = false;
  config.allow_no_wheels = true;
  return config;
}

/// Ticks from a start, over and over.
void ticks(benchmark::State& state, Simulator& simulator, const Start& command, int count) {
  for (auto _ : state) {
    state.PauseTiming();
    simulator.reset();
    state.ResumeTiming();
    for (int i = 0; i < count; ++i) {
      if (command) command(simulator);
      if (simulator.step() != StepStatus::kOk) return state.SkipWithError("diverged");
    }
  }
  state.counters["ns_per_tick"] = benchmark::Counter(static_cast<double>(state.iterations() * count) * 1e-9,
                                                     benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

VehicleDescription ball() { return solidBody(Vector3d(0.15, 0.1, 0.1), 0.5); }

void flyBall(benchmark::State& state, const SimConfig& config) {
  Simulator simulator = make(ball(), terrainOf(flatSoup(40, 10.0)), config);
  placeAt(simulator, {100.0, 100.0, 1000.0}, {3.0, 0.0, 0.0});
  ticks(state, simulator, {}, 5000);
}

void rollBall(benchmark::State& state, const SimConfig& config) {
  Simulator simulator = make(ball(), terrainOf(flatSoup(40, 10.0)), config);
  placeAt(simulator, {100.0, 100.0, 0.099}, {1.0, 0.0, 0.0});
  ticks(state, simulator, {}, 2000);
}

void flyCar(benchmark::State& state, const SimConfig& config) {
  Simulator simulator = make(car(), terrainOf(flatSoup(40, 10.0)), config);
  placeAt(simulator, {100.0, 100.0, 1000.0}, {3.0, 0.0, 0.0});
  ticks(state, simulator, {}, 2000);
}

void flyCompound(benchmark::State& state, const SimConfig& config) {
  Simulator simulator = make(fiveEllipsoids(), terrainOf(flatSoup(40, 10.0)), config);
  placeAt(simulator, {100.3, 100.7, 1000.0}, {3.0, 0.0, 0.0}, {0.1, 0.2, 0.3});
  ticks(state, simulator, {}, 2000);
}

/// Lies on its four wheels; with rest detection the ticks before it is found at rest are not measured.
void lay(benchmark::State& state, const VehicleDescription& vehicle, const SimConfig& config) {
  Simulator simulator = make(vehicle, terrainOf(flatSoup(40, 10.0)), config);
  standAt(simulator, 100.3, 100.7, 0.0);
  for (int i = 0; i < 20000 && !(config.rest_detection && simulator.isResting()); ++i)
    if (simulator.step() != StepStatus::kOk) return state.SkipWithError("diverged");
  if (config.rest_detection != simulator.isResting()) return state.SkipWithError("does not rest");
  constexpr int kTicks = 2000;
  for (auto _ : state)
    for (int i = 0; i < kTicks; ++i) simulator.step();
  state.counters["ns_per_tick"] = benchmark::Counter(static_cast<double>(state.iterations() * kTicks) * 1e-9,
                                                     benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void layCompound(benchmark::State& state, const SimConfig& config) { lay(state, fiveEllipsoids(), config); }
void parkCar(benchmark::State& state, const SimConfig& config) { lay(state, car(), config); }

void driveCar(benchmark::State& state, const SimConfig& config) {
  Simulator simulator = make(car(), terrainOf(hills(100)), config);
  standAt(simulator, 0.0, -12.0, 0.0);
  ticks(state, simulator, [](Simulator& s) { s.command(twist(5.0, 5.0 / 12.0)); }, 3000);
}

void registerAll() {
  const auto add = [](const std::string& name, void (*scene)(benchmark::State&, const SimConfig&), IntegratorKind integrator,
                      const Change& change = {}) {
    SimConfig config = plain(integrator);
    if (change) change(config);
    benchmark::RegisterBenchmark((name + "/" + toString(integrator)).c_str(),
                                 [=](benchmark::State& state) { scene(state, config); });
  };
  const auto unsaved = [](SimConfig& c) { c.exact_savings = ExactSavings::kOff; };
  for (const auto integrator : {IntegratorKind::kSemiImplicitEuler, IntegratorKind::kRk4, IntegratorKind::kRk4Events}) {
    add("ball, rolls", rollBall, integrator);
    add("ball, flies", flyBall, integrator);
    add("ball, flies, nothing left out", flyBall, integrator, unsaved);
    add("compound of five, stands", layCompound, integrator);
    add("compound of five, flies", flyCompound, integrator);
    add("compound of five, rests", layCompound, integrator, [](SimConfig& c) { c.rest_detection = true; });
    add("car, drives", driveCar, integrator);
    add("car, drives, nothing left out", driveCar, integrator, unsaved);
    add("car, drives, no triangles kept", driveCar, integrator, [](SimConfig& c) { c.candidate_cache = false; });
    add("car, drives, one contact an ellipsoid", driveCar, integrator,
        [](SimConfig& c) { c.contacts_per_ellipsoid = ContactsPerEllipsoid::kOne; });
    add("car, drives, solid compound", driveCar, integrator, [](SimConfig& c) { c.solid_compound = true; });
    add("car, drives, rolling resistance and drag", driveCar, integrator,
        [](SimConfig& c) { c.rolling_resistance = 0.015, c.drag_area = 0.6; });
    add("car, drives, error estimate every 10 ticks", driveCar, integrator, [](SimConfig& c) { c.error_estimate_every = 10.0; });
    add("car, flies", flyCar, integrator);
    add("car, parked", parkCar, integrator);
    add("car, rests", parkCar, integrator, [](SimConfig& c) { c.rest_detection = true; });
  }
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test

int main(int argc, char** argv) {
  ellipsoid_vehicle_sim::test::registerAll();
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
