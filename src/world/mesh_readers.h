#pragma once

#include <locale.h>
#include <stdlib.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ellipsoid_vehicle_sim/world/mesh_file.h"

namespace ellipsoid_vehicle_sim {

/// Readers of single formats: `text` is the whole file, `path` is for messages. They need not check for nan or an empty
/// mesh, readMeshFile does.
Loaded<MeshData> readStl(const std::string& text, const std::string& path);
/// How many bytes of an STL file are worth reading, seen from its first 64 KiB: all of a text, of a binary one its triangles
/// and some of what is behind them.
std::uintmax_t bytesOfStl(const std::string& head);
Loaded<MeshData> readObj(const std::string& text, const std::string& path);
Loaded<MeshData> readDae(const std::string& text, const std::string& path);

/// Cuts polygons into triangles.
class PolygonCutter {
 public:
  /// Appends the count - 2 triangles of a polygon of `count` >= 3 corners, in its own sense; concave ones are cut along
  /// diagonals inside. Of a polygon that is no simple one (crossing itself, of no area), all are still there somehow.
  void append(const std::vector<Eigen::Vector3d>& vertices, const std::uint32_t* corners, std::size_t count,
              std::vector<std::array<std::uint32_t, 3>>& triangles);
  /// Concave polygons cut as if they were convex, because looking for their diagonals took too long.
  std::size_t fanned() const { return fanned_; }

 private:
  std::int64_t patience_ = 100000000;  ///< corners looked at; a third of a second for a whole file.
  std::size_t fanned_ = 0;
};

/// Reads numbers with a decimal point whatever the locale of the program is. (std::from_chars for double needs GCC 11.)
class NumberReader {
 public:
  NumberReader() : c_locale_(newlocale(LC_ALL_MASK, "C", static_cast<locale_t>(0))) {}
  ~NumberReader() { freelocale(c_locale_); }
  NumberReader(const NumberReader&) = delete;
  NumberReader& operator=(const NumberReader&) = delete;

  /// The number that is the whole token; nothing else will do. nan and inf are numbers here.
  std::optional<double> number(std::string_view token) const {
    const std::string copy(token);
    char* end = nullptr;
    const double value = strtod_l(copy.c_str(), &end, c_locale_);
    if (copy.empty() || end != copy.c_str() + copy.size()) return std::nullopt;
    return value;
  }

 private:
  locale_t c_locale_;
};

/// Splits a text into words, counting lines; ends of lines are \n, \r\n or \r.
class WordReader {
 public:
  explicit WordReader(const std::string& text) : text_(text) {}

  int line() const { return line_; }

  /// Next word, crossing ends of lines; empty at the end of the text.
  std::string_view word() {
    while (at_ < text_.size() && isBlank(text_[at_])) skipOne();
    return take();
  }

  /// Next word of this line; empty at its end. A backslash at the end of a line joins the next one to it.
  std::string_view wordOfLine() {
    for (;;) {
      while (at_ < text_.size() && isBlank(text_[at_]) && !isEnd(text_[at_])) ++at_;
      const bool goes_on =
          at_ < text_.size() && text_[at_] == '\\' && (at_ + 1 == text_.size() || isEnd(text_[at_ + 1]));
      if (!goes_on) return take();
      ++at_;
      if (at_ < text_.size()) skipOne();
    }
  }

  /// Goes to the start of the next line; false at the end of the text.
  bool nextLine() {
    while (at_ < text_.size() && !isEnd(text_[at_])) ++at_;
    if (at_ >= text_.size()) return false;
    skipOne();
    return true;
  }

 private:
  static bool isEnd(char c) { return c == '\n' || c == '\r'; }
  static bool isBlank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f' || isEnd(c); }

  void skipOne() {
    const char c = text_[at_++];
    if (!isEnd(c)) return;
    if (c == '\r' && at_ < text_.size() && text_[at_] == '\n') ++at_;
    ++line_;
  }

  std::string_view take() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && !isBlank(text_[at_])) ++at_;
    return std::string_view(text_).substr(begin, at_ - begin);
  }

  const std::string& text_;
  std::size_t at_ = 0;
  int line_ = 1;
};

/// A word from a file, cut to a length fit for a message.
inline std::string inQuotes(std::string_view word) {
  std::string clean;
  for (const char c : word.substr(0, 40)) clean += static_cast<unsigned char>(c) < 32 ? '?' : c;
  return "'" + clean + (word.size() > 40 ? "..." : "") + "'";
}

inline std::string fannedNote(std::size_t polygons) {
  return std::to_string(polygons) + " concave polygons have too many corners to cut along diagonals inside: cut as fans";
}

inline std::string atLine(const std::string& path, int line) { return path + ":" + std::to_string(line); }

}  // namespace ellipsoid_vehicle_sim
