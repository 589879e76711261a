// Why not assimp 5.2: it follows an <instance_node> that contains itself until the stack ends, ends the program at an
// assertion where a <polygons> has no count, does not return from a letter among the vertex numbers, reads a negative one
// as 0, believes what counts, strides and offsets say of the size of arrays, takes a unit it cannot read for 1, and rounds
// to float. Read here is what makes shape: geometry, the nodes of the scene and their places.
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "dae_shapes.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Matrix4d;
using Eigen::Vector3d;

constexpr int kDeepestNode = 500;
constexpr std::size_t kMostNodes = 1000000, kMostTriangles = 20000000;

/// Goes through the scene node by node, own geometry first, then the nodes within, then those by instance.
class DaeReader {
 public:
  DaeReader(const XmlTree& tree, const std::string& path)
      : tree_(tree), path_(path), shapes_(tree, path, result_.problems) {}

  Loaded<MeshData> read() {
    if (tree_.root().name != "COLLADA") {
      problem(tree_.root(), "the root element is " + inQuotes("<" + tree_.root().name + ">") + "; allowed is <COLLADA>");
      return std::move(result_);
    }
    for (int i = 0; i < tree_.size(); ++i) {
      if (tree_[i].name != "node" && tree_[i].name != "visual_scene") continue;
      if (const auto id = XmlTree::attribute(tree_[i], "id")) nodes_.emplace(*id, i);
    }
    // By name only where nothing has it as its id.
    for (int i = 0; i < tree_.size(); ++i) {
      if (tree_[i].name != "node") continue;
      if (const auto name = XmlTree::attribute(tree_[i], "name")) nodes_.emplace(*name, i);
    }
    const double unit = lengthUnit();
    const XmlTree::Element* scene = tree_.child(tree_.root(), "scene");
    const XmlTree::Element* instance = scene != nullptr ? tree_.child(*scene, "instance_visual_scene") : nullptr;
    if (instance == nullptr) {
      problem(tree_.root(), "no <scene> with an <instance_visual_scene>, so nothing is shown");
    } else if (const int to = target(*instance); to >= 0 && result_.problems.empty()) {
      Matrix4d X_W = Matrix4d::Identity();
      X_W.topLeftCorner<3, 3>() *= unit;
      visit(to, X_W, 1);
    }
    return finish();
  }

 private:
  Loaded<MeshData> finish() {
    if (!result_.problems.empty()) return std::move(result_);
    if (cutter_.fanned() > 0) note(fannedNote(cutter_.fanned()));
    if (lines_ > 0) note(std::to_string(lines_) + " points and lines ignored");
    if (skews_ > 0) note(std::to_string(skews_) + " <skew> ignored, as RViz does");
    result_.value = std::move(mesh_);
    return std::move(result_);
  }

  void note(const std::string& text) { result_.notes.push_back(path_ + ": " + text); }
  void problem(const XmlTree::Element& element, const std::string& message) {
    result_.problems.push_back({atLine(path_, element.line), message});
  }

  double lengthUnit() {
    const XmlTree::Element* asset = tree_.child(tree_.root(), "asset");
    const XmlTree::Element* unit = asset != nullptr ? tree_.child(*asset, "unit") : nullptr;
    const std::optional<std::string> text = unit != nullptr ? XmlTree::attribute(*unit, "meter") : std::nullopt;
    if (!text) return 1.0;
    const std::optional<double> meter = numbers_.number(*text);
    if (meter && std::isfinite(*meter) && *meter > 0.0) return *meter;
    problem(*unit, "unit meter=" + inQuotes(*text) + "; allowed is a length > 0 in metres");
    return 1.0;
  }

  /// The node or scene of url="#id"; -1 and a problem where there is none.
  int target(const XmlTree::Element& instance) {
    const std::string url = XmlTree::attribute(instance, "url").value_or("");
    const auto found = url.empty() || url[0] != '#' ? nodes_.end() : nodes_.find(url.substr(1));
    if (found != nodes_.end()) return found->second;
    problem(instance, "<" + instance.name + "> of " + inQuotes(url.empty() ? url : url.substr(1)) + ", which is not in the file");
    return -1;
  }

  /// The numbers of a <matrix>, <translate> ...; problems where they are not so many.
  std::optional<std::vector<double>> values(const XmlTree::Element& element, std::size_t count) {
    std::vector<double> result;
    const std::string text(element.content);
    WordReader words(text);
    for (std::string_view word = words.word(); !word.empty() && result.size() <= count; word = words.word()) {
      const std::optional<double> value = numbers_.number(word);
      if (!value || !std::isfinite(*value)) {
        problem(element, inQuotes(word) + " in <" + element.name + "> is not a finite number");
        return std::nullopt;
      }
      result.push_back(*value);
    }
    if (result.size() == count) return result;
    problem(element, "<" + element.name + "> needs " + std::to_string(count) + " numbers");
    return std::nullopt;
  }

  Matrix4d transform(const XmlTree::Element& element) {
    Matrix4d X = Matrix4d::Identity();
    if (element.name == "matrix") {
      if (const auto v = values(element, 16)) X = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(v->data());
    } else if (element.name == "translate") {
      if (const auto v = values(element, 3)) X.topRightCorner<3, 1>() = Vector3d((*v)[0], (*v)[1], (*v)[2]);
    } else if (element.name == "scale") {
      if (const auto v = values(element, 3)) X.diagonal().head<3>() = Vector3d((*v)[0], (*v)[1], (*v)[2]);
    } else if (element.name == "rotate") {
      const auto v = values(element, 4);
      const Vector3d axis = v ? Vector3d((*v)[0], (*v)[1], (*v)[2]) : Vector3d::Zero();
      if (axis.norm() > 0.0)
        X.topLeftCorner<3, 3>() = Eigen::AngleAxisd((*v)[3] * M_PI / 180.0, axis.normalized()).toRotationMatrix();
    } else if (element.name == "lookat") {
      if (const auto v = values(element, 9)) {
        const Vector3d eye((*v)[0], (*v)[1], (*v)[2]), there((*v)[3], (*v)[4], (*v)[5]), up((*v)[6], (*v)[7], (*v)[8]);
        const Vector3d z = (eye - there).normalized(), x = up.cross(z).normalized();
        X.topLeftCorner<3, 3>() << x, z.cross(x), z;
        X.topRightCorner<3, 1>() = eye;
      }
    } else if (element.name == "skew") {
      ++skews_;
    }
    return X;
  }

  bool goesOn() const { return result_.problems.empty(); }

  void visit(int i, const Matrix4d& parent, int depth) {
    const XmlTree::Element& node = tree_[i];
    const std::string id = XmlTree::attribute(node, "id").value_or("");
    if (!on_way_.insert(i).second) return result_.problems.push_back({path_, "node " + inQuotes(id) + " contains itself through <instance_node>"});
    if (++visited_ > kMostNodes) return result_.problems.push_back({path_, "node " + inQuotes(id) + " and others unfold into more than a million nodes"});
    if (depth > kDeepestNode) return result_.problems.push_back({path_, "node " + inQuotes(id) + " unfolds into more than " + std::to_string(kDeepestNode) + " levels"});
    Matrix4d X_W = parent;
    for (const int c : node.children)
      if (goesOn()) X_W = X_W * transform(tree_[c]);
    for (const int c : node.children) {
      if (goesOn() && (tree_[c].name == "instance_geometry" || tree_[c].name == "instance_controller")) append(tree_[c], X_W);
    }
    for (const int c : node.children)
      if (goesOn() && tree_[c].name == "node") visit(c, X_W, depth + 1);
    for (const int c : node.children) {
      const int to = goesOn() && tree_[c].name == "instance_node" ? target(tree_[c]) : -1;
      if (to >= 0) visit(to, X_W, depth + 1);
    }
    on_way_.erase(i);
  }

  void append(const XmlTree::Element& instance, const Matrix4d& X_W) {
    const std::string url = XmlTree::attribute(instance, "url").value_or("");
    const DaeShape* shape = url.empty() || url[0] != '#' ? nullptr : shapes_.shape(url.substr(1));
    if (shape == nullptr) {
      if (goesOn()) problem(instance, "<" + instance.name + "> of " + inQuotes(url.empty() ? url : url.substr(1)) + ", which is not in the file");
      return;
    }
    lines_ += shape->lines;
    if (mesh_.triangles.size() + shape->corners.size() > kMostTriangles)
      return problem(instance, "the scene unfolds into more than " + std::to_string(kMostTriangles) + " triangles");
    const auto base = static_cast<std::uint32_t>(mesh_.vertices.size());
    for (const Vector3d& v : shape->vertices) mesh_.vertices.push_back((X_W * v.homogeneous()).head<3>());
    // A mirror turns the sense of the corners: turn it back, so that the front stays on the outside.
    const bool mirrors = X_W.topLeftCorner<3, 3>().determinant() < 0.0;
    std::size_t begin = 0;
    for (const std::size_t end : shape->ends) {
      polygon_.clear();
      for (std::size_t k = begin; k < end; ++k) polygon_.push_back(base + shape->corners[k]);
      if (mirrors) std::reverse(polygon_.begin() + 1, polygon_.end());
      cutter_.append(mesh_.vertices, polygon_.data(), polygon_.size(), mesh_.triangles);
      begin = end;
    }
  }

  const XmlTree& tree_;
  const std::string& path_;
  Loaded<MeshData> result_;
  DaeShapes shapes_;
  NumberReader numbers_;
  MeshData mesh_;
  PolygonCutter cutter_;
  std::vector<std::uint32_t> polygon_;
  std::map<std::string, int> nodes_;
  std::set<int> on_way_;
  std::size_t visited_ = 0, lines_ = 0, skews_ = 0;
};

}  // namespace

Loaded<MeshData> readDae(const std::string& text, const std::string& path) {
  const Loaded<XmlTree> tree = XmlTree::parse(text, path);
  if (!tree) return {std::nullopt, tree.problems, {}};
  return DaeReader(*tree.value, path).read();
}

}  // namespace ellipsoid_vehicle_sim
