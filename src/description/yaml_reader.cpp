#include "ellipsoid_vehicle_sim/description/yaml_reader.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ellipsoid_vehicle_sim/description/number_text.h"
#include "ellipsoid_vehicle_sim/world/file_bytes.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr std::size_t kDeepest = 100;

bool isBlank(char c) { return c == ' ' || c == '\t'; }

/// The line in which a YAML text is nested deeper than anything here is; 0: nowhere. Counted without reading it: open
/// brackets (also those in quotes, of which nobody leaves a hundred open), and levels of a block, each of which begins
/// further right than the one around it.
int tooDeepLine(const std::string& text) {
  int line = 0, brackets = 0;
  std::vector<std::size_t> columns;  // where the open levels of block begin
  for (std::size_t begin = 0; begin < text.size();) {
    ++line;
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::size_t at = begin;
    while (at < end && isBlank(text[at])) ++at;
    if (at < end)
      while (!columns.empty() && columns.back() >= at - begin) columns.pop_back();
    while (at < end) {
      columns.push_back(at - begin);
      const bool opens = text[at] == '-' || text[at] == '?' || text[at] == ':';
      if (!opens || at + 1 >= end || !isBlank(text[at + 1]) || columns.size() > kDeepest) break;
      for (++at; at < end && isBlank(text[at]);) ++at;
    }
    for (; at < end; ++at) {
      if (text[at] == '[' || text[at] == '{') ++brackets;
      if ((text[at] == ']' || text[at] == '}') && brackets > 0) --brackets;
      if (brackets + static_cast<int>(columns.size()) > static_cast<int>(kDeepest)) return line;
    }
    if (columns.size() > kDeepest) return line;
    begin = end + 1;
  }
  return 0;
}

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

// More is no help to anybody, nor is a key of megabytes.
constexpr std::size_t kMostProblems = 50, kLongestMessage = 2000;

std::string beginningOf(const std::string& message) {
  return message.size() <= kLongestMessage ? message : message.substr(0, kLongestMessage) + " ...";
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

Loaded<YAML::Node> parseYaml(const std::string& text, const std::string& file) {
  Loaded<YAML::Node> result;
  if (const int line = tooDeepLine(text); line > 0) {
    result.problems.push_back({file + ":" + std::to_string(line),
                               "is nested deeper than " + std::to_string(kDeepest) + " levels; allowed are up to that"});
    return result;
  }
  try {
    result.value = YAML::Load(text);
  } catch (const YAML::Exception& error) {
    const std::string line = error.mark.is_null() ? "" : ":" + std::to_string(error.mark.line + 1);
    result.problems.push_back({file + line, "no YAML: " + error.msg});
  }
  return result;
}

void YamlReader::problem(const YAML::Node& node, const std::string& message) {
  if (problems.size() > kMostProblems) return;
  const bool last = problems.size() == kMostProblems;
  problems.push_back({where(node), last ? "and more problems from here on" : beginningOf(message)});
}

std::optional<YAML::Node> YamlReader::open(const std::string& what) {
  Loaded<std::string> text = readFileBytes(path_, what, kLargestYamlFile);
  if (text && text.value->empty()) text = {std::nullopt, {{path_, "is empty, or cannot be read"}}, {}};
  Loaded<YAML::Node> root = text ? parseYaml(*text.value, path_) : Loaded<YAML::Node>{std::nullopt, text.problems, {}};
  problems.insert(problems.end(), root.problems.begin(), root.problems.end());
  return root.value;
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
