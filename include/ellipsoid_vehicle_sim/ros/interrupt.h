#pragma once

#include <condition_variable>
#include <mutex>
#include <thread>

namespace ellipsoid_vehicle_sim {

/// SIGINT came: run no further. For loops that would otherwise go on.
bool interrupted();

/// Ends the process within a second of SIGINT, whatever the ROS master does. roscpp's own handler first takes the node out of
/// the master's books, with all of the node waiting for it, and for ever where the master stands still. Here the run ends
/// first and closes its files; then the books are put in order for as long as the master answers. If it does not, the signal
/// does what it does by default, and the exit status says so; likewise where something large is being loaded.
class InterruptGuard {
 public:
  /// After ros::init with NoSigintHandler, before anything waits for the master.
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

  /// There are files to be closed from here on,
  void runBegins() { tell(Phase::kRun); }
  /// and to here.
  void runEnded() { tell(Phase::kOver); }

 private:
  enum class Phase { kLoad, kRun, kOver };
  void tell(Phase phase);
  void watch();

  std::mutex mutex_;
  std::condition_variable changed_;
  Phase phase_ = Phase::kLoad;
  bool end_ = false;
  std::thread thread_;
};

}  // namespace ellipsoid_vehicle_sim
