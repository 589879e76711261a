// A car on a steady circle. Source: notation.h [BicycleModel].
#include <gtest/gtest.h>

#include "support/motions.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Vector3d;

constexpr double kDegree = M_PI / 180.0;

/// Means over whole samples of a steady circle: speed of the rear axle's middle, of the centre of mass, yaw rate, side
/// slip.
struct Circle {
  double rear_speed = 0.0, speed = 0.0, yaw_rate = 0.0, side_slip = 0.0;
};

struct BicycleModel {
  double front = 0.0, rear = 0.0, mass = 0.0;  // lf, lr from the centre of mass [m], [kg]
  double wheelbase() const { return front + rear; }
};

/// Lengths of the car as built: the centre of mass of all its parts.
BicycleModel bicycleOf(const Simulator& simulator, const CarShape& shape) {
  double moment = 0.0, mass = 0.0;
  const VehicleModel& model = simulator.model();
  std::vector<Vector3d> p(model.bodies.size());
  p[0] = model.X_BR.inverse().p;
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    if (i > 0) p[i] = p[static_cast<std::size_t>(model.bodies[i].parent)] + model.bodies[i].X_PB.p;
    moment += model.bodies[i].inertia.mass * (p[i].x() + model.bodies[i].inertia.p_Acm.x());
    mass += model.bodies[i].inertia.mass;
  }
  const double x = moment / mass;
  return {shape.front - x, x - shape.rear, mass};
}

/// Along the heading, of a point `ahead` of the root link; and the heading's own turning.
Circle circleOf(Simulator& simulator, const CarShape& shape, const BicycleModel& bicycle, const DriveCommand& command,
                double run_up, double seconds) {
  drive(simulator, command, run_up);
  Circle sum;
  const int samples = 200;
  for (int i = 0; i < samples; ++i) {
    drive(simulator, command, seconds / samples);
    const Vector3d w = simulator.rootAngularVelocity_W(), v = simulator.rootVelocity_W();
    const Vector3d forward = simulator.rootPose().q * Vector3d::UnitX(),
                   left = simulator.rootPose().q * Vector3d::UnitY();
    const auto velocityAt = [&](double x) { return Vector3d(v + w.cross(x * forward)); };
    const Vector3d v_cm = velocityAt(shape.rear + bicycle.rear);
    sum.rear_speed += velocityAt(shape.rear).dot(forward) / samples;
    sum.speed += v_cm.norm() / samples;
    sum.yaw_rate += w.z() / samples;
    sum.side_slip += std::atan2(v_cm.dot(left), v_cm.dot(forward)) / samples;
  }
  return sum;
}

TEST(Circle, AtLowSpeedTheAxlesSayWhereTheCarGoes) {
  // 2 m/s, 5 degrees: 0.13 m/s^2 aside, a tyre slip of 1e-3 rad on both axles alike, which cancels in the yaw rate of
  // this balanced car to first order; the wheels' scrub about their own patch and the drive's slip leave less than
  // 1e-3.
  const CarShape shape;
  for (const IntegratorKind kind : {IntegratorKind::kSemiImplicitEuler, IntegratorKind::kRk4})
    for (const double sign : {1.0, -1.0}) {
      SimConfig config;
      config.integrator = kind;
      Simulator simulator = make(car(shape), flatFloor(), config);
      standAt(simulator, 0.0, 0.0, 0.7);
      const BicycleModel bicycle = bicycleOf(simulator, shape);
      const double delta = sign * 5.0 * kDegree;
      const Circle c = circleOf(simulator, shape, bicycle, ackermann(2.0, delta), 6.0, 2.0);
      const double expected = c.rear_speed * std::tan(delta) / bicycle.wheelbase();
      EXPECT_NEAR(c.rear_speed, 2.0, 0.02);
      EXPECT_NEAR(c.yaw_rate, expected, 1e-3 * std::abs(expected)) << toString(kind);
      const double radius = std::hypot(bicycle.wheelbase() / std::tan(delta), bicycle.rear);
      EXPECT_NEAR(c.speed / std::abs(c.yaw_rate), radius, 1e-3 * radius);
      // The rear tyre's slip angle m lf v r / (L C) turns the car inwards by that much.
      EXPECT_NEAR(c.side_slip, std::atan(bicycle.rear * std::tan(delta) / bicycle.wheelbase()), 2e-3);
    }
}

TEST(Circle, ATwistOfSpeedAndYawRateIsFollowed) {
  Simulator simulator = make(car(), flatFloor(), SimConfig{});
  standAt(simulator, 0.0, 0.0, 0.0);
  const CarShape shape;
  const Circle c = circleOf(simulator, shape, bicycleOf(simulator, shape), twist(3.0, 0.3), 6.0, 2.0);
  EXPECT_NEAR(c.rear_speed, 3.0, 0.03);
  EXPECT_NEAR(c.yaw_rate, 0.3, 0.003);
}

TEST(Circle, ASkidSteerTurnsInPlaceByTheShareOfItsTrackInItsDiagonal) {
  // Four wheels of equal slip stiffness at (+-l/2, +-t/2), their treads asked for the yaw rate w_c: each slips by
  // (w_c - w) t / 2 along and w l / 2 across, the forces are in proportion, and their moments balance at
  // w = w_c t^2 / (t^2 + l^2). Loads of a symmetric vehicle do not matter below the cone; nothing else is left out.
  CarShape shape;
  shape.steering = shape.suspension = false;
  shape.height = 0.1;
  for (const IntegratorKind kind : {IntegratorKind::kSemiImplicitEuler, IntegratorKind::kRk4})
    for (const double half_base : {0.4, 1.3}) {
      shape.front = half_base;
      shape.rear = -half_base;
      SimConfig config;
      config.integrator = kind;
      Simulator simulator = make(car(shape), flatFloor(), config);
      standAt(simulator, 0.0, 0.0, 0.3);
      drive(simulator, twist(0.0, 0.5), 6.0);
      const double t = 2.0 * shape.half_track, l = 2.0 * half_base;
      const double expected = 0.5 * t * t / (t * t + l * l);
      EXPECT_NEAR(simulator.rootAngularVelocity_W().z(), expected, 2e-3 * expected) << toString(kind) << " l " << l;
      EXPECT_NEAR(simulator.encoderYawRate(), 0.5, 1e-3);
      EXPECT_LT(simulator.rootPose().p.head<2>().norm(), 1e-6);
    }
}

/// Yaw rate over v delta / L, measured and by the formula for linear tyres of C = k_t l each.
void expectLinearTyres(double front, double rear, double speed) {
  CarShape shape;
  shape.front = front;
  shape.rear = rear;
  SimConfig config;
  config.integrator = IntegratorKind::kSemiImplicitEuler;
  config.max_acceleration = 5.0;
  Simulator simulator = make(car(shape), flatFloor(4000.0), config);
  standAt(simulator, 0.0, 0.0, 0.0);
  const BicycleModel b = bicycleOf(simulator, shape);
  double axle[2] = {0.0, 0.0};  // stiffness of front and rear axle [N/rad]
  for (const WheelUnit& wheel : simulator.model().drive.wheels) {
    const ContactLaw& law = simulator.model().ellipsoids[static_cast<std::size_t>(wheel.ellipsoid)].law;
    axle[wheel.p_FW.x() > 0.0 ? 0 : 1] += law.tangential_stiffness * law.brush_length;
  }
  const double delta = 0.3 * kDegree;
  const Circle c = circleOf(simulator, shape, b, ackermann(speed, delta), speed / 5.0 + 6.0, 1.0);
  const double L = b.wheelbase(), v = c.rear_speed;
  const double K = b.mass / L * (b.rear / axle[1] - b.front / axle[0]);
  const double expected = v * delta / (L + K * v * v);
  // Load moves to the outer wheels, but a linear tyre's stiffness does not follow its load. Left out by the formula:
  // the drive's own slip, roll, and squares of the angles; together below 1 %.
  EXPECT_NEAR(c.yaw_rate, expected, 0.01 * expected) << "v " << v << ", K v^2 / L " << K * v * v / L;
  const double side_slip = (b.rear - b.front * b.mass * v * v / (L * axle[1])) * expected / v;
  EXPECT_NEAR(c.side_slip, side_slip, 0.02 * std::abs(side_slip) + 1e-4);
}

TEST(Circle, ABalancedCarIsNeutralAtSpeed) { expectLinearTyres(1.3, -1.3, 20.0); }
TEST(Circle, ANoseHeavyCarUndersteersWithTheSquareOfTheSpeed) {
  expectLinearTyres(1.1, -1.5, 10.0);
  expectLinearTyres(1.1, -1.5, 25.0);
}
TEST(Circle, ATailHeavyCarOversteers) { expectLinearTyres(1.4, -1.2, 20.0); }

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
