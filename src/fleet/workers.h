#pragma once

#include <memory>

namespace ellipsoid_vehicle_sim {

/// Spreads independent tasks over cores (oneTBB, where it was found at build time; otherwise one after the other).
///
/// Where somebody else keeps the cores busy, side by side takes longer than one after the other: who is done waits for a
/// thread that the system has put aside (20 cars on two cores, one of them taken: 0.50 ms a tick instead of 0.33). The results
/// are the same, so the faster is used: now and then a few runs are made the other way, and that is kept if it was faster.
class Workers {
 public:
  /// `threads`: 0 = as many as there are cores.
  explicit Workers(int threads);
  ~Workers();

  static bool available();
  int threads() const { return threads_; }

  /// task(i) for 0 <= i < n, in any order and at the same time; returns when all are done.
  template <typename Task>
  void forEach(int n, Task& task) {
    run(n, [](void* context, int i) { (*static_cast<Task*>(context))(i); }, &task);
  }

 private:
  void run(int n, void (*call)(void*, int), void* context);
  void runSideBySide(int n, void (*call)(void*, int), void* context);
  bool sideBySideNow() const;
  void learn(bool side_by_side, double seconds);

  struct Seen {
    double seconds = 0.0;
    int runs = 0;
  };

  struct Arena;
  std::unique_ptr<Arena> arena_;
  int threads_ = 1;
  bool side_by_side_ = true;  ///< is the faster, as far as is known.
  int run_ = 0;               ///< of the present cycle of runs.
  Seen usual_, other_;        ///< in it.
};

}  // namespace ellipsoid_vehicle_sim
