// What one ellipsoid against one triangle costs, and how far off it is.
#include <benchmark/benchmark.h>

#include "support/brute_force_contact.h"
#include "workloads.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

template <typename Rule>
void run(benchmark::State& state, ContactKind kind, Rule rule) {
  const std::vector<ContactCase> cases = wheelCases(kind);
  std::size_t i = 0;
  for (auto _ : state) {
    const ContactCase& c = cases[i++ & 63];
    benchmark::DoNotOptimize(rule(c));
  }
}

/// Largest depth error against the exhaustive search [m], over the cases of the peers' own accuracy columns.
void worstError(benchmark::State& state, ContactKind kind) {
  const std::vector<ContactCase> cases = wheelCases(kind, 256);
  double worst = 0.0;
  for (auto _ : state) {
    for (const ContactCase& c : cases) {
      const BruteForceContact reference(c.ellipsoid, c.triangle);
      const double depth = minimumTranslation(c.ellipsoid, c.triangle).depth;
      worst = std::max(worst, std::abs(depth - reference.depth()));
    }
  }
  state.counters["worst_error"] = worst;
}

/// The bound a caller asks before it solves: here along the triangle's own answer, which has to hold.
void cannotExceedBound(benchmark::State& state, ContactKind kind) {
  const std::vector<ContactCase> cases = wheelCases(kind);
  std::vector<TriangleContact> answers;
  for (const ContactCase& c : cases) answers.push_back(minimumTranslation(c.ellipsoid, c.triangle));
  std::size_t i = 0;
  for (auto _ : state) {
    const std::size_t j = i++ & 63;
    benchmark::DoNotOptimize(
        cannotExceed(cases[j].ellipsoid, cases[j].triangle, answers[j].nhat_W, answers[j].depth + 1e-9));
  }
}

void registerAll() {
  const auto exact = [](const ContactCase& c) { return minimumTranslation(c.ellipsoid, c.triangle); };
  const auto clamped = [](const ContactCase& c) { return clampedPoint(c.ellipsoid, c.triangle); };
  for (const auto& [figure, kind] : kContactFigures) {
    const ContactKind k = kind;
    const std::string name = figure;
    benchmark::RegisterBenchmark((name + "/ours").c_str(), [=](benchmark::State& s) { run(s, k, exact); });
    if (k == ContactKind::kNearMiss) continue;
    benchmark::RegisterBenchmark((name + "_error/ours").c_str(), worstError, k)->Iterations(1);
    benchmark::RegisterBenchmark((name + "_clamped_point/ours").c_str(),
                                 [=](benchmark::State& s) { run(s, k, clamped); });
    benchmark::RegisterBenchmark((name + "_bound/ours").c_str(), cannotExceedBound, k);
  }
  benchmark::RegisterBenchmark("miss_beside/ours",
                               [=](benchmark::State& s) { run(s, ContactKind::kMissBeside, exact); });
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test

int main(int argc, char** argv) {
  ellipsoid_vehicle_sim::test::registerAll();
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
