#include "ellipsoid_vehicle_sim/description/urdf_writer.h"

#include <tinyxml2.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "ellipsoid_vehicle_sim/description/collision_shape.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;
using tinyxml2::XMLElement;

/// The shortest text that reads back as the same number.
std::string exactText(double value) {
  char text[40];
  for (int digits = 6; digits <= 17; ++digits) {
    std::snprintf(text, sizeof text, "%.*g", digits, value);
    if (std::strtod(text, nullptr) == value) break;
  }
  return text;
}

std::string vectorText(const Vector3d& v) { return exactText(v.x()) + " " + exactText(v.y()) + " " + exactText(v.z()); }

/// Roll, pitch, yaw about fixed axes, as URDF has them.
Vector3d rpyOf(const Eigen::Quaterniond& q) {
  const Eigen::Matrix3d R = q.toRotationMatrix();
  const double pitch = std::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0)));
  if (std::abs(std::cos(pitch)) < 1e-9) return {std::atan2(-R(1, 2), R(1, 1)), pitch, 0.0};
  return {std::atan2(R(2, 1), R(2, 2)), pitch, std::atan2(R(1, 0), R(0, 0))};
}

XMLElement* add(XMLElement& parent, const char* name) {
  XMLElement* child = parent.GetDocument()->NewElement(name);
  parent.InsertEndChild(child);
  return child;
}

void addOrigin(XMLElement& parent, const Vector3d& xyz, const Vector3d& rpy) {
  XMLElement* origin = add(parent, "origin");
  origin->SetAttribute("xyz", vectorText(xyz).c_str());
  origin->SetAttribute("rpy", vectorText(rpy).c_str());
}

void addCollision(XMLElement& link, const EllipsoidDescription& e) {
  XMLElement* collision = add(link, "collision");
  addOrigin(*collision, e.X_LE.p, rpyOf(e.X_LE.q));
  XMLElement* geometry = add(*collision, "geometry");
  XMLElement* mesh = add(*geometry, "mesh");
  mesh->SetAttribute("filename", kUnitSphereUri);
  mesh->SetAttribute("scale", vectorText(e.radii).c_str());
}

void replaceInertial(XMLElement& element, const LinkDescription& link) {
  while (XMLElement* old = element.FirstChildElement("inertial")) element.DeleteChild(old);
  XMLElement* inertial = element.GetDocument()->NewElement("inertial");
  element.InsertFirstChild(inertial);
  addOrigin(*inertial, link.p_Lcm, Vector3d::Zero());
  add(*inertial, "mass")->SetAttribute("value", exactText(link.mass).c_str());
  XMLElement* inertia = add(*inertial, "inertia");
  const char* const names[3][3] = {{"ixx", "ixy", "ixz"}, {"", "iyy", "iyz"}, {"", "", "izz"}};
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j) inertia->SetAttribute(names[i][j], exactText(link.I_cm_L(i, j)).c_str());
}

}  // namespace

std::string canonicalUrdf(const std::string& text, const VehicleDescription& vehicle,
                          const std::vector<InertiaFinding>& repaired) {
  tinyxml2::XMLDocument document;
  document.Parse(text.data(), text.size());
  XMLElement* robot = document.RootElement();
  for (XMLElement* e = robot ? robot->FirstChildElement("link") : nullptr; e; e = e->NextSiblingElement("link")) {
    const char* name = e->Attribute("name");
    for (const LinkDescription& link : vehicle.links) {
      if (!name || link.name != name) continue;
      for (const InertiaFinding& f : repaired) {
        const bool changed = f.kind != InertiaFinding::Kind::kSymmetry && (f.mass || f.p_Lcm || f.I_cm_L);
        if (f.link == link.name && changed) replaceInertial(*e, link);
      }
      while (XMLElement* old = e->FirstChildElement("collision")) e->DeleteChild(old);
      for (const EllipsoidDescription& ellipsoid : link.ellipsoids) addCollision(*e, ellipsoid);
    }
  }
  tinyxml2::XMLPrinter printer;
  document.Print(&printer);
  return printer.CStr();
}

}  // namespace ellipsoid_vehicle_sim
