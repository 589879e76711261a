#include <gtest/gtest.h>

#include "ellipsoid_vehicle_sim/vehicle/imu.h"
#include "ellipsoid_vehicle_sim/vehicle/wheel_odometry.h"
#include "support/motions.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Vector3d;

TEST(WheelOdometry, FollowsACircleOfTheRootLink) {
  // The reference point 1.3 m behind the root link, at 2 m/s on a circle of 8 m: both go round the same centre.
  WheelOdometry odometry(-1.3, OdometryNoise{});
  const double v = 2.0, radius = 8.0, w = v / radius, dt = 1e-3;
  const int ticks = 10000;
  for (int i = 0; i < ticks; ++i) odometry.advance(v, w, dt);
  const double yaw = w * dt * ticks;
  const Vector3d centre(-1.3, radius, 0.0);
  const Vector3d expected = centre + Eigen::AngleAxisd(yaw, Vector3d::UnitZ()) * (Vector3d::Zero() - centre);
  // Midpoint rule: each tick's chord for its arc, relative error (w dt)^2 / 24 = 3e-9.
  EXPECT_LT((odometry.pose().p - expected).norm(), 1e-6);
  EXPECT_LT(odometry.pose().q.angularDistance(Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Vector3d::UnitZ()))), 1e-12);
}

// A root link that looks to the right of forward: the circle is the same, its own twist is turned.
TEST(WheelOdometry, KnowsThatForwardIsNotAlwaysX) {
  const double quarter = 0.5 * M_PI;
  WheelOdometry odometry(0.5, OdometryNoise{}, quarter);
  EXPECT_TRUE(odometry.pose().p.isZero(1e-15));
  EXPECT_NEAR(odometry.pose().q.angularDistance(Eigen::Quaterniond::Identity()), 0.0, 1e-12);
  for (int i = 0; i < 1000; ++i) odometry.advance(1.0, 0.0, 1e-3);
  EXPECT_TRUE(odometry.pose().p.isApprox(Eigen::Vector3d(0.0, 1.0, 0.0), 1e-12));
  const Eigen::Vector3d twist = odometry.rootTwist(1.0, 0.4);
  // Forward 1 along y; the root link is 0.5 behind the reference, to the right of it while turning left: 0.2 along x.
  EXPECT_NEAR(twist.y(), 1.0, 1e-12);
  EXPECT_NEAR(twist.x(), 0.2, 1e-12);
}

TEST(WheelOdometry, CovarianceGrowsWithTheDistanceAndNotWithTime) {
  OdometryNoise noise;
  noise.position = 0.02;
  noise.yaw = 0.01;
  noise.turn = 0.03;
  WheelOdometry odometry(0.0, noise);
  for (int i = 0; i < 5000; ++i) odometry.advance(0.0, 0.0, 1e-3);
  EXPECT_TRUE(odometry.covariance().isZero(0.0));
  for (int i = 0; i < 8000; ++i) odometry.advance(i < 4000 ? 1.0 : -1.0, 0.0, 1e-3);
  // Straight on and back: 8 m of way. Along it sigma_p^2 s; across, the heading's random walk at the lever that is
  // left, integral of sigma_y^2 (x_end - x(s))^2 ds with x_end = 0: 2 sigma_y^2 L^3 / 3.
  const Eigen::Matrix3d P = odometry.covariance();
  EXPECT_NEAR(P(0, 0), 0.02 * 0.02 * 8.0, 1e-9);
  EXPECT_NEAR(P(2, 2), 0.01 * 0.01 * 8.0, 1e-9);
  EXPECT_NEAR(P(1, 1), 2.0 * 0.01 * 0.01 * 64.0 / 3.0, 0.002 * P(1, 1));
  WheelOdometry turning(0.0, noise);
  for (int i = 0; i < 1000; ++i) turning.advance(0.0, 2.0, 1e-3);
  EXPECT_NEAR(turning.covariance()(2, 2), 0.03 * 0.03 * 2.0, 1e-9);
}

TEST(WheelOdometry, ValuesAreTheWholeState) {
  WheelOdometry odometry(0.4, OdometryNoise{}), other(0.4, OdometryNoise{});
  for (int i = 0; i < 500; ++i) odometry.advance(1.0, 0.3, 1e-3);
  other.setValues(odometry.values());
  for (WheelOdometry* o : {&odometry, &other}) o->advance(2.0, -0.7, 1e-3);
  EXPECT_EQ(other.values(), odometry.values());
  EXPECT_EQ(other.covariance(), odometry.covariance());
}

TEST(Imu, AtRestOnASlopeTellsGravityInItsOwnAxes) {
  const double slope = 0.2;
  Simulator simulator = make(fourFeet(50.0), terrainOf(floorSoup(500.0, 1, slope)), SimConfig{});
  standAt(simulator, 0.0, 0.0, 0.0);
  run(simulator, 1.0);
  const ImuReading reading = readImu(simulator, ImuNoise{}, 0);
  // The floor falls along +x: nose down, so the specific force points backwards and up.
  // The lower feet are loaded more and sink deeper: the block leans by some 1e-5 rad.
  EXPECT_NEAR(reading.f_R.x(), -9.80665 * std::sin(slope), 2e-3);
  EXPECT_NEAR(reading.f_R.y(), 0.0, 1e-4);
  EXPECT_NEAR(reading.f_R.z(), 9.80665 * std::cos(slope), 2e-3);
  EXPECT_LT(reading.w_WR_R.norm(), 1e-6);
}

TEST(Imu, InFreeFallTellsNothing) {
  Simulator simulator = make(solidBody({0.3, 0.2, 0.1}, 5.0), emptySpace(), SimConfig{});
  placeAt(simulator, Vector3d::Zero(), {1.0, 0.0, 3.0}, {0.0, 0.0, 2.0});
  run(simulator, 0.3);
  const ImuReading reading = readImu(simulator, ImuNoise{}, 0);
  EXPECT_LT(reading.f_R.norm(), 1e-12);
  EXPECT_LT((reading.w_WR_R - Vector3d(0, 0, 2)).norm(), 1e-12);
}

TEST(Imu, NoiseHasItsDeviationAndIsAFunctionOfSeedAndSample) {
  Simulator simulator = make(solidBody({0.3, 0.2, 0.1}, 5.0), emptySpace(), SimConfig{});
  placeAt(simulator, Vector3d::Zero(), Vector3d::Zero());
  ImuNoise noise;
  noise.angular_velocity = 0.01;
  noise.acceleration = 0.2;
  noise.orientation = 0.003;
  noise.seed = 7;
  const int n = 20000;
  Vector3d sum = Vector3d::Zero(), w_squares = Vector3d::Zero(), f_squares = Vector3d::Zero();
  double angle_squares = 0.0, product = 0.0, last = 0.0;
  for (int i = 0; i < n; ++i) {
    const ImuReading reading = readImu(simulator, noise, i);
    sum += reading.f_R;
    w_squares += reading.w_WR_R.cwiseAbs2();
    f_squares += reading.f_R.cwiseAbs2();
    angle_squares += std::pow(reading.q_WR.angularDistance(Eigen::Quaterniond::Identity()), 2);
    product += reading.f_R.x() * last;
    last = reading.f_R.x();
  }
  // Mean within 4 sigma / sqrt(n); deviations within 4 / sqrt(2 n) = 2 %; neighbours uncorrelated within 4 / sqrt(n).
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(sum[axis] / n, 0.0, 4.0 * 0.2 / std::sqrt(n));
    EXPECT_NEAR(std::sqrt(w_squares[axis] / n), 0.01, 0.02 * 0.01);
    EXPECT_NEAR(std::sqrt(f_squares[axis] / n), 0.2, 0.02 * 0.2);
  }
  EXPECT_NEAR(std::sqrt(angle_squares / (3 * n)), 0.003, 0.02 * 0.003);
  EXPECT_NEAR(product / n / 0.04, 0.0, 4.0 / std::sqrt(n));

  const ImuReading again = readImu(simulator, noise, 123), same = readImu(simulator, noise, 123);
  EXPECT_EQ(again.f_R, same.f_R);
  noise.seed = 8;
  EXPECT_NE(readImu(simulator, noise, 123).f_R, again.f_R);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
