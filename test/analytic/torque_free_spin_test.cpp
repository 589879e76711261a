// A body that nothing touches, against Euler's solution in elliptic functions. Source: notation.h [TorqueFreeBody].
#include <gtest/gtest.h>

#include "support/motions.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Vector3d;

struct Case {
  Vector3d inertia, w0, w7;  // along the body's axes, at 0 and at 7 s
  double period;
};

// The second starts about the unstable axis.
const Case kCases[] = {
    {{1.0, 2.0, 3.0}, {1.0, 0.1, 1.2}, {-0.110259824444, 0.998920803224, 1.053906578543}, 5.582844270},
    {{2.0, 1.0, 3.0}, {1.0, 0.001, 0.001}, {0.996983857255, 0.077615645159, 0.044818851590}, 55.061681}};

Simulator spinning(const Case& c, IntegratorKind kind, double dt) {
  VehicleDescription body = solidBody({0.3, 0.2, 0.1}, 1.0);
  body.links[0].I_cm_L = c.inertia.asDiagonal();
  SimConfig config;
  config.integrator = kind;
  config.dt = dt;
  config.gravity = 0.0;
  config.allow_unstable = true;
  Simulator simulator = make(body, emptySpace(), config);
  placeAt(simulator, {1.0, 2.0, 3.0}, {0.3, -0.2, 0.1}, c.w0);
  return simulator;
}

Vector3d bodyRates(const Simulator& s) { return s.rootPose().q.conjugate() * s.rootAngularVelocity_W(); }
Vector3d angularMomentum(const Simulator& s, const Case& c) {
  return s.rootPose().q * Vector3d(c.inertia.cwiseProduct(bodyRates(s)));
}

TEST(TorqueFreeSpin, RatesFollowTheEllipticFunctions) {
  // RK4, 1 ms: error of order (w dt)^4 t = 1e-11; the reference has twelve digits.
  for (const Case& c : kCases) {
    Simulator simulator = spinning(c, IntegratorKind::kRk4, 1e-3);
    run(simulator, 7.0);
    EXPECT_LT((bodyRates(simulator) - c.w7).cwiseAbs().maxCoeff(), 1e-10) << bodyRates(simulator).transpose();
  }
}

TEST(TorqueFreeSpin, RatesComeBackAfterAPeriod) {
  for (const Case& c : kCases) {
    Simulator simulator = spinning(c, IntegratorKind::kRk4, c.period / 20000.0);
    for (int i = 0; i < 20000; ++i) simulator.step();
    // The period is printed to 1e-9 and 1e-6 s; rates change by about one a second, or grow from a thousandth.
    EXPECT_LT((bodyRates(simulator) - c.w0).cwiseAbs().maxCoeff(), 2e-6);
  }
}

TEST(TorqueFreeSpin, EnergyAndAngularMomentumInTheWorldAreKept) {
  for (const Case& c : kCases) {
    Simulator simulator = spinning(c, IntegratorKind::kRk4, 1e-3);
    const Vector3d L = angularMomentum(simulator, c);
    const double E = simulator.energy();
    run(simulator, 20.0);
    // Fourth order: (w dt)^4 / 120 a second, a few 1e-13, and rounding of 20,000 steps.
    EXPECT_LT((angularMomentum(simulator, c) - L).cwiseAbs().maxCoeff(), 1e-11);
    EXPECT_NEAR(simulator.energy(), E, 1e-11);
    EXPECT_NEAR(simulator.rootPose().q.norm(), 1.0, 1e-15);
    EXPECT_LT((simulator.rootPose().p - Vector3d(1.0 + 6.0, 2.0 - 4.0, 3.0 + 2.0)).norm(), 1e-11);
  }
}

TEST(TorqueFreeSpin, EulerConvergesToTheSameMotionWithOrderOne) {
  for (const IntegratorKind kind : {IntegratorKind::kExplicitEuler, IntegratorKind::kSemiImplicitEuler}) {
    double error[2];
    for (int i = 0; i < 2; ++i) {
      Simulator simulator = spinning(kCases[0], kind, i == 0 ? 1e-3 : 5e-4);
      run(simulator, 7.0);
      error[i] = (bodyRates(simulator) - kCases[0].w7).norm();
      EXPECT_NEAR(simulator.rootPose().q.norm(), 1.0, 1e-15);
    }
    EXPECT_LT(error[0], 0.05);  // half a step of rates that change by 1.3 a second, for 7 s
    EXPECT_NEAR(std::log2(error[0] / error[1]), 1.0, 0.1) << toString(kind);
  }
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
