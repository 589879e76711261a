#pragma once

namespace ellipsoid_vehicle_sim {

/// Takes the speed out of a vehicle that is let down, whose rest alone matters. First it damps all motion as a ride wants
/// it. What goes on after that is slow: a tilt over an edge, which damping makes slower still. So from then on what gains
/// speed is left alone, and once it gains no more the speed is taken out again, down to half or for a while: kinetic damping,
/// as in dynamic relaxation [Barnes1999]. A mode of frequency w ends after a few of its own periods,
/// where damping d would take some d / w^2.
class SettlingDamper {
 public:
  /// What remains of all speeds after a step of `dt` [s] that ended with `speed` as the largest of them [m/s or rad/s].
  double remainder(double speed, double dt) {
    time_ += dt;
    if (time_ > kRideTime) {
      if (damps_ && (speed < 0.5 * peak_ || time_ - damps_since_ > kLongestDamping)) {
        damps_ = false;
      } else if (!damps_ && speed < speed_) {
        damps_ = true;
        peak_ = speed;
        damps_since_ = time_;
      }
    }
    const double remainder = damps_ ? 1.0 / (1.0 + kDamping * dt) : 1.0;
    speed_ = remainder * speed;
    return remainder;
  }

 private:
  static constexpr double kDamping = 10.0;        // [1/s]: critical for a ride of about 1 Hz, harmless for everything stiffer
  static constexpr double kRideTime = 1.5;        // by then a ride is at rest, or nearly [s]
  static constexpr double kLongestDamping = 0.3;  // [s]

  double time_ = 0.0, speed_ = 0.0, peak_ = 0.0, damps_since_ = kRideTime;
  bool damps_ = true;
};

}  // namespace ellipsoid_vehicle_sim
