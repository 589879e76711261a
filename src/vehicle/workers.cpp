#include "workers.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

#ifdef ELLIPSOID_VEHICLE_SIM_HAS_TBB
#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#endif

namespace ellipsoid_vehicle_sim {
namespace {

// Runs of a cycle, how many at its start are made the other way, and how much faster those have to be.
constexpr int kRuns = 256, kTrials = 8;
constexpr double kBetter = 0.9;

}  // namespace

#ifdef ELLIPSOID_VEHICLE_SIM_HAS_TBB

struct Workers::Arena {
  explicit Arena(int threads)
      : allowed(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads)), arena(threads) {}
  tbb::global_control allowed;  // as many as asked for, also where there are fewer cores
  tbb::task_arena arena;
};

bool Workers::available() { return true; }

Workers::Workers(int threads)
    : threads_(threads > 0 ? threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()))) {
  if (threads_ > 1) arena_ = std::make_unique<Arena>(threads_);
}

void Workers::runSideBySide(int n, void (*call)(void*, int), void* context) {
  // The library hands the tasks over and takes them back in order; said once more in our own words, so that the thread
  // sanitizer, which cannot look into it, sees that too.
  std::atomic<bool> begun{false};
  std::atomic<int> done{0};
  begun.store(true, std::memory_order_release);
  arena_->arena.execute([n, call, context, &begun, &done] {
    tbb::parallel_for(
        tbb::blocked_range<int>(0, n, 1),
        [call, context, &begun, &done](const tbb::blocked_range<int>& range) {
          (void)begun.load(std::memory_order_acquire);
          for (int i = range.begin(); i < range.end(); ++i) call(context, i);
          done.fetch_add(1, std::memory_order_release);
        },
        tbb::simple_partitioner());
  });
  (void)done.load(std::memory_order_acquire);
}

#else

struct Workers::Arena {};

bool Workers::available() { return false; }

Workers::Workers(int) {}

void Workers::runSideBySide(int n, void (*call)(void*, int), void* context) {
  for (int i = 0; i < n; ++i) call(context, i);
}

#endif

bool Workers::sideBySideNow() const { return (run_ < kTrials) != side_by_side_; }

void Workers::learn(bool side_by_side, double seconds) {
  Seen& seen = side_by_side == side_by_side_ ? usual_ : other_;
  seen.seconds += seconds;
  ++seen.runs;
  if (++run_ < kRuns) return;
  if (other_.seconds / other_.runs < kBetter * usual_.seconds / usual_.runs) side_by_side_ = !side_by_side_;
  run_ = 0;
  usual_ = other_ = Seen{};
}

void Workers::run(int n, void (*call)(void*, int), void* context) {
  using Clock = std::chrono::steady_clock;
  const bool choice = n > 1 && threads_ > 1;
  const bool side_by_side = choice && sideBySideNow();
  const Clock::time_point start = choice ? Clock::now() : Clock::time_point{};
  if (side_by_side) {
    runSideBySide(n, call, context);
  } else {
    for (int i = 0; i < n; ++i) call(context, i);
  }
  if (choice) learn(side_by_side, std::chrono::duration<double>(Clock::now() - start).count());
}

Workers::~Workers() = default;

}  // namespace ellipsoid_vehicle_sim
