#pragma once

#include <chrono>
#include <string>

namespace ellipsoid_vehicle_sim {

/// A bar on the error stream, where that is a terminal; elsewhere nothing is written. Drawn ten times a second at most.
class ProgressBar {
 public:
  explicit ProgressBar(std::string title);
  ~ProgressBar() { finish(); }
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// `done`: 0 ... 1; `text` stands behind the bar.
  void show(double done, const std::string& text = "");
  /// Takes the bar away.
  void finish();

 private:
  std::string title_;
  bool terminal_ = false, drawn_ = false;
  std::chrono::steady_clock::time_point started_, last_;
};

}  // namespace ellipsoid_vehicle_sim
