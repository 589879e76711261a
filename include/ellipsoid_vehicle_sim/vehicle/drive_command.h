#pragma once

namespace ellipsoid_vehicle_sim {

/// What the driver asks for. Forward speed of the drive's reference point and yaw rate, or forward speed and the angle of
/// the virtual front wheel. Zero speed and zero yaw rate mean brake.
struct DriveCommand {
  enum class Kind {
    kTwist,      ///< speed and yaw_rate.
    kAckermann,  ///< speed and steering_angle.
    kCoast       ///< no motor, no brake: the vehicle is left alone.
  };
  Kind kind = Kind::kTwist;
  double speed = 0.0;           ///< [m/s], forward positive.
  double yaw_rate = 0.0;        ///< [rad/s], counter-clockwise seen from above.
  double steering_angle = 0.0;  ///< [rad], left positive.

};

}  // namespace ellipsoid_vehicle_sim
