#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace ellipsoid_vehicle_sim {

/// One thing that is wrong with an input: where it stands, what was read there, what is allowed.
struct Problem {
  std::string where;    ///< file and line, link, joint or parameter, e.g. "car.urdf:41 link 'wheel'".
  std::string message;  ///< what was read and what is allowed, one sentence with the offending value in it.

  std::string text() const { return where + ": " + message; }
};

using Problems = std::vector<Problem>;

/// What a loader returns: a value, or every problem it found; `notes` say what was assumed or replaced on the way.
/// There is a value exactly when there are no problems.
template <typename T>
struct Loaded {
  std::optional<T> value;
  Problems problems;
  std::vector<std::string> notes;

  explicit operator bool() const { return value.has_value(); }
};

/// All problems, one a line.
inline std::string problemText(const Problems& problems) {
  std::string text;
  for (const Problem& problem : problems) text += problem.text() + "\n";
  return text;
}

}  // namespace ellipsoid_vehicle_sim
