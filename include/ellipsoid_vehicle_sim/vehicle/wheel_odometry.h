#pragma once

#include <Eigen/Core>

#include "ellipsoid_vehicle_sim/geometry/pose.h"

namespace ellipsoid_vehicle_sim {

/// How uncertain odometry says it is: standard deviations that grow with the square root of the way.
struct OdometryNoise {
  double position = 0.01;  ///< of the distance, after one metre [m].
  double yaw = 0.005;      ///< of the heading, after one metre [rad].
  double turn = 0.02;      ///< of the heading, after turning by one radian [rad].
};

/// Dead reckoning on a plane from what wheel encoders tell, as a robot's base does it; slip and slopes are its errors.
/// Starts at the root link's first place: x = y = yaw = 0. Covariance by linearised propagation of
///   x' = v cos(yaw), y' = v sin(yaw), yaw' = w of the drive's reference point.
class WheelOdometry {
 public:
  /// `reference_x`: where the speed is meant, ahead of the root link [m]; `forward_yaw`: ahead, from the root's x [rad].
  WheelOdometry(double reference_x, const OdometryNoise& noise, double forward_yaw = 0.0)
      : reference_x_(reference_x), forward_yaw_(forward_yaw), noise_(noise) {
    reset();
  }

  void reset();
  /// dt [s] at `speed` [m/s] and `yaw_rate` [rad/s].
  void advance(double speed, double yaw_rate, double dt);

  Pose pose() const;                   ///< of the root link.
  /// Velocity of the root link along its own x and y [m/s], and its yaw rate.
  Eigen::Vector3d rootTwist(double speed, double yaw_rate) const;
  Eigen::Matrix3d covariance() const;  ///< of the root link's x, y, yaw.

  /// The whole state: x, y of the reference point and its heading, and the upper triangle of their covariance row by row.
  using Values = Eigen::Matrix<double, 9, 1>;
  Values values() const;
  void setValues(const Values& values);

 private:
  double reference_x_, forward_yaw_;
  OdometryNoise noise_;
  Eigen::Vector3d at_;  ///< x [m], y [m], yaw [rad].
  Eigen::Matrix3d P_;
};

}  // namespace ellipsoid_vehicle_sim
