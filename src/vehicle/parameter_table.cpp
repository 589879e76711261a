#include "ellipsoid_vehicle_sim/vehicle/parameter_table.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace ellipsoid_vehicle_sim {
namespace {

constexpr std::size_t kManualWidth = 116;  // characters of a comment line

/// The shortest decimal that reads back as the same double, with the point that YAML wants before an exponent.
std::string numberText(double value) {
  char text[40];
  for (int digits = 6; digits <= 17; ++digits) {
    std::snprintf(text, sizeof(text), "%.*g", digits, value);
    if (std::strtod(text, nullptr) == value) break;
  }
  std::string result = text;
  const std::size_t exponent = result.find('e');
  if (exponent != std::string::npos && result.find('.') == std::string::npos) result.insert(exponent, ".0");
  return result;
}

std::string join(const std::vector<std::string>& words, const std::string& separator) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : separator) + word;
  return text;
}

const char* kindText(ParameterKind kind) {
  switch (kind) {
    case ParameterKind::kFlag:
      return "true or false";
    case ParameterKind::kNumber:
      return "a number";
    case ParameterKind::kChoice:
      return "one of the listed words";
    case ParameterKind::kText:
      return "text";
    case ParameterKind::kNumberList:
      return "a list of numbers";
    case ParameterKind::kTextList:
      return "a list of texts";
  }
  return "";
}

bool hasType(ParameterKind kind, const ParameterValue& value) {
  switch (kind) {
    case ParameterKind::kFlag:
      return std::holds_alternative<bool>(value);
    case ParameterKind::kNumber:
      return std::holds_alternative<double>(value) || std::holds_alternative<std::int64_t>(value);
    case ParameterKind::kChoice:
    case ParameterKind::kText:
      return std::holds_alternative<std::string>(value);
    case ParameterKind::kNumberList:
      return std::holds_alternative<std::vector<double>>(value);
    case ParameterKind::kTextList:
      return std::holds_alternative<std::vector<std::string>>(value);
  }
  return false;
}

// Of unknown parameters that are told one by one, and of letters of their names and values: more is no help to anybody.
constexpr std::size_t kMostUnknown = 50, kMostLetters = 500;

std::string beginningOf(const std::string& text) {
  return text.size() <= kMostLetters ? text : text.substr(0, kMostLetters) + " ...";
}

/// Number of single-letter edits between two words (Levenshtein).
std::size_t editDistance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
    }
  }
  return row[b.size()];
}

/// `text` in comment lines no wider than the manual.
std::string commentLines(const std::string& text) {
  std::string lines, line;
  std::size_t start = 0;
  while (start < text.size()) {
    const std::size_t end = std::min(text.find(' ', start), text.size());
    const std::string word = text.substr(start, end - start);
    if (!line.empty() && line.size() + 1 + word.size() + 2 > kManualWidth) {
      lines += "# " + line + "\n";
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
    start = end + 1;
  }
  return lines + "# " + line + "\n";
}

}  // namespace

std::string rangeText(const ParameterSpec& spec) {
  if (spec.kind == ParameterKind::kChoice)
    return join(spec.choices, " | ") +
           (spec.number_too ? " | " + numberText(spec.minimum) + " ... " + numberText(spec.maximum) : "");
  if (spec.kind == ParameterKind::kNumberList && spec.length > 0) return std::to_string(spec.length) + " numbers";
  if (spec.kind != ParameterKind::kNumber) return kindText(spec.kind);
  const bool from = std::isfinite(spec.minimum), to = std::isfinite(spec.maximum);
  if (from && to)
    return (spec.whole ? "whole numbers " : "") + numberText(spec.minimum) + " ... " + numberText(spec.maximum);
  if (from) return "at least " + numberText(spec.minimum);
  if (to) return "at most " + numberText(spec.maximum);
  return "a number";
}

std::string valueText(const ParameterValue& value) {
  if (const auto* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
  if (const auto* whole = std::get_if<std::int64_t>(&value)) return std::to_string(*whole);
  if (const auto* number = std::get_if<double>(&value)) return numberText(*number);
  if (const auto* text = std::get_if<std::string>(&value)) return *text;
  std::vector<std::string> words;
  if (const auto* numbers = std::get_if<std::vector<double>>(&value)) {
    for (const double number : *numbers) words.push_back(numberText(number));
  } else {
    words = std::get<std::vector<std::string>>(value);
  }
  return "[" + join(words, ", ") + "]";
}

std::optional<std::string> refusal(const ParameterSpec& spec, const ParameterValue& value) {
  const std::string read = "'" + valueText(value) + "'";
  if (spec.number_too && hasType(ParameterKind::kNumber, value)) {
    const double number = numberOf(value);
    if (number >= spec.minimum && number <= spec.maximum) return std::nullopt;
    return read + " is out of range, allowed is " + rangeText(spec) + " [" + spec.unit + "]";
  }
  if (!hasType(spec.kind, value)) {
    // The usual trap: YAML takes 1e-3 for text, because a number with an exponent needs a point.
    const bool number_as_text = spec.kind == ParameterKind::kNumber && std::holds_alternative<std::string>(value);
    return read + " was read, expected " + kindText(spec.kind) +
           (number_as_text ? std::string(" (YAML reads 1e-3 as text: write 1.0e-3)") : std::string());
  }
  if (spec.kind == ParameterKind::kNumber) {
    const double number = numberOf(value);
    if (spec.whole && std::isfinite(number) && number != std::floor(number))
      return read + " is no whole number, allowed is " + rangeText(spec);
    // Written so that NaN fails it.
    if (std::isfinite(number) && number >= spec.minimum && number <= spec.maximum) return std::nullopt;
    return read + " is out of range, allowed is " + rangeText(spec) + (spec.unit.empty() ? "" : " [" + spec.unit + "]");
  }
  if (spec.kind == ParameterKind::kChoice) {
    const std::string& word = std::get<std::string>(value);
    if (std::find(spec.choices.begin(), spec.choices.end(), word) != spec.choices.end()) return std::nullopt;
    const std::string close = closestWord(word, spec.choices);
    return read + " is unknown, allowed is " + rangeText(spec) +
           (close.empty() ? "" : "; did you mean '" + close + "'?");
  }
  if (spec.kind == ParameterKind::kNumberList) {
    const auto& numbers = std::get<std::vector<double>>(value);
    if (spec.length > 0 && numbers.size() != spec.length) {
      return read + " has " + std::to_string(numbers.size()) + " numbers, expected " + std::to_string(spec.length);
    }
    for (const double number : numbers) {
      if (!std::isfinite(number)) return read + " holds a number that is not finite";
    }
  }
  return std::nullopt;
}

std::string closestWord(const std::string& word, const std::vector<std::string>& known) {
  std::string best;
  // A third of the letters wrong is still a slip of the hand, more is another word.
  std::size_t best_distance = std::max<std::size_t>(1, word.size() / 3) + 1;
  for (const std::string& candidate : known) {
    // Each letter that one has more than the other is an edit; a word of a megabyte is not compared letter by letter.
    const std::size_t more = std::max(word.size(), candidate.size()) - std::min(word.size(), candidate.size());
    if (more >= best_distance) continue;
    const std::size_t distance = editDistance(word, candidate);
    if (distance < best_distance) {
      best_distance = distance;
      best = candidate;
    }
  }
  return best;
}

Problems unknownParameters(const ParameterValues& values, const std::vector<std::string>& known,
                           const std::string& where) {
  Problems problems;
  for (const auto& [key, value] : values) {
    if (problems.size() == kMostUnknown) {
      problems.push_back({where + "...", "and " + std::to_string(values.size() - kMostUnknown) + " more that do not exist"});
      break;
    }
    const std::string close = closestWord(key, known);
    problems.push_back({where + beginningOf(key), "there is no such parameter (its value is '" + beginningOf(valueText(value)) +
                                                      "')" + (close.empty() ? "" : "; did you mean '" + close + "'?")});
  }
  return problems;
}

std::string referenceRow(const ParameterSpec& spec, const std::optional<ParameterValue>& default_value) {
  const auto cell = [](std::string text) {
    for (std::size_t at = text.find('|'); at != std::string::npos; at = text.find('|', at + 2)) text.insert(at, "\\");
    return text;
  };
  const std::string value = default_value ? "`" + cell(valueText(*default_value)) + "`" : "*derived or none*";
  return "| `" + spec.key + "`" + (spec.running ? " (running)" : "") + " | " + value + " | " + cell(rangeText(spec)) +
         " | " + (spec.unit.empty() ? "" : spec.unit) + " | " + cell(spec.description) + " |\n";
}

std::string manualEntry(const ParameterSpec& spec, const std::optional<ParameterValue>& default_value) {
  const std::string unit = spec.unit.empty() ? "" : " [" + spec.unit + "]";
  const std::string running = spec.running ? "; may change while it runs" : "";
  const std::string comment = commentLines(spec.description) + "# Range: " + rangeText(spec) + unit + running + "\n";
  return "\n" + comment + "#" + spec.key + ":" + (default_value ? " " + valueText(*default_value) : "") + "\n";
}

}  // namespace ellipsoid_vehicle_sim
