#pragma once

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/geometry/problem.h"
#include "ellipsoid_vehicle_sim/vehicle/parameter_table.h"

namespace ellipsoid_vehicle_sim {

/// Numbers a YAML file may give, and the words for them.
struct NumberRange {
  double min = 0.0, max = 0.0;
  std::string text;  ///< "between 0 and 100".
};

/// A scalar by YAML's rules (what stands in quotes is text) or a list of numbers or texts; nullopt for what no
/// parameter can be: nothing, a dictionary, a mixed list.
std::optional<ParameterValue> parameterValue(const YAML::Node& node);

/// A YAML text as a node; a problem where it is no YAML, or nested deeper than 100 levels (some versions of yaml-cpp follow
/// any depth until the stack ends). `file` stands in messages.
Loaded<YAML::Node> parseYaml(const std::string& text, const std::string& file);

/// Strict reading of a YAML file: nothing is taken for something else, every problem carries file and line, and reading
/// goes on after one so that all are told at once.
class YamlReader {
 public:
  explicit YamlReader(std::string path) : path_(std::move(path)) {}

  /// The file as a node; a problem and nullopt where it cannot be read, is empty or is no YAML. `what` for messages.
  std::optional<YAML::Node> open(const std::string& what);

  const std::string& path() const { return path_; }
  std::string where(const YAML::Node& node) const { return path_ + ":" + std::to_string(node.Mark().line + 1); }
  /// After fifty it is only said that there are more.
  void problem(const YAML::Node& node, const std::string& message);

  /// Calls read(key, value) for every pair of a dictionary, after making sure that keys are known and given once.
  template <typename Read>
  void forEachKey(const YAML::Node& map, const std::vector<std::string>& known, Read&& read) {
    std::vector<std::string> seen;
    for (const auto& pair : map) {
      const std::string key = pair.first.IsScalar() ? pair.first.Scalar() : std::string();
      if (std::find(known.begin(), known.end(), key) == known.end()) {
        std::string list;
        for (const std::string& name : known) list += (list.empty() ? "" : ", ") + name;
        problem(pair.first, "unknown key '" + key + "'; known are " + list);
      } else if (std::find(seen.begin(), seen.end(), key) != seen.end()) {
        problem(pair.first, "'" + key + "' is given twice");
      } else {
        seen.push_back(key);
        read(key, pair.second);
      }
    }
  }

  std::string text(const YAML::Node& value, const std::string& key);
  /// With `may_be_negative` the range is that of the size.
  std::optional<double> number(const YAML::Node& value, const std::string& key, const NumberRange& range,
                               bool may_be_negative);
  /// `shape` as in "[x, y, yaw]"; the range is that of the sizes.
  std::optional<std::vector<double>> numbers(const YAML::Node& value, const std::string& key, std::size_t count,
                                             const NumberRange& range, const std::string& shape);
  std::optional<bool> flag(const YAML::Node& value, const std::string& key);

  Problems problems;

 private:
  std::string path_;
};

}  // namespace ellipsoid_vehicle_sim
