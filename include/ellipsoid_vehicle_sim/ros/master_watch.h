#pragma once

#include <ros/node_handle.h>
#include <xmlrpcpp/XmlRpcValue.h>

#include <atomic>
#include <condition_variable>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace ellipsoid_vehicle_sim {

/// Looks every few seconds of wall time whether the ROS master still knows this node. One that was started anew knows
/// nobody: roscpp leaves it at that, and the node would run on, unseen by whoever comes later. Here its topics and
/// services are registered again, and the parameters that others need of it are set again where they are gone
/// (robot_description, /use_sim_time). Connections that were there are not touched; while there is no master nothing
/// waits for it.
class MasterWatch {
 public:
  /// The node's topics and services must stand by now, or by the next look.
  explicit MasterWatch(const ros::NodeHandle& nh);
  ~MasterWatch();
  MasterWatch(const MasterWatch&) = delete;
  MasterWatch& operator=(const MasterWatch&) = delete;

 private:
  void watch();
  void look();
  void rememberServices();
  void registerAgain();
  bool ask(const char* method, const std::vector<XmlRpc::XmlRpcValue>& arguments, XmlRpc::XmlRpcValue& answer) const;

  std::map<std::string, std::string> texts_;  ///< parameters to be there, by name.
  bool simulated_time_ = false;
  std::vector<std::string> services_;  ///< as the master last had them.
  bool unfinished_ = false;            ///< a registration that was not taken whole.

  std::mutex mutex_;
  std::condition_variable ending_;
  std::atomic<bool> end_{false};
  std::thread thread_;
};

}  // namespace ellipsoid_vehicle_sim
