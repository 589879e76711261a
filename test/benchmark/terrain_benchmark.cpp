// The world's side of a contact: candidates, whole queries, building, memory.
#include <benchmark/benchmark.h>

#include <map>

#include "ellipsoid_vehicle_sim/contact/find_contacts.h"
#include "ellipsoid_vehicle_sim/world/mesh_report.h"
#include "ellipsoid_vehicle_sim/world/mesh_tree.h"
#include "workloads.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

constexpr int kSmallHillCells = 32;

const Terrain& hillTerrain(int cells) {
  static std::map<int, Terrain> terrains;
  auto found = terrains.find(cells);
  if (found == terrains.end()) {
    found = terrains.emplace(cells, std::move(*Terrain::build(hills(cells)).value)).first;
  }
  return found->second;
}

void buildTerrain(benchmark::State& state, int cells) {
  const TriangleSoup soup = hills(cells);
  for (auto _ : state) {
    TriangleSoup copy = soup;
    const Loaded<Terrain> terrain = Terrain::build(std::move(copy));
    const double count = terrain.value->triangleCount();
    state.counters["bytes_per_triangle"] = static_cast<double>(terrain.value->memoryBytes()) / count;
  }
}

void buildTree(benchmark::State& state, int cells) {
  const TriangleSoup soup = hills(cells);
  for (auto _ : state) benchmark::DoNotOptimize(MeshTree(soup.vertices, soup.triangles).memoryBytes());
  state.counters["triangles_per_second"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * static_cast<double>(soup.triangles.size()),
                         benchmark::Counter::kIsRate);
}

void inspect(benchmark::State& state, int cells) {
  const TriangleSoup soup = hills(cells);
  for (auto _ : state) benchmark::DoNotOptimize(inspectMesh(soup.vertices, soup.triangles).open_edges);
}

/// Candidates as a step asks for them: a list that is kept while the wheel stays in its box.
void candidatesDriving(benchmark::State& state, int cells) {
  const Terrain& terrain = hillTerrain(cells);
  DrivingPath path(cells);
  CandidateCache cache;
  const Eigen::Vector3d travel(CandidateCache::kStepsAhead * 0.01, 0.0, 0.0);  // as findContacts looks ahead
  std::vector<Eigen::AlignedBox3d> boxes;
  for (int i = 0; i < 65536; ++i) boxes.push_back(boxOf(path.next()));
  std::size_t k = 0, found = 0;
  for (auto _ : state) {
    const Eigen::AlignedBox3d& box = boxes[k++ & 65535];
    found += cache.around(box.min(), box.max(), travel, terrain, true).size();
  }
  state.counters["triangles"] = static_cast<double>(found) / static_cast<double>(state.iterations());
}

/// The tree alone, asked anew for every place.
void query(benchmark::State& state, int cells, bool cold) {
  const Terrain& terrain = hillTerrain(cells);
  DrivingPath path(cells);
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const PosedEllipsoid& place : coldPlaces(cells)) boxes.push_back(boxOf(cold ? place : path.next()));
  std::vector<int> out;
  std::size_t k = 0, found = 0;
  for (auto _ : state) {
    out.clear();
    terrain.candidates(boxes[k++ & 65535], out);
    found += out.size();
  }
  state.counters["triangles"] = static_cast<double>(found) / static_cast<double>(state.iterations());
}

/// The whole query: where, how deep, along which normal. While driving it knows the last pose and triangle, as a step
/// does.
void wheelDriving(benchmark::State& state, int cells) {
  const Terrain& terrain = hillTerrain(cells);
  DrivingPath path(cells);
  std::vector<PosedEllipsoid> places;
  for (int i = 0; i < 65536; ++i) places.push_back(path.next());
  ContactFinder finder;
  ContactMemory memory;
  ContactOptions options;
  options.memory = false;  // geometry alone
  std::size_t k = 0, touches = 0;
  for (auto _ : state) {
    const PosedEllipsoid& wheel = places[k++ & 65535];
    const EllipsoidContacts contacts = findContacts(wheel, memory, terrain, options, finder);
    memory.fresh = false;
    memory.posed = wheel;
    memory.count = contacts.count > 0 ? 1 : 0;
    if (contacts.count > 0) memory.carried[0].triangle = contacts.contact[0].triangle;
    touches += contacts.count > 0;
  }
  state.counters["touching"] = static_cast<double>(touches) / static_cast<double>(state.iterations());
}

void wheelCold(benchmark::State& state, int cells) {
  const Terrain& terrain = hillTerrain(cells);
  const std::vector<PosedEllipsoid> places = coldPlaces(cells);
  ContactFinder finder;
  ContactOptions options;
  options.cache = false;
  const ContactMemory nothing;
  std::size_t k = 0, touches = 0;
  for (auto _ : state) {
    touches += findContacts(places[k++ & 65535], nothing, terrain, options, finder).count > 0;
  }
  state.counters["touching"] = static_cast<double>(touches) / static_cast<double>(state.iterations());
}

void heights(benchmark::State& state, int cells) {
  const Terrain& terrain = hillTerrain(cells);
  double x = 0.0;
  for (auto _ : state) {
    x = std::fmod(x + 0.37, 30.0);
    benchmark::DoNotOptimize(terrain.heights(x, 3.3).size());
  }
}

void frontCrossing(benchmark::State& state, int cells) {
  const Terrain& terrain = hillTerrain(cells);
  double x = 0.0;
  for (auto _ : state) {
    x = std::fmod(x + 0.37, 30.0);
    benchmark::DoNotOptimize(terrain.firstFrontCrossing({x, 3.3, 0.9}, {x + 0.1, 3.3, -0.9}).has_value());
  }
}

void registerAll() {
  using benchmark::RegisterBenchmark;
  // A second or more: the first build also pays for its memory, for us and the peers alike.
  RegisterBenchmark("build/ours", buildTree, kManyHillCells)->Unit(benchmark::kMillisecond)->MinTime(1.0);
  RegisterBenchmark("build_200k/ours", buildTree, kHillCells)->Unit(benchmark::kMillisecond);
  RegisterBenchmark("load/ours", buildTerrain, kManyHillCells)->Unit(benchmark::kMillisecond)->UseRealTime();
  RegisterBenchmark("inspect/ours", inspect, kManyHillCells)->Unit(benchmark::kMillisecond);
  RegisterBenchmark("candidates_driving/ours", candidatesDriving, kHillCells);
  RegisterBenchmark("candidates_cold/ours", query, kHillCells, true);
  RegisterBenchmark("tree_driving/ours", query, kHillCells, false);
  RegisterBenchmark("tree_cold_2k/ours", query, kSmallHillCells, true);
  RegisterBenchmark("tree_cold_2M/ours", query, kManyHillCells, true);
  RegisterBenchmark("wheel_driving/ours", wheelDriving, kHillCells);
  RegisterBenchmark("wheel_cold/ours", wheelCold, kHillCells);
  RegisterBenchmark("wheel_cold_2k/ours", wheelCold, kSmallHillCells);
  RegisterBenchmark("heights/ours", heights, kHillCells);
  RegisterBenchmark("front_crossing/ours", frontCrossing, kHillCells);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test

int main(int argc, char** argv) {
  ellipsoid_vehicle_sim::test::registerAll();
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
