#include "ellipsoid_vehicle_sim/geometry/secular_equation.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/random_contact_cases.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

Vec3 unit(const std::array<double, 3>& v) {
  const Vec3 u{v[0], v[1], v[2]};
  return (1.0 / norm(u)) * u;
}

double halfWidth(const SupportProblem<3>& problem, const Vec3& u) {
  return norm(times({problem.r[0], problem.r[1], problem.r[2]}, u));
}

double delta(const SupportProblem<3>& problem, const Vec3& u) {
  return dot({problem.t[0], problem.t[1], problem.t[2]}, u) + halfWidth(problem, u);
}

/// Largest part of T - E square to u: zero where delta is stationary.
double offAxis(const SupportProblem<3>& problem, const Vec3& u) {
  const Vec3 r{problem.r[0], problem.r[1], problem.r[2]};
  const Vec3 T{problem.t[0], problem.t[1], problem.t[2]};
  const Vec3 E = (-1.0 / halfWidth(problem, u)) * times(r, times(r, u));
  return norm((T - E) - delta(problem, u) * u);
}

/// Semi-axes with the thinnest last, a point in and about the ellipsoid.
SupportProblem<3> randomProblem(RandomContactCases& random) {
  std::array<double, 3> r = {1.0, random.uniform(0.1, 1.0), random.logUniform(0.01, 1.0)};
  if (r[1] < r[2]) std::swap(r[1], r[2]);
  const Eigen::Vector3d w = random.unitVector() * random.uniform(0.01, 1.5);
  return {{w[0] * r[0], w[1] * r[1], w[2] * r[2]}, r};
}

TEST(SecularEquation, NearMinimumIsTheLeastOverAllDirections) {
  RandomContactCases random(1);
  for (int i = 0; i < 2000; ++i) {
    const SupportProblem<3> problem = randomProblem(random);
    const double least = delta(problem, unit(nearMinimum(problem)));
    for (int j = 0; j < 200; ++j) {
      // 1e-15: rounding of two lengths of order 1.
      EXPECT_GE(delta(problem, Vec3::from(random.unitVector())), least - 1e-15);
    }
  }
}

TEST(SecularEquation, FarMinimumIsStationaryAndHasNoLowerGroundAround) {
  RandomContactCases random(2);
  int found = 0;
  for (int i = 0; i < 20000; ++i) {
    const SupportProblem<3> problem = randomProblem(random);
    const auto direction = farMinimum(problem);
    if (!direction) continue;
    ++found;
    const Vec3 u = unit(*direction);
    EXPECT_LT(offAxis(problem, u), 1e-10);
    for (int j = 0; j < 20; ++j) {
      const Vec3 around = u + 1e-4 * problem.r[2] * Vec3::from(random.unitVector());
      EXPECT_GE(delta(problem, (1.0 / norm(around)) * around), delta(problem, u) - 1e-14);
    }
  }
  EXPECT_GT(found, 1000);
}

TEST(SecularEquation, TheLeastDepthBoundIsBelowTheNearDepthOfEveryPointInside) {
  RandomContactCases random(3);
  int run = 0;
  for (int i = 0; i < 20000; ++i) {
    const SupportProblem<3> problem = randomProblem(random);
    const double bound = leastDepthSquared(problem);
    if (gaugeSquared(problem) >= 1.0) {
      EXPECT_LT(bound, 0.0);
      continue;
    }
    ++run;
    const double depth = delta(problem, unit(nearMinimum(problem)));
    EXPECT_LE(bound, depth * depth * (1.0 + 1e-12));
  }
  EXPECT_GT(run, 5000);
}

// A far point and a near one, a needle and a disc: the residual of the normal through t, in parts of the largest
// semi-axis.
TEST(SecularEquation, NearMinimumIsStationaryForNeedlesAndDiscs) {
  RandomContactCases random(4);
  for (const std::array<double, 3> r : {std::array<double, 3>{1.0, 1.0, 1e-6}, {1.0, 1e-6, 1e-6}, {1.0, 1.0, 1.0}}) {
    for (int i = 0; i < 1000; ++i) {
      const Eigen::Vector3d w = random.unitVector() * random.logUniform(1e-3, 1e3);
      const SupportProblem<3> problem{{w[0] * r[0], w[1] * r[1], w[2] * r[2]}, r};
      EXPECT_LT(offAxis(problem, unit(nearMinimum(problem))), 1e-12 * std::max(1.0, w.norm()));
    }
  }
}

TEST(SecularEquation, EveryPushDirectionIsStationary) {
  RandomContactCases random(5);
  for (int i = 0; i < 20000; ++i) {
    const SupportProblem<3> problem = randomProblem(random);
    for (const Vec3& u : pushDirections(problem)) EXPECT_LT(offAxis(problem, u), 1e-7);
  }
}

// The number of sign changes of sum (a_i / (r_i^2 - lambda))^2 - 1 on a fine grid between and beside its poles.
TEST(SecularEquation, PushDirectionsAreAsManyAsTheEquationHasPositiveRoots) {
  RandomContactCases random(6);
  int most = 0, missed_by_grid = 0;
  for (int i = 0; i < 500; ++i) {
    const SupportProblem<3> problem = randomProblem(random);
    const auto& r = problem.r;
    const auto residual = [&](double lambda) {
      double sum = -1.0;
      for (int j = 0; j < 3; ++j) sum += std::pow(r[j] * problem.t[j] / (r[j] * r[j] - lambda), 2);
      return sum;
    };
    int roots = 0;
    const std::array<double, 5> ends = {0.0, r[2] * r[2], r[1] * r[1], r[0] * r[0], 20.0};
    for (int gap = 0; gap < 4; ++gap) {
      double before = residual(gap == 0 ? 0.0 : ends[gap] * (1.0 + 1e-15));
      for (int j = 1; j < 20000; ++j) {
        // Dense towards both ends, where the roots beside a pole of small weight lie.
        const double x = 0.5 - 0.5 * std::cos(M_PI * j / 20000.0);
        const double here = residual(ends[gap] + x * (ends[gap + 1] - ends[gap]));
        roots += (before > 0.0) != (here > 0.0) ? 1 : 0;
        before = here;
      }
    }
    const PushDirections found = pushDirections(problem);
    const int count = static_cast<int>(found.end() - found.begin());
    EXPECT_GE(count, roots);
    // The grid may step over two roots that merge.
    EXPECT_LE(count, roots + 2);
    missed_by_grid += count - roots;
    most = std::max(most, count);
  }
  EXPECT_LE(missed_by_grid, 20);
  EXPECT_EQ(most, 6);
}

TEST(SecularEquation, AVanishingCoordinateGivesBothMirrorImages) {
  const SupportProblem<3> problem{{0.1, withoutZero(0.0, 1.0), withoutZero(0.0, 1.0)}, {1.0, 0.5, 0.2}};
  const Vec3 near = unit(nearMinimum(problem));
  const auto far = farMinimum(problem);
  ASSERT_TRUE(far);
  EXPECT_GT(near.z, 0.0);
  EXPECT_NEAR(unit(*far).z, -near.z, 1e-15);
  EXPECT_NEAR(unit(*far).x, near.x, 1e-15);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
