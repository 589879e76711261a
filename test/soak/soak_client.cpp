// soak_client NODE SEED SECONDS WALL: subscribes to all that a running simulator publishes and floods it with commands
// for so many simulated seconds, WALL seconds at most. Prints one line of JSON: what was seen. scripts/soak.py starts it
// again and again.
#include <dynamic_reconfigure/Reconfigure.h>
#include <ros/master.h>
#include <ros/ros.h>
#include <std_srvs/Trigger.h>

#include <cstdio>
#include <cstdlib>
#include <thread>

#include "command_fuzzer.h"
#include "report_text.h"
#include "topic_watcher.h"

namespace ellipsoid_vehicle_sim {
namespace {

// Simulated time passes some hundred times as fast as ours.
const ros::Duration kPatience(3000.0);

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

/// Lets the simulator run on as fast as it can, from its start.
void settle(const std::string& node) {
  for (const char* name : {"/reset", "/resume"}) {
    std_srvs::Trigger service;
    ros::service::call(node + name, service);
  }
  dynamic_reconfigure::Reconfigure fast;
  fast.request.config.doubles.resize(1);
  fast.request.config.doubles[0].name = "real_time_factor";
  fast.request.config.doubles[0].value = 0.0;
  ros::service::call(node + "/set_parameters", fast);
}

int run(int argc, char** argv) {
  if (argc != 5) {
    std::fprintf(stderr, "soak_client NODE SEED SECONDS WALL\n");
    return 2;
  }
  const std::string node = argv[1];
  const auto seed = static_cast<std::uint64_t>(std::atoll(argv[2]));
  const double seconds = std::atof(argv[3]), wall = std::atof(argv[4]);
  ros::NodeHandle nh;
  TopicWatcher watcher(nh, node);
  ros::AsyncSpinner spinner(1);
  spinner.start();

  const ros::WallTime begin = ros::WallTime::now();
  const auto spent = [&begin]() { return (ros::WallTime::now() - begin).toSec(); };
  while (ros::ok() && watcher.time() == 0.0 && spent() < wall) ros::WallDuration(0.01).sleep();
  std::vector<std::string> faults;
  if (watcher.time() == 0.0) faults.push_back("no /clock for " + std::to_string(wall) + " s");

  const auto shapes = ros::topic::waitForMessage<visualization_msgs::MarkerArray>("collision_shapes", nh, kPatience);
  const auto state = ros::topic::waitForMessage<sensor_msgs::JointState>("joint_states", nh, kPatience);
  CommandFuzzer commands(nh, state ? state->name : std::vector<std::string>(), seed + 1);
  if (!shapes || !state) faults.push_back("the latched messages did not come");
  settle(node);

  const double first = watcher.time();
  std::atomic<bool> end{false};
  std::thread flood([&]() {
    while (ros::ok() && !end) commands.round();
  });
  AbsurdNumbers random(seed);
  double progress = watcher.time();
  ros::WallTime moved = ros::WallTime::now();
  while (ros::ok() && watcher.time() - first < seconds && spent() < wall) {
    if (random.one(3)) watcher.toggle(random.index(1000));
    ros::WallDuration(random.uniform(0.0, 0.02)).sleep();
    // Stopped on purpose, or fallen off the world and frozen: start again.
    if (watcher.time() > progress) {
      progress = watcher.time();
      moved = ros::WallTime::now();
    } else if ((ros::WallTime::now() - moved).toSec() > 0.5) {
      settle(node);
      moved = ros::WallTime::now();
    }
  }
  end = true;
  flood.join();
  settle(node);

  const std::vector<std::string> seen = watcher.faults(), strange = unwatched(nh, watcher.names());
  faults.insert(faults.end(), seen.begin(), seen.end());
  faults.insert(faults.end(), strange.begin(), strange.end());
  std::printf(
      "{\"from\": %.6f, \"to\": %.6f, \"messages\": %ld, \"commands\": %ld, \"silent\": %s, \"faults\": %s}\n",
      first, watcher.time(), watcher.messages(), commands.sent(), listed(watcher.silent()).c_str(),
      listed(faults).c_str());
  return 0;
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim

int main(int argc, char** argv) {
  ros::init(argc, argv, "soak_client", ros::init_options::AnonymousName);
  return ellipsoid_vehicle_sim::run(argc, argv);
}
