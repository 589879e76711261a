#include <benchmark/benchmark.h>

#include <cmath>
#include <map>
#include <random>

#include "ellipsoid_vehicle_sim/world/mesh_report.h"
#include "ellipsoid_vehicle_sim/world/mesh_tree.h"
#include "ellipsoid_vehicle_sim/world/terrain.h"

namespace ellipsoid_vehicle_sim {
namespace {

/// Rolling ground of 2 n^2 triangles, 1 m cells.
TriangleSoup rolling(int n) {
  TriangleSoup soup;
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) soup.vertices.emplace_back(i, j, 0.5 * std::sin(0.21 * i) * std::cos(0.17 * j));
  }
  const auto at = [n](int i, int j) { return static_cast<std::uint32_t>(j * (n + 1) + i); };
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      soup.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      soup.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return soup;
}

int cellsFor(std::int64_t triangles) {
  return static_cast<int>(std::lround(std::sqrt(0.5 * static_cast<double>(triangles))));
}

const Terrain& rollingTerrain(std::int64_t triangles) {
  static std::map<std::int64_t, Terrain> terrains;
  auto found = terrains.find(triangles);
  if (found == terrains.end()) {
    found = terrains.emplace(triangles, std::move(*Terrain::build(rolling(cellsFor(triangles))).value)).first;
  }
  return found->second;
}

Eigen::AlignedBox3d wheelBox(double x, double y) {
  const Eigen::Vector3d center(x, y, 0.3), half(0.35, 0.15, 0.35);
  return {center - half, center + half};
}

void BuildTerrain(benchmark::State& state) {
  const TriangleSoup soup = rolling(cellsFor(state.range(0)));
  for (auto _ : state) {
    TriangleSoup copy = soup;
    const Loaded<Terrain> terrain = Terrain::build(std::move(copy));
    state.counters["bytes_per_triangle"] =
        static_cast<double>(terrain.value->memoryBytes()) / terrain.value->triangleCount();
    state.counters["MB"] = 1e-6 * static_cast<double>(terrain.value->memoryBytes());
  }
}
BENCHMARK(BuildTerrain)->Arg(200000)->Arg(2000000)->Unit(benchmark::kMillisecond);

void BuildTree(benchmark::State& state) {
  const TriangleSoup soup = rolling(cellsFor(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(MeshTree(soup.vertices, soup.triangles).memoryBytes());
}
BENCHMARK(BuildTree)->Arg(200000)->Arg(2000000)->Unit(benchmark::kMillisecond);

void InspectMesh(benchmark::State& state) {
  const TriangleSoup soup = rolling(cellsFor(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(inspectMesh(soup.vertices, soup.triangles).open_edges);
}
BENCHMARK(InspectMesh)->Arg(2000000)->Unit(benchmark::kMillisecond);

/// The box of a wheel at 10 m/s, asked every millisecond: what is near in memory stays near.
void QueryDriving(benchmark::State& state) {
  const Terrain& terrain = rollingTerrain(state.range(0));
  const double length = terrain.bounds().sizes().x();
  std::vector<int> out;
  double x = 0.0, y = 1.0;
  std::size_t found = 0;
  for (auto _ : state) {
    x += 0.01;
    if (x > length) x = 0.0, y = std::fmod(y + 7.3, length);
    out.clear();
    terrain.query(wheelBox(x, y), out);
    found += out.size();
  }
  state.counters["triangles"] = static_cast<double>(found) / static_cast<double>(state.iterations());
}
BENCHMARK(QueryDriving)->Arg(2000)->Arg(200000)->Arg(2000000);

/// The same box anywhere in the world: nothing is in the cache.
void QueryCold(benchmark::State& state) {
  const Terrain& terrain = rollingTerrain(state.range(0));
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> along(0.0, terrain.bounds().sizes().x());
  std::vector<Eigen::AlignedBox3d> boxes;
  for (int i = 0; i < 65536; ++i) boxes.push_back(wheelBox(along(random), along(random)));
  std::vector<int> out;
  std::size_t k = 0, found = 0;
  for (auto _ : state) {
    out.clear();
    terrain.query(boxes[k++ & 65535], out);
    found += out.size();
  }
  state.counters["triangles"] = static_cast<double>(found) / static_cast<double>(state.iterations());
}
BENCHMARK(QueryCold)->Arg(2000)->Arg(200000)->Arg(2000000);

void Heights(benchmark::State& state) {
  const Terrain& terrain = rollingTerrain(state.range(0));
  double x = 0.0;
  for (auto _ : state) {
    x = std::fmod(x + 0.37, 30.0);
    benchmark::DoNotOptimize(terrain.heights(x, 3.3).size());
  }
}
BENCHMARK(Heights)->Arg(200000);

void FrontCrossing(benchmark::State& state) {
  const Terrain& terrain = rollingTerrain(state.range(0));
  double x = 0.0;
  for (auto _ : state) {
    x = std::fmod(x + 0.37, 30.0);
    benchmark::DoNotOptimize(terrain.firstFrontCrossing({x, 3.3, 0.9}, {x + 0.1, 3.3, -0.9}).has_value());
  }
}
BENCHMARK(FrontCrossing)->Arg(200000);

}  // namespace
}  // namespace ellipsoid_vehicle_sim

BENCHMARK_MAIN();
