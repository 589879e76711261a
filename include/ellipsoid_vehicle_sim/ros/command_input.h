#pragma once

#include <geometry_msgs/Twist.h>
#include <ros/node_handle.h>
#include <ros/subscriber.h>

#include <array>
#include <cstdint>
#include <deque>
#include <string>
#include <variant>
#include <vector>

#include "ellipsoid_vehicle_sim/ros/ackermann_message.h"
#include "ellipsoid_vehicle_sim/ros/joint_command_message.h"
#include "ellipsoid_vehicle_sim/ros/parameters.h"
#include "ellipsoid_vehicle_sim/ros/wall_throttle.h"
#include "ellipsoid_vehicle_sim/vehicle/simulator.h"
#include "ellipsoid_vehicle_sim/vehicle/snapshot.h"

namespace ellipsoid_vehicle_sim {

/// The commanders' topics: cmd_vel, ackermann_cmd, joint_commands. What is not finite or cannot be obeyed is dropped,
/// counted and warned about. Who wins: of cmd_vel and ackermann_cmd the latest; a joint named in joint_commands obeys
/// that while it is younger than command_timeout, whatever the vehicle is asked for.
///
/// Free-running, a command is in force from the next tick. In lockstep the topics of `lockstep_topics` are queued and
/// one of each is taken a period, so that a run is a function of the commands' sequence alone; the other topics are in
/// force when they come.
class CommandInput {
 public:
  CommandInput(ros::NodeHandle& nh, const NodeOptions& options, Simulator& simulator);

  /// Whether each lockstep topic has a command waiting.
  bool isComplete() const;
  /// Takes one command of each lockstep topic.
  void takeOne();
  /// Takes all that wait: the last of each topic stays in force.
  void takeAll();
  void clear();
  /// The lockstep topics without a command, with their number of publishers.
  std::string missing() const;

  std::int64_t dropped() const { return dropped_; }
  const std::string& lastRefusal() const { return last_refusal_; }  ///< "" before the first.

  /// The waiting commands, for a snapshot; false if the bytes are none.
  void save(ByteWriter& out) const;
  bool restore(ByteReader& in);

 private:
  using Command = std::variant<DriveCommand, std::vector<JointRequest>>;
  enum Topic { kCmdVel, kAckermannCmd, kJointCommands, kTopicCount };
  struct Input {
    ros::Subscriber subscriber;
    bool lockstep = false;
    std::deque<Command> waiting;
  };

  void onTwist(const geometry_msgs::Twist& twist);
  void onAckermann(const AckermannDriveStamped& message);
  void onJoints(const JointCommandMessage& message);
  void accept(Topic topic, Command command);
  void apply(Topic topic, const Command& command);
  void refuse(Topic topic, const std::string& reason);

  Simulator& simulator_;
  std::array<Input, kTopicCount> inputs_;
  std::int64_t dropped_ = 0;
  std::string last_refusal_;
  WallThrottle refusals_{1.0}, queues_{5.0};
};

/// "" if the message can be taken; otherwise why not.
std::string refusalOf(const geometry_msgs::Twist& message);
std::string refusalOf(const AckermannDriveStamped& message);
std::string refusalOf(const JointCommandMessage& message);

}  // namespace ellipsoid_vehicle_sim
