#include "ellipsoid_vehicle_sim/scene/progress_bar.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace ellipsoid_vehicle_sim {

using Clock = std::chrono::steady_clock;

ProgressBar::ProgressBar(std::string title)
    : title_(std::move(title)), terminal_(isatty(STDERR_FILENO) != 0), started_(Clock::now()), last_(started_) {}

void ProgressBar::show(double done, const std::string& text) {
  if (!terminal_) return;
  const Clock::time_point now = Clock::now();
  if (drawn_ && now - last_ < std::chrono::milliseconds(100)) return;
  last_ = now;
  drawn_ = true;
  constexpr int kWidth = 30;
  const double share = std::clamp(done, 0.0, 1.0);
  const int full = static_cast<int>(share * kWidth);
  const std::string bar = std::string(static_cast<std::size_t>(full), '#') + std::string(kWidth - full, '.');
  const double seconds = std::chrono::duration<double>(now - started_).count();
  char left[32] = "";
  if (share > 0.02 && seconds > 1.0) std::snprintf(left, sizeof left, ", %.0f s left", seconds * (1.0 - share) / share);
  // \033[K: nothing of a longer line before stays behind.
  std::fprintf(stderr, "\r%s [%s] %3.0f %%%s %.60s\033[K", title_.c_str(), bar.c_str(), 100.0 * share, left,
               text.c_str());
  std::fflush(stderr);
}

void ProgressBar::finish() {
  if (!drawn_) return;
  std::fputs("\r\033[K", stderr);
  std::fflush(stderr);
  drawn_ = false;
}

}  // namespace ellipsoid_vehicle_sim
