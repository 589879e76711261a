// Requests for single joints: what each joint can be asked for, and why not.

#include <cmath>
#include <cstdio>
#include <set>

#include "ellipsoid_vehicle_sim/vehicle/drive.h"

namespace ellipsoid_vehicle_sim {
namespace {

std::string refusalOf(const JointRequest& request) {
  if (!request.position && !request.velocity && !request.effort)
    return "no position, velocity or effort is given for it";
  for (const auto& value : {request.position, request.velocity, request.effort}) {
    if (value && !std::isfinite(*value)) return "is asked for " + std::to_string(*value) + ", which is not finite";
    if (value && std::abs(*value) > kLargestCommand) {
      char text[32];
      std::snprintf(text, sizeof text, "%.3g", *value);
      return std::string("is asked for ") + text + "; allowed is up to 1e9, up or down";
    }
  }
  return "";
}

// Why a joint that is neither a motor nor on a path takes no request.
std::string refusalOf(const VehicleModel& model, const std::string& name) {
  std::string known;
  for (const JointDescription& joint : model.description.joints) {
    if (joint.name == name)
      return std::string("is ") + toString(joint.role) +
             ": it has no motor and is on no path, so nothing can be asked of it";
    const bool commanded =
        joint.role == JointRole::kDrive || joint.role == JointRole::kSteer || joint.role == JointRole::kPrescribed;
    if (commanded) known += (known.empty() ? "" : ", ") + joint.name;
  }
  return "there is no such joint; those that can be asked for something are: " + (known.empty() ? "none" : known);
}

std::string takeForMotor(const DriveModel& drive, const JointRequest& request, DriveState& state) {
  JointCommand command;
  int units = 0;
  for (const WheelUnit& wheel : drive.wheels) {
    if (wheel.name != request.joint) continue;
    ++units;
    if (wheel.tread >= 0 && request.effort)
      return "turns without mass (solid_compound): only its velocity can be asked for";
  }
  if (request.velocity) {
    command.kind = JointCommand::Kind::kVelocity;
    command.value = *request.velocity;
    command.effort = request.effort.value_or(0.0) / units;
  } else if (request.effort) {
    command.kind = JointCommand::Kind::kEffort;
    command.value = *request.effort / units;
  } else {
    return "is a wheel: its velocity or effort can be asked for, not its position";
  }
  for (const WheelUnit& wheel : drive.wheels)
    if (wheel.name == request.joint) state.wheel_command[wheel.unit] = command;
  return "";
}

std::string takeForPath(const JointRequest& request, JointCommand& command) {
  if (!request.position && !request.velocity)
    return "follows a path: its position or velocity can be asked for, not effort";
  command = JointCommand{};
  command.kind = request.position ? JointCommand::Kind::kPosition : JointCommand::Kind::kVelocity;
  command.value = request.position ? *request.position : *request.velocity;
  return "";
}

}  // namespace

std::string countRefusal(const VehicleModel& model, std::size_t count) {
  const std::size_t joints = model.description.joints.size();
  if (count == 0) return "names no joint";
  if (count <= joints) return "";
  return "names " + std::to_string(count) + " joints; the vehicle has " + std::to_string(joints) +
         ", and each can be named once";
}

Problems takeJointRequests(const VehicleModel& model, const std::vector<JointRequest>& requests, DriveState& drive) {
  Problems problems;
  if (const std::string refusal = countRefusal(model, requests.size()); !refusal.empty())
    return {{"joint command", refusal}};
  std::vector<JointCommand> wheels = drive.wheel_command, profiles = drive.profile_command;
  std::set<std::string> seen;
  for (const JointRequest& request : requests) {
    std::string refusal = refusalOf(request);
    if (!seen.insert(request.joint).second) refusal = "is named twice";
    int prescribed = -1;
    for (std::size_t p = 0; p < model.prescribed_joints.size(); ++p)
      if (model.description.joints[model.prescribed_joints[p].description].name == request.joint)
        prescribed = static_cast<int>(p);
    bool motor = false;
    for (const WheelUnit& wheel : model.drive.wheels) motor = motor || (wheel.driven && wheel.name == request.joint);

    if (refusal.empty()) {
      const int leader = prescribed >= 0 ? model.prescribed_joints[prescribed].leader : -1;
      refusal = leader >= 0 ? "mimics '" + model.description.joints[model.prescribed_joints[leader].description].name +
                                  "': ask that one"
                : prescribed >= 0 ? takeForPath(request, drive.profile_command[prescribed])
                : motor         ? takeForMotor(model.drive, request, drive)
                                : refusalOf(model, request.joint);
    }
    if (!refusal.empty()) problems.push_back({"joint '" + request.joint + "'", refusal});
  }
  if (!problems.empty()) {
    drive.wheel_command = std::move(wheels);
    drive.profile_command = std::move(profiles);
  }
  return problems;
}

}  // namespace ellipsoid_vehicle_sim
