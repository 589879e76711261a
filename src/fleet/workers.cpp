#include "workers.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

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

#ifdef __SANITIZE_THREAD__

// The sanitizer cannot look into the library and takes each task that it hands over for a race. Here the tasks run on threads
// that it understands, with nothing that would order one of them after another.
void Workers::runSideBySide(int n, void (*call)(void*, int), void* context) {
  std::atomic<int> next{0};
  const auto work = [n, call, context, &next] {
    for (int i; (i = next.fetch_add(1, std::memory_order_relaxed)) < n;) call(context, i);
  };
  std::vector<std::thread> others;
  for (int k = 1; k < std::min(threads_, n); ++k) others.emplace_back(work);
  work();
  for (std::thread& other : others) other.join();
}

#else

void Workers::runSideBySide(int n, void (*call)(void*, int), void* context) {
  arena_->arena.execute([n, call, context] {
    tbb::parallel_for(
        tbb::blocked_range<int>(0, n, 1),
        [call, context](const tbb::blocked_range<int>& range) {
          for (int i = range.begin(); i < range.end(); ++i) call(context, i);
        },
        tbb::simple_partitioner());
  });
}

#endif

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
