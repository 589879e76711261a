#include "ellipsoid_vehicle_sim/description/parameter_file.h"

#include <yaml-cpp/yaml.h>

#include <fstream>
#include <sstream>

namespace ellipsoid_vehicle_sim {
namespace {

/// A scalar by YAML's rules: what stands in quotes is text.
ParameterValue scalarOf(const YAML::Node& node) {
  const bool quoted = node.Tag() == "!";
  bool flag;
  std::int64_t whole;
  double number;
  if (!quoted && YAML::convert<std::int64_t>::decode(node, whole)) return whole;
  if (!quoted && YAML::convert<double>::decode(node, number)) return number;
  if (!quoted && YAML::convert<bool>::decode(node, flag)) return flag;
  return node.Scalar();
}

std::optional<ParameterValue> valueOf(const YAML::Node& node) {
  if (node.IsScalar()) return scalarOf(node);
  if (!node.IsSequence()) return std::nullopt;
  std::vector<double> numbers;
  std::vector<std::string> texts;
  for (const YAML::Node& item : node) {
    if (!item.IsScalar()) return std::nullopt;
    const ParameterValue value = scalarOf(item);
    if (const auto* text = std::get_if<std::string>(&value)) {
      texts.push_back(*text);
    } else if (!std::holds_alternative<bool>(value)) {
      numbers.push_back(numberOf(value));
    }
  }
  if (texts.size() == node.size() && !texts.empty()) return ParameterValue(texts);
  if (numbers.size() == node.size()) return ParameterValue(numbers);
  return std::nullopt;
}

}  // namespace

Loaded<ParameterValues> readParameterFile(const std::string& path) {
  Loaded<ParameterValues> result;
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in) {
    result.problems.push_back({path, "the file cannot be read"});
    return result;
  }
  ParameterValues values;
  try {
    const YAML::Node root = YAML::Load(text.str());
    if (!root.IsNull() && !root.IsMap()) {
      result.problems.push_back({path, "holds no 'key: value' pairs"});
      return result;
    }
    for (const auto& pair : root) {
      const std::string key = pair.first.Scalar();
      const std::string where = path + ":" + std::to_string(pair.first.Mark().line + 1) + " " + key;
      const auto value = valueOf(pair.second);
      if (!value) {
        result.problems.push_back({where, "is empty, a dictionary or a mixed list, which no parameter is"});
      } else if (!values.emplace(key, *value).second) {
        result.problems.push_back({where, "is given twice"});
      }
    }
  } catch (const YAML::Exception& error) {
    result.problems.push_back({path + ":" + std::to_string(error.mark.line + 1), "no YAML: " + error.msg});
  }
  if (result.problems.empty()) result.value = std::move(values);
  return result;
}

}  // namespace ellipsoid_vehicle_sim
