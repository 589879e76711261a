#include "xml_tags.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>

namespace ellipsoid_vehicle_sim {
namespace {

constexpr const char* kBlank = " \t\r\n";

/// &amp; &#65; &#x41;, as far as they are ASCII: names hold nothing else that matters here.
std::string withoutReferences(std::string_view value) {
  std::string text;
  for (std::size_t at = 0; at < value.size(); ++at) {
    const std::size_t end = value[at] == '&' ? value.find(';', at) : std::string_view::npos;
    if (end == std::string_view::npos) {
      text += value[at];
      continue;
    }
    const std::string name(value.substr(at + 1, end - at - 1));
    long code = -1;
    if (name == "amp") code = '&';
    if (name == "lt") code = '<';
    if (name == "gt") code = '>';
    if (name == "quot") code = '"';
    if (name == "apos") code = '\'';
    if (name.size() > 1 && name[0] == '#')
      code = name[1] == 'x' ? std::strtol(name.c_str() + 2, nullptr, 16) : std::strtol(name.c_str() + 1, nullptr, 10);
    if (code < 1 || code > 127) {
      text += value[at];
      continue;
    }
    text += static_cast<char>(code);
    at = end;
  }
  return text;
}

}  // namespace

bool XmlTagReader::skip(std::size_t from, const char* end_mark) {
  const std::size_t at = text_.find(end_mark, from);
  if (at == std::string::npos) return false;
  end_ = at + std::strlen(end_mark);
  return true;
}

bool XmlTagReader::next() {
  for (;;) {
    begin_ = text_.find('<', end_);
    if (begin_ == std::string::npos) return false;
    const std::string_view rest = std::string_view(text_).substr(begin_);
    const auto startsWith = [&rest](std::string_view mark) { return rest.substr(0, mark.size()) == mark; };
    const char* end_mark = startsWith("<!--") ? "-->" : startsWith("<![CDATA[") ? "]]>" : startsWith("<?") ? "?>" : nullptr;
    if (end_mark == nullptr) break;
    if (!skip(begin_ + 2, end_mark)) return !(cut_off_ = true);
  }
  for (; counted_ < begin_; ++counted_) line_ += text_[counted_] == '\n';
  char quote = '\0';
  for (end_ = begin_ + 1; end_ < text_.size() && (quote != '\0' || text_[end_] != '>'); ++end_) {
    const char c = text_[end_];
    if (quote != '\0') {
      if (c == quote) quote = '\0';
    } else if (c == '"' || c == '\'') {
      quote = c;
    }
  }
  if (end_ >= text_.size()) return !(cut_off_ = true);
  ++end_;
  std::string_view inside = std::string_view(text_).substr(begin_ + 1, end_ - begin_ - 2);
  closes_ = !inside.empty() && inside.front() == '/';
  empty_ = !inside.empty() && inside.back() == '/';
  if (closes_) inside.remove_prefix(1);
  if (empty_ && !inside.empty()) inside.remove_suffix(1);
  const std::size_t name_end = std::min(inside.find_first_of(kBlank), inside.size());
  name_ = inside.substr(0, name_end);
  attributes_ = inside.substr(name_end);
  return true;
}

std::string_view XmlTagReader::content() const {
  const std::size_t past = std::min(text_.find('<', end_), text_.size());
  return std::string_view(text_).substr(end_, past - end_);
}

std::optional<std::string> xmlAttribute(std::string_view attributes, std::string_view name) {
  for (std::size_t at = attributes.find_first_not_of(kBlank); at != std::string_view::npos;) {
    const std::size_t name_end = std::min(attributes.find_first_of(" \t\r\n=", at), attributes.size());
    const std::size_t open = attributes.find_first_of("\"'", name_end);
    if (open == std::string_view::npos) return std::nullopt;
    const std::size_t close = attributes.find(attributes[open], open + 1);
    if (close == std::string_view::npos) return std::nullopt;
    if (attributes.substr(at, name_end - at) == name)
      return withoutReferences(attributes.substr(open + 1, close - open - 1));
    at = attributes.find_first_not_of(kBlank, close + 1);
  }
  return std::nullopt;
}

}  // namespace ellipsoid_vehicle_sim
