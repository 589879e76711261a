#pragma once

#include <xmlrpcpp/XmlRpcValue.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

namespace ellipsoid_vehicle_sim {

/// What became of a call.
enum class Answer {
  kCame,    ///< [code, message, value], as in all of ROS's interfaces.
  kNone,    ///< not in time, or not of that form: somebody is there who stands still.
  kNobody,  ///< there is no such server.
};

/// A list of them, as arguments of a call.
XmlRpc::XmlRpcValue listOf(const std::vector<XmlRpc::XmlRpcValue>& items);

/// Calls a server, and gives up when `patience` is over, or at once when `end` is set. roscpp's own calls wait for ever for
/// a server that stands still (stopped, or on a host that fell silent) and must not be made where that would hurt.
Answer callServer(const std::string& host, std::uint32_t port, const char* method, const XmlRpc::XmlRpcValue& arguments,
                  std::chrono::milliseconds patience, const std::atomic<bool>& end, XmlRpc::XmlRpcValue& answer);

/// Whether the ROS master is there and answers.
Answer askMaster(std::chrono::milliseconds patience);

}  // namespace ellipsoid_vehicle_sim
