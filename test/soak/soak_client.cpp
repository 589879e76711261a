// soak_client NODE PID MASTER_PID SEED SECONDS WALL: bothers a running simulator for so many simulated seconds, WALL
// seconds at most. Prints one line of JSON: what was seen. scripts/soak.py starts it again and again.
#include <ros/master.h>
#include <ros/ros.h>

#include <cstdio>
#include <cstdlib>
#include <thread>

#include "service_fuzzer.h"
#include "topic_watcher.h"

namespace ellipsoid_vehicle_sim {
namespace {

// Simulated time passes some hundred times as fast as ours.
const ros::Duration kPatience(3000.0);

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += static_cast<unsigned char>(c) < 32 ? ' ' : c;
  }
  return result + "\"";
}

std::string listed(const std::vector<std::string>& texts) {
  std::string result;
  for (const std::string& text : texts) result += (result.empty() ? "" : ", ") + quoted(text);
  return "[" + result + "]";
}

/// Topics that the simulator publishes and nobody looks at here: a new one has to be added to the watcher.
std::vector<std::string> unwatched(ros::NodeHandle& nh, const std::vector<std::string>& watched) {
  ros::master::V_TopicInfo all;
  ros::master::getTopics(all);
  std::vector<std::string> result;
  for (const auto& topic : all) {
    bool known = topic.name == "/rosout" || topic.name == "/rosout_agg";
    for (const std::string& name : watched) known = known || nh.resolveName(name) == topic.name;
    for (const char* command : {"cmd_vel", "ackermann_cmd", "joint_commands", "initialpose"})
      known = known || nh.resolveName(command) == topic.name;
    if (!known) result.push_back("nobody watches " + topic.name);
  }
  return result;
}

int run(int argc, char** argv) {
  if (argc != 7) {
    std::fprintf(stderr, "soak_client NODE PID MASTER_PID SEED SECONDS WALL\n");
    return 2;
  }
  const std::string node = argv[1];
  const std::vector<long> pids = {std::atol(argv[2]), std::atol(argv[3])};
  const auto seed = static_cast<std::uint64_t>(std::atoll(argv[4]));
  const double seconds = std::atof(argv[5]), wall = std::atof(argv[6]);
  ros::NodeHandle nh;
  TopicWatcher watcher(nh, node);
  ros::AsyncSpinner spinner(1);
  spinner.start();

  const ros::WallTime begin = ros::WallTime::now();
  const auto spent = [&begin]() { return (ros::WallTime::now() - begin).toSec(); };
  while (ros::ok() && watcher.time() == 0.0 && spent() < wall) ros::WallDuration(0.01).sleep();
  std::vector<std::string> faults;
  if (watcher.time() == 0.0) faults.push_back("no /clock for " + std::to_string(wall) + " s");

  // Names to be right with now and then: from the simulator's own words.
  const auto shapes = ros::topic::waitForMessage<visualization_msgs::MarkerArray>("collision_shapes", nh, kPatience);
  std::vector<std::string> ellipsoids;
  ExplainContact known;
  ros::service::call(node + "/explain_contact", known);
  for (std::size_t at = known.response.message.find("there are: ");
       at != std::string::npos && at < known.response.message.size();) {
    at = known.response.message.find_first_not_of(",: ", at + (ellipsoids.empty() ? 11 : 0));
    const std::size_t end = std::min(known.response.message.find(',', at), known.response.message.size());
    ellipsoids.push_back(known.response.message.substr(at, end - at));
    at = end;
  }
  const auto state = ros::topic::waitForMessage<sensor_msgs::JointState>("joint_states", nh, kPatience);
  CommandFuzzer commands(nh, state ? state->name : std::vector<std::string>(), seed + 1);
  ServiceFuzzer services(node, ellipsoids, pids, seed + 2);
  if (!shapes || ellipsoids.empty() || !state) faults.push_back("the latched messages did not come");
  services.settle();

  const double first = watcher.time();
  std::atomic<bool> end{false};
  std::thread flood([&]() {
    while (ros::ok() && !end) commands.round();
  });
  AbsurdNumbers random(seed);
  double progress = watcher.time();
  ros::WallTime moved = ros::WallTime::now();
  while (ros::ok() && watcher.time() - first < seconds && spent() < wall) {
    services.round();
    if (random.one(3)) watcher.toggle(random.index(1000));
    ros::WallDuration(random.uniform(0.0, 0.02)).sleep();
    // Stopped on purpose, or fallen off the world and frozen: start again.
    if (watcher.time() > progress) {
      progress = watcher.time();
      moved = ros::WallTime::now();
    } else if ((ros::WallTime::now() - moved).toSec() > 0.5) {
      services.settle();
      moved = ros::WallTime::now();
    }
  }
  end = true;
  flood.join();
  services.settle();

  for (const auto* more : {&services.faults()}) faults.insert(faults.end(), more->begin(), more->end());
  const std::vector<std::string> seen = watcher.faults(), strange = unwatched(nh, watcher.names());
  faults.insert(faults.end(), seen.begin(), seen.end());
  faults.insert(faults.end(), strange.begin(), strange.end());
  std::string latencies;
  for (const auto& [name, latency] : services.latencies()) {
    char text[200];
    std::snprintf(text, sizeof text, "%s\"%s\": [%ld, %.6f, %.6f]", latencies.empty() ? "" : ", ", name.c_str(),
                  latency.calls, latency.worst, latency.worst_served);
    latencies += text;
  }
  std::printf(
      "{\"from\": %.6f, \"to\": %.6f, \"messages\": %ld, \"commands\": %ld, \"services\": {%s}, \"lost\": %ld, "
      "\"silent\": %s, \"faults\": %s}\n",
      first, watcher.time(), watcher.messages(), commands.sent(), latencies.c_str(), services.lost(),
      listed(watcher.silent()).c_str(), listed(faults).c_str());
  return 0;
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim

int main(int argc, char** argv) {
  ros::init(argc, argv, "soak_client", ros::init_options::AnonymousName);
  return ellipsoid_vehicle_sim::run(argc, argv);
}
