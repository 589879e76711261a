#include "ellipsoid_vehicle_sim/ros/pacing.h"

#include <algorithm>
#include <cmath>

namespace ellipsoid_vehicle_sim {
namespace {

constexpr std::int64_t kUnlimited = 1000000;
constexpr double kLongestLag = 0.1;  // [s] of wall time

}  // namespace

void WallPacer::start(Clock::time_point now, std::int64_t step) {
  start_ = now;
  start_step_ = step;
}

double WallPacer::scheduled(Clock::time_point now) const {
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  return static_cast<double>(start_step_) + elapsed * factor_ / dt_;
}

std::int64_t WallPacer::due(Clock::time_point now, std::int64_t step) {
  if (factor_ == 0.0) return kUnlimited;
  const auto ticks = static_cast<std::int64_t>(std::floor(scheduled(now))) - step;
  const double lag = static_cast<double>(ticks) * dt_ / factor_;
  if (lag <= kLongestLag) return std::max<std::int64_t>(ticks, 0);
  lost_ += lag;
  start(now, step);
  return 1;
}

double WallPacer::wait(Clock::time_point now, std::int64_t step) const {
  if (factor_ == 0.0) return 0.0;
  return std::max(0.0, (static_cast<double>(step) - scheduled(now)) * dt_ / factor_);
}

}  // namespace ellipsoid_vehicle_sim
