#include "ellipsoid_vehicle_sim/contact/damped_spring.h"

#include <gtest/gtest.h>

#include <cmath>

namespace ellipsoid_vehicle_sim {
namespace {

struct Row {
  double zeta, contact_time, restitution;
};

// Closed form, checked against a fine integration of m y'' = -max(0, k y + c y') when the table was made; six digits.
constexpr Row kTable[] = {{0.0, 3.141593, 1.0},      {0.05, 3.045360, 0.858758}, {0.1, 2.956075, 0.744079},
                          {0.2, 2.795354, 0.571740}, {0.3, 2.654475, 0.450975},  {0.5, 2.418399, 0.298436},
                          {0.7, 2.227562, 0.210285}, {1.0, 2.0, 0.135335},       {1.5, 1.721636, 0.075588},
                          {3.0, 1.246450, 0.023770}};

TEST(BounceOfDampedSpring, AgreesWithTheTable) {
  for (const Row& row : kTable) {
    const BounceTime bounce = bounceOfDampedSpring(row.zeta);
    EXPECT_NEAR(bounce.contact_time, row.contact_time, 5e-7) << "zeta " << row.zeta;
    EXPECT_NEAR(bounce.restitution, row.restitution, 5e-7) << "zeta " << row.zeta;
  }
}

TEST(BounceOfDampedSpring, IsWhatTheEquationOfMotionDoes) {
  // y'' = -max(0, y + 2 zeta y') from y = 0, y' = 1, by RK4 at 1e-5, until the force ends.
  for (const double zeta : {0.0, 0.13, 0.6, 1.0, 2.2}) {
    double y = 0.0, v = 1.0, t = 0.0;
    const double h = 1e-5;
    const auto force = [&](double y_, double v_) { return y_ + 2.0 * zeta * v_; };
    while (force(y, v) > 0.0 || t == 0.0) {
      const double v1 = v, a1 = -force(y, v);
      const double v2 = v + 0.5 * h * a1, a2 = -force(y + 0.5 * h * v1, v2);
      const double v3 = v + 0.5 * h * a2, a3 = -force(y + 0.5 * h * v2, v3);
      const double v4 = v + h * a3, a4 = -force(y + h * v3, v4);
      y += h / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4);
      v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
      t += h;
    }
    const BounceTime bounce = bounceOfDampedSpring(zeta);
    // The end is met within one step; the force is zero there, so the speed is right to second order.
    EXPECT_NEAR(bounce.contact_time, t, 1.1e-5) << "zeta " << zeta;
    EXPECT_NEAR(bounce.restitution, -v, 1e-9) << "zeta " << zeta;
  }
}

TEST(BounceOfDampedSpring, IsSmoothThroughCriticalDamping) {
  for (const double off : {1e-3, 1e-5, 1e-6, 2e-7, 1e-8, 0.0}) {
    // d(omega t)/d(zeta) = -2/3 at zeta = 1; the second derivative is of order one.
    EXPECT_NEAR(bounceOfDampedSpring(1.0 + off).contact_time, 2.0 - 2.0 / 3.0 * off, 1e-6) << off;
    EXPECT_NEAR(bounceOfDampedSpring(1.0 - off).contact_time, 2.0 + 2.0 / 3.0 * off, 1e-6) << off;
  }
}

TEST(DampingRatioForRestitution, InvertsTheBounce) {
  for (const Row& row : kTable) {
    const double e = bounceOfDampedSpring(row.zeta).restitution;
    EXPECT_NEAR(dampingRatioForRestitution(e), row.zeta, 1e-6) << "zeta " << row.zeta;
  }
}

TEST(DampingRatioForRestitution, FullReboundNeedsNoDamping) { EXPECT_EQ(dampingRatioForRestitution(1.0), 0.0); }

TEST(DampingRatioForRestitution, IsFiniteAndLargeForNoRebound) {
  const double zeta = dampingRatioForRestitution(0.0);
  EXPECT_TRUE(std::isfinite(zeta));
  EXPECT_GT(zeta, 100.0);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
