#pragma once

#include <boost/thread/recursive_mutex.hpp>
#include <dynamic_reconfigure/server.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "ellipsoid_vehicle_sim/RunningConfig.h"
#include "ellipsoid_vehicle_sim/ros/parameters.h"

namespace ellipsoid_vehicle_sim {

/// The parameters that may change while the node runs, by dynamic_reconfigure. A change is applied between two ticks,
/// before the caller gets its reply; it is logged and published, latched, on running_parameters with the number of the
/// tick.
class RunningParameters {
 public:
  /// `apply` is called with the options as they are to be; `step` and `stamp` tell where the run is.
  RunningParameters(ros::NodeHandle& nh, ros::NodeHandle& nh_priv, NodeOptions& options, std::function<void()> apply,
                    std::function<std::int64_t()> step, std::function<ros::Time()> stamp);

  /// The options were changed from inside (a state was restored): tells those who show them.
  void refresh();
  /// Tells the values in force; the first time when there is a time to stamp them with.
  void publish();

 private:
  void onChange(RunningConfig& config);
  void showOptions();

  NodeOptions& options_;
  std::function<void()> apply_;
  std::function<std::int64_t()> step_;
  std::function<ros::Time()> stamp_;
  ros::Publisher publisher_;
  boost::recursive_mutex mutex_;  ///< of server_, which asks for one from whoever changes its values from inside.
  dynamic_reconfigure::Server<RunningConfig> server_;
};

/// The keys, in the order of the options' table, and where each stands in the generated class.
const std::vector<std::pair<std::string, double RunningConfig::*>>& runningParameterKeys();

}  // namespace ellipsoid_vehicle_sim
