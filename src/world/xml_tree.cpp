#include "xml_tree.h"

#include "mesh_readers.h"
#include "xml_tags.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr std::size_t kDeepest = 500;

}  // namespace

Loaded<XmlTree> XmlTree::parse(const std::string& text, const std::string& path) {
  Loaded<XmlTree> result;
  XmlTree tree;
  XmlTagReader tags(text);
  std::vector<int> open;
  const auto refuse = [&](int line, const std::string& message) {
    result.problems.push_back({line > 0 ? atLine(path, line) : path, message});
    return result;
  };
  while (tags.next()) {
    const std::string name(tags.name());
    if (name.substr(0, 1) == "!")
      return refuse(tags.line(), "a document type definition (<" + name.substr(0, 20) + ">), which is not read; allowed is a file without");
    if (tags.closes()) {
      if (open.empty() || tree[open.back()].name != name)
        return refuse(tags.line(), "malformed XML: " + inQuotes("</" + name + ">") + " closes " +
                                       (open.empty() ? "nothing" : inQuotes("<" + tree[open.back()].name + ">")));
      open.pop_back();
      continue;
    }
    if (name.empty() || (open.empty() && !tree.elements_.empty()))
      return refuse(tags.line(), "malformed XML: " + inQuotes("<" + name + ">") + " where no element can be");
    const int i = tree.size();
    tree.elements_.push_back({name, tags.line(), tags.attributes(), tags.opens() ? tags.content() : std::string_view(), {}});
    if (!open.empty()) tree.elements_[static_cast<std::size_t>(open.back())].children.push_back(i);
    if (!tags.opens()) continue;
    open.push_back(i);
    if (open.size() > kDeepest) return refuse(tags.line(), "elements nested deeper than " + std::to_string(kDeepest));
  }
  if (tags.isCutOff()) return refuse(tags.line(), "malformed XML: a tag or comment that does not end");
  if (!open.empty())
    return refuse(tree[open.back()].line, "malformed XML: " + inQuotes("<" + tree[open.back()].name + ">") + " is never closed");
  if (tree.elements_.empty()) return refuse(0, "holds no XML element");
  result.value = std::move(tree);
  return result;
}

const XmlTree::Element* XmlTree::child(const Element& element, std::string_view name) const {
  for (const int i : element.children)
    if ((*this)[i].name == name) return &(*this)[i];
  return nullptr;
}

std::optional<std::string> XmlTree::attribute(const Element& element, std::string_view name) {
  return xmlAttribute(element.attributes, name);
}

}  // namespace ellipsoid_vehicle_sim
