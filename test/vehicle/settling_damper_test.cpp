#include "../../src/vehicle/settling_damper.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

// How long a mode takes to come to rest.

namespace ellipsoid_vehicle_sim {
namespace {

constexpr double kStep = 1e-3;

/// x'' = -w |w| x from x = 0.1 m; unstable for w < 0, which ends at a wall at x = 1 m that takes all speed. Time until slower
/// than 1e-6 m/s for 0.1 s [s].
double timeToRest(double w) {
  SettlingDamper damper;
  double x = w < 0.0 ? 1e-4 : 0.1, v = 0.0;
  int quiet = 0, step = 0;
  for (; quiet < 100 && step < 1000000; ++step) {
    v -= kStep * w * std::abs(w) * x;
    x += kStep * v;
    if (w < 0.0 && x >= 1.0) x = 1.0, v = 0.0;
    v *= damper.remainder(std::abs(v), kStep);
    quiet = std::abs(v) < 1e-6 ? quiet + 1 : 0;
  }
  return kStep * step;
}

TEST(SettlingDamper, ARideOfOneHertzTakesAsLongAsDampingAloneWould) { EXPECT_LT(timeToRest(2.0 * M_PI), 4.0); }

// Of a damping d of 10/s alone, which leaves x' = -w^2/d x: 26, 92, 313 and 1030 s.
TEST(SettlingDamper, SlowModesEndAfterSomeOfTheirOwnPeriods) {
  EXPECT_LT(timeToRest(2.0), 11.0);
  EXPECT_LT(timeToRest(1.0), 13.0);
  EXPECT_LT(timeToRest(0.5), 16.0);
  EXPECT_LT(timeToRest(0.25), 20.0);
}

TEST(SettlingDamper, StiffModesToo) {
  for (const double w : {10.0, 30.0, 100.0}) EXPECT_LT(timeToRest(w), 6.0) << w;
}

// From 0.1 mm beside the top to 1 m away: some ln(2e4) / w, not d / w^2 times as much, 92 s.
TEST(SettlingDamper, WhatTipsIsLeftToTip) { EXPECT_LT(timeToRest(-1.0), 13.0); }

TEST(SettlingDamper, WhatGainsSpeedIsLeftAloneOnlyAfterTheFirstDamping) {
  SettlingDamper damper;
  double time = 0.0, speed = 1.0;
  for (; time < 1.4; time += kStep) EXPECT_LT(damper.remainder(speed *= 1.01, kStep), 1.0);
  for (; time < 2.0; time += kStep) damper.remainder(speed *= 1.01, kStep);
  EXPECT_EQ(damper.remainder(speed *= 1.01, kStep), 1.0);
  EXPECT_LT(damper.remainder(speed *= 0.99, kStep), 1.0);
  EXPECT_LT(damper.remainder(speed *= 1.01, kStep), 1.0) << "damped for a while, whatever it does";
  EXPECT_EQ(damper.remainder(0.49 * speed, kStep), 1.0) << "down to half";
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
