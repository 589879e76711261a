#include "ellipsoid_vehicle_sim/description/number_text.h"

#include <cmath>
#include <locale>
#include <sstream>

namespace ellipsoid_vehicle_sim {
namespace {

bool isDigit(char c) { return c >= '0' && c <= '9'; }
bool isBlank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

/// [+-] digits [. digits] [e [+-] digits], at least one digit before the exponent.
bool looksLikeNumber(const std::string& word) {
  std::size_t i = 0, digits = 0;
  if (i < word.size() && (word[i] == '+' || word[i] == '-')) ++i;
  for (; i < word.size() && isDigit(word[i]); ++i) ++digits;
  if (i < word.size() && word[i] == '.') ++i;
  for (; i < word.size() && isDigit(word[i]); ++i) ++digits;
  if (digits == 0) return false;
  if (i < word.size() && (word[i] == 'e' || word[i] == 'E')) {
    ++i;
    if (i < word.size() && (word[i] == '+' || word[i] == '-')) ++i;
    const std::size_t exponent = i;
    while (i < word.size() && isDigit(word[i])) ++i;
    if (i == exponent) return false;
  }
  return i == word.size();
}

std::optional<double> wordToNumber(const std::string& word) {
  if (!looksLikeNumber(word)) return std::nullopt;
  // A stream in the classic locale: strtod would follow the process's locale, from_chars needs GCC 11.
  std::istringstream stream(word);
  stream.imbue(std::locale::classic());
  double value = 0.0;
  stream >> value;
  if (stream.fail() || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace

std::optional<std::vector<double>> parseNumberList(const std::string& text) {
  std::vector<double> numbers;
  for (std::size_t i = 0; i < text.size();) {
    if (isBlank(text[i])) {
      ++i;
      continue;
    }
    const std::size_t begin = i;
    while (i < text.size() && !isBlank(text[i])) ++i;
    const auto number = wordToNumber(text.substr(begin, i - begin));
    if (!number) return std::nullopt;
    numbers.push_back(*number);
  }
  return numbers;
}

std::optional<double> parseNumber(const std::string& text) {
  const auto numbers = parseNumberList(text);
  if (!numbers || numbers->size() != 1) return std::nullopt;
  return numbers->front();
}

std::string numberText(double value) {
  std::ostringstream stream;
  stream.imbue(std::locale::classic());
  stream.precision(6);
  stream << (value == 0.0 ? 0.0 : value);  // no "-0" in messages
  return stream.str();
}

}  // namespace ellipsoid_vehicle_sim
