// Which step each integrator can hold. Source: notation.h [OscillatorLimits].
#include "ellipsoid_vehicle_sim/vehicle/certificate.h"

#include <gtest/gtest.h>

#include "support/motions.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Vector3d;

struct Row {
  double zeta, explicit_euler, semi_implicit, rk4;
};

const Row kLimits[] = {{0.0, 0.0, 2.0, 2.828427},
                       {0.05, 0.1, 1.902498, 2.909800},
                       {0.1, 0.2, 1.809975, 2.950853},
                       {0.2, 0.4, 1.639608, 2.940088},
                       {0.3, 0.6, 1.488061, 2.835300},
                       {0.5, 1.0, 1.236068, 2.622542},
                       {0.7071, 1.414214, 1.035276, 2.704353},
                       {1.0, 2.0, 0.828427, 2.785294},
                       {1.5, 0.763932, 0.605551, 1.063887},
                       {2.0, 0.535898, 0.472136, 0.746317},
                       {5.0, 0.202041, 0.198039, 0.281372}};

TEST(Certificate, OscillatorLimitsAreThoseOfTheTable) {
  // Six decimals; 0.7071 stands for 1/sqrt(2), 7e-6 away.
  for (const Row& row : kLimits) {
    const double tolerance = row.zeta == 0.7071 ? 3e-5 : 1e-6;
    EXPECT_NEAR(oscillatorLimit(IntegratorKind::kExplicitEuler, row.zeta), row.explicit_euler, tolerance) << row.zeta;
    EXPECT_NEAR(oscillatorLimit(IntegratorKind::kSemiImplicitEuler, row.zeta), row.semi_implicit, tolerance)
        << row.zeta;
    EXPECT_NEAR(oscillatorLimit(IntegratorKind::kRk4, row.zeta), row.rk4, tolerance) << row.zeta;
  }
}

// A ball that only its contact's spring holds: omega = 100/s at 10 kg and 1e5 N/m.
constexpr double kMass = 10.0, kStiffness = 1e5, kOmega = 100.0;

SimConfig ballConfig(IntegratorKind kind, double zeta, double dt) {
  SimConfig config = springConfig(kind, dt, kStiffness, 2.0 * zeta * kMass * kOmega);
  config.gravity = 9.81;
  config.allow_unstable = false;
  return config;
}

VehicleDescription ball() { return solidBody(Vector3d::Constant(0.3), kMass); }

TEST(Certificate, OfABodyOnOneSpringIsTheClosedForm) {
  for (const double zeta : {0.1, 0.5, 1.5}) {
    const Simulator simulator = make(ball(), flatFloor(), ballConfig(IntegratorKind::kRk4, zeta, 1e-3));
    const StabilityCertificate& certificate = simulator.certificate();
    EXPECT_TRUE(certificate.from_rest_pose);
    for (const IntegratorKind kind : oneStepIntegrators()) {
      const double expected = oscillatorLimit(kind, zeta) / kOmega;
      EXPECT_NEAR(certificate.largestStep(kind), expected, 0.01 * expected) << toString(kind) << " zeta " << zeta;
    }
    if (zeta < 1.0) {
      ASSERT_FALSE(certificate.modes.empty());
      EXPECT_NEAR(certificate.modes.front().frequency, kOmega, 0.01 * kOmega);
      EXPECT_NEAR(certificate.modes.front().damping_ratio, zeta, 0.01);
      EXPECT_NE(certificate.modes.front().name.find("base z"), std::string::npos) << certificate.modes.front().name;
    }
  }
}

TEST(Certificate, AnUndampedSpringIsNothingForExplicitEuler) {
  const Simulator simulator = make(ball(), flatFloor(), ballConfig(IntegratorKind::kRk4, 0.0, 1e-3));
  EXPECT_LT(simulator.certificate().largestStep(IntegratorKind::kExplicitEuler), 1e-6);
  EXPECT_NEAR(simulator.certificate().largestStep(IntegratorKind::kSemiImplicitEuler), 2.0 / kOmega, 0.02 / kOmega);
  EXPECT_NEAR(simulator.certificate().largestStep(IntegratorKind::kRk4), std::sqrt(8.0) / kOmega,
              0.01 * std::sqrt(8.0) / kOmega);
}

/// Set down at rest, then left alone or commanded: the largest speed of the last tenth of the run.
double speedAfterRest(const VehicleDescription& vehicle, SimConfig config, int steps,
                      const DriveCommand* command = nullptr) {
  config.allow_unstable = true;
  Simulator simulator = make(vehicle, flatFloor(), config);
  standAt(simulator, 0.0, 0.0, 0.0);
  double fastest = 0.0;
  for (int i = 0; i < steps; ++i) {
    if (command) simulator.command(*command);
    if (simulator.step() != StepStatus::kOk) return 1e300;
    double speed = simulator.rootVelocity_W().norm();
    for (const double qd : simulator.state().motion.qd) speed = std::max(speed, std::abs(qd));
    if (i >= steps - steps / 10) fastest = std::max(fastest, speed);
  }
  return fastest;
}

// Set-down leaves a rest good to 1e-6 m/s; what grows leaves that far behind.
constexpr double kStaysAtRest = 1e-5, kHasGrown = 1e-3;

TEST(Certificate, FivePercentBelowTheBoundHoldsAndFivePercentAboveGrows) {
  for (const double zeta : {0.1, 0.5, 1.5})
    for (const IntegratorKind kind : oneStepIntegrators()) {
      const double bound =
          make(ball(), flatFloor(), ballConfig(IntegratorKind::kRk4, zeta, 1e-3)).certificate().largestStep(kind);
      // Explicit Euler grows by 0.1 zeta^2 a step there: the slowest of all, 1e-3.
      constexpr int kSteps = 30000;
      EXPECT_LT(speedAfterRest(ball(), ballConfig(kind, zeta, 0.95 * bound), kSteps), kStaysAtRest)
          << toString(kind) << " zeta " << zeta;
      EXPECT_GT(speedAfterRest(ball(), ballConfig(kind, zeta, 1.05 * bound), kSteps), kHasGrown)
          << toString(kind) << " zeta " << zeta;
    }
}

TEST(Certificate, TheBoundOfACarIsWhereTheCarBeginsToShake) {
  // The bound covers a parked car and one that drives: below it both hold, above it one of them does not. Driving is a
  // crawl of 0.1 mm/s, 0.3 mrad/s of the wheels, so that the pose is still that of the certificate.
  const DriveCommand crawl = twist(1e-4);
  SimConfig config;
  for (const IntegratorKind kind : {IntegratorKind::kSemiImplicitEuler, IntegratorKind::kRk4}) {
    config.integrator = kind;
    config.relaxation_time = 2e-3;
    const double bound = make(car(), flatFloor(), config).certificate().largestStep(kind);
    SimConfig below = config, above = config;
    below.dt = 0.95 * bound;
    above.dt = 1.05 * bound;
    EXPECT_LT(speedAfterRest(car(), below, 4000), kStaysAtRest) << toString(kind) << " " << bound;
    EXPECT_LT(speedAfterRest(car(), below, 4000, &crawl), 1e-3) << toString(kind) << " " << bound;
    EXPECT_GT(std::max(speedAfterRest(car(), above, 4000), speedAfterRest(car(), above, 4000, &crawl)), 0.1)
        << toString(kind) << " " << bound;
  }
}

TEST(Certificate, AStepThatCannotHoldIsRefusedWithTheLargestThatCan) {
  for (const IntegratorKind kind : oneStepIntegrators()) {
    const double bound = oscillatorLimit(kind, 0.5) / kOmega;
    const Loaded<Simulator> refused = [&] {
      SimConfig config = ballConfig(kind, 0.5, 2.0 * bound);
      config.allow_no_wheels = true;
      return Simulator::create(ball(), flatFloor(), config);
    }();
    ASSERT_FALSE(refused) << toString(kind);
    const std::string text = problemText(refused.problems);
    EXPECT_NE(text.find("parameter 'dt'"), std::string::npos) << text;
    EXPECT_NE(text.find(toString(kind)), std::string::npos) << text;
    EXPECT_NE(text.find("allow_unstable"), std::string::npos) << text;
    char asked[40];
    std::snprintf(asked, sizeof asked, "is %.6g s", 2.0 * bound);
    EXPECT_NE(text.find(asked), std::string::npos) << text;
    const std::size_t at = text.find("steps up to ");
    ASSERT_NE(at, std::string::npos) << text;
    EXPECT_NEAR(std::stod(text.substr(at + 12)), bound, 0.01 * bound) << text;
  }
}

TEST(Certificate, AllowUnstableRunsAndSaysSo) {
  SimConfig config = ballConfig(IntegratorKind::kSemiImplicitEuler, 0.5, 0.05);
  config.allow_unstable = true;
  const Simulator simulator = make(ball(), flatFloor(), config);
  bool said = false;
  for (const std::string& line : simulator.loadReport()) said = said || line.find("UNSTABLE") != std::string::npos;
  EXPECT_TRUE(said);
}

TEST(Certificate, WithoutARestPoseEachContactStandsForItself) {
  SimConfig config = ballConfig(IntegratorKind::kRk4, 0.3, 1e-3);
  config.gravity = 0.0;
  const Simulator simulator = make(ball(), flatFloor(), config);
  EXPECT_FALSE(simulator.certificate().from_rest_pose);
  for (const IntegratorKind kind : oneStepIntegrators()) {
    const double expected = oscillatorLimit(kind, 0.3) / kOmega;
    EXPECT_NEAR(simulator.certificate().largestStep(kind), expected, 1e-9 * expected) << toString(kind);
  }
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
