#pragma once

#include <string>
#include <vector>

namespace ellipsoid_vehicle_sim {

/// A text as JSON has it.
inline std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += static_cast<unsigned char>(c) < 32 ? ' ' : c;
  }
  return result + "\"";
}

/// Texts as a list of JSON.
inline std::string listed(const std::vector<std::string>& texts) {
  std::string result;
  for (const std::string& text : texts) result += (result.empty() ? "" : ", ") + quoted(text);
  return "[" + result + "]";
}

}  // namespace ellipsoid_vehicle_sim
