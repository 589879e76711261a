#include "xml_reader.h"

#include "ellipsoid_vehicle_sim/description/number_text.h"

namespace ellipsoid_vehicle_sim {

std::string placeText(const std::string& file, int line, const std::string& what, const std::string& name) {
  std::string place = file;
  if (line > 0) place += ":" + std::to_string(line);
  if (!what.empty()) place += " " + what;
  if (!name.empty()) place += " '" + name + "'";
  return place;
}

std::string attributeText(const tinyxml2::XMLElement& element, const char* attribute) {
  const char* value = element.Attribute(attribute);
  return "<" + std::string(element.Name()) + " " + attribute + "=\"" + (value ? value : "") + "\">";
}

int countChildren(const tinyxml2::XMLElement& parent, const char* name) {
  int count = 0;
  for (auto* e = parent.FirstChildElement(name); e; e = e->NextSiblingElement(name)) ++count;
  return count;
}

void XmlReader::problem(int line, const std::string& message) {
  problems_.push_back({placeText(file_, line, what_, name_), message});
  ok_ = false;
}

void XmlReader::note(int line, const std::string& message) {
  notes_.push_back(placeText(file_, line, what_, name_) + ": " + message);
}

std::optional<std::string> XmlReader::text(const tinyxml2::XMLElement& element, const char* attribute) {
  const char* value = element.Attribute(attribute);
  if (value && *value) return std::string(value);
  problem(element.GetLineNum(), "<" + std::string(element.Name()) + "> has no " + attribute + "; it needs one");
  return std::nullopt;
}

std::optional<double> XmlReader::checked(const tinyxml2::XMLElement& element, const char* attribute, const char* text,
                                         const Allowed& allowed) {
  const auto value = parseNumber(text);
  if (value && *value >= allowed.min && *value <= allowed.max) return value;
  problem(element.GetLineNum(), attributeText(element, attribute) + (value ? " is out of range" : " is no number") +
                                    "; allowed is " + allowed.text);
  return std::nullopt;
}

std::optional<double> XmlReader::number(const tinyxml2::XMLElement& element, const char* attribute,
                                        const Allowed& allowed) {
  if (const char* text = element.Attribute(attribute)) return checked(element, attribute, text, allowed);
  problem(element.GetLineNum(),
          "<" + std::string(element.Name()) + "> has no " + attribute + "; it needs " + allowed.text);
  return std::nullopt;
}

std::optional<double> XmlReader::optionalNumber(const tinyxml2::XMLElement& element, const char* attribute,
                                                const Allowed& allowed) {
  const char* text = element.Attribute(attribute);
  return text ? checked(element, attribute, text, allowed) : std::nullopt;
}

std::optional<Eigen::Vector3d> XmlReader::vector(const tinyxml2::XMLElement& element, const char* attribute,
                                                 const Allowed& allowed) {
  const char* text = element.Attribute(attribute);
  if (!text) {
    problem(element.GetLineNum(), "<" + std::string(element.Name()) + "> has no " + attribute +
                                      "; it needs three numbers, each " + allowed.text);
    return std::nullopt;
  }
  const auto numbers = parseNumberList(text);
  std::string wrong;
  if (!numbers) {
    wrong = " holds something that is no number";
  } else if (numbers->size() != 3) {
    wrong = " holds " + std::to_string(numbers->size()) + " number" + (numbers->size() == 1 ? "" : "s");
  } else {
    for (double n : *numbers) {
      if (n < allowed.min || n > allowed.max) wrong = " holds " + numberText(n) + ", out of range";
    }
  }
  if (wrong.empty()) return Eigen::Vector3d((*numbers)[0], (*numbers)[1], (*numbers)[2]);
  problem(element.GetLineNum(),
          attributeText(element, attribute) + wrong + "; allowed are three numbers, each " + allowed.text);
  return std::nullopt;
}

Pose XmlReader::origin(const tinyxml2::XMLElement& parent) {
  Pose pose;
  const tinyxml2::XMLElement* element = parent.FirstChildElement("origin");
  if (!element) return pose;
  if (element->Attribute("xyz")) {
    if (const auto xyz = vector(*element, "xyz", kAnyLength)) pose.p = *xyz;
  }
  if (element->Attribute("rpy")) {
    if (const auto rpy = vector(*element, "rpy", kAnyNumber)) {
      pose.q = quaternionFromRpy(rpy->x(), rpy->y(), rpy->z()).normalized();
    }
  }
  return pose;
}

}  // namespace ellipsoid_vehicle_sim
