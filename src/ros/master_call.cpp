#include "ellipsoid_vehicle_sim/ros/master_call.h"

#include <ros/master.h>
#include <ros/this_node.h>
#include <xmlrpcpp/XmlRpcClient.h>

namespace ellipsoid_vehicle_sim {

using XmlRpc::XmlRpcValue;

XmlRpcValue listOf(const std::vector<XmlRpcValue>& items) {
  XmlRpcValue list;
  list.setSize(static_cast<int>(items.size()));
  for (int i = 0; i < list.size(); ++i) list[i] = items[static_cast<std::size_t>(i)];
  return list;
}

Answer callServer(const std::string& host, std::uint32_t port, const char* method, const XmlRpcValue& arguments,
                  std::chrono::milliseconds patience, const std::atomic<bool>& end, XmlRpcValue& answer) {
  XmlRpc::XmlRpcClient client(host.c_str(), static_cast<int>(port), "/");
  const auto latest = std::chrono::steady_clock::now() + patience;
  bool open = client.executeNonBlock(method, arguments), done = false, lost = !open;
  while (open && !done) {
    client._disp.work(0.002);
    done = client.executeCheckDone(answer);
    // Without a connection left it will never be done.
    lost = !done && client.getfd() == -1;
    open = !lost && !end && std::chrono::steady_clock::now() < latest;
  }
  const bool well = done && !client.isFault() && answer.getType() == XmlRpcValue::TypeArray && answer.size() == 3;
  client.close();
  if (lost) return Answer::kNobody;
  return well ? Answer::kCame : Answer::kNone;
}

Answer askMaster(std::chrono::milliseconds patience) {
  const std::atomic<bool> never{false};
  XmlRpcValue answer;
  return callServer(ros::master::getHost(), ros::master::getPort(), "getPid", listOf({XmlRpcValue(ros::this_node::getName())}),
                    patience, never, answer);
}

}  // namespace ellipsoid_vehicle_sim
