#include "ellipsoid_vehicle_sim/description/yaml_reader.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#include "ellipsoid_vehicle_sim/description/number_text.h"

namespace ellipsoid_vehicle_sim {
namespace {

namespace fs = std::filesystem;

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

}  // namespace

std::optional<ParameterValue> parameterValue(const YAML::Node& node) {
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

std::optional<YAML::Node> YamlReader::open(const std::string& what) {
  std::ifstream in(path_, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in || text.str().empty()) {
    std::error_code error;
    const std::string reason = fs::is_directory(path_, error) ? "is a folder, not a " + what + " file"
                               : !fs::exists(path_, error)    ? "there is no such file"
                                                              : "is empty, or cannot be read";
    problems.push_back({path_, reason});
    return std::nullopt;
  }
  try {
    return YAML::Load(text.str());
  } catch (const YAML::Exception& error) {
    problems.push_back({path_ + ":" + std::to_string(error.mark.line + 1), "no YAML: " + error.msg});
  }
  return std::nullopt;
}

std::string YamlReader::text(const YAML::Node& value, const std::string& key) {
  if (value.IsScalar() && !value.Scalar().empty()) return value.Scalar();
  problem(value, "'" + key + "' is not a text");
  return {};
}

std::optional<double> YamlReader::number(const YAML::Node& value, const std::string& key, const NumberRange& range,
                                         bool may_be_negative) {
  if (!value.IsScalar()) {
    problem(value, "'" + key + "' is not a number; allowed is " + range.text);
    return std::nullopt;
  }
  const std::optional<double> x = parseNumber(value.Scalar());
  const double size = x ? (may_be_negative ? std::abs(*x) : *x) : std::numeric_limits<double>::quiet_NaN();
  if (size >= range.min && size <= range.max) return x;
  problem(value, "'" + key + "' is " + (x ? "" : "no number: ") + value.Scalar() + "; allowed is " + range.text);
  return std::nullopt;
}

std::optional<std::vector<double>> YamlReader::numbers(const YAML::Node& value, const std::string& key,
                                                       std::size_t count, const NumberRange& range,
                                                       const std::string& shape) {
  if (!value.IsSequence() || value.size() != count) {
    problem(value, "'" + key + "' is not " + shape);
    return std::nullopt;
  }
  std::vector<double> result;
  for (const YAML::Node& item : value) {
    if (const std::optional<double> x = number(item, key, range, true)) result.push_back(*x);
  }
  if (result.size() != count) return std::nullopt;
  return result;
}

std::optional<bool> YamlReader::flag(const YAML::Node& value, const std::string& key) {
  bool result = false;
  if (value.IsScalar() && YAML::convert<bool>::decode(value, result)) return result;
  problem(value, "'" + key + "' is not true or false");
  return std::nullopt;
}

}  // namespace ellipsoid_vehicle_sim
