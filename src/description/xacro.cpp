#include "ellipsoid_vehicle_sim/description/xacro.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>

#include "ellipsoid_vehicle_sim/world/file_bytes.h"

extern char** environ;

namespace ellipsoid_vehicle_sim {
namespace {

constexpr int kPatience = 30;  // [s]
constexpr std::size_t kLongestTail = 600;  // of what it says of an error

struct Output {
  std::string text, errors;
  int status = -1;
  bool found = false, in_time = false;
};

/// Runs xacro with its outputs in pipes; nothing of the path goes through a shell.
Output runXacro(const std::string& path) {
  Output output;
  int out[2], err[2];
  if (pipe2(out, O_CLOEXEC) != 0) return output;
  if (pipe2(err, O_CLOEXEC) != 0) {
    close(out[0]), close(out[1]);
    return output;
  }
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, out[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, err[1], STDERR_FILENO);
  std::string command = "xacro", argument = path;
  char* const words[] = {command.data(), argument.data(), nullptr};
  pid_t pid = 0;
  output.found = posix_spawnp(&pid, "xacro", &actions, nullptr, words, environ) == 0;
  posix_spawn_file_actions_destroy(&actions);
  close(out[1]), close(err[1]);

  pollfd pipes[2] = {{out[0], POLLIN, 0}, {err[0], POLLIN, 0}};
  std::string* texts[2] = {&output.text, &output.errors};
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(kPatience);
  int open = output.found ? 2 : 0;
  while (open > 0 && output.text.size() <= kLargestXmlFile) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
    if (left.count() <= 0) break;
    const int ready = poll(pipes, 2, static_cast<int>(left.count()));
    if (ready < 0 && errno != EINTR) break;
    for (int i = 0; i < 2 && ready > 0; ++i) {
      if (pipes[i].fd < 0 || pipes[i].revents == 0) continue;
      char buffer[4096];
      const ssize_t n = read(pipes[i].fd, buffer, sizeof buffer);
      if (n > 0) {
        texts[i]->append(buffer, static_cast<std::size_t>(n));
        // Of what it complains of, the end counts.
        if (i == 1 && texts[1]->size() > 64 * kLongestTail) texts[1]->erase(0, texts[1]->size() - kLongestTail);
      } else if (n == 0 || errno != EINTR) {
        pipes[i].fd = -1;
        --open;
      }
    }
  }
  close(out[0]), close(err[0]);
  if (!output.found) return output;
  output.in_time = open == 0;
  if (!output.in_time) kill(pid, SIGKILL);
  while (waitpid(pid, &output.status, 0) < 0 && errno == EINTR) {
  }
  // A shell-less spawn on some systems reports a missing program by the child's exit code.
  if (output.in_time && WIFEXITED(output.status) && WEXITSTATUS(output.status) == 127 && output.text.empty())
    output.found = false;
  return output;
}

std::string lastLines(const std::string& text) {
  std::string flat;
  for (const char c : text.substr(text.size() > kLongestTail ? text.size() - kLongestTail : 0)) flat += c == '\n' ? ' ' : c;
  while (!flat.empty() && flat.back() == ' ') flat.pop_back();
  return flat.empty() ? "it gives no reason" : "it says: " + flat;
}

}  // namespace

bool isXacroFile(const std::string& path) {
  const std::string ending = ".xacro";
  return path.size() > ending.size() && path.compare(path.size() - ending.size(), ending.size(), ending) == 0;
}

Loaded<std::string> readVehicleText(const std::string& path) {
  Loaded<std::string> text = readFileBytes(path, "URDF", kLargestXmlFile);
  for (Problem& problem : text.problems) problem.message += "; allowed is a URDF file";
  if (!text || !isXacroFile(path)) return text;
  Output output = runXacro(path);
  const auto refuse = [&path](const std::string& message) {
    return Loaded<std::string>{std::nullopt, {{path, message}}, {}};
  };
  if (!output.found)
    return refuse(
        "this is a xacro file, and there is no command xacro in the PATH to expand it; expand it where there is one, xacro"
        " FILE.xacro > FILE.urdf: the simulator reads plain URDF");
  if (output.text.size() > kLargestXmlFile)
    return refuse("xacro writes more than " + std::to_string(kLargestXmlFile) + " bytes for it, and was ended");
  if (!output.in_time)
    return refuse("xacro took longer than " + std::to_string(kPatience) + " s to expand it, and was ended");
  if (!WIFEXITED(output.status) || WEXITSTATUS(output.status) != 0)
    return refuse("xacro cannot expand it; " + lastLines(output.errors));
  return {std::move(output.text), {}, {path + ": expanded by xacro; line numbers are those of its output"}};
}

}  // namespace ellipsoid_vehicle_sim
