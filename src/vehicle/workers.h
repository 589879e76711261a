#pragma once

#include <memory>

namespace ellipsoid_vehicle_sim {

/// Spreads independent tasks over cores (oneTBB, where it was found at build time; otherwise one after the other).
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

  struct Arena;
  std::unique_ptr<Arena> arena_;
  int threads_ = 1;
};

}  // namespace ellipsoid_vehicle_sim
