// A touch on a damped spring that cannot pull. Source: notation.h [BounceClosedForm].
#include <gtest/gtest.h>

#include "ellipsoid_vehicle_sim/contact/damped_spring.h"
#include "support/motions.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Vector3d;

constexpr double kMass = 250.0, kStiffness = 1e7, kRadius = 0.5, kSpeed = 2.0;
const double kOmega = std::sqrt(kStiffness / kMass);

double dampingOf(double zeta) { return 2.0 * zeta * std::sqrt(kStiffness * kMass); }

/// Falls onto the floor with `gap` to go.
Bounce bounceOf(SimConfig config, double gap, double speed = kSpeed, double mass = kMass) {
  Simulator simulator = make(solidBody(Vector3d::Constant(kRadius), mass), flatFloor(), config);
  placeAt(simulator, {0.0, 0.0, kRadius + gap}, {0.0, 0.0, -speed});
  return bounce(simulator);
}

struct Row {
  double zeta, contact_time, restitution;  // omega_0 t_c, e
};

const Row kRows[] = {{0.0, 3.141593, 1.0},      {0.05, 3.045360, 0.858758}, {0.1, 2.956075, 0.744079},
                     {0.2, 2.795354, 0.571740}, {0.3, 2.654475, 0.450975},  {0.5, 2.418399, 0.298436},
                     {0.7, 2.227562, 0.210285}, {1.0, 2.0, 0.135335},       {1.5, 1.721636, 0.075588},
                     {3.0, 1.246450, 0.023770}};

TEST(Bounce, ClosedFormIsThatOfTheTable) {
  for (const Row& row : kRows) {
    const BounceTime time = bounceOfDampedSpring(row.zeta);
    EXPECT_NEAR(time.contact_time, row.contact_time, 6e-7);
    EXPECT_NEAR(time.restitution, row.restitution, 6e-7);
    // At zeta = 3 the printed digits of e tell zeta to 7e-5.
    EXPECT_NEAR(dampingRatioForRestitution(row.restitution), row.zeta, 1e-4);
  }
}

TEST(Bounce, GivesBackTheSpeedAndLastsAsTheClosedFormSays) {
  // h = omega dt = 0.002. Where the force jumps (c v at touch) a step is half right: c v dt / m = 2 zeta h v at most,
  // twice.
  constexpr double kDt = 1e-5;
  const double h = kOmega * kDt;
  for (const IntegratorKind kind : {IntegratorKind::kSemiImplicitEuler, IntegratorKind::kRk4})
    for (const Row& row : kRows) {
      const Bounce b = bounceOf(springConfig(kind, kDt, kStiffness, dampingOf(row.zeta)), 1e-3);
      EXPECT_NEAR(b.exit_speed / kSpeed, row.restitution, 2.0 * row.zeta * h + h * h)
          << toString(kind) << " zeta " << row.zeta;
      // Both ends fall inside a step; where damping is strong the release itself is late by part of one.
      EXPECT_NEAR(b.contact_time, row.contact_time / kOmega, 3.0 * kDt) << toString(kind) << " zeta " << row.zeta;
    }
}

TEST(Bounce, UndampedDepthIsSpeedOverFrequency) {
  const Bounce b = bounceOf(springConfig(IntegratorKind::kRk4, 1e-5, kStiffness, 0.0), 1e-3);
  // The deepest point falls between two steps: 1 - cos(h / 2).
  EXPECT_NEAR(b.depth, kSpeed / kOmega, 1e-6 * kSpeed / kOmega);
}

TEST(Bounce, WithGravityLeavesAsIntegratedFinely) {
  // m = 250 kg, k = 1e7 N/m, c = 5 kN s/m, g = 9.81, 2 m/s: 15.492877 ms, 1.713117463 m/s, 9.492232 mm.
  constexpr double kDt = 1e-5;
  SimConfig config = springConfig(IntegratorKind::kRk4, kDt, kStiffness, 5000.0);
  config.gravity = 9.81;
  const Bounce b = bounceOf(config, 1e-9);
  // zeta = 0.05 at h = 0.002: 2 zeta h = 2e-4 of the speed for the jump at touch, and one step of gravity.
  EXPECT_NEAR(b.exit_speed, 1.713117463, 2e-4 * kSpeed + 9.81 * kDt);
  EXPECT_NEAR(b.contact_time, 15.492877e-3, 2.0 * kDt);
  EXPECT_NEAR(b.depth, 9.492232e-3, 1e-3 * 9.492232e-3);
}

struct Phases {
  double zeta, dt, semi_implicit, rk4;  // largest error of the exit speed [-] over all phases of the first touch
};

// Source: notation.h [OscillatorErrors], last line: these are what the method can do, h = 0.2 and 0.05.
const Phases kPhases[] = {{0.0, 1e-3, 0.44e-2, 0.22e-2},   {0.1, 1e-3, 1.7e-2, 1.1e-2},
                          {0.3, 1e-3, 3.5e-2, 1.9e-2},     {0.0, 2.5e-4, 0.018e-2, 0.010e-2},
                          {0.1, 2.5e-4, 0.42e-2, 0.25e-2}, {0.3, 2.5e-4, 0.89e-2, 0.45e-2}};

TEST(Bounce, ErrorAtAnyPhaseIsWithinTheMethodsOwn) {
  for (const Phases& row : kPhases)
    for (const IntegratorKind kind : {IntegratorKind::kSemiImplicitEuler, IntegratorKind::kRk4}) {
      const double e = bounceOfDampedSpring(row.zeta).restitution;
      Simulator simulator = make(solidBody(Vector3d::Constant(kRadius), kMass), flatFloor(),
                                 springConfig(kind, row.dt, kStiffness, dampingOf(row.zeta)));
      double largest = 0.0;
      constexpr int kCount = 200;
      for (int i = 0; i < kCount; ++i) {
        const double gap = kSpeed * row.dt * (1.0 + (i + 0.5) / kCount);
        placeAt(simulator, {0.0, 0.0, kRadius + gap}, {0.0, 0.0, -kSpeed});
        largest = std::max(largest, std::abs(bounce(simulator).exit_speed / kSpeed - e));
      }
      // Errors of the source are of the incoming speed; its own phases were random, hence a margin of a tenth.
      const double bound = kind == IntegratorKind::kRk4 ? row.rk4 : row.semi_implicit;
      EXPECT_LT(largest, 1.1 * bound) << toString(kind) << " zeta " << row.zeta << " dt " << row.dt;
    }
}

TEST(Bounce, RestitutionAndContactTimeOfTheConfigurationAreMet) {
  for (const double e : {0.1, 0.3, 0.6, 0.9, 1.0})
    for (const double mass : {5.0, 250.0, 1e4}) {
      SimConfig config = springConfig(IntegratorKind::kRk4, 1e-5, 1.0, 0.0);
      config.stiffness.reset();
      config.damping.reset();
      config.contact_time = 0.01;
      config.restitution = e;
      const Bounce b = bounceOf(config, 1e-3, 1.0, mass);
      // h = pi / 1000; the jump at touch as above.
      EXPECT_NEAR(b.exit_speed, e, 4e-3) << "e " << e << ", " << mass << " kg";
      EXPECT_NEAR(b.contact_time, 0.01, 2e-5) << "e " << e << ", " << mass << " kg";
    }
}

TEST(Bounce, IsTheSameAtEverySpeedWithoutGravity) {
  // The law is linear: speeds scale, times do not.
  for (const double speed : {1e-3, 0.1, 20.0}) {
    const double dt = 1e-5;
    const Bounce b =
        bounceOf(springConfig(IntegratorKind::kRk4, dt, kStiffness, dampingOf(0.1)), 0.5 * speed * dt, speed);
    EXPECT_NEAR(b.exit_speed / speed, 0.744079, 5e-4) << speed;
  }
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
