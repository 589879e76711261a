#include "ellipsoid_vehicle_sim/ros/interrupt.h"

#include <ros/init.h>
#include <semaphore.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>

#include "ellipsoid_vehicle_sim/ros/master_call.h"

namespace ellipsoid_vehicle_sim {
namespace {

using std::chrono::milliseconds;

// Of wall time, from the signal: for the run and its files; then until the master is asked, and how long it may take.
constexpr milliseconds kForTheRun(400), kForTheMaster(300), kPatience(200);

// Set by the handler, on whichever thread that runs, and read by others.
std::atomic<bool> came{false};
static_assert(std::atomic<bool>::is_always_lock_free);
sem_t woken;

// A semaphore is what a signal handler may touch.
void onInterrupt(int) {
  came = true;
  const int kept = errno;
  sem_post(&woken);
  errno = kept;
}

void endAtOnce() {
  std::fflush(stdout);
  std::signal(SIGINT, SIG_DFL);
  std::raise(SIGINT);
}

}  // namespace

bool interrupted() { return came; }

InterruptGuard::InterruptGuard() {
  sem_init(&woken, 0, 0);
  thread_ = std::thread([this] { watch(); });
  struct sigaction action {};
  action.sa_handler = onInterrupt;
  sigaction(SIGINT, &action, nullptr);
}

InterruptGuard::~InterruptGuard() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    end_ = true;
  }
  changed_.notify_all();
  sem_post(&woken);
  thread_.join();
}

void InterruptGuard::tell(Phase phase) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    phase_ = phase;
  }
  changed_.notify_all();
}

void InterruptGuard::watch() {
  while (sem_wait(&woken) != 0 && errno == EINTR) {
  }
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait_for(lock, kForTheRun, [this] { return phase_ == Phase::kOver || end_; });
  if (end_) return;
  // Whoever waits inside roscpp for something else than the master gives up, and the books are put in order.
  ros::requestShutdown();
  while (!changed_.wait_for(lock, kForTheMaster, [this] { return end_; })) {
    // Nothing is open yet, and the books are closed.
    if (phase_ == Phase::kLoad && !ros::isStarted()) endAtOnce();
    lock.unlock();
    if (askMaster(kPatience) == Answer::kNone) {
      std::fputs("interrupted while the ROS master does not answer: ended without being taken out of its books\n", stderr);
      endAtOnce();
    }
    lock.lock();
  }
}

}  // namespace ellipsoid_vehicle_sim
