#pragma once

#include <chrono>
#include <cstdint>

namespace ellipsoid_vehicle_sim {

/// How many ticks are due on the wall clock. Decides only *when* ticks happen, never what happens in them. No ROS in
/// here.
class WallPacer {
 public:
  using Clock = std::chrono::steady_clock;

  /// `factor`: simulated over wall time, 0 = as fast as possible. `dt`: tick [s].
  WallPacer(double factor, double dt) : factor_(factor), dt_(dt) {}

  /// From `now` on, `step` ticks having been made.
  void start(Clock::time_point now, std::int64_t step);
  /// Ticks to make now. More than a tenth of a second behind, what is missing is given up: it is not caught up in a
  /// rush.
  std::int64_t due(Clock::time_point now, std::int64_t step);
  /// Until tick number `step` is due [s], 0 if it is.
  double wait(Clock::time_point now, std::int64_t step) const;
  /// Wall time given up so far [s].
  double lost() const { return lost_; }

 private:
  /// Tick that is due at `now`.
  double scheduled(Clock::time_point now) const;

  double factor_;
  double dt_;
  Clock::time_point start_{};
  std::int64_t start_step_ = 0;
  double lost_ = 0.0;
};

}  // namespace ellipsoid_vehicle_sim
