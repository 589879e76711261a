#pragma once

#include <poll.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <functional>
#include <stdexcept>
#include <string>

#include "support/slowdown.h"

namespace ellipsoid_vehicle_sim {

/// How a child process fared.
struct ChildReport {
  std::string text;        ///< what the function returned; empty if it never did.
  bool ended = false;      ///< it returned, rather than crashed or was ended for taking too long.
  double seconds = 0.0;    ///< [s] wall time.
  double peak_memory = 0;  ///< [MiB] resident, more than the parent had.
};

/// Runs the function in a child process, so that it may crash or take up memory, and ends it after `longest` seconds.
inline ChildReport inChild(const std::function<std::string()>& function, double longest) {
  using Clock = std::chrono::steady_clock;
  rusage mine;
  getrusage(RUSAGE_SELF, &mine);
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("no pipe");
  const Clock::time_point start = Clock::now();
  const pid_t pid = fork();
  if (pid < 0) throw std::runtime_error("no child process");
  if (pid == 0) {
    close(ends[0]);
    std::string text = "\n" + function();
    for (std::size_t at = 0; at < text.size();) {
      const ssize_t n = write(ends[1], text.data() + at, text.size() - at);
      if (n <= 0) break;
      at += static_cast<std::size_t>(n);
    }
    _exit(0);
  }
  close(ends[1]);
  ChildReport report;
  const auto seconds = [start] { return std::chrono::duration<double>(Clock::now() - start).count(); };
  for (;;) {
    pollfd end{ends[0], POLLIN, 0};
    const double left = slowdown() * longest - seconds();
    if (left <= 0.0 || poll(&end, 1, static_cast<int>(1e3 * left) + 1) <= 0) break;
    char buffer[4096];
    const ssize_t n = read(ends[0], buffer, sizeof buffer);
    if (n <= 0) break;
    report.text.append(buffer, static_cast<std::size_t>(n));
  }
  report.seconds = seconds();
  close(ends[0]);
  report.ended = !report.text.empty();
  if (report.ended) report.text.erase(0, 1);
  kill(pid, SIGKILL);  // of no effect on one that has ended
  int status = 0;
  rusage its;
  wait4(pid, &status, 0, &its);
  report.peak_memory = static_cast<double>(its.ru_maxrss - mine.ru_maxrss) / 1024.0;
  return report;
}

}  // namespace ellipsoid_vehicle_sim
