#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/description/urdf_loader.h"

// Pieces of URDF text from which the description tests put vehicles together, and what they look for in the answer.

namespace ellipsoid_vehicle_sim {

inline const std::string kTestUrdfFolder = std::string(TEST_DATA_DIR) + "/urdf/";
inline const std::string kShippedUrdfFolder = std::string(TEST_DATA_DIR) + "/../../urdf/";

inline std::string robotText(const std::string& inside) { return "<robot name=\"test\">\n" + inside + "</robot>\n"; }

/// A body of some mass with right inertia.
inline std::string inertialText(double mass = 1.0) {
  const std::string m = std::to_string(mass), i = std::to_string(0.01 * mass);
  return "<inertial><mass value=\"" + m + "\"/><inertia ixx=\"" + i + "\" ixy=\"0\" ixz=\"0\" iyy=\"" + i +
         "\" iyz=\"0\" izz=\"" + i + "\"/></inertial>\n";
}

inline std::string collisionText(const std::string& shape, const std::string& xyz = "0 0 0",
                                 const std::string& rpy = "0 0 0") {
  return "<collision><origin xyz=\"" + xyz + "\" rpy=\"" + rpy + "\"/><geometry>" + shape + "</geometry></collision>\n";
}

inline std::string linkText(const std::string& name, const std::string& inside) {
  return "<link name=\"" + name + "\">\n" + inside + "</link>\n";
}

/// The link the sample vehicles are built on: 10 kg, a box whose bottom is at z = 0.
inline std::string baseText() {
  return linkText("base", inertialText(10.0) + collisionText("<box size=\"0.6 0.4 0.2\"/>", "0 0 0.1"));
}

inline std::string jointText(const std::string& name, const std::string& type, const std::string& parent,
                             const std::string& child, const std::string& xyz, const std::string& axis,
                             const std::string& rest = "") {
  return "<joint name=\"" + name + "\" type=\"" + type + "\"><parent link=\"" + parent + "\"/><child link=\"" + child +
         "\"/><origin xyz=\"" + xyz + "\"/><axis xyz=\"" + axis + "\"/>" + rest + "</joint>\n";
}

/// A wheel of radius 0.1 m: link `name` on joint `name`_axle, standing like a wheel on the lateral axis.
inline std::string wheelText(const std::string& name, const std::string& parent, const std::string& xyz,
                             const std::string& axis = "0 1 0") {
  return linkText(name, inertialText() + collisionText("<cylinder radius=\"0.1\" length=\"0.05\"/>", "0 0 0",
                                                       "1.5707963267948966 0 0")) +
         jointText(name + "_axle", "continuous", parent, name, xyz, axis);
}

/// Two wheels on the base's rear axle.
inline std::string rearAxleText() {
  return wheelText("rl", "base", "-0.2 0.25 0") + wheelText("rr", "base", "-0.2 -0.25 0");
}

inline std::string transmissionText(const std::string& joint, const std::string& interface = "EffortJointInterface") {
  return "<transmission name=\"" + joint + "_t\"><joint name=\"" + joint + "\"><hardwareInterface>" + interface +
         "</hardwareInterface></joint></transmission>\n";
}

inline Loaded<VehicleDescription> loadText(const std::string& inside, const UrdfOptions& options = {}) {
  return loadUrdfText(robotText(inside), "test.urdf", {}, options);
}

inline const JointDescription& jointOf(const VehicleDescription& vehicle, const std::string& name) {
  const auto found = std::find_if(vehicle.joints.begin(), vehicle.joints.end(),
                                  [&name](const JointDescription& j) { return j.name == name; });
  if (found == vehicle.joints.end()) throw std::out_of_range("no joint " + name);
  return *found;
}

inline const LinkDescription& linkOf(const VehicleDescription& vehicle, const std::string& name) {
  const auto found = std::find_if(vehicle.links.begin(), vehicle.links.end(),
                                  [&name](const LinkDescription& l) { return l.name == name; });
  if (found == vehicle.links.end()) throw std::out_of_range("no link " + name);
  return *found;
}

inline int countRole(const VehicleDescription& vehicle, JointRole role) {
  return static_cast<int>(
      std::count_if(vehicle.joints.begin(), vehicle.joints.end(),
                    [role](const JointDescription& j) { return j.role == role && j.type != JointType::kFixed; }));
}

inline double massOf(const VehicleDescription& vehicle) {
  double mass = 0.0;
  for (const LinkDescription& link : vehicle.links) mass += link.mass;
  return mass;
}

/// True if one of the texts holds every one of the words.
inline bool anyHolds(const std::vector<std::string>& texts, const std::vector<std::string>& words) {
  return std::any_of(texts.begin(), texts.end(), [&words](const std::string& text) {
    return std::all_of(words.begin(), words.end(),
                       [&text](const std::string& word) { return text.find(word) != std::string::npos; });
  });
}

/// Refused, with one of the problems holding every one of the words.
inline testing::AssertionResult refusedWith(const Loaded<VehicleDescription>& loaded,
                                            const std::vector<std::string>& words) {
  if (loaded) return testing::AssertionFailure() << "the file was loaded";
  std::vector<std::string> texts;
  for (const Problem& problem : loaded.problems) texts.push_back(problem.text());
  if (anyHolds(texts, words)) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "no problem says so:\n" << problemText(loaded.problems);
}

/// Loaded, with one of the notes holding every one of the words.
inline testing::AssertionResult notedWith(const Loaded<VehicleDescription>& loaded,
                                          const std::vector<std::string>& words) {
  if (!loaded) return testing::AssertionFailure() << "the file was refused:\n" << problemText(loaded.problems);
  if (anyHolds(loaded.notes, words)) return testing::AssertionSuccess();
  testing::AssertionResult result = testing::AssertionFailure() << "no note says so:\n";
  for (const std::string& note : loaded.notes) result << note << "\n";
  return result;
}

inline testing::AssertionResult isLoaded(const Loaded<VehicleDescription>& loaded) {
  if (loaded) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "the file was refused:\n" << problemText(loaded.problems);
}

}  // namespace ellipsoid_vehicle_sim
