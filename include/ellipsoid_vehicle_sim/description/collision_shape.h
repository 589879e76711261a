#pragma once

#include <Eigen/Core>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/description/urdf_text.h"
#include "ellipsoid_vehicle_sim/description/uri_resolver.h"
#include "ellipsoid_vehicle_sim/geometry/pose.h"
#include "ellipsoid_vehicle_sim/geometry/problem.h"

namespace ellipsoid_vehicle_sim {

/// Reads the vertices of a mesh file, in the file's own axes and units as RViz draws them; passed in, so that this
/// layer does not choose the mesh library.
using MeshVertexReader = std::function<Loaded<std::vector<Eigen::Vector3d>>(const std::string& path)>;

/// The world layer's mesh reader, vertices only.
Loaded<std::vector<Eigen::Vector3d>> readMeshVertices(const std::string& path);

/// A <collision> with its mesh read: what there is to be turned into an ellipsoid. Frame S: the shape's own axes with
/// the origin in its middle (of a mesh: of its bounding box).
struct CollisionShape {
  enum class Kind { kEllipsoid, kBox, kCylinder, kMesh };
  Kind kind = Kind::kEllipsoid;
  Pose X_LS;             ///< in the link frame.
  Eigen::Vector3d half;  ///< half extents along the axes of S [m]; a cylinder stands along z.
  std::shared_ptr<const std::vector<Eigen::Vector3d>> vertices_S;  ///< mesh only.
  int line = 0;
  std::string text;  ///< "cylinder r=0.1651 l=0.1143".
};

/// How far the shape reaches from its middle in the direction d_S (unit) [m].
double support(const CollisionShape& shape, const Eigen::Vector3d& d_S);

/// "2 x 0.8 x 0.5".
std::string extentsText(const Eigen::Vector3d& extents);

/// Unit vectors spread evenly over the sphere (a golden spiral).
std::vector<Eigen::Vector3d> evenDirections(int count);

/// The name under which every file may ask for a sphere of radius 1 m; its scale are the semi-axes of an ellipsoid.
constexpr const char* kUnitSphereUri = "package://ellipsoid_vehicle_sim/meshes/unit_sphere.stl";

/// A sphere through the vertices, or none: all of them within 1 % of one radius about one centre, and their hull
/// reaching at least 85 % of it in every direction. (The corners of a cube, and the rims of a wheel, lie on a sphere
/// too; the hull tells them apart: it reaches 58 % and 71 %, an icosahedron 79 %, a ball of 80 faces 93 %.)
struct FittedSphere {
  Eigen::Vector3d centre;
  double radius;
};
std::optional<FittedSphere> fitSphere(const std::vector<Eigen::Vector3d>& vertices);

/// Turns the text of shapes into shapes, reading each mesh once however many links name it.
class ShapeBuilder {
 public:
  ShapeBuilder(std::string file, UriResolver resolver, MeshVertexReader reader);

  /// The shapes of a link's collisions; a mesh that is missing, empty, a git-LFS pointer, unreadable or not finite is a
  /// problem.
  std::vector<CollisionShape> build(const LinkText& link, Problems& problems, std::vector<std::string>& notes);
  /// True if a visual's mesh is there; nothing more is ever needed of it.
  bool visualExists(const ShapeText& visual) const;

 private:
  struct Mesh {
    std::vector<Eigen::Vector3d> vertices;
    std::optional<FittedSphere> sphere;
    std::string fault;  ///< why it cannot be used; empty if it can.
  };
  const Mesh& mesh(const std::string& uri, std::vector<std::string>& notes);
  std::optional<CollisionShape> buildMesh(const ShapeText& text, const std::string& place, Problems& problems,
                                          std::vector<std::string>& notes);

  std::string file_;
  UriResolver resolver_;
  MeshVertexReader reader_;
  std::map<std::string, Mesh> meshes_;
};

}  // namespace ellipsoid_vehicle_sim
