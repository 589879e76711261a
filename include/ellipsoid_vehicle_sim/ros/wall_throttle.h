#pragma once

#include <chrono>

namespace ellipsoid_vehicle_sim {

/// Lets something be said once in a while of wall time. Not ROS_WARN_THROTTLE: that counts simulated time, which may
/// stand still or run a hundred times faster.
class WallThrottle {
 public:
  explicit WallThrottle(double period) : period_(period) {}

  /// True the first time, and again when the period [s] is over.
  bool due() {
    const auto now = std::chrono::steady_clock::now();
    if (said_ && now - last_ < period_) return false;
    said_ = true;
    last_ = now;
    return true;
  }

 private:
  std::chrono::duration<double> period_;
  std::chrono::steady_clock::time_point last_;
  bool said_ = false;
};

}  // namespace ellipsoid_vehicle_sim
