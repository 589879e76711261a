// Bullet on the contact workloads: its two penetration solvers, its mesh, its tree. It has no ellipsoid of its own; the
// shape below gives it the exact support point. Built twice: in float, Bullet's usual self, and in double.
#include <benchmark/benchmark.h>
#include <btBulletCollisionCommon.h>

#include <cfloat>

#include <BulletCollision/NarrowPhaseCollision/btComputeGjkEpaPenetration.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpa2.h>
#include <BulletCollision/CollisionShapes/btTriangleShape.h>
#include <BulletCollision/NarrowPhaseCollision/btMprPenetration.h>

#include "bullet_shapes.h"
#include "workloads.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

/// What the solvers' templates ask of a shape with its pose.
struct PosedShape {
  const btConvexInternalShape* shape;
  btTransform pose;
  btVector3 centre;
  const btTransform& getWorldTransform() const { return pose; }
  btVector3 getObjectCenterInWorld() const { return centre; }
  btVector3 getLocalSupportWithMargin(const btVector3& d) const {
    return shape->localGetSupportingVertexWithoutMargin(d);
  }
};

struct BulletCase {
  BulletEllipsoid ellipsoid;
  btTriangleShape triangle;
  btTransform pose;
  BulletCase(const ContactCase& c)
      : ellipsoid(toBullet(c.ellipsoid.radii)),
        triangle(toBullet(c.triangle.v[0]), toBullet(c.triangle.v[1]), toBullet(c.triangle.v[2])),
        pose(toBullet(c.ellipsoid.R_WE), toBullet(c.ellipsoid.p_WE)) {
    triangle.setMargin(0);
  }
};

/// Depth [m]; 0 without contact.
double portalRefinement(const BulletCase& c) {
  const btVector3 middle = (c.triangle.m_vertices1[0] + c.triangle.m_vertices1[1] + c.triangle.m_vertices1[2]) / 3;
  const PosedShape a{&c.ellipsoid, c.pose, c.pose.getOrigin()}, b{&c.triangle, btTransform::getIdentity(), middle};
  btMprDistanceInfo info;
  if (btComputeMprPenetration(a, b, btMprCollisionDescription(), &info) != 0) return 0.0;
  return -static_cast<double>(info.m_distance);
}

double expandingPolytope(const BulletCase& c) {
  btGjkEpaSolver2::sResults results;
  const btVector3 guess = c.pose.getOrigin() - c.triangle.m_vertices1[0];
  if (!btGjkEpaSolver2::Penetration(&c.ellipsoid, c.pose, &c.triangle, btTransform::getIdentity(), guess, results,
                                    false))
    return 0.0;
  return -static_cast<double>(results.distance);
}

template <typename Solver>
void run(benchmark::State& state, ContactKind kind, Solver solver) {
  constexpr std::size_t kCount = 1024;
  const std::vector<ContactCase> cases = wheelCases(kind, kCount);
  std::vector<std::unique_ptr<BulletCase>> bullet;
  for (const ContactCase& c : cases) bullet.push_back(std::make_unique<BulletCase>(c));
  double worst = 0.0;
  int wrong = 0, missed = 0;
  for (std::size_t i = 0; i < kCount; ++i) {
    const double depth = minimumTranslation(cases[i].ellipsoid, cases[i].triangle).depth, found = solver(*bullet[i]);
    const double error = std::abs(found - depth);
    missed += depth > 0.0 && found <= 0.0;
    if (found > 0.0) worst = std::max(worst, error), wrong += error > 1e-3;
  }
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(solver(*bullet[i++ & 63]));
  state.counters["worst_error"] = worst;
  state.counters["wrong_percent"] = 100.0 * wrong / kCount;
  state.counters["missed_percent"] = 100.0 * missed / kCount;
}

const BulletMesh& hillMesh() {
  static const BulletMesh mesh(hills(kHillCells));
  return mesh;
}

void candidates(benchmark::State& state, bool cold) {
  struct Count : btNodeOverlapCallback {
    std::size_t found = 0;
    void processNode(int, int) override { ++found; }
  } count;
  const BulletMesh& mesh = hillMesh();
  DrivingPath path(kHillCells);
  std::vector<std::pair<btVector3, btVector3>> boxes;
  for (const PosedEllipsoid& place : coldPlaces(kHillCells)) {
    const Eigen::AlignedBox3d box = boxOf(cold ? place : path.next());
    boxes.emplace_back(toBullet(box.min()), toBullet(box.max()));
  }
  std::size_t k = 0;
  for (auto _ : state) {
    const auto& box = boxes[k++ & 65535];
    mesh.shape->getOptimizedBvh()->reportAabbOverlappingNodex(&count, box.first, box.second);
  }
  state.counters["triangles"] = static_cast<double>(count.found) / static_cast<double>(state.iterations());
}

void wholeQuery(benchmark::State& state, bool cold) {
  struct Deepest : btCollisionWorld::ContactResultCallback {
    btScalar depth = 0;
    btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper*, int, int,
                             const btCollisionObjectWrapper*, int, int) override {
      depth = std::max(depth, -point.getDistance());
      return 0;
    }
  };
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btCollisionWorld world(&dispatcher, &broadphase, &configuration);
  btCollisionObject ground, wheel;
  ground.setCollisionShape(hillMesh().shape.get());
  BulletEllipsoid ellipsoid(toBullet(benchmarkWheel()));
  wheel.setCollisionShape(&ellipsoid);
  std::vector<PosedEllipsoid> places = coldPlaces(kHillCells);
  DrivingPath path(kHillCells);
  if (!cold)
    for (PosedEllipsoid& place : places) place = path.next();
  std::size_t k = 0, touches = 0;
  for (auto _ : state) {
    wheel.setWorldTransform(btTransform(btMatrix3x3::getIdentity(), toBullet(places[k++ & 65535].p_WE)));
    Deepest deepest;
    world.contactPairTest(&wheel, &ground, deepest);
    touches += deepest.depth > 0;
  }
  state.counters["touching"] = static_cast<double>(touches) / static_cast<double>(state.iterations());
}

void build(benchmark::State& state) {
  const TriangleSoup soup = hills(kManyHillCells);
  for (auto _ : state) {
    state.PauseTiming();
    const BulletMesh mesh(soup, false);
    state.ResumeTiming();
    mesh.shape->buildOptimizedBvh();
    state.PauseTiming();
    const double bytes = mesh.shape->getOptimizedBvh()->calculateSerializeBufferSize() + mesh.bytes();
    state.counters["bytes_per_triangle"] = bytes / static_cast<double>(soup.triangles.size());
    state.ResumeTiming();
  }
  state.counters["triangles_per_second"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * static_cast<double>(soup.triangles.size()),
                         benchmark::Counter::kIsRate);
}

void registerAll() {
  const auto add = [](const std::string& figure, const std::string& how, auto&& function) {
    const std::string name = figure + "/" + kBulletName + how;
    return benchmark::RegisterBenchmark(name.c_str(), function);
  };
  for (const auto& [figure, kind] : kContactFigures) {
    const ContactKind k = kind;
    add(figure, " MPR", [=](benchmark::State& s) { run(s, k, portalRefinement); });
    if (k != ContactKind::kNearMiss) add(figure, " EPA", [=](benchmark::State& s) { run(s, k, expandingPolytope); });
  }
  for (const bool cold : {false, true}) {
    const std::string how = cold ? "_cold" : "_driving";
    add("candidates" + how, "", [=](benchmark::State& s) { candidates(s, cold); });
    add("wheel" + how, "", [=](benchmark::State& s) { wholeQuery(s, cold); });
  }
  add("build", "", build)->Unit(benchmark::kMillisecond)->MinTime(1.0);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test

int main(int argc, char** argv) {
  ellipsoid_vehicle_sim::test::registerAll();
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
