#include <cstring>
#include <set>

#include "ellipsoid_vehicle_sim/description/number_text.h"
#include "xml_reader.h"

namespace ellipsoid_vehicle_sim {
namespace {

using tinyxml2::XMLElement;

std::optional<LimitText> readLimit(const XMLElement& element, XmlReader& reader) {
  LimitText limit;
  limit.line = element.GetLineNum();
  limit.lower = reader.optionalNumber(element, "lower", kAnyLimit);
  limit.upper = reader.optionalNumber(element, "upper", kAnyLimit);
  // Both are asked for by urdfdom, and with it by every ROS tool: a limit without them loads nowhere.
  const auto effort = reader.number(element, "effort", kNotNegative);
  const auto velocity = reader.number(element, "velocity", kNotNegative);
  if (limit.lower && limit.upper && *limit.lower > *limit.upper) {
    reader.problem(limit.line, "<limit> reads lower=" + numberText(*limit.lower) +
                                   " above upper=" + numberText(*limit.upper) + "; allowed is lower <= upper");
  }
  if (!effort || !velocity) return std::nullopt;
  limit.effort = *effort;
  limit.velocity = *velocity;
  return limit;
}

void readDynamics(const XMLElement& element, XmlReader& reader, JointDescription& joint) {
  joint.damping = reader.optionalNumber(element, "damping", kNotNegative).value_or(0.0);
  joint.friction = reader.optionalNumber(element, "friction", kNotNegative).value_or(0.0);
  joint.spring_stiffness = reader.optionalNumber(element, "spring_stiffness", kNotNegative);
  joint.spring_reference = reader.optionalNumber(element, "spring_reference", kAnyNumber);
}

std::optional<JointMimic> readMimic(const XMLElement& element, XmlReader& reader) {
  JointMimic mimic;
  const auto joint = reader.text(element, "joint");
  mimic.multiplier = reader.optionalNumber(element, "multiplier", kAnyNumber).value_or(1.0);
  mimic.offset = reader.optionalNumber(element, "offset", kAnyNumber).value_or(0.0);
  if (!joint) return std::nullopt;
  mimic.joint = *joint;
  return mimic;
}

std::string readLinkName(const XMLElement& joint, const char* tag, XmlReader& reader) {
  const XMLElement* element = joint.FirstChildElement(tag);
  if (!element) {
    reader.problem(joint.GetLineNum(), "the joint has no <" + std::string(tag) + ">; it needs one");
    return {};
  }
  return reader.text(*element, "link").value_or("");
}

void checkType(const XMLElement& element, const std::string& type, XmlReader& reader) {
  const std::set<std::string> known = {"fixed", "continuous", "revolute", "prismatic"};
  if (known.count(type)) return;
  const std::string allowed = "; allowed are fixed, continuous, revolute, prismatic";
  if (type == "floating" || type == "planar") {
    reader.problem(element.GetLineNum(), "joint type \"" + type +
                                             "\" is not simulated: a vehicle floats by itself, and is"
                                             " moved by its wheels" +
                                             allowed);
  } else {
    reader.problem(element.GetLineNum(), "unknown joint type \"" + type + "\"" + allowed);
  }
}

/// The value of <springStiffness>12</springStiffness> or <springStiffness value="12"/>.
std::optional<double> gazeboNumber(const XMLElement& parent, const char* tag, const Allowed& allowed,
                                   XmlReader& reader) {
  const XMLElement* element = parent.FirstChildElement(tag);
  if (!element) return std::nullopt;
  if (element->Attribute("value")) return reader.number(*element, "value", allowed);
  const char* text = element->GetText();
  const auto value = parseNumber(text ? text : "");
  if (value && *value >= allowed.min && *value <= allowed.max) return value;
  reader.problem(element->GetLineNum(),
                 "<" + std::string(tag) + "> reads \"" + (text ? text : "") + "\"; allowed is " + allowed.text);
  return std::nullopt;
}

/// A number of a surface; one that cannot be read is no reason to refuse what other programs take.
std::optional<double> surfaceNumber(const XMLElement& parent, const char* tag, XmlReader& reader) {
  const XMLElement* element = parent.FirstChildElement(tag);
  if (!element) return std::nullopt;
  const char* text = element->Attribute("value") ? element->Attribute("value") : element->GetText();
  const auto value = parseNumber(text ? text : "");
  if (value && *value >= 0.0) return value;
  reader.note(element->GetLineNum(), "<" + std::string(tag) + "> reads \"" + (text ? text : "") +
                                         "\", which makes no physical sense (a number >= 0 would): it is ignored");
  return std::nullopt;
}

}  // namespace

JointText readJoint(const XMLElement& element, const std::string& file, Problems& problems,
                    std::vector<std::string>& notes) {
  JointText result;
  JointDescription& joint = result.joint;
  joint.line = element.GetLineNum();
  const char* name = element.Attribute("name");
  joint.name = name ? name : "";
  XmlReader reader(file, "joint", joint.name, problems, notes);
  if (joint.name.empty()) reader.problem(joint.line, "the joint has no name; it needs one");
  if (const auto type = reader.text(element, "type")) {
    result.type = *type;
    checkType(element, *type, reader);
  }
  joint.parent = readLinkName(element, "parent", reader);
  joint.child = readLinkName(element, "child", reader);
  joint.X_PJ = reader.origin(element);
  if (const XMLElement* axis = element.FirstChildElement("axis")) {
    result.axis_line = axis->GetLineNum();
    if (axis->Attribute("xyz")) result.axis = reader.vector(*axis, "xyz", kAnyNumber);
  }
  if (const XMLElement* limit = element.FirstChildElement("limit")) result.limit = readLimit(*limit, reader);
  if (const XMLElement* dynamics = element.FirstChildElement("dynamics")) readDynamics(*dynamics, reader, joint);
  if (const XMLElement* mimic = element.FirstChildElement("mimic")) {
    result.mimic_line = mimic->GetLineNum();
    joint.mimic = readMimic(*mimic, reader);
  }
  const std::set<std::string> known = {"origin",      "parent",           "child", "axis", "limit", "dynamics", "mimic",
                                       "calibration", "safety_controller"};
  for (auto* e = element.FirstChildElement(); e; e = e->NextSiblingElement()) {
    if (known.count(e->Name()) == 0) reader.note(e->GetLineNum(), "<" + std::string(e->Name()) + "> is ignored");
  }
  result.complete = reader.ok();
  return result;
}

void readTransmission(const XMLElement& element, std::vector<TransmissionText>& transmissions) {
  for (auto* joint = element.FirstChildElement("joint"); joint; joint = joint->NextSiblingElement("joint")) {
    const char* name = joint->Attribute("name");
    if (!name) continue;
    TransmissionText transmission{name, joint->GetLineNum(), false, "<transmission>"};
    for (auto* i = joint->FirstChildElement("hardwareInterface"); i; i = i->NextSiblingElement("hardwareInterface")) {
      const char* text = i->GetText();
      if (text && std::string(text).find("VelocityJointInterface") != std::string::npos) {
        transmission.velocity_interface = true;
      }
    }
    transmissions.push_back(transmission);
  }
}

void readRos2Control(const XMLElement& element, std::vector<TransmissionText>& transmissions) {
  for (auto* joint = element.FirstChildElement("joint"); joint; joint = joint->NextSiblingElement("joint")) {
    const char* name = joint->Attribute("name");
    const XMLElement* command = joint->FirstChildElement("command_interface");
    if (!name || !command) continue;
    bool velocity = false;
    for (; command; command = command->NextSiblingElement("command_interface"))
      velocity |= command->Attribute("name", "velocity") != nullptr;
    transmissions.push_back({name, joint->GetLineNum(), velocity, "<ros2_control>"});
  }
}

/// The joints that Gazebo's plugin of a drive is told to turn: <leftJoint>, <right_joint>, <frontLeftJoint>, ...
void readDrivePlugins(const XMLElement& gazebo, std::vector<TransmissionText>& transmissions) {
  for (auto* plugin = gazebo.FirstChildElement("plugin"); plugin; plugin = plugin->NextSiblingElement("plugin")) {
    const char* file = plugin->Attribute("filename");
    if (!file || !std::strstr(file, "drive")) continue;
    for (auto* e = plugin->FirstChildElement(); e; e = e->NextSiblingElement()) {
      const std::string tag = e->Name();
      const bool side = tag.find("eft") != std::string::npos || tag.find("ight") != std::string::npos ||
                        tag.find("wheel") != std::string::npos || tag.find("actuated") != std::string::npos;
      const bool joint = tag.find("oint") != std::string::npos && tag.find("steer") == std::string::npos;
      if (side && joint && e->GetText())
        transmissions.push_back({e->GetText(), e->GetLineNum(), true, "drive plugin"});
    }
  }
}

void readGazebo(const XMLElement& element, const std::string& file, std::vector<GazeboJointText>& gazebo,
                std::vector<GazeboLinkText>& surfaces, Problems& problems, std::vector<std::string>& notes) {
  const char* reference = element.Attribute("reference");
  if (!reference) return;
  XmlReader reader(file, "gazebo", reference, problems, notes);
  GazeboJointText joint;
  joint.joint = reference;
  joint.line = element.GetLineNum();
  joint.spring_stiffness = gazeboNumber(element, "springStiffness", kNotNegative, reader);
  joint.spring_reference = gazeboNumber(element, "springReference", kAnyNumber, reader);
  if (joint.spring_stiffness || joint.spring_reference) gazebo.push_back(joint);
  GazeboLinkText surface{reference, element.GetLineNum(), {}, {}, {}, {}};
  surface.mu1 = surfaceNumber(element, "mu1", reader);
  surface.mu2 = surfaceNumber(element, "mu2", reader);
  surface.kp = surfaceNumber(element, "kp", reader);
  surface.kd = surfaceNumber(element, "kd", reader);
  if (surface.mu1 || surface.mu2 || surface.kp || surface.kd) surfaces.push_back(surface);
}

}  // namespace ellipsoid_vehicle_sim
