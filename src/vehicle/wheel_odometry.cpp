#include "ellipsoid_vehicle_sim/vehicle/wheel_odometry.h"

#include <cmath>

namespace ellipsoid_vehicle_sim {

using Eigen::Matrix3d;
using Eigen::Vector3d;

void WheelOdometry::reset() {
  at_ = Vector3d(reference_x_ * std::cos(forward_yaw_), reference_x_ * std::sin(forward_yaw_), forward_yaw_);
  P_.setZero();
}

void WheelOdometry::advance(double speed, double yaw_rate, double dt) {
  const double ds = speed * dt, turn = yaw_rate * dt;
  // The heading half way: exact to second order, and for constant curvature to third.
  const double yaw = at_[2] + 0.5 * turn;
  const double c = std::cos(yaw), s = std::sin(yaw);
  at_ += Vector3d(ds * c, ds * s, turn);

  Matrix3d F = Matrix3d::Identity();
  F(0, 2) = -ds * s;
  F(1, 2) = ds * c;
  const double along = noise_.position * noise_.position * std::abs(ds);
  Matrix3d Q = Matrix3d::Zero();
  Q(0, 0) = along * c * c;
  Q(0, 1) = Q(1, 0) = along * c * s;
  Q(1, 1) = along * s * s;
  Q(2, 2) = noise_.yaw * noise_.yaw * std::abs(ds) + noise_.turn * noise_.turn * std::abs(turn);
  // Symmetric to the last bit, so that the upper triangle is the whole of it.
  const Matrix3d P = F * P_ * F.transpose() + Q;
  P_ = 0.5 * (P + P.transpose());
}

Pose WheelOdometry::pose() const {
  const double c = std::cos(at_[2]), s = std::sin(at_[2]);
  return {Vector3d(at_[0] - reference_x_ * c, at_[1] - reference_x_ * s, 0.0),
          Eigen::Quaterniond(Eigen::AngleAxisd(at_[2] - forward_yaw_, Vector3d::UnitZ()))};
}

Vector3d WheelOdometry::rootTwist(double speed, double yaw_rate) const {
  const double c = std::cos(forward_yaw_), s = std::sin(forward_yaw_), aside = -yaw_rate * reference_x_;
  return {c * speed - s * aside, s * speed + c * aside, yaw_rate};
}

Matrix3d WheelOdometry::covariance() const {
  Matrix3d J = Matrix3d::Identity();
  J(0, 2) = reference_x_ * std::sin(at_[2]);
  J(1, 2) = -reference_x_ * std::cos(at_[2]);
  return J * P_ * J.transpose();
}

WheelOdometry::Values WheelOdometry::values() const {
  Values values;
  values << at_, P_(0, 0), P_(0, 1), P_(0, 2), P_(1, 1), P_(1, 2), P_(2, 2);
  return values;
}

void WheelOdometry::setValues(const Values& v) {
  at_ = v.head<3>();
  P_ << v[3], v[4], v[5], v[4], v[6], v[7], v[5], v[7], v[8];
}

}  // namespace ellipsoid_vehicle_sim
