#include "ellipsoid_vehicle_sim/description/urdf_text.h"

#include <algorithm>
#include <set>

#include "ellipsoid_vehicle_sim/description/number_text.h"
#include "xml_reader.h"

namespace ellipsoid_vehicle_sim {
namespace {

using tinyxml2::XMLElement;

const char* const kXacroHint = "run it through xacro first, the simulator reads plain URDF";

bool isBlankText(const std::string& text) { return text.find_first_not_of(" \t\r\n") == std::string::npos; }

/// What a text is that is no XML at all; empty if it may be XML.
std::string notXmlReason(const std::string& text) {
  if (isBlankText(text)) return "the file is empty; allowed is a URDF";
  if (isGitLfsPointer(text))
    return "this is a git-LFS pointer, not the file itself; run 'git lfs pull' where it came from";
  if (text.find('\0') != std::string::npos) return "the file holds zero bytes, so it is no text; allowed is a URDF";
  // urdfdom's XML reader (TinyXML 2.6) waits for ever for the rest of such a character.
  if (text.find('\xef', text.size() < 2 ? 0 : text.size() - 2) != std::string::npos)
    return "the file ends in the middle of a character (byte 0xef); allowed is a URDF";
  return {};
}

/// tinyxml2's "Error=XML_ERROR_MISMATCHED_ELEMENT ErrorID=14 (0xe) Line number=7: XMLElement name=link", for people.
std::string xmlErrorText(const tinyxml2::XMLDocument& document) {
  std::string error = document.ErrorName();
  const std::string prefix = "XML_ERROR_";
  if (error.compare(0, prefix.size(), prefix) == 0) error = error.substr(prefix.size());
  for (char& c : error) c = c == '_' ? ' ' : static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  const std::string whole = document.ErrorStr() ? document.ErrorStr() : "";
  const auto detail = whole.rfind(": ");
  if (detail != std::string::npos) error += " (" + whole.substr(detail + 2) + ")";
  return error;
}

bool hasXacroExpression(const char* text) {
  if (!text) return false;
  const std::string s = text;
  return s.find("${") != std::string::npos || s.find("$(") != std::string::npos;
}

/// One walk over all elements for what urdfdom and xacro would trip over.
class LeftoverSearch {
 public:
  LeftoverSearch(const std::string& file, Problems& problems) : file_(file), problems_(problems) {}

  void visit(const XMLElement& element) {
    if (std::string(element.Name()).compare(0, 6, "xacro:") == 0) {
      found(element.GetLineNum(), "<" + std::string(element.Name()) + ">");
    }
    for (auto* a = element.FirstAttribute(); a; a = a->Next()) {
      if (hasXacroExpression(a->Value())) found(a->GetLineNum(), attributeText(element, a->Name()));
    }
    if (hasXacroExpression(element.GetText())) found(element.GetLineNum(), element.GetText());
    for (auto* e = element.FirstChildElement(); e; e = e->NextSiblingElement()) visit(*e);
  }

  /// One problem for all of them: each is the same mistake.
  void report() const {
    if (count_ == 0) return;
    std::string message = "xacro was not run on this file: it still holds " + first_;
    if (count_ > 1) message += " and " + std::to_string(count_ - 1) + " more of the kind";
    problems_.push_back({placeText(file_, line_, "", ""), message + "; " + kXacroHint});
  }

  int count() const { return count_; }

 private:
  void found(int line, const std::string& what) {
    if (count_++ == 0) line_ = line, first_ = what;
  }

  const std::string& file_;
  Problems& problems_;
  int count_ = 0, line_ = 0;
  std::string first_;
};

std::optional<ShapeText> readGeometry(const XMLElement& geometry, bool collision, XmlReader& reader) {
  const XMLElement* element = geometry.FirstChildElement();
  if (!element) {
    reader.problem(geometry.GetLineNum(), "<geometry> is empty; it needs one of box, cylinder, sphere, mesh");
    return std::nullopt;
  }
  const std::set<std::string> shapes = {"box", "cylinder", "sphere", "mesh", "capsule", "ellipsoid", "plane"};
  for (const XMLElement* other = element->NextSiblingElement(); other; other = other->NextSiblingElement()) {
    const std::string name = other->Name();
    if (shapes.count(name) == 0)
      reader.note(other->GetLineNum(), "<" + name + "> inside <geometry> is ignored, as by every ROS tool");
  }
  const XMLElement* second = element->NextSiblingElement();
  while (second && shapes.count(second->Name()) == 0) second = second->NextSiblingElement();
  if (second) {
    reader.problem(second->GetLineNum(),
                   "<geometry> holds a second shape <" + std::string(second->Name()) +
                       ">; allowed is one, put the other in a <collision> or <visual> of its own");
    return std::nullopt;
  }
  ShapeText shape;
  shape.line = element->GetLineNum();
  const std::string kind = element->Name();
  if (kind == "box") {
    shape.kind = ShapeText::Kind::kBox;
    const auto size = reader.vector(*element, "size", kPositiveLength);
    if (!size) return std::nullopt;
    shape.size = *size;
  } else if (kind == "cylinder") {
    shape.kind = ShapeText::Kind::kCylinder;
    const auto radius = reader.number(*element, "radius", kPositiveLength);
    const auto length = reader.number(*element, "length", kPositiveLength);
    if (!radius || !length) return std::nullopt;
    shape.size = {*radius, *length, 0.0};
  } else if (kind == "sphere") {
    shape.kind = ShapeText::Kind::kSphere;
    const auto radius = reader.number(*element, "radius", kPositiveLength);
    if (!radius) return std::nullopt;
    shape.size = {*radius, 0.0, 0.0};
  } else if (kind == "mesh") {
    shape.kind = ShapeText::Kind::kMesh;
    const auto filename = reader.text(*element, "filename");
    if (!filename) return std::nullopt;
    shape.filename = *filename;
    if (element->Attribute("scale")) {
      // Mirrored pictures are common and harmless; a mirrored or flat collision shape is refused.
      const auto scale = reader.vector(*element, "scale", collision ? kPositiveScale : kAnyNumber);
      if (!scale) return std::nullopt;
      shape.scale = *scale;
    }
  } else {
    reader.problem(element->GetLineNum(), "unknown shape <" + kind + ">; allowed are box, cylinder, sphere, mesh" +
                                              " (an ellipsoid is a mesh unit_sphere.stl with its semi-axes as scale)");
    return std::nullopt;
  }
  return shape;
}

std::optional<ShapeText> readShape(const XMLElement& parent, bool collision, XmlReader& reader) {
  const Pose X_LS = reader.origin(parent);
  const XMLElement* geometry = parent.FirstChildElement("geometry");
  if (!geometry) {
    reader.problem(parent.GetLineNum(), "<" + std::string(parent.Name()) + "> has no <geometry>; it needs one");
    return std::nullopt;
  }
  auto shape = readGeometry(*geometry, collision, reader);
  if (shape) shape->X_LS = X_LS;
  return shape;
}

std::optional<InertialText> readInertial(const XMLElement& element, bool accept_negative_mass, XmlReader& reader) {
  InertialText inertial;
  inertial.line = element.GetLineNum();
  inertial.X_LI = reader.origin(element);
  const XMLElement* mass = element.FirstChildElement("mass");
  const XMLElement* inertia = element.FirstChildElement("inertia");
  if (!mass) reader.problem(inertial.line, "<inertial> has no <mass>; it needs one");
  if (!inertia) reader.problem(inertial.line, "<inertial> has no <inertia>; it needs one");
  std::optional<double> value;
  if (mass) value = reader.number(*mass, "value", accept_negative_mass ? kAnyMass : kMass);
  const auto read = parseNumber(mass && mass->Attribute("value") ? mass->Attribute("value") : "");
  if (mass && !value && read && *read < 0.0)
    reader.suggest("<mass value=\"" + numberText(-*read) + "\"/>, or repair_inertia: true");
  bool complete = value.has_value() && inertia;
  if (value) inertial.mass = *value;
  if (inertia) {
    const char* const names[3][3] = {{"ixx", "ixy", "ixz"}, {"ixy", "iyy", "iyz"}, {"ixz", "iyz", "izz"}};
    for (int i = 0; i < 3; ++i) {
      for (int j = i; j < 3; ++j) {
        const auto entry = reader.number(*inertia, names[i][j], kInertia);
        complete = complete && entry;
        inertial.inertia(i, j) = inertial.inertia(j, i) = entry.value_or(0.0);
      }
    }
  }
  if (!complete) return std::nullopt;
  return inertial;
}

LinkText readLink(const XMLElement& element, const std::string& file, bool accept_negative_mass, Problems& problems,
                  std::vector<std::string>& notes) {
  LinkText link;
  link.line = element.GetLineNum();
  const char* name = element.Attribute("name");
  link.name = name ? name : "";
  XmlReader reader(file, "link", link.name, problems, notes);
  if (link.name.empty()) reader.problem(link.line, "the link has no name; it needs one");
  link.inertial_count = countChildren(element, "inertial");
  link.visual_count = countChildren(element, "visual");
  link.collision_count = countChildren(element, "collision");
  if (const XMLElement* inertial = element.FirstChildElement("inertial")) {
    link.inertial = readInertial(*inertial, accept_negative_mass, reader);
    if (const XMLElement* second = inertial->NextSiblingElement("inertial")) {
      reader.problem(second->GetLineNum(), "a second <inertial>; allowed is one");
    }
  }
  for (auto* e = element.FirstChildElement("visual"); e; e = e->NextSiblingElement("visual")) {
    if (auto shape = readShape(*e, false, reader)) link.visuals.push_back(std::move(*shape));
  }
  for (auto* e = element.FirstChildElement("collision"); e; e = e->NextSiblingElement("collision")) {
    if (auto shape = readShape(*e, true, reader)) link.collisions.push_back(std::move(*shape));
  }
  const std::set<std::string> known = {"inertial", "visual", "collision"};
  for (auto* e = element.FirstChildElement(); e; e = e->NextSiblingElement()) {
    if (known.count(e->Name()) == 0) reader.note(e->GetLineNum(), "<" + std::string(e->Name()) + "> is ignored");
  }
  link.complete = reader.ok();
  return link;
}

/// Far more than any vehicle has: what is worked out for all pairs of them stays a matter of seconds.
void checkCounts(const UrdfText& urdf, const std::string& file, Problems& problems) {
  std::size_t shapes = 0, moving = 0;
  for (const LinkText& link : urdf.links) shapes += static_cast<std::size_t>(link.collision_count);
  for (const JointText& joint : urdf.joints) moving += joint.type == "fixed" ? 0 : 1;
  const auto check = [&](std::size_t count, const char* what, std::size_t most) {
    if (count <= most) return;
    problems.push_back({file, "has " + std::to_string(count) + " " + what + "; allowed are up to " + std::to_string(most)});
  };
  check(urdf.links.size(), "links", kMostLinks);
  check(moving, "joints that move", kMostMovingJoints);
  check(shapes, "collision shapes", kMostCollisionShapes);
}

/// What no reader of URDF expands; urdfdom and tinyxml2 leave it in the text, where it means something else.
bool declaresEntities(const tinyxml2::XMLDocument& document) {
  for (auto* node = document.FirstChild(); node; node = node->NextSibling())
    if (node->ToUnknown() && std::string(node->Value()).find("<!ENTITY") != std::string::npos) return true;
  return false;
}

/// urdfdom refuses the whole file for a material defined twice; it does not say where.
void checkMaterials(const XMLElement& robot, const std::string& file, Problems& problems) {
  std::set<std::string> seen;
  for (auto* e = robot.FirstChildElement("material"); e; e = e->NextSiblingElement("material")) {
    const char* name = e->Attribute("name");
    if (name && !seen.insert(name).second) {
      problems.push_back({placeText(file, e->GetLineNum(), "material", name), "defined twice; allowed is once"});
    }
  }
}

}  // namespace

bool isGitLfsPointer(const std::string& text) {
  const std::string head = "version https://git-lfs.github.com/spec/";
  return text.compare(0, head.size(), head) == 0;
}

std::optional<UrdfText> readUrdfText(const std::string& text, const std::string& file, Problems& problems,
                                     std::vector<std::string>& notes, bool accept_negative_mass) {
  const std::string reason = notXmlReason(text);
  if (!reason.empty()) {
    problems.push_back({file, reason});
    return std::nullopt;
  }
  tinyxml2::XMLDocument document;
  const bool malformed = document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS;
  if (declaresEntities(document) || (malformed && text.find("<!ENTITY") != std::string::npos)) {
    problems.push_back({file, "declares entities (<!ENTITY>), which no reader of URDF expands; allowed is a URDF without"});
    return std::nullopt;
  }
  if (malformed) {
    problems.push_back({placeText(file, document.ErrorLineNum(), "", ""),
                        "malformed XML: " + xmlErrorText(document) + "; allowed is a well-formed URDF"});
    return std::nullopt;
  }
  const XMLElement* robot = document.RootElement();
  if (!robot || std::string(robot->Name()) != "robot") {
    const std::string found = robot ? robot->Name() : "";
    problems.push_back({placeText(file, robot ? robot->GetLineNum() : 0, "", ""),
                        "the root element is <" + found + ">" + (found == "sdf" ? ", this is an SDF file" : "") +
                            "; allowed is a URDF, <robot name=...>"});
    return std::nullopt;
  }
  LeftoverSearch leftovers(file, problems);
  leftovers.visit(*robot);
  leftovers.report();
  // Every macro would be an unknown element and every expression no number: one message is enough.
  if (leftovers.count() > 0) return std::nullopt;

  UrdfText urdf;
  const char* name = robot->Attribute("name");
  urdf.name = name ? name : "";
  if (urdf.name.empty()) {
    problems.push_back({placeText(file, robot->GetLineNum(), "<robot>", ""), "it has no name; it needs one"});
  }
  checkMaterials(*robot, file, problems);
  for (auto* e = robot->FirstChildElement(); e; e = e->NextSiblingElement()) {
    const std::string tag = e->Name();
    if (tag == "link") {
      urdf.links.push_back(readLink(*e, file, accept_negative_mass, problems, notes));
    } else if (tag == "joint") {
      urdf.joints.push_back(readJoint(*e, file, problems, notes));
    } else if (tag == "transmission") {
      readTransmission(*e, urdf.transmissions);
    } else if (tag == "ros2_control") {
      readRos2Control(*e, urdf.transmissions);
      notes.push_back(placeText(file, e->GetLineNum(), "", "") +
                      ": of <ros2_control> only the joints with a command interface are read, as hints of what drives");
    } else if (tag == "gazebo") {
      readGazebo(*e, file, urdf.gazebo_joints, urdf.gazebo_links, problems, notes);
      readDrivePlugins(*e, urdf.transmissions);
    } else if (tag != "material") {
      notes.push_back(placeText(file, e->GetLineNum(), "", "") + ": <" + tag + "> is ignored");
    }
  }
  const std::size_t before = problems.size();
  checkCounts(urdf, file, problems);
  if (problems.size() > before) return std::nullopt;
  return urdf;
}

}  // namespace ellipsoid_vehicle_sim
