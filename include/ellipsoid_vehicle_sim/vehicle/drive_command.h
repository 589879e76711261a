#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace ellipsoid_vehicle_sim {

/// Anything larger that is asked for is nonsense, and dropped [SI]: no vehicle has it, and its products might overflow.
constexpr double kLargestCommand = 1e9;

/// What the driver asks of the vehicle as a whole. Forward speed of the drive's reference point and yaw rate, or forward
/// speed and the angle of the virtual front wheel. Zero speed and zero yaw rate mean brake.
struct DriveCommand {
  enum class Kind : unsigned char {
    kTwist,      ///< speed and yaw_rate.
    kAckermann,  ///< speed and steering_angle.
    kCoast       ///< no motor, no brake: the vehicle is left alone.
  };
  Kind kind = Kind::kTwist;
  double speed = 0.0;           ///< [m/s], forward positive.
  double yaw_rate = 0.0;        ///< [rad/s], counter-clockwise seen from above.
  double steering_angle = 0.0;  ///< [rad], left positive.

  // kAckermann only: how fast the change may be, within the vehicle's own limits. 0: those alone.
  double steering_angle_velocity = 0.0;  ///< of steering_angle [rad/s], >= 0.
  double acceleration = 0.0;             ///< of speed, up and down [m/s^2], >= 0. With it, zero speed slows down at this
                                         ///< rate and brakes only when it stands.
  double jerk = 0.0;                     ///< of the acceleration [m/s^3], >= 0.
};

/// What a controller asks of one joint, in the joint's own sign; more than one may be given. A motor follows velocity,
/// with effort added to its servo's, or effort alone; a joint on a path (steering, lift) follows position, else velocity.
struct JointRequest {
  std::string joint;
  std::optional<double> position;  ///< [rad] or [m].
  std::optional<double> velocity;  ///< [rad/s] or [m/s].
  std::optional<double> effort;    ///< [N m] or [N].
};

/// The request in force for one joint, as the state keeps it.
struct JointCommand {
  enum class Kind : unsigned char { kNone, kPosition, kVelocity, kEffort };
  Kind kind = Kind::kNone;
  double value = 0.0;
  double effort = 0.0;   ///< kVelocity of a motor: added to its servo's [N m].
  std::int64_t age = 0;  ///< ticks since it came.
};

}  // namespace ellipsoid_vehicle_sim
