// FCL on the contact workloads, in double: its default penetration solver, and its tree of oriented boxes.
#include <benchmark/benchmark.h>
#include <fcl/fcl.h>

#include "workloads.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

fcl::Transform3d poseOf(const PosedEllipsoid& e) {
  fcl::Transform3d X = fcl::Transform3d::Identity();
  X.linear() = e.R_WE;
  X.translation() = e.p_WE;
  return X;
}

double penetration(const fcl::detail::GJKSolver_libccdd& solver, const fcl::Ellipsoidd& shape, const ContactCase& c) {
  fcl::Vector3d point, normal;
  double depth = 0.0;
  const auto& v = c.triangle.v;
  if (!solver.shapeTriangleIntersect(shape, poseOf(c.ellipsoid), v[0], v[1], v[2], &point, &depth, &normal)) return 0.0;
  return depth;
}

void run(benchmark::State& state, ContactKind kind) {
  constexpr std::size_t kCount = 1024;
  const std::vector<ContactCase> cases = wheelCases(kind, kCount);
  const fcl::detail::GJKSolver_libccdd solver;
  const fcl::Ellipsoidd shape(benchmarkWheel());
  double worst = 0.0;
  int wrong = 0, missed = 0;
  for (const ContactCase& c : cases) {
    const double depth = minimumTranslation(c.ellipsoid, c.triangle).depth, found = penetration(solver, shape, c);
    const double error = std::abs(found - depth);
    missed += depth > 0.0 && found <= 0.0;
    if (found > 0.0) worst = std::max(worst, error), wrong += error > 1e-3;
  }
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(penetration(solver, shape, cases[i++ & 63]));
  state.counters["worst_error"] = worst;
  state.counters["wrong_percent"] = 100.0 * wrong / kCount;
  state.counters["missed_percent"] = 100.0 * missed / kCount;
}

using Mesh = fcl::BVHModel<fcl::OBBRSSd>;

std::shared_ptr<Mesh> meshOf(const TriangleSoup& soup) {
  auto mesh = std::make_shared<Mesh>();
  std::vector<fcl::Triangle> triangles;
  for (const auto& t : soup.triangles) triangles.emplace_back(t[0], t[1], t[2]);
  mesh->beginModel();
  mesh->addSubModel(soup.vertices, triangles);
  mesh->endModel();
  return mesh;
}

void wholeQuery(benchmark::State& state, bool cold) {
  fcl::CollisionObjectd ground(meshOf(hills(kHillCells)));
  fcl::CollisionObjectd wheel(std::make_shared<fcl::Ellipsoidd>(benchmarkWheel()));
  std::vector<PosedEllipsoid> places = coldPlaces(kHillCells);
  DrivingPath path(kHillCells);
  if (!cold)
    for (PosedEllipsoid& place : places) place = path.next();
  const fcl::CollisionRequestd request(16, true);
  std::size_t k = 0, touches = 0;
  for (auto _ : state) {
    wheel.setTransform(poseOf(places[k++ & 65535]));
    fcl::CollisionResultd result;
    fcl::collide(&wheel, &ground, request, result);
    touches += result.isCollision();
  }
  state.counters["touching"] = static_cast<double>(touches) / static_cast<double>(state.iterations());
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test

int main(int argc, char** argv) {
  using namespace ellipsoid_vehicle_sim::test;
  for (const auto& [figure, kind] : kContactFigures)
    benchmark::RegisterBenchmark((std::string(figure) + "/FCL").c_str(), run, kind);
  benchmark::RegisterBenchmark("wheel_driving/FCL", wholeQuery, false);
  benchmark::RegisterBenchmark("wheel_cold/FCL", wholeQuery, true);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
