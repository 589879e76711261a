#pragma once

#include <tinyxml2.h>

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/description/urdf_text.h"
#include "ellipsoid_vehicle_sim/geometry/pose.h"
#include "ellipsoid_vehicle_sim/geometry/problem.h"

namespace ellipsoid_vehicle_sim {

/// What a number may be; both ends belong to it.
struct Allowed {
  double min = -kLargestNumber;
  double max = kLargestNumber;
  const char* text = "a finite number between -1e15 and 1e15";
};

constexpr Allowed kAnyNumber{};
/// "1e+16" is some tools' word for "no limit"; no joint gets there.
constexpr Allowed kAnyLimit{-1e300, 1e300, "a finite number between -1e300 and 1e300"};
constexpr Allowed kNotNegative{0.0, kLargestNumber, "a finite number >= 0, at most 1e15"};
constexpr Allowed kAnyLength{-kLargestLength, kLargestLength, "a finite number between -1e6 and 1e6 m"};
constexpr Allowed kPositiveLength{kSmallestLength, kLargestLength, "a finite number > 0, between 1e-9 and 1e6 m"};
constexpr Allowed kPositiveScale{kSmallestLength, kLargestLength, "a finite number > 0, between 1e-9 and 1e6"};
constexpr Allowed kMass{0.0, kLargestMass, "a finite number >= 0, at most 1e9 kg"};
constexpr Allowed kAnyMass{-kLargestMass, kLargestMass, "a finite number, at most 1e9 kg either way"};
constexpr Allowed kInertia{-kLargestInertia, kLargestInertia, "a finite number between -1e15 and 1e15 kg m^2"};

/// Reads attributes of one link, joint or other named element, and collects what is wrong with them under its name.
class XmlReader {
 public:
  XmlReader(std::string file, std::string what, std::string name, Problems& problems, std::vector<std::string>& notes)
      : file_(std::move(file)), what_(std::move(what)), name_(std::move(name)), problems_(problems), notes_(notes) {}

  void problem(int line, const std::string& message);
  void note(int line, const std::string& message);
  /// Adds to the last problem what could be written instead.
  void suggest(const std::string& text) { problems_.back().message += "; suggested: " + text; }
  /// True while nothing was refused through this reader.
  bool ok() const { return ok_; }

  /// A text attribute that must be there and not be empty.
  std::optional<std::string> text(const tinyxml2::XMLElement& element, const char* attribute);
  /// A number that must be there.
  std::optional<double> number(const tinyxml2::XMLElement& element, const char* attribute, const Allowed& allowed);
  /// A number that may be missing; nullopt also if it is there and wrong.
  std::optional<double> optionalNumber(const tinyxml2::XMLElement& element, const char* attribute,
                                       const Allowed& allowed);
  /// Three numbers that must be there.
  std::optional<Eigen::Vector3d> vector(const tinyxml2::XMLElement& element, const char* attribute,
                                        const Allowed& allowed);
  /// <origin> of the parent element; identity if it is missing, also where it was wrong (and refused).
  Pose origin(const tinyxml2::XMLElement& parent);

 private:
  std::optional<double> checked(const tinyxml2::XMLElement& element, const char* attribute, const char* text,
                                const Allowed& allowed);

  std::string file_, what_, name_;
  Problems& problems_;
  std::vector<std::string>& notes_;
  bool ok_ = true;
};

/// "<mass value="-3">", as the text has it.
std::string attributeText(const tinyxml2::XMLElement& element, const char* attribute);

/// How many direct children carry this name.
int countChildren(const tinyxml2::XMLElement& parent, const char* name);

JointText readJoint(const tinyxml2::XMLElement& element, const std::string& file, Problems& problems,
                    std::vector<std::string>& notes);
void readTransmission(const tinyxml2::XMLElement& element, std::vector<TransmissionText>& transmissions);
void readRos2Control(const tinyxml2::XMLElement& element, std::vector<TransmissionText>& transmissions);
void readDrivePlugins(const tinyxml2::XMLElement& gazebo, std::vector<TransmissionText>& transmissions);
void readGazebo(const tinyxml2::XMLElement& element, const std::string& file, std::vector<GazeboJointText>& gazebo,
                std::vector<GazeboLinkText>& surfaces, Problems& problems, std::vector<std::string>& notes);

}  // namespace ellipsoid_vehicle_sim
