#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ellipsoid_vehicle_sim/geometry/problem.h"

namespace ellipsoid_vehicle_sim {

/// The elements of an XML text; what they say stays in the text, which has to outlive them. No element lies deeper than
/// 500 others, so that they may be walked by recursion.
class XmlTree {
 public:
  struct Element {
    std::string name;
    int line = 0;
    std::string_view attributes, content;  ///< of an element with children, up to the first.
    std::vector<int> children;
  };

  /// Problems: tags that do not fit together or do not end, a document type definition, elements nested too deep.
  static Loaded<XmlTree> parse(const std::string& text, const std::string& path);

  const Element& root() const { return elements_.front(); }
  const Element& operator[](int i) const { return elements_[static_cast<std::size_t>(i)]; }
  int size() const { return static_cast<int>(elements_.size()); }
  /// The first child of this name; nullptr: none.
  const Element* child(const Element& element, std::string_view name) const;
  static std::optional<std::string> attribute(const Element& element, std::string_view name);

 private:
  std::vector<Element> elements_;  ///< in document order
};

}  // namespace ellipsoid_vehicle_sim
