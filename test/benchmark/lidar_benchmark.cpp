// A lidar of 1081 rays over 270 degrees, 30 m far, 0.5 m above the hills of 200,000 triangles and half of its rays into
// them: at 40 Hz a scan may take 1250 us for 5 % of a core. With four cars around, and with noise.
#include <benchmark/benchmark.h>

#include "ellipsoid_vehicle_sim/sensors/lidar.h"
#include "workloads.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

const Terrain& hillTerrain() {
  static const Terrain terrain = std::move(*Terrain::build(hills(kHillCells)).value);
  return terrain;
}

/// A car's chassis and wheels, four times around the sensor.
std::vector<PosedEllipsoid> carsAround(const Eigen::Vector3d& p) {
  std::vector<PosedEllipsoid> ellipsoids;
  for (int car = 0; car < 4; ++car) {
    const Eigen::Vector3d at = p + Eigen::Vector3d(car < 2 ? 8.0 : -8.0, car % 2 == 0 ? 5.0 : -5.0, 0.0);
    ellipsoids.emplace_back(at, Eigen::Matrix3d::Identity(), drop::chassis());
    for (const Eigen::Vector3d& wheel : drop::wheels())
      ellipsoids.emplace_back(at + wheel, Eigen::Matrix3d::Identity(), benchmarkWheel());
  }
  return ellipsoids;
}

void scan(benchmark::State& state, std::unique_ptr<const RayCaster> (*make)()) {
  const auto caster = make();
  if (!caster) {
    state.SkipWithError("built without Embree");
    return;
  }
  LidarSpec spec;
  spec.noise = 0.01;
  Lidar lidar(spec, 1);
  std::vector<double> ranges;
  const double limit = 0.5 * kHillCells - 40.0;
  std::int64_t k = 0;
  double seen = 0.0;
  for (auto _ : state) {
    // Somewhere else each time, as a car at 40 m/s would be after two seconds.
    const double x = std::fmod(37.0 * static_cast<double>(k), 2.0 * limit) - limit;
    const double y = std::fmod(91.0 * static_cast<double>(k), 2.0 * limit) - limit;
    const Pose X_WS{{x, y, hillHeight(x, y) + 0.5}, quaternionFromRpy(0.0, 0.0, 0.1 * static_cast<double>(k))};
    const std::vector<PosedEllipsoid> cars = carsAround(X_WS.p);
    lidar.scan(X_WS, *caster, cars.data(), cars.size(), k++, ranges);
    for (const double range : ranges) seen += std::isfinite(range);
  }
  const double scans = static_cast<double>(state.iterations());
  state.counters["us_per_scan"] =
      benchmark::Counter(1e-6 * scans, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  state.counters["rays_that_hit"] = seen / scans;
}

void registerAll() {
  using benchmark::RegisterBenchmark;
  RegisterBenchmark(
      "lidar_scan/ours", scan, +[]() { return makeRayCaster(hillTerrain()); })
      ->Unit(benchmark::kMicrosecond);
  RegisterBenchmark(
      "lidar_scan_own_tree/ours", scan, +[]() { return makeOwnTreeRayCaster(hillTerrain()); })
      ->Unit(benchmark::kMicrosecond);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test

int main(int argc, char** argv) {
  ellipsoid_vehicle_sim::test::registerAll();
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
