#pragma once

#include <Eigen/Core>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>

namespace ellipsoid_vehicle_sim {

/// What is said about a run at its end: how far, how fast, how deep. No ROS in here.
class RunStatistics {
 public:
  /// One tick took so long, and left the deepest contact `penetration` [m] and so many contacts.
  void addStep(std::chrono::nanoseconds duration, double penetration, int contacts);
  /// Where the vehicle is. Distance is horizontal and adds up between calls: call it every tenth of a simulated second,
  /// so that the trembling of a parked vehicle does not count as travel.
  void addPosition(const Eigen::Vector3d& p_WR);
  /// The next position is no continuation of the last: reset, teleport.
  void jump() { has_position_ = false; }

  std::int64_t steps() const { return steps_; }
  double distance() const { return distance_; }  ///< [m]
  double meanStepTime() const;                   ///< [s]
  /// Shorter than this were the given share of the steps [s], to one per cent.
  double stepTimeQuantile(double share) const;
  double largestPenetration() const { return largest_penetration_; }  ///< [m]
  int mostContacts() const { return most_contacts_; }

  /// The report, one `key: value unit` a line, `result: ...` last.
  std::string report(double simulated_time, double wall_time, const std::string& result) const;

 private:
  // Step times are counted in bins one per cent wide, from 10 ns to about 20 s.
  static constexpr double kShortest = 1e-8;  // [s]
  static constexpr double kBinRatio = 1.01;
  static constexpr std::size_t kBins = 2160;

  std::array<std::int64_t, kBins> bins_{};
  std::int64_t steps_ = 0;
  double total_time_ = 0.0;
  double largest_penetration_ = 0.0;
  int most_contacts_ = 0;
  double distance_ = 0.0;
  bool has_position_ = false;
  Eigen::Vector3d last_position_ = Eigen::Vector3d::Zero();
};

}  // namespace ellipsoid_vehicle_sim
