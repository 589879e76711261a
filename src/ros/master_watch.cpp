#include "ellipsoid_vehicle_sim/ros/master_watch.h"

#include <ros/connection_manager.h>
#include <ros/console.h>
#include <ros/master.h>
#include <ros/network.h>
#include <ros/param.h>
#include <ros/publication.h>
#include <ros/this_node.h>
#include <ros/topic_manager.h>
#include <ros/xmlrpc_manager.h>

#include <chrono>

#include "ellipsoid_vehicle_sim/ros/master_call.h"

namespace ellipsoid_vehicle_sim {
namespace {

using XmlRpc::XmlRpcValue;

constexpr std::chrono::seconds kBetweenLooks(2);  // of wall time
constexpr std::chrono::seconds kPatience(2);      // with a master that does not answer, which must not keep us from ending

}  // namespace

MasterWatch::MasterWatch(const ros::NodeHandle& nh) {
  std::string key, text;
  if (nh.searchParam("robot_description", key) && nh.getParam(key, text)) texts_[key] = text;
  ros::param::get("/use_sim_time", simulated_time_);
  rememberServices();
  thread_ = std::thread([this] { watch(); });
}

MasterWatch::~MasterWatch() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    end_ = true;
  }
  ending_.notify_all();
  thread_.join();
}

void MasterWatch::watch() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (!ending_.wait_for(lock, kBetweenLooks, [this] { return end_.load(); })) {
    lock.unlock();
    if (ros::ok()) look();
    lock.lock();
  }
}

bool MasterWatch::ask(const char* method, const std::vector<XmlRpcValue>& arguments, XmlRpcValue& answer) const {
  std::vector<XmlRpcValue> all = {XmlRpcValue(ros::this_node::getName())};
  all.insert(all.end(), arguments.begin(), arguments.end());
  return callServer(ros::master::getHost(), ros::master::getPort(), method, listOf(all), kPatience, end_, answer) ==
         Answer::kCame;
}

void MasterWatch::look() {
  XmlRpcValue answer;
  if (!ask("lookupNode", {XmlRpcValue(ros::this_node::getName())}, answer)) return;  // no master at the moment
  if (static_cast<int>(answer[0]) == 1 && !unfinished_) {
    rememberServices();
  } else {
    registerAgain();
  }
}

void MasterWatch::rememberServices() {
  XmlRpcValue answer;
  if (!ask("getSystemState", {}, answer) || static_cast<int>(answer[0]) != 1) return;
  XmlRpcValue& all = answer[2][2];
  std::vector<std::string> services;
  for (int i = 0; i < all.size(); ++i)
    for (int k = 0; k < all[i][1].size(); ++k)
      if (static_cast<std::string>(all[i][1][k]) == ros::this_node::getName())
        services.push_back(static_cast<std::string>(all[i][0]));
  if (!services.empty()) services_ = services;
}

void MasterWatch::registerAgain() {
  const std::string us = ros::XMLRPCManager::instance()->getServerURI();
  XmlRpcValue answer;
  bool whole = true;
  for (const auto& [key, text] : texts_) {
    if (ask("hasParam", {XmlRpcValue(key)}, answer) && !static_cast<bool>(answer[2]))
      whole = ask("setParam", {XmlRpcValue(key), XmlRpcValue(text)}, answer) && whole;
  }
  if (simulated_time_) whole = ask("setParam", {XmlRpcValue("/use_sim_time"), XmlRpcValue(true)}, answer) && whole;
  const std::string service_uri =
      "rosrpc://" + ros::network::getHost() + ":" + std::to_string(ros::ConnectionManager::instance()->getTCPPort());
  for (const std::string& service : services_)
    whole = ask("registerService", {XmlRpcValue(service), XmlRpcValue(service_uri), XmlRpcValue(us)}, answer) && whole;
  ros::V_string topics;
  ros::this_node::getAdvertisedTopics(topics);
  for (const std::string& topic : topics) {
    const ros::PublicationPtr publication = ros::TopicManager::instance()->lookupPublication(topic);
    if (!publication) continue;
    whole = ask("registerPublisher", {XmlRpcValue(topic), XmlRpcValue(publication->getDataType()), XmlRpcValue(us)},
                answer) &&
            whole;
  }
  topics.clear();
  ros::this_node::getSubscribedTopics(topics);
  std::string host;
  std::uint32_t port = 0;
  whole = ros::network::splitURI(us, host, port) && whole;
  for (const std::string& topic : topics) {
    // "*": whatever type it turns out to have; the subscription itself knows.
    if (!ask("registerSubscriber", {XmlRpcValue(topic), XmlRpcValue("*"), XmlRpcValue(us)}, answer)) {
      whole = false;
      continue;
    }
    // Who publishes it by now is what the master would have told us had it known us.
    const XmlRpcValue publishers = answer[2];
    callServer(host, port, "publisherUpdate",
               listOf({XmlRpcValue(ros::this_node::getName()), XmlRpcValue(topic), publishers}), kPatience, end_, answer);
  }
  unfinished_ = !whole;
  if (whole)
    ROS_WARN("the ROS master was started anew: topics and services are registered with it again");
  else
    ROS_WARN("the ROS master was started anew and could not be told everything; that is tried again");
}

}  // namespace ellipsoid_vehicle_sim
