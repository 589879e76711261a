#include "ellipsoid_vehicle_sim/contact/contact_force.h"

#include <gtest/gtest.h>

#include "support/random_contact_cases.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Vector3d;

constexpr double kMu = 0.8;
const FrictionCoefficients kFriction = {kMu, kMu, 1.0};
const Vector3d kUp = Vector3d::UnitZ();
const Vector3d kNone = Vector3d::Zero();

ContactLaw law(FrictionMode mode) {
  ContactLaw law;
  law.stiffness = 1e6;
  law.damping = 5e3;
  law.mode = mode;
  law.tangential_stiffness = 2e5;
  law.tangential_damping = 400.0;
  law.brush_length = 0.1;
  law.relaxation_time = 0.002;
  law.viscous_friction = 1e3;
  return law;
}

const FrictionMode kModes[] = {FrictionMode::kViscous, FrictionMode::kAnchored, FrictionMode::kBrush};

Vector3d heading(int i) {
  const double angle = 2.0 * M_PI * i / 12.0;
  return {std::cos(angle), std::sin(angle), 0.0};
}

TEST(ContactForce, NormalForceIsStiffnessTimesDepthPlusDampingTimesItsRate) {
  for (const FrictionMode mode : kModes) {
    const ContactForce force = contactForce(law(mode), kFriction, kUp, 0.01, 1.0, {0.0, 0.0, -0.5}, kNone, kNone);
    EXPECT_DOUBLE_EQ(force.normal, 1e6 * 0.01 + 5e3 * 0.5);
  }
}

TEST(ContactForce, DamperLowersThePushToNothingAndNeverPulls) {
  // The spring's 10 kN are gone at 2 m/s of parting.
  EXPECT_GT(contactForce(law(FrictionMode::kAnchored), kFriction, kUp, 0.01, 1.0, {0, 0, 1.9}, kNone, kNone).normal,
            0.0);
  for (const double speed : {2.0, 2.1, 10.0, 1e6})
    for (const FrictionMode mode : kModes) {
      const ContactForce force =
          contactForce(law(mode), kFriction, kUp, 0.01, 1.0, {3.0, 0.0, speed}, kNone, {0.01, 0, 0});
      EXPECT_EQ(force.normal, 0.0) << speed;
      EXPECT_TRUE(force.friction_W.isZero(0.0)) << speed;
    }
}

TEST(ContactForce, NoDepthIsNoForceHoweverFast) {
  for (const double depth : {0.0, -0.01})
    for (const FrictionMode mode : kModes) {
      const ContactForce force = contactForce(law(mode), kFriction, kUp, depth, 1.0, {1, 0, -100}, kNone, {0.01, 0, 0});
      EXPECT_EQ(force.normal, 0.0);
      EXPECT_TRUE(force.friction_W.isZero(0.0));
    }
}

TEST(ContactForce, ShareScalesNormalForceAndFrictionAlike) {
  for (const FrictionMode mode : {FrictionMode::kAnchored, FrictionMode::kBrush}) {
    const Vector3d v(0.2, 0.1, -0.3), roll(1.0, 0.0, 0.0), z(0.001, 0.002, 0.0);
    const ContactForce whole = contactForce(law(mode), kFriction, kUp, 0.01, 1.0, v, roll, z);
    const ContactForce part = contactForce(law(mode), kFriction, kUp, 0.01, 0.3, v, roll, z);
    EXPECT_NEAR(part.normal, 0.3 * whole.normal, 1e-9);
    EXPECT_TRUE(part.friction_W.isApprox(0.3 * whole.friction_W, 1e-12));
    EXPECT_NEAR(part.stretch_limit, whole.stretch_limit, 1e-15);
  }
}

TEST(ContactForce, FrictionOpposesTheSlipVectorAtEveryHeading) {
  for (const FrictionMode mode : kModes)
    for (const double speed : {1e-9, 1e-3, 0.3, 30.0})
      for (int i = 0; i < 12; ++i) {
        const ContactForce force = contactForce(law(mode), kFriction, kUp, 0.01, 1.0, speed * heading(i), kNone, kNone);
        const double size = force.friction_W.norm();
        EXPECT_GT(size, 0.0);
        EXPECT_LE((force.friction_W + size * heading(i)).norm(), 1e-12 * size) << speed << " m/s, heading " << i;
      }
}

TEST(ContactForce, SlidingFrictionOpposesTheSlipVectorWhateverTheStretchWas) {
  // Slides at each heading after having been stretched along x; the old stretch must be forgotten within a few of its
  // lengths.
  for (int i = 0; i < 12; ++i) {
    const ContactLaw anchored = law(FrictionMode::kAnchored);
    const double dt = 1e-4, limit = kMu * 1e6 * 0.01;
    Vector3d z(limit / anchored.tangential_stiffness, 0.0, 0.0);
    ContactForce force;
    for (int step = 0; step < 20000; ++step) {
      force = contactForce(anchored, kFriction, kUp, 0.01, 1.0, 0.5 * heading(i), kNone, z);
      z += dt * force.anchor_rate_W;
      if (z.norm() > force.stretch_limit) z *= force.stretch_limit / z.norm();
    }
    EXPECT_TRUE(force.sliding);
    // 1 m at a stretch of 4 cm: the old direction is gone but for exp(-25).
    EXPECT_LE((force.friction_W + limit * heading(i)).norm(), 1e-6 * limit) << "heading " << i;
  }
}

TEST(ContactForce, NeverLeavesItsCone) {
  RandomContactCases random(31);
  for (int i = 0; i < 30000; ++i) {
    const FrictionMode mode = kModes[random.index(3)];
    const Vector3d u = random.unitVector();
    Vector3d z = random.logUniform(1e-6, 1.0) * random.unitVector();
    z -= u.dot(z) * u;
    const Vector3d v = random.logUniform(1e-6, 100.0) * random.unitVector();
    const Vector3d roll = random.index(2) * random.logUniform(1e-3, 100.0) * random.unitVector();
    FrictionCoefficients mu{random.uniform(0.5, 1.5), 0.0, random.logUniform(1e-3, 1.0)};
    mu.mu_kinetic = random.uniform(0.0, 1.0) * mu.mu_static;
    const ContactForce force =
        contactForce(law(mode), mu, u, random.logUniform(1e-6, 0.1), random.uniform(0.0, 1.0), v, roll, z);
    const double slip = (v - u.dot(v) * u).norm();
    EXPECT_GE(force.normal, 0.0);
    EXPECT_LE(force.friction_W.norm(), mu.at(slip) * force.normal * (1.0 + 1e-12));
    EXPECT_LE(std::abs(force.friction_W.dot(u)), 1e-10 * (1.0 + force.friction_W.norm() + z.norm() * 2e5));
  }
}

TEST(ContactForce, IsContinuousThroughZeroSlip) {
  for (const FrictionMode mode : kModes) {
    const ContactLaw l = law(mode);
    // Slope of the force at zero: the damper's, or the viscous coefficient; nothing jumps.
    const double slope = mode == FrictionMode::kViscous ? l.viscous_friction : l.tangential_damping;
    for (const Vector3d& z : {Vector3d(0, 0, 0), Vector3d(0.004, -0.003, 0.0)})
      for (const double speed : {1e-3, 1e-6, 1e-12})
        for (int i = 0; i < 12; ++i) {
          const Vector3d still = contactForce(l, kFriction, kUp, 0.01, 1.0, kNone, kNone, z).friction_W;
          const Vector3d moving = contactForce(l, kFriction, kUp, 0.01, 1.0, speed * heading(i), kNone, z).friction_W;
          EXPECT_NEAR((moving - still).norm(), slope * speed, 1e-9 * slope * speed + 1e-11);
        }
  }
}

TEST(ContactForce, AnchoredFrictionIsASpringToTheFirstTouch) {
  const ContactLaw anchored = law(FrictionMode::kAnchored);
  // The cone carries 8 kN: a stretch of 4 cm.
  for (const double stretch : {1e-9, 1e-3, 0.039}) {
    const Vector3d z = stretch * heading(5);
    const ContactForce force = contactForce(anchored, kFriction, kUp, 0.01, 1.0, kNone, kNone, z);
    EXPECT_TRUE(force.friction_W.isApprox(-anchored.tangential_stiffness * z, 1e-14));
    EXPECT_FALSE(force.sliding);
    EXPECT_TRUE(force.anchor_rate_W.isZero(0.0));
    EXPECT_NEAR(force.stretch_limit, 0.04, 1e-15);
  }
  const ContactForce beyond = contactForce(anchored, kFriction, kUp, 0.01, 1.0, kNone, kNone, 0.05 * heading(5));
  EXPECT_NEAR(beyond.friction_W.norm(), 8e3, 1e-9);
  EXPECT_TRUE(beyond.sliding);
}

TEST(ContactForce, BrushAtRestIsTheAnchor) {
  const Vector3d v(0.01, 0.0, 0.0), z(0.001, 0.0005, 0.0);
  const ContactForce brush = contactForce(law(FrictionMode::kBrush), kFriction, kUp, 0.01, 1.0, v, kNone, z);
  const ContactForce anchored = contactForce(law(FrictionMode::kAnchored), kFriction, kUp, 0.01, 1.0, v, kNone, z);
  EXPECT_EQ(brush.friction_W, anchored.friction_W);
  EXPECT_EQ(brush.anchor_rate_W, anchored.anchor_rate_W);
}

/// The brush's force after rolling at `speed` with the slip angle alpha until it is steady.
ContactForce steadyBrush(double speed, double alpha) {
  const ContactLaw brush = law(FrictionMode::kBrush);
  const Vector3d roll(speed * std::cos(alpha), 0.0, 0.0), slip(0.0, speed * std::sin(alpha), 0.0);
  const double dt = 1e-4;
  Vector3d z = kNone;
  ContactForce force;
  // Twenty relaxation lengths, or times above the knee.
  const int steps = static_cast<int>(20.0 * std::max(brush.brush_length / speed, brush.relaxation_time) / dt) + 1;
  for (int i = 0; i < steps; ++i) {
    force = contactForce(brush, kFriction, kUp, 0.01, 1.0, slip, roll, z);
    z += dt * force.anchor_rate_W;
    if (z.norm() > force.stretch_limit) z *= force.stretch_limit / z.norm();
  }
  return force;
}

TEST(ContactForce, SteadyBrushHasTheCorneringStiffnessThenSlides) {
  // C = k_t l = 2e4 N; the cone at 8 kN is reached at tan alpha = 0.4. Speeds on both sides of the knee l / tau = 50
  // m/s.
  const double C = 2e5 * 0.1, limit = kMu * 1e6 * 0.01;
  for (const double speed : {0.5, 5.0, 40.0, 120.0})
    for (const double degrees : {0.1, 1.0, 5.0, 15.0, 20.0, 25.0, 60.0}) {
      const double alpha = degrees * M_PI / 180.0;
      const ContactForce force = steadyBrush(speed, alpha);
      const double expected = std::min(C * std::tan(alpha), limit);
      EXPECT_NEAR(force.friction_W.norm(), expected, 1e-3 * expected) << speed << " m/s, " << degrees << " degrees";
      EXPECT_NEAR(-force.friction_W.y(), force.friction_W.norm(), 1e-9) << speed << " m/s, " << degrees << " degrees";
      if (C * std::tan(alpha) > 1.01 * limit) {
        EXPECT_NEAR(force.friction_W.norm(), limit, 1e-9 * limit);
        EXPECT_TRUE(force.sliding);
      }
    }
}

TEST(FrictionCoefficients, FallsFromStaticToKineticWithTheSlipSpeed) {
  const FrictionCoefficients mu{1.0, 0.6, 0.05};
  EXPECT_EQ(mu.at(0.0), 1.0);
  EXPECT_NEAR(mu.at(0.05), 0.6 + 0.4 * std::exp(-1.0), 1e-15);
  EXPECT_NEAR(mu.at(1.0), 0.6, 1e-15);
  EXPECT_EQ((FrictionCoefficients{0.7, 0.7, 0.05}.at(0.01)), 0.7);
}

TEST(TurnedWithNormal, KeepsTheLengthAndStaysSquareToTheNormal) {
  RandomContactCases random(32);
  for (int i = 0; i < 5000; ++i) {
    const Vector3d from = random.unitVector();
    Vector3d to = (from + random.logUniform(1e-12, 3.0) * random.unitVector()).normalized();
    if (from.dot(to) < -0.5) to = -to;
    Vector3d z = random.unitVector();
    z -= from.dot(z) * from;
    const Vector3d turned = turnedWithNormal(z, from, to);
    EXPECT_NEAR(turned.norm(), z.norm(), 1e-14);
    EXPECT_NEAR(turned.dot(to), 0.0, 1e-14);
    // The smallest rotation leaves its own axis alone.
    const Vector3d axis = from.cross(to);
    EXPECT_NEAR(turned.dot(axis), z.dot(axis), 1e-14);
  }
  EXPECT_EQ(turnedWithNormal(Vector3d::UnitX(), kUp, kUp), Vector3d::UnitX());
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
