#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace ellipsoid_vehicle_sim {

/// The value of an attribute, with its character references resolved; `attributes` as they stand in the tag.
std::optional<std::string> xmlAttribute(std::string_view attributes, std::string_view name);

/// Goes through the tags of an XML text as a parser would: what looks like one in a comment, in CDATA, in quotes or in
/// a processing instruction is none. It does not ask whether the tags fit together.
class XmlTagReader {
 public:
  explicit XmlTagReader(const std::string& text) : text_(text) {}

  /// Goes to the next tag; false: there is none left, or one that does not end.
  bool next();

  std::string_view name() const { return name_; }  ///< "!DOCTYPE" for <!DOCTYPE ...>.
  bool opens() const { return !closes_ && !empty_; }  ///< <a>.
  bool closes() const { return closes_; }             ///< </a>.
  bool isEmpty() const { return empty_; }             ///< <a/>.
  int line() const { return line_; }                  ///< of the tag's first character, from 1.
  /// The text up to whatever comes next.
  std::string_view content() const;
  std::string_view attributes() const { return attributes_; }
  bool isCutOff() const { return cut_off_; }  ///< the text ends inside a tag or a comment.

 private:
  bool skip(std::size_t from, const char* end_mark);

  const std::string& text_;
  std::size_t begin_ = 0, end_ = 0, counted_ = 0;
  int line_ = 1;
  std::string_view name_, attributes_;
  bool closes_ = false, empty_ = false, cut_off_ = false;
};

}  // namespace ellipsoid_vehicle_sim
