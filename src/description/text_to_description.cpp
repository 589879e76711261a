#include "text_to_description.h"

#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "ellipsoid_vehicle_sim/description/inertia_check.h"
#include "ellipsoid_vehicle_sim/description/number_text.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

JointType typeOf(const std::string& type) {
  if (type == "continuous") return JointType::kContinuous;
  if (type == "revolute") return JointType::kRevolute;
  if (type == "prismatic") return JointType::kPrismatic;
  return JointType::kFixed;  // also for what was refused
}

/// Puts the problems and notes of one joint or link in its name.
struct Place {
  const std::string& file;
  const char* what;
  const std::string& name;
  Problems& problems;
  std::vector<std::string>& notes;

  void problem(int line, const std::string& message) const {
    problems.push_back({placeText(file, line, what, name), message});
  }
  void note(int line, const std::string& message) const {
    notes.push_back(placeText(file, line, what, name) + ": " + message);
  }
};

Eigen::Vector3d axisOf(const JointText& text, const Place& place) {
  if (!text.axis) {
    if (text.complete) place.note(text.joint.line, "no <axis xyz=...>: taken is 1 0 0, as URDF says");
    return Eigen::Vector3d::UnitX();
  }
  const double size = text.axis->cwiseAbs().maxCoeff();
  if (size < 1e-9) {
    place.problem(text.axis_line, "<axis xyz=\"" + numberText(text.axis->x()) + " " + numberText(text.axis->y()) + " " +
                                      numberText(text.axis->z()) +
                                      "\"> has no direction; allowed is a vector longer than 1e-9");
    return Eigen::Vector3d::UnitX();
  }
  return (*text.axis / size).normalized();
}

void applyLimits(const JointText& text, const Place& place, JointDescription& joint) {
  if (!text.limit) {
    if (joint.type != JointType::kContinuous && text.complete) {
      place.problem(joint.line,
                    "a " + text.type + " joint has no <limit>; it needs one with lower, upper, effort, velocity");
    }
    return;
  }
  const LimitText& limit = *text.limit;
  if (joint.type == JointType::kContinuous) {
    // Steering joints come as "continuous" with limits; 0 and 0 from tools that write every attribute.
    const bool both = limit.lower && limit.upper;
    if (both && *limit.lower < *limit.upper) {
      joint.lower = *limit.lower;
      joint.upper = *limit.upper;
      place.note(limit.line, "a continuous joint with lower and upper: they are kept as limits");
    } else if (limit.lower || limit.upper) {
      place.note(limit.line, "a continuous joint whose limits leave no range: taken as unlimited");
    }
  } else {
    joint.lower = limit.lower.value_or(0.0);  // URDF's default
    joint.upper = limit.upper.value_or(0.0);
    if (joint.lower > joint.upper && !(limit.lower && limit.upper)) {
      place.problem(limit.line, "<limit> gives " + std::string(limit.lower ? "lower=" : "upper=") +
                                    numberText(limit.lower ? *limit.lower : *limit.upper) +
                                    " and the other is 0 by default; allowed is lower <= upper");
    }
  }
  constexpr double kUnlimited = 1e6;  // a million radians or metres are no stop
  if (joint.lower <= -kUnlimited) joint.lower = -kInfinity;
  if (joint.upper >= kUnlimited) joint.upper = kInfinity;
  if (limit.effort > 0.0) joint.effort_limit = limit.effort;
  if (limit.velocity > 0.0) joint.velocity_limit = limit.velocity;
}

JointDescription describeJoint(const JointText& text, const std::string& file, Problems& problems,
                               std::vector<std::string>& notes) {
  JointDescription joint = text.joint;
  const Place place{file, "joint", joint.name, problems, notes};
  joint.type = typeOf(text.type);
  if (joint.type == JointType::kFixed) {
    if (joint.mimic) place.note(text.mimic_line, "<mimic> on a fixed joint is ignored");
    joint.mimic.reset();
    return joint;
  }
  joint.axis = axisOf(text, place);
  applyLimits(text, place, joint);
  return joint;
}

LinkDescription describeLink(const LinkText& text, const std::string& file, Problems& problems,
                             std::vector<std::string>& notes) {
  LinkDescription link;
  link.name = text.name;
  link.line = text.line;
  if (!text.inertial) return link;
  const InertialText& inertial = *text.inertial;
  const Place place{file, "link", link.name, problems, notes};
  link.inertial_line = inertial.line;
  if (inertial.mass == 0.0) {
    if (inertial.inertia.cwiseAbs().maxCoeff() > 0.0) {
      place.note(inertial.line, "mass 0 with an inertia: the inertia is ignored, what weighs nothing resists nothing");
    }
    return link;
  }
  // Whether that is a reason to refuse the file depends on what is fixed to the link: the lint says.
  link.inertia_fault = inertiaFault(inertial.inertia);
  link.mass = inertial.mass;
  link.p_Lcm = inertial.X_LI.p;
  const Eigen::Matrix3d R = inertial.X_LI.q.toRotationMatrix();
  link.I_cm_L = R * inertial.inertia * R.transpose();
  link.I_cm_L = (0.5 * (link.I_cm_L + link.I_cm_L.transpose())).eval();  // symmetric to the last bit
  return link;
}

/// Mimics that lead nowhere or in a circle.
void checkMimics(const UrdfText& urdf, const std::string& file, Problems& problems) {
  std::map<std::string, const JointText*> joints;
  for (const JointText& j : urdf.joints) joints.emplace(j.joint.name, &j);
  for (const JointText& j : urdf.joints) {
    if (!j.joint.mimic) continue;
    const std::string place = placeText(file, j.mimic_line, "joint", j.joint.name);
    if (joints.count(j.joint.mimic->joint) == 0) {
      problems.push_back(
          {place, "it mimics '" + j.joint.mimic->joint + "', which does not exist; allowed is a joint of this file"});
      continue;
    }
    std::set<std::string> seen = {j.joint.name};
    const JointText* next = joints.at(j.joint.mimic->joint);
    while (next && seen.insert(next->joint.name).second) {
      const auto found = next->joint.mimic ? joints.find(next->joint.mimic->joint) : joints.end();
      next = found == joints.end() ? nullptr : found->second;
    }
    if (next && next->joint.name == j.joint.name) {
      problems.push_back({place, "it mimics '" + j.joint.mimic->joint +
                                     "', which in the end mimics it; allowed is a joint that moves by itself"});
    }
  }
}

/// <gazebo reference="joint"> springs, where <dynamics> says nothing. A stiffness of 0 is Gazebo's word for "no
/// spring".
void addGazeboSprings(const UrdfText& urdf, VehicleDescription& vehicle) {
  for (const GazeboJointText& g : urdf.gazebo_joints) {
    for (JointDescription& joint : vehicle.joints) {
      if (joint.name != g.joint || joint.type == JointType::kFixed || joint.spring_stiffness) continue;
      if (!g.spring_stiffness || *g.spring_stiffness == 0.0) continue;
      joint.spring_stiffness = g.spring_stiffness;
      if (!joint.spring_reference) joint.spring_reference = g.spring_reference;
    }
  }
}

}  // namespace

VehicleDescription describe(const UrdfText& urdf, const TreeOrder& order, const std::string& file, Problems& problems,
                            std::vector<std::string>& notes) {
  VehicleDescription vehicle;
  vehicle.name = urdf.name;
  vehicle.file = file;
  vehicle.root = urdf.links[order.links.front()].name;
  for (int l : order.links) vehicle.links.push_back(describeLink(urdf.links[l], file, problems, notes));
  for (int j : order.joints) vehicle.joints.push_back(describeJoint(urdf.joints[j], file, problems, notes));
  checkMimics(urdf, file, problems);
  addGazeboSprings(urdf, vehicle);
  return vehicle;
}

void checkJointsAndInertias(const UrdfText& urdf, const std::string& file, Problems& problems,
                            std::vector<std::string>& notes) {
  for (const LinkText& link : urdf.links) {
    const LinkDescription described = describeLink(link, file, problems, notes);
    if (!described.inertia_fault.empty())
      problems.push_back({placeText(file, described.inertial_line, "link", link.name), described.inertia_fault});
  }
  for (const JointText& joint : urdf.joints) describeJoint(joint, file, problems, notes);
  checkMimics(urdf, file, problems);
}

void checkMasses(const VehicleDescription& vehicle, const UrdfText& urdf, const std::map<std::string, JointRole>& roles,
                 bool repair, Problems& problems) {
  std::map<std::string, const LinkText*> texts;
  for (const LinkText& link : urdf.links) texts.emplace(link.name, &link);
  const std::vector<int> parents = parentLinks(vehicle);
  for (std::size_t l = 0; l < vehicle.links.size(); ++l) {
    const JointDescription* joint = l == 0 ? nullptr : &vehicle.joints[l - 1];
    if (joint) {
      const auto role = roles.find(joint->name);
      if (joint->type == JointType::kFixed || (role != roles.end() && role->second == JointRole::kLocked)) continue;
    }
    double mass = 0.0;
    bool shapes = false, complete = true;
    for (const GroupedLink& g : rigidGroup(vehicle, parents, static_cast<int>(l))) {
      const LinkText& text = *texts.at(vehicle.links[g.link].name);
      mass += text.inertial ? text.inertial->mass : 0.0;
      shapes = shapes || text.collision_count > 0;
      complete = complete && text.complete;
    }
    if (mass > 0.0 || !complete || repair) continue;  // a mass that could not be read is a problem already
    const std::string place = placeText(vehicle.file, vehicle.links[l].line, "link", vehicle.links[l].name);
    const std::string allowed = "; allowed is an <inertial> with a mass > 0 kg and its inertia";
    if (!joint) {
      problems.push_back({place, "the root link and what is fixed to it weigh 0 kg" + allowed});
    } else if (shapes) {
      problems.push_back({place, "it moves on joint '" + joint->name + "', collides, and weighs 0 kg" + allowed});
    }
  }
}

void noteEffortLimits(const VehicleDescription& vehicle, const UrdfText& urdf, std::vector<std::string>& notes) {
  std::set<std::string> zero_effort, zero_velocity;
  for (const JointText& j : urdf.joints) {
    if (j.type == "fixed" || !j.limit) continue;
    if (j.limit->effort == 0.0) zero_effort.insert(j.joint.name);
    if (j.limit->velocity == 0.0) zero_velocity.insert(j.joint.name);
  }
  std::string efforts, velocities, none;
  for (const JointDescription& joint : vehicle.joints) {
    const auto add = [&](std::string& list) { list += (list.empty() ? "'" : ", '") + joint.name + "'"; };
    if (zero_effort.count(joint.name))
      add(efforts);
    else if (joint.role == JointRole::kDrive && joint.effort_limit == kInfinity)
      add(none);
    if (zero_velocity.count(joint.name)) add(velocities);
  }
  if (!efforts.empty()) notes.push_back(vehicle.file + ": effort=\"0\" on joints " + efforts + ": taken as unlimited");
  if (!velocities.empty())
    notes.push_back(vehicle.file + ": velocity=\"0\" on joints " + velocities + ": taken as unlimited");
  if (!none.empty())
    notes.push_back(vehicle.file + ": no <limit effort=...> on the driven joints " + none + ": unlimited");
}

}  // namespace ellipsoid_vehicle_sim
