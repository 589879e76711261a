#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/geometry/pose.h"
#include "ellipsoid_vehicle_sim/geometry/problem.h"
#include "ellipsoid_vehicle_sim/geometry/triangle.h"

namespace ellipsoid_vehicle_sim {

/// What a mesh of the world is made of. Without a friction of its own it takes the vehicle's.
struct Surface {
  std::string name;
  std::optional<double> mu_static;   ///< Coulomb coefficient before sliding [-].
  std::optional<double> mu_kinetic;  ///< while sliding [-], <= mu_static.
};

/// What was found wrong, or worth knowing, in the triangles of a world; none of it stops a run.
struct MeshReport {
  std::int64_t read = 0;                 ///< triangles in the files.
  std::int64_t zero_area = 0;            ///< dropped.
  std::int64_t duplicates = 0;           ///< same three corners in the same sense, kept.
  std::int64_t opposite_duplicates = 0;  ///< same three corners in the opposite sense (a two-sided sheet), kept.
  std::int64_t open_edges = 0;           ///< edges with one triangle.
  std::int64_t nonmanifold_edges = 0;    ///< edges with three or more.
  std::int64_t flipped_edges = 0;        ///< edges whose two triangles run along them in the same direction.
};

/// A corner soup as read from files, before it becomes a Terrain.
struct TriangleSoup {
  std::vector<Eigen::Vector3d> vertices;                ///< in W [m].
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< indices into vertices, counter-clockwise from the front.
  std::vector<std::uint16_t> surface;                   ///< index into surfaces, one per triangle.
  std::vector<Surface> surfaces;
};

/// Corners further from the origin than this on any axis [m] are refused: a double resolves 1e-7 m there.
constexpr double kLargestCoordinate = 1e9;

/// Where a vertical line meets the terrain.
struct HeightHit {
  double z;        ///< [m].
  bool faces_up;   ///< the front of the triangle is above.
  int triangle;
};

/// The static world: an immutable soup of one-sided triangles with a box tree over it. Triangle indices are those of the
/// soup after the triangles without area were dropped, in file order, so "lowest index" means first in the files.
/// Cheap to move, never copied; safe to read from several threads.
class Terrain {
 public:
  /// Drops triangles without area. Problems: a non-finite corner, no triangle at all, more than 2^31 - 1 of them.
  static Loaded<Terrain> build(TriangleSoup soup);

  Terrain(Terrain&&) noexcept;
  Terrain& operator=(Terrain&&) noexcept;
  ~Terrain();

  int triangleCount() const;
  /// Corners and unit normal of triangle i.
  Triangle triangle(int i) const;
  /// The corners of triangle i alone.
  void corners(int i, std::array<Eigen::Vector3d, 3>& v) const;
  /// Says that the corners of these triangles are asked for next: memory fetches all of them at once.
  void prefetchCorners(const std::vector<int>& triangles) const;
  const Surface& surface(int i) const;
  int surfaceIndex(int i) const;
  const std::vector<Surface>& surfaces() const;
  Eigen::AlignedBox3d bounds() const;
  const MeshReport& report() const;
  /// Bytes held by corners, indices and tree.
  std::size_t memoryBytes() const;

  /// Appends the indices of all triangles whose own box meets `box` (closed on closed, no false negatives, no extras), in
  /// no particular order. Allocates only when `out` has to grow.
  void query(const Eigen::AlignedBox3d& box, std::vector<int>& out) const;

  /// As `query`, with a few whose box only nearly meets `box`: by what the tree rounds, a 255th of a leaf. Reads nothing
  /// but the tree.
  void candidates(const Eigen::AlignedBox3d& box, std::vector<int>& out) const;

  /// Whether any triangle's box may meet `box`; false proves that none does. Stops at the first.
  bool mayMeet(const Eigen::AlignedBox3d& box) const;

  /// Where the vertical line through (x, y) meets the terrain, top first. A seam between triangles counts once.
  /// Rims belong to the terrain; upright triangles are never met.
  std::vector<HeightHit> heights(double x, double y) const;

  /// First triangle that the segment from a to b crosses from its front to its back, if any. Of two segments that meet on
  /// a surface the later one crosses it. Edges belong to both triangles and rounding decides for a crossing, so that
  /// nothing slips through a seam; a segment that grazes a rim within rounding may count.
  std::optional<int> firstFrontCrossing(const Eigen::Vector3d& a, const Eigen::Vector3d& b) const;

 private:
  struct Impl;
  explicit Terrain(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ellipsoid_vehicle_sim
