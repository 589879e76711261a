#include "dae_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace ellipsoid_vehicle_sim {
namespace {

constexpr double kMostInputs = 64.0;
constexpr std::size_t kMostProblems = 20;

/// Calls read(word) for the words of an element's content until it says no.
template <typename Read>
void forEachWord(std::string_view text, Read&& read) {
  const char* blank = " \t\r\n";
  for (std::size_t at = text.find_first_not_of(blank); at != std::string_view::npos;) {
    const std::size_t end = std::min(text.find_first_of(blank, at), text.size());
    if (!read(text.substr(at, end - at))) return;
    at = text.find_first_not_of(blank, end);
  }
}

}  // namespace

DaeShapes::DaeShapes(const XmlTree& tree, const std::string& path, Problems& problems)
    : tree_(tree), path_(path), problems_(problems) {
  for (int i = 0; i < tree.size(); ++i)
    if (const auto id = XmlTree::attribute(tree[i], "id")) by_id_.emplace(*id, i);
}

void DaeShapes::problem(const Element& element, const std::string& message) {
  if (problems_.size() < kMostProblems) problems_.push_back({atLine(path_, element.line), message});
}

const DaeShapes::Element* DaeShapes::find(const std::string& id) const {
  const auto found = by_id_.find(id);
  return found == by_id_.end() ? nullptr : &tree_[found->second];
}

/// The element of this name that url="#id" or source="#id" leads to; a problem where there is none.
const DaeShapes::Element* DaeShapes::follow(const Element& from, const char* attribute, const char* name) {
  const std::string url = XmlTree::attribute(from, attribute).value_or("");
  const Element* to = !url.empty() && url[0] == '#' ? find(url.substr(1)) : nullptr;
  if (to != nullptr && to->name == name) return to;
  problem(from, "<" + from.name + " " + attribute + "=" + inQuotes(url) + ">: there is no such <" + name + "> in the file");
  return nullptr;
}

const DaeShapes::Element* DaeShapes::input(const Element& of, const char* semantic) const {
  for (const int i : of.children)
    if (tree_[i].name == "input" && XmlTree::attribute(tree_[i], "semantic") == std::string(semantic)) return &tree_[i];
  return nullptr;
}

/// A whole number >= 0.
std::optional<double> DaeShapes::count(const Element& element, const char* attribute, double without) {
  const std::optional<std::string> text = XmlTree::attribute(element, attribute);
  if (!text) return without;
  const std::optional<double> value = number_reader_.number(*text);
  if (value && *value >= 0.0 && *value <= 4294967295.0 && *value == std::floor(*value)) return value;
  problem(element, "<" + element.name + " " + attribute + "=" + inQuotes(*text) + "> is not a number of things");
  return std::nullopt;
}

std::optional<std::vector<double>> DaeShapes::numbers(const Element& array) {
  std::vector<double> values;
  const std::optional<double> announced = count(array, "count", -1.0);
  if (!announced) return std::nullopt;
  bool readable = array.children.empty();
  if (!readable) problem(array, "<" + array.name + "> holds something else than numbers");
  forEachWord(array.content, [&](std::string_view word) {
    const std::optional<double> value = number_reader_.number(word);
    if (!value) problem(array, inQuotes(word) + " in <" + array.name + "> is not a number");
    readable = readable && value;
    values.push_back(value.value_or(0.0));
    return readable;
  });
  if (!readable) return std::nullopt;
  if (*announced >= 0.0 && *announced > static_cast<double>(values.size())) {
    problem(array, "<" + array.name + " count=" + inQuotes(*XmlTree::attribute(array, "count")) + "> holds " +
                       std::to_string(values.size()) + " numbers");
    return std::nullopt;
  }
  return values;
}

DaeShapes::Points& DaeShapes::positions(const Element& source) {
  const auto known = positions_.find(&source);
  if (known != positions_.end()) return known->second;
  Points& result = positions_[&source];
  std::vector<Eigen::Vector3d>& points = result.points;
  const Element* technique = tree_.child(source, "technique_common");
  const Element* accessor = technique != nullptr ? tree_.child(*technique, "accessor") : nullptr;
  const Element* array = accessor != nullptr ? follow(*accessor, "source", "float_array") : tree_.child(source, "float_array");
  if (array == nullptr) {
    if (accessor == nullptr) problem(source, "<source> of positions without a <float_array>");
    return result;
  }
  double stride = 3.0, offset = 0.0, points_announced = -1.0;
  std::array<double, 3> axis = {0.0, 1.0, 2.0};
  if (accessor != nullptr) {
    const auto given_stride = count(*accessor, "stride", 1.0), given_offset = count(*accessor, "offset", 0.0);
    const auto given_count = count(*accessor, "count", -1.0);
    if (!given_stride || !given_offset || !given_count) return result;
    stride = *given_stride, offset = *given_offset, points_announced = *given_count;
    double place = 0.0;
    for (const int i : accessor->children) {
      if (tree_[i].name != "param") continue;
      const std::string name = XmlTree::attribute(tree_[i], "name").value_or("");
      if (name == "X" || name == "Y" || name == "Z") axis[static_cast<std::size_t>(name[0] - 'X')] = place;
      ++place;
    }
  }
  const std::optional<std::vector<double>> values = numbers(*array);
  if (!values) return result;
  const double size = static_cast<double>(values->size()), last = *std::max_element(axis.begin(), axis.end());
  if (points_announced < 0.0) points_announced = stride > 0.0 ? std::floor(size / stride) : 0.0;
  if (points_announced > 0.0 && (stride < 1.0 || offset + (points_announced - 1.0) * stride + last >= size)) {
    problem(*accessor, "<accessor> reaches beyond the " + std::to_string(values->size()) + " numbers of its array");
    return result;
  }
  points.reserve(static_cast<std::size_t>(points_announced));
  for (double i = 0.0; i < points_announced; ++i) {
    const auto at = [&](std::size_t k) { return (*values)[static_cast<std::size_t>(offset + i * stride + axis[k])]; };
    points.emplace_back(at(0), at(1), at(2));
  }
  result.number.resize(points.size());
  result.number_of.resize(points.size(), 0);
  return result;
}

std::vector<std::uint32_t> DaeShapes::indices(const Element& element, bool& readable) {
  std::vector<std::uint32_t> values;
  if (!element.children.empty()) {
    problem(element, "<" + element.name + "> holds something else than numbers");
    readable = false;
  }
  forEachWord(element.content, [&](std::string_view word) {
    const bool digits = word.size() <= 10 && word.find_first_not_of("0123456789") == std::string_view::npos;
    const double value = digits ? number_reader_.number(word).value_or(-1.0) : -1.0;
    if (value < 0.0 || value > 4294967294.0) {
      problem(element, inQuotes(word) + " in <" + element.name + "> is not a vertex number");
      readable = false;
    }
    values.push_back(readable ? static_cast<std::uint32_t>(value) : 0u);
    return readable;
  });
  return values;
}

void DaeShapes::readPrimitive(const Element& primitive, DaeShape& shape) {
  // Where among the numbers of a corner its position is, and where the positions are.
  double inputs = 1.0, place = 0.0;
  const Element* vertex = input(primitive, "VERTEX");
  const Element* position = vertex == nullptr ? input(primitive, "POSITION") : nullptr;
  for (const int i : primitive.children) {
    if (tree_[i].name != "input") continue;
    const std::optional<double> offset = count(tree_[i], "offset", 0.0);
    if (!offset) return;
    if (*offset >= kMostInputs)
      return problem(tree_[i], "<input offset=" + inQuotes(*XmlTree::attribute(tree_[i], "offset")) + ">; allowed are 0 to " +
                                   std::to_string(static_cast<int>(kMostInputs) - 1));
    inputs = std::max(inputs, *offset + 1.0);
    if (&tree_[i] == vertex || &tree_[i] == position) place = *offset;
  }
  if (vertex != nullptr) {
    const Element* vertices = follow(*vertex, "source", "vertices");
    if (vertices == nullptr) return;
    position = input(*vertices, "POSITION");
  }
  if (position == nullptr) return problem(primitive, "<" + primitive.name + "> without positions");
  const Element* source = follow(*position, "source", "source");
  if (source == nullptr) return;
  const std::size_t problems_before = problems_.size();
  Points& from = positions(*source);
  const std::vector<Eigen::Vector3d>& points = from.points;
  if (problems_.size() > problems_before) return;

  bool readable = true;
  std::vector<std::uint32_t> sizes;  // of a polylist's polygons
  if (const Element* vcount = tree_.child(primitive, "vcount"); vcount != nullptr && primitive.name == "polylist") {
    sizes = indices(*vcount, readable);
    if (!readable) return;
  }
  const std::optional<double> announced = count(primitive, "count", 0.0);
  if (!announced) return;
  const auto vertexOf = [&](std::uint32_t point) {
    if (from.number_of[point] != shape_count_) {
      from.number_of[point] = shape_count_;
      from.number[point] = static_cast<std::uint32_t>(shape.vertices.size());
      shape.vertices.push_back(points[point]);
    }
    return from.number[point];
  };
  const auto add = [&](std::initializer_list<std::uint32_t> corners) {
    for (const std::uint32_t c : corners) shape.corners.push_back(vertexOf(c));
    shape.ends.push_back(shape.corners.size());
  };
  for (const int i : primitive.children) {
    if (tree_[i].name == "ph") return problem(tree_[i], "polygons with holes (<ph>) are not read; allowed are <p>");
    if (tree_[i].name != "p") continue;
    const std::vector<std::uint32_t> all = indices(tree_[i], readable);
    if (!readable) return;
    const std::size_t step = static_cast<std::size_t>(inputs);
    if (all.size() % step != 0)
      return problem(tree_[i], std::to_string(all.size()) + " numbers in <p>, with " + std::to_string(step) + " to a corner: cut off");
    std::vector<std::uint32_t> p;
    for (std::size_t k = static_cast<std::size_t>(place); k < all.size(); k += step) {
      p.push_back(all[k]);
      if (p.back() >= points.size())
        return problem(tree_[i], "vertex number " + std::to_string(p.back()) + " of " + std::to_string(points.size()));
    }
    const std::size_t n = p.size();
    if (primitive.name == "triangles") {
      if (n % 3 != 0 || static_cast<double>(n / 3) != *announced)
        return problem(primitive, "<triangles count=" + inQuotes(XmlTree::attribute(primitive, "count").value_or("")) + "> has " +
                                      std::to_string(n) + " corners");
      for (std::size_t k = 0; k + 2 < n; k += 3) add({p[k], p[k + 1], p[k + 2]});
    } else if (primitive.name == "polylist") {
      std::size_t begin = 0;
      for (const std::uint32_t size : sizes) {
        if (size > n - begin) return problem(primitive, "<vcount> asks for more corners than <p> has (" + std::to_string(n) + ")");
        if (size < 3) {
          ++shape.lines;
        } else {
          for (std::size_t k = begin; k < begin + size; ++k) shape.corners.push_back(vertexOf(p[k]));
          shape.ends.push_back(shape.corners.size());
        }
        begin += size;
      }
      if (begin != n || static_cast<double>(sizes.size()) != *announced)
        return problem(primitive, "<polylist count=" + inQuotes(XmlTree::attribute(primitive, "count").value_or("")) + "> has " +
                                      std::to_string(sizes.size()) + " polygons of " + std::to_string(begin) +
                                      " corners together, and " + std::to_string(n) + " corners");
    } else if (primitive.name == "polygons") {
      if (n < 3) {
        shape.lines += n > 0 ? 1 : 0;
        continue;
      }
      for (const std::uint32_t point : p) shape.corners.push_back(vertexOf(point));
      shape.ends.push_back(shape.corners.size());
    } else if (primitive.name == "trifans") {
      for (std::size_t k = 1; k + 1 < n; ++k) add({p[0], p[k], p[k + 1]});
    } else if (primitive.name == "tristrips") {
      for (std::size_t k = 0; k + 2 < n; ++k) k % 2 == 0 ? add({p[k], p[k + 1], p[k + 2]}) : add({p[k + 1], p[k], p[k + 2]});
    } else {
      shape.lines += primitive.name == "lines" ? n / 2 : n > 0 ? n - 1 : 0;
    }
  }
}

const DaeShape* DaeShapes::shape(const std::string& id) {
  const auto known = shapes_.find(id);
  if (known != shapes_.end()) return &known->second;
  const Element* element = find(id);
  if (element != nullptr && element->name == "controller") {
    // Drawn as modelled, as assimp leaves it.
    const Element* skin = tree_.child(*element, "skin");
    element = skin != nullptr ? follow(*skin, "source", "geometry") : nullptr;
  }
  if (element == nullptr || element->name != "geometry") return nullptr;
  DaeShape& shape = shapes_[id];
  ++shape_count_;
  const Element* mesh = tree_.child(*element, "mesh");
  if (mesh == nullptr) return &shape;
  for (const int i : mesh->children) {
    const std::string& name = tree_[i].name;
    for (const char* known_name : {"triangles", "polylist", "polygons", "trifans", "tristrips", "lines", "linestrips"})
      if (name == known_name) readPrimitive(tree_[i], shape);
  }
  return &shape;
}

}  // namespace ellipsoid_vehicle_sim
