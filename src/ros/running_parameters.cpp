#include "ellipsoid_vehicle_sim/ros/running_parameters.h"

#include <ros/console.h>

#include <utility>

#include "ellipsoid_vehicle_sim/ParameterChange.h"

namespace ellipsoid_vehicle_sim {
namespace {

/// Calls `use(key, option, field)` for each running parameter.
template <typename Options, typename Use>
void forEach(Options& options, const Use& use) {
  const ParameterTable<NodeOptions> table = nodeParameters();
  for (const auto& [key, member] : runningParameterKeys()) {
    for (const Parameter<NodeOptions>& row : table) {
      if (row.spec.key == key) use(row, member, options);
    }
  }
}

RunningConfig toConfig(const NodeOptions& options) {
  RunningConfig config = RunningConfig::__getDefault__();
  forEach(options, [&config](const Parameter<NodeOptions>& row, double RunningConfig::*member,
                             const NodeOptions& from) { config.*member = numberOf(*row.get(from)); });
  return config;
}

}  // namespace

const std::vector<std::pair<std::string, double RunningConfig::*>>& runningParameterKeys() {
  static const std::vector<std::pair<std::string, double RunningConfig::*>> keys = {
      {"clock_rate", &RunningConfig::clock_rate},         {"publish_rate", &RunningConfig::publish_rate},
      {"marker_rate", &RunningConfig::marker_rate},       {"imu_rate", &RunningConfig::imu_rate},
      {"marker_scale", &RunningConfig::marker_scale},     {"real_time_factor", &RunningConfig::real_time_factor},
      {"friction_scale", &RunningConfig::friction_scale},
  };
  return keys;
}

RunningParameters::RunningParameters(ros::NodeHandle& nh, ros::NodeHandle& nh_priv, NodeOptions& options,
                                     std::function<void()> apply, std::function<std::int64_t()> step,
                                     std::function<ros::Time()> stamp)
    : options_(options),
      apply_(std::move(apply)),
      step_(std::move(step)),
      stamp_(std::move(stamp)),
      publisher_(nh.advertise<ParameterChange>("running_parameters", 10, true)),
      server_(mutex_, nh_priv) {
  showOptions();
  // Calls back at once, with the options as they are.
  server_.setCallback([this](RunningConfig& config, std::uint32_t) { onChange(config); });
}

void RunningParameters::showOptions() {
  const boost::recursive_mutex::scoped_lock lock(mutex_);
  server_.updateConfig(toConfig(options_));
}

void RunningParameters::refresh() {
  showOptions();
  publish();
}

void RunningParameters::onChange(RunningConfig& config) {
  std::string changes;
  forEach(options_, [&](const Parameter<NodeOptions>& row, double RunningConfig::*member, NodeOptions& options) {
    const ParameterValue before = *row.get(options), wanted = config.*member;
    if (before == wanted) return;
    // The server clamps to the ranges of the .cfg; those of the table are asked too, and are the same by test.
    std::optional<std::string> reason = refusal(row.spec, wanted);
    if (row.spec.key == "real_time_factor" && options.clock != ClockMode::kPublish) reason = "needs clock: publish";
    if (reason) {
      ROS_WARN("%s stays as it is: %s", row.spec.key.c_str(), reason->c_str());
      return;
    }
    row.set(options, wanted);
    changes += (changes.empty() ? "" : ", ") + row.spec.key + " " + valueText(before) + " -> " + valueText(wanted);
  });
  config = toConfig(options_);  // what the caller is told
  if (changes.empty()) return;
  ROS_INFO("from step %ld on: %s", static_cast<long>(step_()), changes.c_str());
  apply_();
  publish();
}

void RunningParameters::publish() {
  ParameterChange message;
  message.header.stamp = stamp_();
  message.step = step_();
  forEach(options_, [&message](const Parameter<NodeOptions>& row, double RunningConfig::*, const NodeOptions& options) {
    message.names.push_back(row.spec.key);
    message.values.push_back(numberOf(*row.get(options)));
  });
  publisher_.publish(message);
}

}  // namespace ellipsoid_vehicle_sim
