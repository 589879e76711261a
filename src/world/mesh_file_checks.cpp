// What assimp 5.2 has to be kept from: it follows an <instance_node> that contains itself until the stack ends, dies of
// an array without a count, does not return from a letter among the vertex numbers and reads a negative one as 0,
// leaves out an instance of a geometry that is not there, takes a unit it cannot read for 1 and one of 0 as it is.
#include <cmath>
#include <map>
#include <set>

#include "mesh_readers.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr int kDeepestNode = 500;
constexpr double kMostNodes = 1e6;

/// Value of an attribute in the inside of a tag, e.g. of `id` in `node id="a" name="b"`.
std::optional<std::string> attribute(std::string_view tag, std::string_view name) {
  for (std::size_t at = tag.find(name); at != std::string_view::npos; at = tag.find(name, at + 1)) {
    const bool starts =
        at > 0 && (tag[at - 1] == ' ' || tag[at - 1] == '\t' || tag[at - 1] == '\n' || tag[at - 1] == '\r');
    const std::size_t equals = tag.find_first_not_of(" \t\r\n", at + name.size());
    if (!starts || equals == std::string_view::npos || tag[equals] != '=') continue;
    const std::size_t open = tag.find_first_of("\"'", equals);
    if (open == std::string_view::npos) return std::nullopt;
    const std::size_t close = tag.find(tag[open], open + 1);
    if (close == std::string_view::npos) return std::nullopt;
    return std::string(tag.substr(open + 1, close - open - 1));
  }
  return std::nullopt;
}

std::string_view nameOf(std::string_view tag) { return tag.substr(0, tag.find_first_of(" \t\r\n/", 1)); }

/// Nodes by id with the ids they instantiate or hold, in a DAE's scene.
class NodeGraph {
 public:
  /// Number of nodes that a walk from `id` visits; NaN when it comes back to itself.
  double walk(const std::string& id) {
    const auto known = size_.find(id);
    if (known != size_.end()) return known->second;
    if (!open_.insert(id).second) return std::nan("");
    double size = 1.0;
    for (const std::string& child : children[id]) size += walk(child);
    open_.erase(id);
    return size_[id] = size;
  }

  std::map<std::string, std::vector<std::string>> children;

 private:
  std::map<std::string, double> size_;
  std::set<std::string> open_;
};

}  // namespace

Problems checkDae(const std::string& text, const std::string& path) {
  Problems problems;
  NodeGraph graph;
  NumberReader numbers;
  std::vector<std::string> open;  // ids of the nodes around this place
  int line = 1, unnamed = 0;
  std::size_t counted = 0;
  std::set<std::string> geometries;
  std::vector<std::pair<int, std::string>> instances;  // of geometries, with their lines
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at + 1)) {
    for (; counted < at; ++counted) line += text[counted] == '\n';
    if (text.compare(at, 4, "<!--") == 0) {
      at = text.find("-->", at);
      if (at == std::string::npos) break;
      continue;
    }
    const std::size_t end = text.find('>', at);
    if (end == std::string::npos) break;
    const std::string_view tag = std::string_view(text).substr(at + 1, end - at - 1);
    const std::string_view name = nameOf(tag);
    if (name == "unit") {
      const std::optional<std::string> meter = attribute(tag, "meter");
      const std::optional<double> value = meter ? numbers.number(*meter) : 1.0;
      if (!value || !std::isfinite(*value) || *value <= 0.0) {
        problems.push_back(
            {atLine(path, line), "unit meter=" + inQuotes(*meter) + "; allowed is a length > 0 in metres"});
      }
    } else if (name == "p" || name == "h" || name == "vcount") {
      const std::size_t odd = text.find_first_not_of("0123456789 \t\r\n", end + 1);
      if (odd != std::string::npos && text[odd] != '<') {
        const std::size_t past = text.find_first_of(" \t\r\n<", odd);
        problems.push_back({atLine(path, line), inQuotes(std::string_view(text).substr(odd, past - odd)) + " in <" +
                                                    std::string(name) + "> is not a vertex number"});
      }
    } else if (name == "float_array") {
      const std::optional<double> count = numbers.number(attribute(tag, "count").value_or(""));
      // Two bytes to a number, the last one without a blank.
      if (!count || *count < 0.0 || *count > 0.5 * static_cast<double>(text.size())) {
        problems.push_back(
            {atLine(path, line), "float_array with count=" + inQuotes(attribute(tag, "count").value_or("")) +
                                     " in a file of " + std::to_string(text.size()) + " bytes"});
      }
    } else if (name == "geometry") {
      geometries.insert(attribute(tag, "id").value_or(""));
    } else if (name == "instance_geometry") {
      const std::string url = attribute(tag, "url").value_or("");
      if (!url.empty() && url[0] == '#') instances.emplace_back(line, url.substr(1));
    } else if (name == "node") {
      const std::string id = attribute(tag, "id").value_or("\n" + std::to_string(unnamed++));
      if (!open.empty()) graph.children[open.back()].push_back(id);
      graph.children[id];
      if (tag.empty() || tag.back() != '/') open.push_back(id);
      if (open.size() > kDeepestNode) {
        problems.push_back({atLine(path, line), "nodes nested deeper than " + std::to_string(kDeepestNode)});
        return problems;
      }
    } else if (name == "/node") {
      if (!open.empty()) open.pop_back();
    } else if (name == "instance_node" && !open.empty()) {
      const std::string url = attribute(tag, "url").value_or("");
      if (!url.empty() && url[0] == '#') graph.children[open.back()].push_back(url.substr(1));
    }
  }
  for (const auto& [instance_line, id] : instances) {
    if (geometries.count(id) == 0) {
      problems.push_back(
          {atLine(path, instance_line), "<instance_geometry> of " + inQuotes(id) + ", which is not in the file"});
    }
  }
  const std::map<std::string, std::vector<std::string>> nodes = graph.children;
  for (const auto& node : nodes) {
    const double size = graph.walk(node.first);
    if (size <= kMostNodes) continue;
    problems.push_back({path, "node " + inQuotes(node.first) +
                                  (std::isnan(size) ? " contains itself through <instance_node>"
                                                    : " unfolds into more than a million nodes")});
    break;
  }
  return problems;
}

}  // namespace ellipsoid_vehicle_sim
