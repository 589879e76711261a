#include "ellipsoid_vehicle_sim/description/collision_shape.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "ellipsoid_vehicle_sim/description/number_text.h"
#include "ellipsoid_vehicle_sim/world/mesh_file.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

/// Centre c of the sphere that meets |v - c|^2 = R^2 best, linear in c and R^2 - |c|^2.
std::optional<Vector3d> sphereCentre(const std::vector<Vector3d>& vertices, const Vector3d& middle, double size) {
  Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
  Eigen::Vector4d b = Eigen::Vector4d::Zero();
  for (const Vector3d& vertex : vertices) {
    const Vector3d v = (vertex - middle) / size;  // about the middle and of size one, or the squares cancel
    const Eigen::Vector4d row(2.0 * v.x(), 2.0 * v.y(), 2.0 * v.z(), 1.0);
    A += row * row.transpose();
    b += row * v.squaredNorm();
  }
  const double count = static_cast<double>(vertices.size());
  Eigen::Matrix4d inverse;
  bool invertible = false;  // not for points of a plane, or of fewer dimensions; of size one, 1e-9 is far from both
  (A / count).eval().computeInverseWithCheck(inverse, invertible, 1e-9);
  if (!invertible) return std::nullopt;
  const Eigen::Vector4d solution = inverse * (b / count);
  return middle + size * solution.head<3>();
}

}  // namespace

std::string extentsText(const Vector3d& extents) {
  return numberText(extents.x()) + " x " + numberText(extents.y()) + " x " + numberText(extents.z());
}

std::vector<Vector3d> evenDirections(int count) {
  std::vector<Vector3d> directions;
  const double golden = M_PI * (3.0 - std::sqrt(5.0));
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / count, r = std::sqrt(1.0 - z * z);
    directions.emplace_back(r * std::cos(golden * i), r * std::sin(golden * i), z);
  }
  return directions;
}

Loaded<std::vector<Vector3d>> readMeshVertices(const std::string& path) {
  auto mesh = readMeshFile(path);
  Loaded<std::vector<Vector3d>> result{std::nullopt, std::move(mesh.problems), std::move(mesh.notes)};
  if (mesh) result.value = std::move(mesh.value->vertices);
  return result;
}

double support(const CollisionShape& shape, const Vector3d& d_S) {
  const Vector3d& h = shape.half;
  switch (shape.kind) {
    case CollisionShape::Kind::kEllipsoid:
      return h.cwiseProduct(d_S).norm();
    case CollisionShape::Kind::kBox:
      return h.dot(d_S.cwiseAbs());
    case CollisionShape::Kind::kCylinder:
      return h.x() * std::hypot(d_S.x(), d_S.y()) + h.z() * std::abs(d_S.z());
    case CollisionShape::Kind::kMesh:
      break;
  }
  double reach = 0.0;
  if (shape.vertices_S) {
    for (const Vector3d& v : *shape.vertices_S) reach = std::max(reach, v.dot(d_S));
  }
  return reach;
}

std::optional<FittedSphere> fitSphere(const std::vector<Vector3d>& vertices) {
  if (vertices.size() < 12) return std::nullopt;
  Vector3d low = vertices.front(), high = vertices.front();
  for (const Vector3d& v : vertices) low = low.cwiseMin(v), high = high.cwiseMax(v);
  const double size = 0.5 * (high - low).maxCoeff();
  if (!(size > 0.0)) return std::nullopt;
  const auto centre = sphereCentre(vertices, 0.5 * (low + high), size);
  if (!centre) return std::nullopt;
  double smallest = std::numeric_limits<double>::infinity(), largest = 0.0;
  for (const Vector3d& v : vertices) {
    const double r = (v - *centre).norm();
    smallest = std::min(smallest, r), largest = std::max(largest, r);
  }
  const double radius = 0.5 * (smallest + largest);
  if (!(largest - radius <= 0.01 * radius)) return std::nullopt;
  for (const Vector3d& d : evenDirections(200)) {
    double reach = 0.0;
    for (const Vector3d& v : vertices) reach = std::max(reach, (v - *centre).dot(d));
    if (reach < 0.85 * radius) return std::nullopt;
  }
  // The largest: all vertices lie in or on it, and a modelled sphere's vertices lie on the sphere that was meant.
  return FittedSphere{*centre, largest};
}

ShapeBuilder::ShapeBuilder(std::string file, UriResolver resolver, MeshVertexReader reader)
    : file_(std::move(file)), resolver_(std::move(resolver)), reader_(std::move(reader)) {}

const ShapeBuilder::Mesh& ShapeBuilder::mesh(const std::string& uri, std::vector<std::string>& notes) {
  const auto known = meshes_.find(uri);
  if (known != meshes_.end()) return known->second;
  Mesh& mesh = meshes_[uri];
  if (uri == kUnitSphereUri) {
    // Known by its name: the shipped vehicles then load wherever the package lies.
    mesh.sphere = FittedSphere{Vector3d::Zero(), 1.0};
    return mesh;
  }
  const auto path = resolver_(uri);
  if (!path) {
    mesh.fault = "was not found";
    return mesh;
  }
  auto loaded = reader_(*path);
  if (!loaded) {
    mesh.fault = "cannot be read";
    for (const Problem& problem : loaded.problems) mesh.fault += " (" + problem.text() + ")";
    return mesh;
  }
  for (const std::string& note : loaded.notes) notes.push_back(note);
  mesh.vertices = std::move(*loaded.value);
  if (mesh.vertices.empty()) mesh.fault = "holds no triangles";
  for (const Vector3d& v : mesh.vertices) {
    if (!v.allFinite())
      mesh.fault = "holds a vertex that is not finite";
    else if (!(v.cwiseAbs().maxCoeff() <= kLargestLength))
      mesh.fault = "holds a vertex farther than 1e6 from its origin";
    if (!mesh.fault.empty()) return mesh;
  }
  mesh.sphere = fitSphere(mesh.vertices);
  return mesh;
}

std::optional<CollisionShape> ShapeBuilder::buildMesh(const ShapeText& text, const std::string& place,
                                                      Problems& problems, std::vector<std::string>& notes) {
  const Mesh& source = mesh(text.filename, notes);
  if (!source.fault.empty()) {
    problems.push_back(
        {place, "collision mesh \"" + text.filename + "\" " + source.fault +
                    "; allowed is a mesh file (STL,"
                    " OBJ, DAE) of finite vertices, package:// looked up beside the URDF and in the package folders"});
    return std::nullopt;
  }
  CollisionShape shape;
  shape.line = text.line;
  const std::string name = text.filename.substr(text.filename.find_last_of('/') + 1);
  const auto inRange = [&](double smallest, double largest) {
    if (smallest >= kSmallestLength && largest <= kLargestLength) return true;
    problems.push_back({place, "collision mesh \"" + text.filename + "\" is " + extentsText(2.0 * shape.half) +
                                   " m after scale; allowed is between 1e-9 and 1e6 m"});
    return false;
  };
  if (source.sphere) {
    shape.kind = CollisionShape::Kind::kEllipsoid;
    shape.half = source.sphere->radius * text.scale;
    if (!inRange(shape.half.minCoeff(), shape.half.maxCoeff())) return std::nullopt;
    shape.X_LS = text.X_LS * Pose{source.sphere->centre.cwiseProduct(text.scale), Eigen::Quaterniond::Identity()};
    shape.text = "sphere mesh " + name + " " + extentsText(shape.half);
    return shape;
  }
  Vector3d low = source.vertices.front(), high = low;
  for (const Vector3d& v : source.vertices) low = low.cwiseMin(v), high = high.cwiseMax(v);
  const Vector3d middle = 0.5 * (low + high);
  shape.kind = CollisionShape::Kind::kMesh;
  shape.half = 0.5 * (high - low).cwiseProduct(text.scale);
  shape.X_LS = text.X_LS * Pose{middle.cwiseProduct(text.scale), Eigen::Quaterniond::Identity()};
  const double largest = shape.half.maxCoeff();
  if (!inRange(largest, largest)) return std::nullopt;  // a flat one is thickened below
  // A sheet has no ellipsoid; a hundredth of its width is thin enough and still a body.
  constexpr double kThinnest = 0.01;
  if (shape.half.minCoeff() < kThinnest * largest) {
    notes.push_back(place + ": collision mesh " + name + " is " + extentsText(2.0 * shape.half) +
                    " m, nearly flat: thickened to 1 % of its width");
    shape.half = shape.half.cwiseMax(kThinnest * largest);
  }
  auto vertices = std::make_shared<std::vector<Vector3d>>();
  vertices->reserve(source.vertices.size());
  for (const Vector3d& v : source.vertices) vertices->push_back((v - middle).cwiseProduct(text.scale));
  shape.vertices_S = std::move(vertices);
  shape.text = "mesh " + name + " " + extentsText(2.0 * shape.half);
  return shape;
}

std::vector<CollisionShape> ShapeBuilder::build(const LinkText& link, Problems& problems,
                                                std::vector<std::string>& notes) {
  std::vector<CollisionShape> shapes;
  for (const ShapeText& text : link.collisions) {
    if (text.kind == ShapeText::Kind::kMesh) {
      if (auto shape = buildMesh(text, placeText(file_, text.line, "link", link.name), problems, notes)) {
        shapes.push_back(std::move(*shape));
      }
      continue;
    }
    CollisionShape shape;
    shape.line = text.line;
    shape.X_LS = text.X_LS;
    const Vector3d& size = text.size;
    if (text.kind == ShapeText::Kind::kSphere) {
      shape.kind = CollisionShape::Kind::kEllipsoid;
      shape.half = Vector3d::Constant(size[0]);
      shape.text = "sphere r=" + numberText(size[0]);
    } else if (text.kind == ShapeText::Kind::kBox) {
      shape.kind = CollisionShape::Kind::kBox;
      shape.half = 0.5 * size;
      shape.text = "box " + extentsText(size);
    } else {
      shape.kind = CollisionShape::Kind::kCylinder;
      shape.half = {size[0], size[0], 0.5 * size[1]};
      shape.text = "cylinder r=" + numberText(size[0]) + " l=" + numberText(size[1]);
    }
    shapes.push_back(std::move(shape));
  }
  return shapes;
}

bool ShapeBuilder::visualExists(const ShapeText& visual) const {
  return visual.kind != ShapeText::Kind::kMesh || visual.filename == kUnitSphereUri ||
         resolver_(visual.filename).has_value();
}

}  // namespace ellipsoid_vehicle_sim
