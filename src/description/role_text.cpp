#include "role_text.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "ellipsoid_vehicle_sim/description/joint_roles.h"
#include "ellipsoid_vehicle_sim/description/number_text.h"

namespace ellipsoid_vehicle_sim {
namespace {

bool canPlay(const std::string& type, JointRole role) {
  const bool rotary = type == "continuous" || type == "revolute", moves = rotary || type == "prismatic";
  switch (role) {
    case JointRole::kLocked:
      return true;
    case JointRole::kDrive:
    case JointRole::kFreeWheel:
    case JointRole::kSteer:
      return rotary;
    case JointRole::kSuspension:
    case JointRole::kPassive:
    case JointRole::kPrescribed:
      return moves;
  }
  return false;
}

}  // namespace

std::string typeText(JointType type) {
  switch (type) {
    case JointType::kFixed:
      return "fixed";
    case JointType::kContinuous:
      return "continuous";
    case JointType::kRevolute:
      return "revolute";
    case JointType::kPrismatic:
      return "prismatic";
  }
  return "";
}

std::string axisText(const Eigen::Vector3d& axis) {
  const double one_degree = std::cos(M_PI / 180.0);
  int j = 0;
  if (axis.cwiseAbs().maxCoeff(&j) >= one_degree) return std::string(axis[j] < 0.0 ? "-" : "") + "xyz"[j];
  std::string text = "(";
  for (int i = 0; i < 3; ++i) text += (i ? ", " : "") + numberText(std::round(axis[i] * 1000.0) / 1000.0);
  return text + ")";
}

std::string limitsText(const JointDescription& joint) {
  return numberText(joint.lower) + " ... " + numberText(joint.upper);
}

std::string wheelCount(std::size_t count) { return std::to_string(count) + (count == 1 ? " wheel" : " wheels"); }

void checkHints(const RoleHints& hints, const std::vector<JointText>& joints, const std::string& file,
                Problems& problems) {
  const auto find = [&](const std::string& name) -> const JointText* {
    for (const JointText& j : joints) {
      if (j.joint.name == name) return &j;
    }
    return nullptr;
  };
  std::string known;
  for (const JointText& j : joints) {
    if (j.type != "fixed") known += (known.empty() ? "'" : ", '") + j.joint.name + "'";
  }
  const std::string allowed = "; allowed are the movable joints of the vehicle: " + (known.empty() ? "none" : known);
  for (const auto& [name, role] : hints.roles) {
    const JointText* joint = find(name);
    if (!joint) {
      problems.push_back({"parameter roles", "there is no joint '" + name + "'" + allowed});
    } else if (!canPlay(joint->type, role)) {
      problems.push_back({placeText(file, joint->joint.line, "joint", name),
                          "a " + joint->type + " joint cannot be '" + toString(role) + "', as parameter roles asks"});
    }
  }
  for (const std::string& name : hints.drive_joints) {
    const JointText* joint = find(name);
    if (!joint) {
      problems.push_back({"parameter drive_joints", "there is no joint '" + name + "'" + allowed});
    } else if (!canPlay(joint->type, JointRole::kDrive)) {
      problems.push_back({placeText(file, joint->joint.line, "joint", name),
                          "a " + joint->type + " joint cannot drive a wheel, as parameter drive_joints asks"});
    }
  }
}

std::vector<std::string> jointTable(const VehicleDescription& vehicle) {
  std::size_t name_width = 5, type_width = 4, role_width = 4;
  std::size_t fixed = 0;
  for (const JointDescription& j : vehicle.joints) {
    if (j.type == JointType::kFixed) {
      ++fixed;
      continue;
    }
    name_width = std::max(name_width, j.name.size());
    type_width = std::max(type_width, typeText(j.type).size());
    role_width = std::max(role_width, std::string(toString(j.role)).size());
  }
  const auto pad = [](std::string text, std::size_t width) { return text + std::string(width + 2 - text.size(), ' '); };
  std::vector<std::string> lines = {pad("joint", name_width) + pad("type", type_width) + pad("role", role_width) +
                                    "why"};
  for (const JointDescription& j : vehicle.joints) {
    if (j.type == JointType::kFixed) continue;
    lines.push_back(pad(j.name, name_width) + pad(typeText(j.type), type_width) + pad(toString(j.role), role_width) +
                    j.role_reason);
  }
  lines.push_back(std::to_string(fixed) + (fixed == 1 ? " fixed joint, " : " fixed joints, ") +
                  "layout: " + toString(vehicle.layout) +
                  (vehicle.layout_text == toString(vehicle.layout) ? "" : " (" + vehicle.layout_text + ")"));
  if (vehicle.forward_yaw != 0.0)
    lines.push_back("forward: " + axisText({std::cos(vehicle.forward_yaw), std::sin(vehicle.forward_yaw), 0.0}) +
                    " of the root link; axes above are as seen looking forward");
  return lines;
}

}  // namespace ellipsoid_vehicle_sim
