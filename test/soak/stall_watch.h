#pragma once

#include <pthread.h>
#include <sched.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

namespace ellipsoid_vehicle_sim {

/// Time that a thread was ready to run and got no processor [s]. `task` is a folder of /proc/PID/task.
inline double waitedForProcessor(const std::string& task) {
  std::ifstream in(task + "/schedstat");
  long ran, delayed;
  return in >> ran >> delayed ? 1e-9 * static_cast<double>(delayed) : 0.0;
}

/// How long each processor stood still: that of a virtual machine does while its host runs something else on it, for up to
/// a few tenths of a second, and no clock of the kernel's own tells. A thread on each processor sleeps and sees by how much
/// it wakes too late, without having waited for its turn.
class StallWatch {
 public:
  StallWatch() : stalled_(std::max(1u, std::thread::hardware_concurrency())) {
    for (std::size_t cpu = 0; cpu < stalled_.size(); ++cpu) threads_.emplace_back([this, cpu] { watch(cpu); });
  }
  ~StallWatch() {
    end_ = true;
    for (std::thread& thread : threads_) thread.join();
  }
  StallWatch(const StallWatch&) = delete;
  StallWatch& operator=(const StallWatch&) = delete;

  /// So far, of each processor [s].
  std::vector<double> stalled() const { return {stalled_.begin(), stalled_.end()}; }

 private:
  void watch(std::size_t cpu) {
    using Clock = std::chrono::steady_clock;
    constexpr std::chrono::milliseconds kSleep(2);
    constexpr double kUsual = 1e-3;  // later than that is late [s]
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(cpu, &set);
    if (pthread_setaffinity_np(pthread_self(), sizeof set, &set) != 0) return;  // not ours to use
    const std::string task = "/proc/self/task/" + std::to_string(syscall(SYS_gettid));
    double waited = waitedForProcessor(task);
    while (!end_) {
      const auto start = Clock::now();
      std::this_thread::sleep_for(kSleep);
      const double late = std::chrono::duration<double>(Clock::now() - start - kSleep).count();
      if (late < kUsual) continue;
      const double now = waitedForProcessor(task), stall = late - (now - waited);
      waited = now;
      if (stall > kUsual) stalled_[cpu] = stalled_[cpu] + stall;
    }
  }

  std::vector<std::atomic<double>> stalled_;
  std::atomic<bool> end_{false};
  std::vector<std::thread> threads_;
};

}  // namespace ellipsoid_vehicle_sim
