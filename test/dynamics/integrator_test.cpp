// The one-step methods on the permanent spring x'' = -omega^2 x, alone and through the whole simulator, and on
// rotations. h = omega dt = 0.2: k = 1e7 N/m, 250 kg, 1 ms.
#include "ellipsoid_vehicle_sim/dynamics/integrator.h"

#include <gtest/gtest.h>

#include <array>
#include <complex>

#include "support/motions.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

/// Position and velocity over omega, time in 1/omega.
struct Spring {
  struct State {
    double x = 1.0, v = 0.0;
  };
  using Rate = State;
  void rate(const State& s, double, Rate& k) { k = {s.v, -s.x}; }
  void positionRates(const State& s, Rate& k) { k.x = s.v; }
  void advance(const State& s, double h, const Rate& k, State& result) const {
    result = {s.x + h * k.x, s.v + h * k.v};
  }
  void advanceVelocities(State& s, double h, const Rate& k) const { s.v += h * k.v; }
  void advancePositions(State& s, double h, const Rate& k) const { s.x += h * k.x; }
  void toTangent(double, const Rate&, Rate&) const {}
  void combine(Rate (&k)[4]) const {
    k[0].x = (k[0].x + 2.0 * k[1].x + 2.0 * k[2].x + k[3].x) / 6.0;
    k[0].v = (k[0].v + 2.0 * k[1].v + 2.0 * k[2].v + k[3].v) / 6.0;
  }
};

template <typename System>
void integrate(IntegratorKind kind, System& system, typename System::State& x, double dt) {
  typename System::Rate k[4];
  typename System::State scratch = x;
  switch (kind) {
    case IntegratorKind::kExplicitEuler:
      return explicitEulerStep(system, x, dt, k, scratch);
    case IntegratorKind::kSemiImplicitEuler:
      return semiImplicitEulerStep(system, x, dt, k, scratch);
    case IntegratorKind::kRk4:
      return rk4Step(system, x, dt, k, scratch);
    default:
      FAIL() << toString(kind) << " is no formula of one step";
  }
}

double distance(double x, double v, double t) { return std::hypot(x - std::cos(t), v + std::sin(t)); }

/// Largest error of (x, v / omega) over the span, amplitude 1.
double largestError(IntegratorKind kind, double h, int steps) {
  Spring spring;
  Spring::State s;
  double largest = 0.0;
  for (int i = 1; i <= steps; ++i) {
    integrate(kind, spring, s, h);
    largest = std::max(largest, distance(s.x, s.v, i * h));
  }
  return largest;
}

constexpr double kStep = 0.2;
int stepsOf(int periods) { return static_cast<int>(std::lround(periods * 2.0 * M_PI / kStep)); }

// Printed with two digits: half a unit in the second is at most 5 %.
constexpr double kTwoDigits = 0.05;

struct Row {
  IntegratorKind kind;
  double one_step, one_period, ten_periods, hundred_periods;
};

// Source: notation.h [OscillatorErrors].
const std::array<Row, 3> kTable = {{{IntegratorKind::kExplicitEuler, 2.0e-2, 0.84, 472.0, 6e26},
                                    {IntegratorKind::kSemiImplicitEuler, 2.0e-2, 1.1e-1, 2.0e-1, 1.1},
                                    {IntegratorKind::kRk4, 2.7e-6, 8.3e-5, 8.4e-4, 8.4e-3}}};

TEST(Integrator, ErrorOnThePermanentSpringIsThatOfTheTable) {
  for (const Row& row : kTable) {
    SCOPED_TRACE(toString(row.kind));
    EXPECT_NEAR(largestError(row.kind, kStep, 1), row.one_step, kTwoDigits * row.one_step);
    EXPECT_NEAR(largestError(row.kind, kStep, stepsOf(1)), row.one_period, kTwoDigits * row.one_period);
    EXPECT_NEAR(largestError(row.kind, kStep, stepsOf(10)), row.ten_periods, kTwoDigits * row.ten_periods);
    // 6e26 has one digit.
    const double tolerance = row.hundred_periods > 1e20 ? 0.1 : kTwoDigits;
    EXPECT_NEAR(largestError(row.kind, kStep, stepsOf(100)), row.hundred_periods, tolerance * row.hundred_periods);
  }
}

TEST(Integrator, AmplitudePerStepFollowsTheAmplificationFactor) {
  // |G|^2: explicit 1 + h^2; RK4 1 - h^6/72 + h^8/576. Semi-implicit Euler keeps x^2 + v^2 - h x v for ever (its own
  // shadow energy), exactly. Source: notation.h [OscillatorErrors].
  const double h = kStep;
  const int steps = stepsOf(100);
  Spring spring;
  Spring::State explicit_euler, semi, rk4;
  for (int i = 0; i < steps; ++i) {
    integrate(IntegratorKind::kExplicitEuler, spring, explicit_euler, h);
    integrate(IntegratorKind::kSemiImplicitEuler, spring, semi, h);
    integrate(IntegratorKind::kRk4, spring, rk4, h);
  }
  const double expected = std::pow(1.0 + h * h, 0.5 * steps);
  EXPECT_NEAR(std::hypot(explicit_euler.x, explicit_euler.v), expected, 1e-10 * expected);
  EXPECT_NEAR(semi.x * semi.x + semi.v * semi.v - h * semi.x * semi.v, 1.0, 1e-10);
  EXPECT_NEAR(std::hypot(rk4.x, rk4.v), std::pow(1.0 - std::pow(h, 6) / 72.0 + std::pow(h, 8) / 576.0, 0.5 * steps),
              1e-12);
  EXPECT_NEAR(std::hypot(rk4.x, rk4.v), 1.0 - 0.0014, 1e-4);
}

TEST(Integrator, ObservedOrdersAreOneOneAndFour) {
  const double expected[] = {1.0, 1.0, 4.0};
  for (const IntegratorKind kind : oneStepIntegrators()) {
    const double coarse = largestError(kind, 0.02, 300), fine = largestError(kind, 0.01, 600);
    EXPECT_NEAR(std::log2(coarse / fine), expected[static_cast<int>(kind)], 0.05) << toString(kind);
  }
}

/// The same spring, swinging between two masses of the simulator.
double largestErrorInTheSimulator(IntegratorKind kind, int steps) {
  SimConfig config = springConfig(kind, 1e-3, 1e5, 100.0);
  const double omega = kStep / config.dt, reduced_mass = 250.0;
  Simulator simulator = make(springPair(reduced_mass, reduced_mass * omega * omega), emptySpace(), config);
  placeAt(simulator, Vector3d::Zero(), Vector3d::Zero());
  std::vector<JointReading> joints;
  simulator.jointReadings(joints);
  const double amplitude = joints[0].position;
  EXPECT_GT(std::abs(amplitude), 1e-4);
  double largest = 0.0;
  for (int i = 1; i <= steps; ++i) {
    EXPECT_EQ(simulator.step(), StepStatus::kOk);
    simulator.jointReadings(joints);
    largest = std::max(largest,
                       distance(joints[0].position / amplitude, joints[0].velocity / (amplitude * omega), i * kStep));
  }
  return largest;
}

TEST(Integrator, ErrorThroughTheWholeSimulatorIsTheSame) {
  // Rounding of the joint's own scale: 1e-16 m over a millimetre of amplitude.
  for (const IntegratorKind kind : oneStepIntegrators()) {
    const int steps = stepsOf(10);
    const double alone = largestError(kind, kStep, steps);
    EXPECT_NEAR(largestErrorInTheSimulator(kind, steps), alone, 1e-6 * alone + 1e-9) << toString(kind);
  }
}

/// Free rotation of a body with the inertia (1, 2, 3) kg m^2: attitude and angular velocity in W.
struct FreeRotation {
  struct State {
    Quaterniond q = Quaterniond::Identity();
    Vector3d w = {1.0, 0.1, 1.2};
  };
  struct Rate {
    Vector3d w, alpha;
  };
  void rate(const State& s, double, Rate& k) {
    const Vector3d I(1.0, 2.0, 3.0), w_B = s.q.conjugate() * s.w;
    const Vector3d moment = -w_B.cross(Vector3d(I.cwiseProduct(w_B)));
    k = {s.w, s.q * Vector3d(moment.cwiseQuotient(I))};
  }
  void positionRates(const State& s, Rate& k) { k.w = s.w; }
  void advance(const State& s, double h, const Rate& k, State& result) const {
    result.q = quaternionFromRotationVector(h * k.w) * s.q;
    result.w = s.w + h * k.alpha;
  }
  void advanceVelocities(State& s, double h, const Rate& k) const { s.w += h * k.alpha; }
  void advancePositions(State& s, double h, const Rate& k) const { s.q = quaternionFromRotationVector(h * k.w) * s.q; }
  void toTangent(double h, const Rate& previous, Rate& k) const { k.w = rotationVectorRate(h * previous.w, k.w); }
  void combine(Rate (&k)[4]) const {
    k[0].w = (k[0].w + 2.0 * k[1].w + 2.0 * k[2].w + k[3].w) / 6.0;
    k[0].alpha = (k[0].alpha + 2.0 * k[1].alpha + 2.0 * k[2].alpha + k[3].alpha) / 6.0;
  }
};

Quaterniond attitudeAfter(IntegratorKind kind, double seconds, int steps) {
  FreeRotation body;
  FreeRotation::State s;
  for (int i = 0; i < steps; ++i) integrate(kind, body, s, seconds / steps);
  return s.q;
}

TEST(Integrator, RotationsHaveTheOrderOfTheMethod) {
  const Quaterniond exact = attitudeAfter(IntegratorKind::kRk4, 2.0, 20000);
  const double expected[] = {1.0, 1.0, 4.0};
  for (const IntegratorKind kind : oneStepIntegrators()) {
    const int steps = kind == IntegratorKind::kRk4 ? 50 : 2000;
    const double coarse = exact.angularDistance(attitudeAfter(kind, 2.0, steps));
    const double fine = exact.angularDistance(attitudeAfter(kind, 2.0, 2 * steps));
    EXPECT_NEAR(std::log2(coarse / fine), expected[static_cast<int>(kind)], 0.1) << toString(kind);
  }
}

TEST(Integrator, RotationVectorRateIsTheDerivativeOfTheVector) {
  // exp(r(t)) with r' from the formula must turn with w: compared with central differences of the product's logarithm.
  const Vector3d w(0.7, -1.1, 0.4);
  for (const double angle : {0.0, 1e-8, 1e-3, 0.03162, 0.03163, 0.5, 2.0, 3.0}) {
    const Vector3d r = angle * Vector3d(0.36, 0.48, 0.8);
    const double h = 1e-4;
    const Vector3d rate = rotationVectorRate(r, w);
    const Quaterniond forward = quaternionFromRotationVector(r + h * rate),
                      back = quaternionFromRotationVector(r - h * rate);
    const Eigen::AngleAxisd turned(forward * back.conjugate());
    EXPECT_LT((turned.angle() * turned.axis() / (2.0 * h) - w).norm(), 1e-7) << "angle " << angle;
  }
}

TEST(Integrator, ConstantTurningIsExactForEveryMethod) {
  struct Turning : FreeRotation {
    void rate(const State& s, double, Rate& k) { k = {s.w, Vector3d::Zero()}; }
  };
  for (const IntegratorKind kind : oneStepIntegrators()) {
    Turning body;
    FreeRotation::State s;
    s.w = {3.0, -2.0, 1.0};
    for (int i = 0; i < 1000; ++i) integrate(kind, body, s, 0.01);
    EXPECT_LT(s.q.normalized().angularDistance(quaternionFromRotationVector(10.0 * s.w)), 1e-12) << toString(kind);
  }
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
