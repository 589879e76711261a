// What one ellipsoid against one triangle costs: a wheel of 0.35 x 0.12 x 0.35 m and triangles with edges of about 1
// m, depths of 0.1 to 50 mm. Each case cycles through 64 poses of its kind, so that the branch predictor learns no
// single one.
#include <benchmark/benchmark.h>

#include <vector>

#include "support/random_contact_cases.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

enum class Kind { kNearMiss, kMissBeside, kFace, kEdge, kVertex };

/// The wheel steered and leaning a little over a triangle that lies nearly level.
ContactCase wheelCase(Kind kind, RandomContactCases& random) {
  const Eigen::Matrix3d tilt = Eigen::AngleAxisd(random.uniform(-0.3, 0.3), random.unitVector()).toRotationMatrix();
  const Triangle triangle = makeTriangle(tilt * Eigen::Vector3d(0.0, 0.0, 0.0), tilt * Eigen::Vector3d(1.1, 0.1, 0.0),
                                         tilt * Eigen::Vector3d(0.3, 0.9, 0.0));
  const auto& v = triangle.v;
  const Eigen::Vector3d& n = triangle.nhat_W;
  const Eigen::Matrix3d R = (Eigen::AngleAxisd(random.uniform(-3.1, 3.1), Eigen::Vector3d::UnitZ()) *
                             Eigen::AngleAxisd(random.uniform(-0.1, 0.1), Eigen::Vector3d::UnitX()) *
                             Eigen::AngleAxisd(random.uniform(-3.1, 3.1), Eigen::Vector3d::UnitY()))
                                .toRotationMatrix();
  const double depth = random.logUniform(1e-4, 0.05);
  const int k = random.index(3);
  const Eigen::Vector3d e = (v[(k + 1) % 3] - v[k]).normalized(), m = e.cross(n);
  const Eigen::Vector3d inside = 0.4 * v[0] + 0.3 * v[1] + 0.3 * v[2];
  const Eigen::Vector3d on_edge = v[k] + random.uniform(0.2, 0.8) * (v[(k + 1) % 3] - v[k]);
  const Eigen::Vector3d outwards = (2.0 * v[k] - v[(k + 1) % 3] - v[(k + 2) % 3]).normalized();
  const Eigen::Vector3d r = random.wheelRadii();
  const double angle = random.uniform(0.05, 1.2);
  const Eigen::Vector3d u_edge = std::cos(angle) * n + std::sin(angle) * m;
  switch (kind) {
    case Kind::kNearMiss:
      return {RandomContactCases::placed(R, r, inside, n, -depth), triangle};
    case Kind::kMissBeside:
      return {RandomContactCases::placed(R, r, on_edge, u_edge, -depth), triangle};
    case Kind::kFace:
      return {RandomContactCases::placed(R, r, inside, n, depth), triangle};
    case Kind::kEdge:
      return {RandomContactCases::placed(R, r, on_edge, u_edge, depth), triangle};
    default:
      return {RandomContactCases::placed(R, r, v[k], (n + random.uniform(0.05, 2.0) * outwards).normalized(), depth),
              triangle};
  }
}

bool isOf(Kind kind, const TriangleContact& contact, const ContactCase& c) {
  const int feature = static_cast<int>(contact.feature);
  switch (kind) {
    case Kind::kNearMiss:
      return !contact;
    case Kind::kMissBeside:  // the plane is reached, the triangle is not.
      return !contact && c.ellipsoid.halfWidth(c.triangle.nhat_W) >
                             c.triangle.nhat_W.dot(c.ellipsoid.p_WE - c.triangle.v[0]) + 1e-4;
    case Kind::kFace:
      return contact.feature == Feature::kFace;
    case Kind::kEdge:
      return feature >= static_cast<int>(Feature::kEdge0) && feature <= static_cast<int>(Feature::kEdge2);
    default:
      return feature >= static_cast<int>(Feature::kVertex0);
  }
}

std::vector<ContactCase> wheelCases(Kind kind) {
  RandomContactCases random(7);
  std::vector<ContactCase> cases;
  while (cases.size() < 64) {
    const ContactCase c = wheelCase(kind, random);
    if (isOf(kind, minimumTranslation(c.ellipsoid, c.triangle), c)) cases.push_back(c);
  }
  return cases;
}

template <typename Rule>
void run(benchmark::State& state, Kind kind, Rule rule) {
  const std::vector<ContactCase> cases = wheelCases(kind);
  std::size_t i = 0;
  for (auto _ : state) {
    const ContactCase& c = cases[i++ & 63];
    benchmark::DoNotOptimize(rule(c));
  }
}

void minimumTranslationRule(benchmark::State& state, Kind kind) {
  run(state, kind, [](const ContactCase& c) { return minimumTranslation(c.ellipsoid, c.triangle); });
}

void clampedPointRule(benchmark::State& state, Kind kind) {
  run(state, kind, [](const ContactCase& c) { return clampedPoint(c.ellipsoid, c.triangle); });
}

/// The bound a caller asks before it solves: here along the triangle's own answer, which has to hold.
void cannotExceedBound(benchmark::State& state, Kind kind) {
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

BENCHMARK_CAPTURE(minimumTranslationRule, near_miss, Kind::kNearMiss);
BENCHMARK_CAPTURE(minimumTranslationRule, miss_beside, Kind::kMissBeside);
BENCHMARK_CAPTURE(minimumTranslationRule, face, Kind::kFace);
BENCHMARK_CAPTURE(minimumTranslationRule, edge, Kind::kEdge);
BENCHMARK_CAPTURE(minimumTranslationRule, vertex, Kind::kVertex);
BENCHMARK_CAPTURE(clampedPointRule, edge, Kind::kEdge);
BENCHMARK_CAPTURE(clampedPointRule, vertex, Kind::kVertex);
BENCHMARK_CAPTURE(cannotExceedBound, edge, Kind::kEdge);
BENCHMARK_CAPTURE(cannotExceedBound, vertex, Kind::kVertex);

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test

BENCHMARK_MAIN();
