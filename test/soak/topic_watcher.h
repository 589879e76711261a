#pragma once

#include <diagnostic_msgs/DiagnosticArray.h>
#include <dynamic_reconfigure/Config.h>
#include <dynamic_reconfigure/ConfigDescription.h>
#include <nav_msgs/Odometry.h>
#include <ros/node_handle.h>
#include <rosgraph_msgs/Clock.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/LaserScan.h>
#include <std_msgs/Bool.h>
#include <tf2_msgs/TFMessage.h>
#include <visualization_msgs/MarkerArray.h>

#include <atomic>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/ContactStates.h"
#include "ellipsoid_vehicle_sim/ParameterChange.h"
#include "nan_search.h"

namespace ellipsoid_vehicle_sim {

/// Subscribes to every topic of the simulator, looks for NaN in each message and for a clock that goes back.
class TopicWatcher {
 public:
  TopicWatcher(ros::NodeHandle& nh, const std::string& node) : nh_(nh) {
    watch<nav_msgs::Odometry>("odom");
    watch<nav_msgs::Odometry>("ground_truth");
    watch<tf2_msgs::TFMessage>("/tf");
    watch<tf2_msgs::TFMessage>("/tf_static");
    watch<sensor_msgs::JointState>("joint_states");
    watch<sensor_msgs::Imu>("imu");
    watch<sensor_msgs::LaserScan>("front/scan");
    watch<sensor_msgs::PointCloud2>("top/points");
    watch<ContactStates>("contacts");
    watch<visualization_msgs::MarkerArray>("contact_markers");
    watch<visualization_msgs::MarkerArray>("collision_shapes");
    watch<visualization_msgs::MarkerArray>("world");
    watch<diagnostic_msgs::DiagnosticArray>("diagnostics");
    watch<std_msgs::Bool>("ready");
    watch<ParameterChange>("running_parameters");
    watch<dynamic_reconfigure::Config>(node + "/parameter_updates");
    watch<dynamic_reconfigure::ConfigDescription>(node + "/parameter_descriptions");
    add("/clock", [this]() {
      const boost::function<void(const rosgraph_msgs::ClockConstPtr&)> callback =
          [this](const rosgraph_msgs::ClockConstPtr& message) { onClock(*message); };
      return nh_.subscribe<rosgraph_msgs::Clock>("/clock", 1000, callback);
    });
    for (auto& topic : topics_) topic.second.subscriber = topic.second.subscribe();
  }

  /// All topics that it knows; the simulator may publish none beside them.
  std::vector<std::string> names() const {
    std::vector<std::string> result;
    for (const auto& topic : topics_) result.push_back(topic.first);
    return result;
  }
  /// One subscriber goes, or comes back. The clock's stays.
  void toggle(int index) {
    auto topic = std::next(topics_.begin(), index % static_cast<int>(topics_.size()));
    if (topic->first == "/clock") return;
    if (topic->second.subscriber) {
      topic->second.subscriber.shutdown();
    } else {
      topic->second.subscriber = topic->second.subscribe();
    }
  }
  long messages() const { return messages_; }
  /// [s]
  double time() const { return time_; }
  std::vector<std::string> faults() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return faults_;
  }
  /// Topics of which no message ever came.
  std::vector<std::string> silent() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::vector<std::string> result;
    for (const auto& topic : topics_)
      if (heard_.count(topic.first) == 0) result.push_back(topic.first);
    return result;
  }

 private:
  struct Topic {
    std::function<ros::Subscriber()> subscribe;
    ros::Subscriber subscriber;
  };
  void add(const std::string& name, std::function<ros::Subscriber()> subscribe) {
    topics_[name].subscribe = std::move(subscribe);
  }
  template <typename Message>
  void watch(const std::string& name) {
    add(name, [this, name]() {
      const boost::function<void(const typename Message::ConstPtr&)> callback =
          [this, name](const typename Message::ConstPtr& message) {
            hear(name);
            if (NanSearch::finds(*message)) fault("NaN on " + name);
          };
      return nh_.subscribe<Message>(name, 1000, callback);
    });
  }
  void onClock(const rosgraph_msgs::Clock& message) {
    hear("/clock");
    const double now = message.clock.toSec();
    if (now < time_) fault("/clock went back from " + std::to_string(time_) + " to " + std::to_string(now));
    time_ = now;
  }
  void hear(const std::string& name) {
    ++messages_;
    const std::lock_guard<std::mutex> lock(mutex_);
    heard_[name] = true;
  }
  void fault(const std::string& text) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (faults_.size() < 20) faults_.push_back(text);
  }

  ros::NodeHandle& nh_;
  std::map<std::string, Topic> topics_;
  std::atomic<long> messages_{0};
  std::atomic<double> time_{0.0};
  mutable std::mutex mutex_;
  std::map<std::string, bool> heard_;
  std::vector<std::string> faults_;
};

}  // namespace ellipsoid_vehicle_sim
