#include "ellipsoid_vehicle_sim/ros/command_input.h"

#include <ros/console.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "ellipsoid_vehicle_sim/ros/conversions.h"
#include "ellipsoid_vehicle_sim/vehicle/drive.h"

namespace ellipsoid_vehicle_sim {
namespace {

// Free-running only the last command counts; in lockstep none may be lost.
constexpr int kCommandQueue = 100;
constexpr std::size_t kLongestWaiting = 100;

std::string lengthRefusal(const char* field, std::size_t length, std::size_t names) {
  if (length == 0 || length == names) return "";
  return std::string(field) + " has " + std::to_string(length) + " values for " + std::to_string(names) +
         " names; allowed are none or one for each";
}

std::string sizeRefusal(std::initializer_list<double> values) {
  for (const double value : values) {
    if (!std::isfinite(value)) return "it is not finite";
    if (std::abs(value) > kLargestCommand) return "it holds a value above 1e9, up or down";
  }
  return "";
}

}  // namespace

std::string refusalOf(const geometry_msgs::Twist& m) {
  // Also what a ground vehicle does not look at: a NaN anywhere means that the sender is broken.
  return sizeRefusal({m.linear.x, m.linear.y, m.linear.z, m.angular.x, m.angular.y, m.angular.z});
}

std::string refusalOf(const AckermannDriveStamped& m) {
  const std::string refusal =
      sizeRefusal({m.steering_angle, m.steering_angle_velocity, m.speed, m.acceleration, m.jerk});
  if (!refusal.empty()) return refusal;
  if (m.steering_angle_velocity < 0.0F || m.acceleration < 0.0F || m.jerk < 0.0F) {
    return "steering_angle_velocity, acceleration and jerk are absolute bounds, and one is negative";
  }
  return "";
}

std::string refusalOf(const JointCommandMessage& m) {
  const std::size_t names = m.told[0];
  for (const std::string& refusal : {lengthRefusal("position", m.told[1], names), lengthRefusal("velocity", m.told[2], names),
                                     lengthRefusal("effort", m.told[3], names)}) {
    if (!refusal.empty()) return refusal;
  }
  return "";
}

CommandInput::CommandInput(ros::NodeHandle& nh, const NodeOptions& options, Simulator& simulator)
    : simulator_(simulator) {
  // No delay: with Nagle's algorithm a lockstep command takes 40 ms.
  const ros::TransportHints hints = ros::TransportHints().tcpNoDelay();
  inputs_[kCmdVel].subscriber = nh.subscribe("cmd_vel", kCommandQueue, &CommandInput::onTwist, this, hints);
  inputs_[kAckermannCmd].subscriber =
      nh.subscribe("ackermann_cmd", kCommandQueue, &CommandInput::onAckermann, this, hints);
  inputs_[kJointCommands].subscriber =
      nh.subscribe("joint_commands", kCommandQueue, &CommandInput::onJoints, this, hints);
  if (!options.lockstep) return;
  for (const std::string& topic : options.lockstep_topics) {
    const std::array<const char*, kTopicCount> names = kCommandTopics;
    inputs_[static_cast<std::size_t>(std::find(names.begin(), names.end(), topic) - names.begin())].lockstep = true;
  }
}

void CommandInput::onTwist(const geometry_msgs::Twist& twist) {
  if (const std::string refusal = refusalOf(twist); !refusal.empty()) return refuse(kCmdVel, refusal);
  accept(kCmdVel, toDriveCommand(twist));
}

void CommandInput::onAckermann(const AckermannDriveStamped& message) {
  std::string refusal = refusalOf(message);
  if (refusal.empty() && simulator_.model().drive.layout != DriveLayout::kAckermann) {
    refusal = "this vehicle has no wheel that steers: use cmd_vel";
  }
  if (!refusal.empty()) return refuse(kAckermannCmd, refusal);
  accept(kAckermannCmd, toDriveCommand(message));
}

void CommandInput::onJoints(const JointCommandMessage& message) {
  std::string refusal = countRefusal(simulator_.model(), message.told[0]);
  if (refusal.empty()) refusal = refusalOf(message);
  if (!refusal.empty()) return refuse(kJointCommands, refusal);
  accept(kJointCommands, toJointRequests(message));
}

void CommandInput::accept(Topic topic, Command command) {
  Input& input = inputs_[topic];
  if (!input.lockstep) return apply(topic, command);
  // What the joints are is known now: a command that will be refused is no answer.
  if (const auto* requests = std::get_if<std::vector<JointRequest>>(&command)) {
    const Problems problems = simulator_.checkJoints(*requests);
    if (!problems.empty()) return refuse(topic, problems.front().text());
  }
  input.waiting.push_back(std::move(command));
  if (input.waiting.size() > kLongestWaiting) input.waiting.pop_front();
  if (input.waiting.size() > kLongestWaiting / 10 && queues_.due()) {
    ROS_WARN("lockstep: %zu commands wait on %s; send one for each odom message", input.waiting.size(),
             input.subscriber.getTopic().c_str());
  }
}

void CommandInput::apply(Topic topic, const Command& command) {
  if (const auto* drive = std::get_if<DriveCommand>(&command)) {
    simulator_.command(*drive);
    return;
  }
  const Problems problems = simulator_.commandJoints(std::get<std::vector<JointRequest>>(command));
  if (!problems.empty()) refuse(topic, problems.front().text());
}

void CommandInput::refuse(Topic topic, const std::string& reason) {
  ++dropped_;
  last_refusal_ = inputs_[topic].subscriber.getTopic() + ": " + reason;
  if (refusals_.due()) {
    ROS_WARN("%s: a command was dropped (%ld so far): %s", inputs_[topic].subscriber.getTopic().c_str(),
             static_cast<long>(dropped_), reason.c_str());
  }
}

bool CommandInput::isComplete() const {
  return std::all_of(inputs_.begin(), inputs_.end(),
                     [](const Input& input) { return !input.lockstep || !input.waiting.empty(); });
}

void CommandInput::takeOne() {
  for (int topic = 0; topic < kTopicCount; ++topic) {
    std::deque<Command>& waiting = inputs_[static_cast<std::size_t>(topic)].waiting;
    if (waiting.empty()) continue;
    apply(static_cast<Topic>(topic), waiting.front());
    waiting.pop_front();
  }
}

void CommandInput::takeAll() {
  const auto any = [](const Input& input) { return !input.waiting.empty(); };
  while (std::any_of(inputs_.begin(), inputs_.end(), any)) takeOne();
}

void CommandInput::clear() {
  for (Input& input : inputs_) input.waiting.clear();
}

std::string CommandInput::missing() const {
  std::string text;
  for (const Input& input : inputs_) {
    if (!input.lockstep || !input.waiting.empty()) continue;
    text += (text.empty() ? "'" : ", '") + input.subscriber.getTopic() + "' (" +
            std::to_string(input.subscriber.getNumPublishers()) + " publishers)";
  }
  return text;
}

void CommandInput::save(ByteWriter& out) const {
  const auto addOptional = [&out](const std::optional<double>& value) {
    out.add(static_cast<std::uint8_t>(value.has_value() ? 1 : 0));
    out.add(value.value_or(0.0));
  };
  for (const Input& input : inputs_) {
    out.add(static_cast<std::uint64_t>(input.waiting.size()));
    for (const Command& command : input.waiting) {
      out.add(static_cast<std::uint8_t>(command.index()));
      if (const auto* drive = std::get_if<DriveCommand>(&command)) {
        out.add(static_cast<std::uint8_t>(drive->kind));
        for (const double value : {drive->speed, drive->yaw_rate, drive->steering_angle, drive->steering_angle_velocity,
                                   drive->acceleration, drive->jerk}) {
          out.add(value);
        }
        continue;
      }
      const auto& requests = std::get<std::vector<JointRequest>>(command);
      out.add(static_cast<std::uint64_t>(requests.size()));
      for (const JointRequest& request : requests) {
        out.add(request.joint);
        addOptional(request.position);
        addOptional(request.velocity);
        addOptional(request.effort);
      }
    }
  }
}

bool CommandInput::restore(ByteReader& in) {
  const auto optionalNumber = [&in]() -> std::optional<double> {
    const bool given = in.byte() != 0;
    const double value = in.number();
    return given ? std::optional<double>(value) : std::nullopt;
  };
  std::array<std::deque<Command>, kTopicCount> waiting;
  for (auto& queue : waiting) {
    const std::uint64_t count = in.whole();
    if (count > kLongestWaiting) return false;
    for (std::uint64_t n = count; n > 0 && in.ok(); --n) {
      if (in.byte() == 0) {
        DriveCommand drive;
        drive.kind = static_cast<DriveCommand::Kind>(in.byte());
        if (drive.kind > DriveCommand::Kind::kCoast) return false;
        for (double* value : {&drive.speed, &drive.yaw_rate, &drive.steering_angle, &drive.steering_angle_velocity,
                              &drive.acceleration, &drive.jerk}) {
          *value = in.number();
        }
        queue.push_back(drive);
        continue;
      }
      std::vector<JointRequest> requests;
      for (std::uint64_t m = in.whole(); m > 0 && in.ok(); --m) {
        JointRequest request;
        request.joint = in.text();
        request.position = optionalNumber();
        request.velocity = optionalNumber();
        request.effort = optionalNumber();
        requests.push_back(request);
      }
      queue.push_back(requests);
    }
  }
  if (!in.ok()) return false;
  for (std::size_t i = 0; i < waiting.size(); ++i) inputs_[i].waiting = std::move(waiting[i]);
  return true;
}

}  // namespace ellipsoid_vehicle_sim
