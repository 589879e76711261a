#pragma once

#include <dirent.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "stall_watch.h"

namespace ellipsoid_vehicle_sim {

/// What the machine kept from the processes that an answer goes through: processors that others had, or that stood still.
/// No node can do anything about it.
class MachineTime {
 public:
  /// What was kept from whom between two moments [s].
  struct Kept {
    std::vector<double> waited;  ///< of each process: the longest that one of its threads was ready and had no processor
    double stalled = 0.0;        ///< the longest that a processor stood still
    double sum() const {
      double result = stalled;
      for (const double process : waited) result += process;
      return result;
    }
  };
  /// So far, since whenever.
  struct Reading {
    std::chrono::steady_clock::time_point at;
    std::vector<std::map<std::string, double>> waited;  ///< of each process and thread [s]
    std::vector<double> stalled;                        ///< of each processor [s]
  };

  explicit MachineTime(std::vector<long> pids) : pids_(std::move(pids)) {}

  Reading read() const {
    Reading result = waits();
    result.stalled = stalls_.stalled();
    return result;
  }
  /// Since then. An answer goes through a process on one thread, or from one to the next: of two that wait in turn the
  /// longer wait counts, so it is rather too little than what all of them waited, much of it at the same time.
  Kept since(const Reading& then) const {
    const Reading now = waits();
    Kept result;
    for (std::size_t i = 0; i < now.waited.size(); ++i) {
      double longest = 0.0;
      for (const auto& [thread, waited] : now.waited[i]) {
        const auto before = then.waited[i].find(thread);
        longest = std::max(longest, waited - (before == then.waited[i].end() ? 0.0 : before->second));
      }
      result.waited.push_back(longest);
    }
    // Whoever watches a processor that stood still has to wake up first. Processors may stand still together.
    if (now.at - then.at > kWorthALook) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    const std::vector<double> stalled = stalls_.stalled();
    for (std::size_t i = 0; i < stalled.size(); ++i) result.stalled = std::max(result.stalled, stalled[i] - then.stalled[i]);
    return result;
  }

 private:
  static constexpr std::chrono::milliseconds kWorthALook{30};

  Reading waits() const {
    Reading result{std::chrono::steady_clock::now(), {}, {}};
    for (const long pid : pids_) result.waited.push_back(threadsOf(pid));
    return result;
  }
  static std::map<std::string, double> threadsOf(long pid) {
    const std::string folder = "/proc/" + std::to_string(pid) + "/task/";
    std::map<std::string, double> result;
    if (DIR* tasks = opendir(folder.c_str())) {
      while (const dirent* entry = readdir(tasks))
        if (entry->d_name[0] != '.') result[entry->d_name] = waitedForProcessor(folder + entry->d_name);
      closedir(tasks);
    }
    return result;
  }

  std::vector<long> pids_;
  StallWatch stalls_;
};

}  // namespace ellipsoid_vehicle_sim
