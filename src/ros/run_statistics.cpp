#include "ellipsoid_vehicle_sim/ros/run_statistics.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace ellipsoid_vehicle_sim {

void RunStatistics::addStep(std::chrono::nanoseconds duration, double penetration, int contacts) {
  const double seconds = 1e-9 * static_cast<double>(duration.count());
  const double bin = std::log(std::max(seconds, kShortest) / kShortest) / std::log(kBinRatio);
  ++bins_[std::min(static_cast<std::size_t>(bin), kBins - 1)];
  ++steps_;
  total_time_ += seconds;
  largest_penetration_ = std::max(largest_penetration_, penetration);
  most_contacts_ = std::max(most_contacts_, contacts);
}

void RunStatistics::addPosition(const Eigen::Vector3d& p_WR) {
  if (has_position_) distance_ += (p_WR - last_position_).head<2>().norm();
  last_position_ = p_WR;
  has_position_ = true;
}

double RunStatistics::meanStepTime() const { return steps_ > 0 ? total_time_ / static_cast<double>(steps_) : 0.0; }

double RunStatistics::stepTimeQuantile(double share) const {
  const double wanted = share * static_cast<double>(steps_);
  std::int64_t below = 0;
  for (std::size_t i = 0; i < kBins; ++i) {
    below += bins_[i];
    if (below > 0 && static_cast<double>(below) >= wanted)
      return kShortest * std::pow(kBinRatio, static_cast<double>(i + 1));
  }
  return 0.0;
}

std::string RunStatistics::report(double simulated_time, double wall_time, const std::string& result) const {
  char text[512];
  std::snprintf(text, sizeof(text),
                "simulated time: %.3f s\n"
                "distance: %.2f m\n"
                "real-time factor: %.2f\n"
                "step time mean: %.2f us\n"
                "step time p99: %.2f us\n"
                "largest penetration: %.3f mm\n"
                "most contacts: %d\n",
                simulated_time, distance_, wall_time > 0.0 ? simulated_time / wall_time : 0.0, 1e6 * meanStepTime(),
                1e6 * stepTimeQuantile(0.99), 1e3 * largest_penetration_, most_contacts_);
  return text + ("result: " + result + "\n");
}

}  // namespace ellipsoid_vehicle_sim
