// soak_caller NODE PID MASTER_PID SEED ALLOWED: calls the services of a running simulator until its standard input ends, and
// does nothing else: how long an answer takes is what a caller feels who does not drown in messages himself. Answers that
// take more than ALLOWED seconds are counted. Prints one line of JSON: what was seen. scripts/soak.py starts it beside a
// soak_client.
#include <poll.h>
#include <ros/ros.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

#include "report_text.h"
#include "service_fuzzer.h"

namespace ellipsoid_vehicle_sim {
namespace {

/// Names to be right with now and then: from the simulator's own words.
std::vector<std::string> ellipsoidNames(const std::string& node) {
  std::vector<std::string> names;
  ExplainContact known;
  ros::service::call(node + "/explain_contact", known);
  const std::string& text = known.response.message;
  for (std::size_t at = text.find("there are: "); at != std::string::npos && at < text.size();) {
    at = text.find_first_not_of(",: ", at + (names.empty() ? 11 : 0));
    const std::size_t end = std::min(text.find(',', at), text.size());
    names.push_back(text.substr(at, end - at));
    at = end;
  }
  return names;
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6f", value);
  return text;
}

bool inputEnded() {
  pollfd input{STDIN_FILENO, 0, 0};
  return poll(&input, 1, 0) > 0 && (input.revents & (POLLHUP | POLLERR | POLLNVAL)) != 0;
}

int run(int argc, char** argv) {
  if (argc != 6) {
    std::fprintf(stderr, "soak_caller NODE PID MASTER_PID SEED ALLOWED\n");
    return 2;
  }
  const std::string node = argv[1];
  ros::NodeHandle nh;
  if (!ros::service::waitForService(node + "/explain_contact", ros::Duration(600.0))) return 0;
  const std::vector<std::string> ellipsoids = ellipsoidNames(node);
  ServiceFuzzer services(node, ellipsoids, {std::atol(argv[2]), std::atol(argv[3])},
                         static_cast<std::uint64_t>(std::atoll(argv[4])), std::atof(argv[5]));
  AbsurdNumbers random(static_cast<std::uint64_t>(std::atoll(argv[4])) + 1);
  while (ros::ok() && !inputEnded()) {
    services.round();
    ros::WallDuration(random.uniform(0.0, 0.02)).sleep();
  }
  std::vector<std::string> faults = services.faults();
  if (ellipsoids.empty()) faults.push_back("~explain_contact names no ellipsoids");
  std::string latencies;
  for (const auto& [name, latency] : services.latencies()) {
    std::string kept;
    for (const double waited : latency.kept_from_worst.waited) kept += number(waited) + ", ";
    latencies += (latencies.empty() ? "" : ", ") + quoted(name) + ": {\"calls\": " + std::to_string(latency.calls) +
                 ", \"late\": [" + std::to_string(latency.late) + ", " + std::to_string(latency.late_served) + "]" +
                 ", \"worst\": " + number(latency.worst) + ", \"kept\": [" + kept +
                 number(latency.kept_from_worst.stalled) + "], \"served\": " + number(latency.worst_served) + "}";
  }
  std::printf("{\"services\": {%s}, \"lost\": %ld, \"faults\": %s}\n", latencies.c_str(), services.lost(),
              listed(faults).c_str());
  return 0;
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim

int main(int argc, char** argv) {
  ros::init(argc, argv, "soak_caller", ros::init_options::AnonymousName);
  return ellipsoid_vehicle_sim::run(argc, argv);
}
