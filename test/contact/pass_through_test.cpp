// What a penalty contact can stop, and that what it cannot is never silent. A single sheet without thickness is the
// worst case: once the centre is behind it, nothing pushes any more.
#include <gtest/gtest.h>

#include "support/contact_scenes.h"
#include "support/random_contact_cases.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

const Vector3d kWheel(0.35, 0.12, 0.35);

class Caught : public testing::TestWithParam<ContactSetting> {};

TEST_P(Caught, AWheelJustAboveTheGroundUnderAnyLoad) {
  // 50 kg: stops from 156 m/s within half its width; omega dt = 0.45 at 1 ms, which explicit Euler holds with zeta =
  // 0.3.
  const double mass = 50.0;
  for (const double height : {0.0, 1e-6, 1e-4})
    for (const double acceleration : {10.0, 200.0, 2000.0}) {
      SimConfig config =
          frictionless(GetParam().integrator, GetParam().dt, GetParam().contacts, 2.0 * 0.3 * std::sqrt(1e7 * mass));
      config.gravity = acceleration;
      BareRun wheel(solidBody(kWheel, mass), flatFloor(5.0, 4), config);
      wheel.place({0.1, 0.2, 0.35 + height});
      for (int i = 0; i < 300; ++i) {
        wheel.step();
        // Nothing of the touch may count as a jump.
        ASSERT_EQ(wheel.memory().slack, 0.0) << height << " m, " << acceleration << " m/s^2, step " << i;
        // The fall into the sag of 1 cm at most overshoots to less than twice, but for the step in which it begins.
        ASSERT_GT(wheel.position().z(), 0.35 - 0.03) << height << " m, " << acceleration << " m/s^2, step " << i;
      }
      EXPECT_EQ(wheel.passedThrough(), 0);
    }
}

TEST_P(Caught, AWheelThatHitsAtAnySpeed) {
  const double mass = 50.0;
  RandomContactCases random(71);
  for (const double speed : {5.0, 20.0, 50.0, 100.0})
    for (const double height : {0.0, 1e-6, 1e-4, 0.013, 0.031}) {
      SimConfig config =
          frictionless(GetParam().integrator, GetParam().dt, GetParam().contacts, 2.0 * 0.3 * std::sqrt(1e7 * mass));
      BareRun wheel(solidBody(kWheel, mass), flatFloor(50.0, 40), config);
      // Also askew in its direction of travel.
      wheel.place({0.1, 0.2, 0.35 + height}, Quaterniond::Identity(), {random.uniform(0.0, 0.5) * speed, 0.0, -speed});
      bool touched = false;
      for (int i = 0; i < 400 && wheel.velocity().z() < 0.0; ++i) {
        wheel.step();
        touched = touched || wheel.memory().count > 0;
        ASSERT_GT(wheel.position().z(), 0.0) << speed << " m/s from " << height << " m, step " << i;
        ASSERT_EQ(wheel.memory().slack, 0.0) << speed << " m/s from " << height << " m, step " << i;
      }
      EXPECT_TRUE(touched);
      EXPECT_GT(wheel.velocity().z(), 0.0) << speed << " m/s from " << height << " m";
      EXPECT_EQ(wheel.passedThrough(), 0);
    }
}

INSTANTIATE_TEST_SUITE_P(Settings, Caught, testing::ValuesIn(allContactSettings()), settingName);

/// Shapes by name, and steps in parts of the largest that the certificate allows.
struct Sheet {
  IntegratorKind integrator;
  Vector3d radii;
};

class SingleSheet : public testing::TestWithParam<Sheet> {
 protected:
  /// Throws the body at a sheet from random phases of the step; returns how often its centre ended behind it and how
  /// often that was said.
  struct Outcome {
    int throws = 0, behind = 0, reported = 0;
  };
  Outcome throwAt(double part_of_step, double part_of_speed, unsigned seed, double restitution = 0.3) const {
    const double mass = 100.0;
    SimConfig config;
    config.integrator = GetParam().integrator;
    config.restitution = restitution;
    config.gravity = 0.0;
    config.allow_unstable = true;
    const auto terrain = flatFloor(20.0, 3);
    const double largest =
        make(solidBody(GetParam().radii, mass), terrain, config).certificate().largestStep(config.integrator);
    config.dt = std::min(0.1, part_of_step * largest);
    config.allow_unstable = false;
    Simulator body = make(solidBody(GetParam().radii, mass), terrain, config);
    const double speed = part_of_speed * body.model().stoppable_speed[0];
    RandomContactCases random(seed);
    Outcome outcome;
    for (int i = 0; i < 40; ++i) {
      ++outcome.throws;
      // The first of them flat on, then any attitude; random part of a step before the touch.
      const Eigen::Matrix3d R = i < 8 ? Eigen::Matrix3d::Identity() : random.rotation();
      const double half = PosedEllipsoid(Vector3d::Zero(), R, GetParam().radii).halfBox().z();
      const Vector3d tilt =
          i % 2 == 0 ? Vector3d::Zero() : Vector3d(random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3), 0.0);
      Pose start;
      start.p = {random.uniform(-1, 1), random.uniform(-1, 1), half + random.uniform(0.0, 1.0) * speed * config.dt};
      start.q = Quaterniond(R);
      if (!body.place(start, speed * (tilt - Vector3d::UnitZ()).normalized(), Vector3d::Zero()).empty()) continue;
      bool behind = false;
      for (int step = 0; step < 200 && !behind && (step < 3 || body.rootVelocity_W().z() < 0.0); ++step) {
        body.step();
        behind = body.rootPose().p.z() <= 0.0;
      }
      outcome.behind += behind;
      outcome.reported += body.events().passed_through > 0;
    }
    return outcome;
  }
};

TEST_P(SingleSheet, NothingPassesBelowTheStoppableSpeedWhateverTheStep) {
  // Without any damping too, where an integrator can hold that: nothing but the spring stops it then.
  for (const double restitution : {0.3, 1.0}) {
    if (restitution == 1.0 && GetParam().integrator == IntegratorKind::kExplicitEuler) continue;
    for (const double part_of_step : {0.02, 0.1, 0.3, 0.4, 0.6, 0.9, 1.0})
      for (const double part_of_speed : {0.1, 0.5, 0.9, 0.999}) {
        const Outcome outcome = throwAt(part_of_step, part_of_speed, 72, restitution);
        EXPECT_EQ(outcome.behind, 0) << part_of_step << " of the largest step, " << part_of_speed
                                     << " of the stoppable speed, restitution " << restitution;
        EXPECT_EQ(outcome.reported, 0) << part_of_step << " of the largest step, " << part_of_speed
                                       << " of the stoppable speed, restitution " << restitution;
      }
  }
}

TEST_P(SingleSheet, PassingAboveTheStoppableSpeedIsNeverSilent) {
  int passed = 0;
  for (const double part_of_step : {0.05, 0.3, 1.0})
    for (const double part_of_speed : {1.5, 3.0, 20.0}) {
      const Outcome outcome = throwAt(part_of_step, part_of_speed, 73);
      EXPECT_EQ(outcome.reported, outcome.behind)
          << part_of_step << " of the largest step, " << part_of_speed << " of the stoppable speed";
      passed += outcome.behind;
    }
  EXPECT_GT(passed, 100);
}

std::string sheetName(const testing::TestParamInfo<Sheet>& sheet) {
  const Vector3d& r = sheet.param.radii;
  const char* shape = r.z() < 0.1 ? "Disc" : r.y() == r.z() ? "Sphere" : "Wheel";
  const char* integrator = sheet.param.integrator == IntegratorKind::kExplicitEuler       ? "ExplicitEuler"
                           : sheet.param.integrator == IntegratorKind::kSemiImplicitEuler ? "SemiImplicitEuler"
                                                                                          : "Rk4";
  return std::string(integrator) + shape;
}

INSTANTIATE_TEST_SUITE_P(Shapes, SingleSheet,
                         testing::Values(Sheet{IntegratorKind::kExplicitEuler, {0.3, 0.3, 0.3}},
                                         Sheet{IntegratorKind::kExplicitEuler, {0.35, 0.12, 0.35}},
                                         Sheet{IntegratorKind::kSemiImplicitEuler, {0.3, 0.3, 0.3}},
                                         Sheet{IntegratorKind::kSemiImplicitEuler, {0.35, 0.12, 0.35}},
                                         Sheet{IntegratorKind::kRk4, {0.3, 0.3, 0.3}},
                                         Sheet{IntegratorKind::kRk4, {0.35, 0.12, 0.35}},
                                         Sheet{IntegratorKind::kRk4, {0.4, 0.4, 0.02}}),
                         sheetName);

/// Something thin that stands at x = 0, its front to -x and its back to +x, `thickness` apart; `height` tall on the
/// ground z = 0, or a wall without a ground that is far larger than the body.
struct ThinThing {
  double thickness;
  std::optional<double> height;

  std::shared_ptr<const Terrain> terrain() const {
    TriangleSoup soup;
    const double low = height ? 0.0 : -20.0, high = height.value_or(20.0), t = thickness;
    addQuad(soup, {0, 20, low}, {0, -20, low}, {0, -20, high}, {0, 20, high});
    addQuad(soup, {t, -20, low}, {t, 20, low}, {t, 20, high}, {t, -20, high});
    if (height) {
      addQuad(soup, {0, -20, high}, {t, -20, high}, {t, 20, high}, {0, 20, high});
      addQuad(soup, {-50, -20, 0}, {0, -20, 0}, {0, 20, 0}, {-50, 20, 0});
      addQuad(soup, {t, -20, 0}, {t + 50, -20, 0}, {t + 50, 20, 0}, {t, 20, 0});
    }
    return terrainOf(soup);
  }
};

struct ThinOutcome {
  int throws = 0, through = 0, reported = 0;
};

/// Throws a wheel along +x at a thin thing, from random phases of the step and attitudes about its axle and the
/// vertical. It is through when its centre is behind the front and the thing still reaches higher than the body's
/// lowest point by more than the body's half width: climbing over it is not going through it.
ThinOutcome throwAtThin(const ThinThing& thing, IntegratorKind integrator, double mass, double part_of_step,
                        double part_of_speed, unsigned seed, double fastest = 300.0) {
  SimConfig config;
  config.integrator = integrator;
  config.gravity = thing.height ? 9.80665 : 0.0;
  config.allow_unstable = true;
  config.mu_static = config.mu_kinetic = 0.0;
  const auto terrain = thing.terrain();
  const double largest = make(solidBody(kWheel, mass), terrain, config).certificate().largestStep(integrator);
  config.dt = std::min(0.05, part_of_step * largest);
  config.allow_unstable = false;
  Simulator body = make(solidBody(kWheel, mass), terrain, config);
  const double speed = std::min(fastest, part_of_speed * body.model().stoppable_speed[0]);
  RandomContactCases random(seed);
  ThinOutcome outcome;
  for (int i = 0; i < 16; ++i) {
    const double heading = i < 4 ? 0.0 : random.uniform(-1.5, 1.5);
    const Eigen::Matrix3d R = (Eigen::AngleAxisd(heading, Vector3d::UnitZ()) *
                               Eigen::AngleAxisd(random.uniform(-3.0, 3.0), Vector3d::UnitY()))
                                  .toRotationMatrix();
    const Vector3d half = PosedEllipsoid(Vector3d::Zero(), R, kWheel).halfBox();
    Pose start;
    start.p = {-half.x() - random.uniform(0.0, 1.0) * speed * config.dt, random.uniform(-1, 1), half.z()};
    start.q = Quaterniond(R);
    if (!body.place(start, {speed, 0.0, 0.0}, Vector3d::Zero()).empty()) continue;
    ++outcome.throws;
    bool behind = false, through = false;
    for (int step = 0; step < 200 && !behind && (step < 3 || body.rootVelocity_W().x() > 0.0); ++step) {
      if (body.step() != StepStatus::kOk) break;
      const Pose X = body.rootPose();
      behind = X.p.x() > 0.0;
      const double low = X.p.z() - PosedEllipsoid(X.p, X.q.toRotationMatrix(), kWheel).halfBox().z();
      through = behind && low < thing.height.value_or(20.0) - kWheel.minCoeff();
    }
    outcome.through += through;
    outcome.reported += body.events().passed_through > 0;
  }
  return outcome;
}

TEST(ThinThings, NothingPassesAWallOrKerbBelowTheStoppableSpeed) {
  int throws = 0;
  for (const IntegratorKind integrator : {IntegratorKind::kSemiImplicitEuler, IntegratorKind::kRk4})
    for (const ThinThing& thing : {ThinThing{0.0, {}}, ThinThing{0.001, {}}, ThinThing{0.01, {}}, ThinThing{0.05, 0.6},
                                   ThinThing{0.05, 0.25}, ThinThing{10.0, 0.25}})
      for (const double mass : {1.0, 100.0})
        for (const double part_of_step : {0.05, 0.4, 1.0})
          for (const double part_of_speed : {0.2, 0.999}) {
            const ThinOutcome outcome = throwAtThin(thing, integrator, mass, part_of_step, part_of_speed, 74);
            throws += outcome.throws;
            EXPECT_EQ(outcome.through, 0)
                << thing.thickness << " m thick, " << thing.height.value_or(0.0) << " m tall, " << mass << " kg, "
                << part_of_step << " of the largest step, " << part_of_speed << " of the stoppable speed";
            EXPECT_EQ(outcome.reported, 0)
                << thing.thickness << " m thick, " << thing.height.value_or(0.0) << " m tall";
          }
  EXPECT_GT(throws, 2000);
}

TEST(ThinThings, PassingAtUpTo300MetresASecondIsNeverSilent) {
  int through = 0;
  for (const ThinThing& thing : {ThinThing{0.0, {}}, ThinThing{0.001, {}}, ThinThing{0.05, 0.6}})
    for (const double part_of_step : {0.1, 1.0})
      for (const double speed : {60.0, 300.0}) {
        const ThinOutcome outcome =
            throwAtThin(thing, IntegratorKind::kSemiImplicitEuler, 2000.0, part_of_step, 1e9, 75, speed);
        EXPECT_GE(outcome.reported, outcome.through)
            << thing.thickness << " m thick, " << part_of_step << " of the largest step, " << speed << " m/s";
        through += outcome.through;
      }
  EXPECT_GT(through, 50);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
