#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/time.h>

#include <cstdint>

#include "ellipsoid_vehicle_sim/ros/pacing.h"
#include "ellipsoid_vehicle_sim/ros/parameters.h"
#include "ellipsoid_vehicle_sim/ros/wall_throttle.h"

namespace ellipsoid_vehicle_sim {

/// Which time a tick has, and when it is due.
///   publish  stamps start at zero; ticks are paced by the wall clock and the real-time factor; /clock is ours.
///   follow   stamps are the received /clock's; ticks keep up with it. Where it jumps (back, or ahead by more than ten
///            seconds) that is reported and the stamps jump with it; nothing is simulated for it.
///   wall     stamps are the wall clock's.
/// Stamps never go back, but for a followed clock that does.
class SimClock {
 public:
  SimClock(ros::NodeHandle& nh, const NodeOptions& options, double dt);

  /// From `step` on; waits for somebody else's first /clock. False: shut down meanwhile.
  bool start(std::int64_t step);
  /// Time of tick number `step`.
  ros::Time stamp(std::int64_t step) const;
  /// Our /clock, where it is ours.
  void publish(std::int64_t step);

  /// Ticks to make now, after `step`.
  std::int64_t due(std::int64_t step);
  /// Wall time until tick number `step` is due [s], 0 if it is.
  double wait(std::int64_t step) const;
  /// Time stood still up to now (pause, reset, a command awaited): not to be caught up with.
  void skip(std::int64_t step);
  void setFactor(double factor, std::int64_t step);

  ClockMode mode() const { return mode_; }
  double factor() const { return factor_; }
  double lost() const { return lost_ + pacer_.lost(); }  ///< wall time given up by falling behind [s].
  std::int64_t jumps() const { return jumps_; }          ///< of the followed clock.

 private:
  /// Tick number `step` is now.
  void anchor(std::int64_t step);

  ClockMode mode_;
  double factor_;
  double dt_;
  WallPacer pacer_;
  ros::Publisher publisher_;
  ros::Time anchor_stamp_;  ///< of tick number anchor_step_; the others follow from it.
  std::int64_t anchor_step_ = 0;
  bool anchored_ = false;
  ros::Time last_followed_;
  WallPacer::Clock::time_point last_change_{};
  double lost_ = 0.0;
  std::int64_t jumps_ = 0;
  WallThrottle standing_{5.0};
};

}  // namespace ellipsoid_vehicle_sim
