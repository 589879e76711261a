#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/description/collision_shape.h"
#include "ellipsoid_vehicle_sim/vehicle/vehicle_description.h"

// What collides is made of ellipsoids; what a URDF holds are boxes, cylinders, spheres and meshes. The rules:
//
// Ground wheels (joint role drive or free wheel). All shapes of the wheel's link and of what is fixed to it become one
// spheroid, its axis exactly the joint's axis, its centre exactly on it: an ellipsoid out of round by 1 % hammers the
// suspension once a turn. Rolling radius and width are kept, so the wheel's bottom stays at its height:
//   cylinder r, l     r, l/2 along the axis
//   sphere, ellipsoid its radii
//   box               half its edge across the axis (not its corner), half its edge along the axis
//   mesh              its largest distance from the axis; the width of its tread, all that lies beyond 80 % of that
//   distance
//                     (a hub or an axle stub is no tread)
//   several           the largest rolling radius; the width over all shapes that reach 80 % of it
// What this changes (the shapes' offset from the axis and their tilt against it) is the residual, told in a note.
//
// Everything else, one ellipsoid a shape, or a compound of up to ShapeRules::body_ellipsoids:
//   sphere, sphere-like mesh   exactly; a mesh counts as one whose vertices lie on a sphere before the scale is applied
//   cylinder r, l              radii r, r, l/2      } of the same half extents, inscribed: it fills 2/3 of the
//   cylinder, box a, b, c                radii a/2, b/2, c/2  } 52 % of the box, and its corners are free mesh
//   inscribed in the box around it along the mesh's own axes
//   compound           the box around the shape is cut into up to so many cells, as near to cubes as the number allows, and
//                      the longest side first; each cell is shrunk to what the shape's hull fills of it (125 points are
//                      tried) and filled like a box. With fewer than three ground wheels a vehicle leans on its body: what
//                      reaches the ground there is a compound of at least eight, whose undersides are the shape's
// Shapes that are there twice, or lie inside another one of the same rigid body, are dropped with a note: they would double
// its stiffness or do nothing.
//
// fit_error is the largest distance between the shape's hull and the ellipsoid: for a box that of its corners.
//
// A body's ellipsoid may come lower than its shape did, where the box around a mesh does. If it would then reach below
// the wheels, which the shape itself does not, it is raised until its bottom is the shape's, and a note says so. A
// shape that itself reaches below the wheels is left alone, and a note says that the vehicle will stand on it.

namespace ellipsoid_vehicle_sim {

/// A shape seen from a frame G.
struct PlacedShape {
  const CollisionShape* shape;
  Pose X_GS;
};

/// The spheroid that stands for the shapes of a wheel turning about an axis through the origin of G.
struct WheelMeasure {
  double radius = 0.0;        ///< rolling radius [m].
  double half_width = 0.0;    ///< along the axis [m].
  double axial_centre = 0.0;  ///< of the spheroid, along the axis from the origin of G [m].
  bool round = false;         ///< the largest shape is: equal radii within 10 %, centred within 10 % of its radius.
  double offset = 0.0;        ///< residual: largest distance of a tread shape's middle from the axis [m].
  double tilt = 0.0;          ///< residual: largest angle of a tread shape's own axis against the joint's [rad].
  int line = 0;               ///< of the largest shape.
  std::string text;           ///< "cylinder r=0.1651 l=0.1143", "3 shapes".
};

/// Measures the shapes (at least one) about the unit vector axis_G.
WheelMeasure measureWheel(const std::vector<PlacedShape>& shapes, const Eigen::Vector3d& axis_G);

/// A wheel that stands on the ground: which joint turns it, and its spheroid in the joint's child link.
struct GroundWheel {
  int joint = 0;
  WheelMeasure measure;
  Eigen::Vector3d p_FC =
      Eigen::Vector3d::Zero();  ///< its centre, joints at zero, in the root link's frame turned to look forward [m].
  double bottom = 0.0;          ///< its lowest z there [m].
};

/// What the user says about the rules.
struct ShapeRules {
  int body_ellipsoids = 1;  ///< for each shape of the body, at most.
};
constexpr int kMostBodyEllipsoids = 64;

/// An ellipsoid of a compound: half extents, placed in the shape's frame.
struct Cell {
  Eigen::Vector3d centre_S;
  Eigen::Vector3d radii;
};

/// The compound of at most `count` ellipsoids that stands for a shape that is no ellipsoid itself.
std::vector<Cell> compoundOf(const CollisionShape& shape, int count);

/// Largest distance between a compound's surface and the shape's hull [m].
double compoundError(const std::vector<Cell>& cells, const CollisionShape& shape);

/// Which of the shapes of one rigid body, placed in one frame, are there twice or inside another: index of the one that
/// stands for it, -1 for those that stay.
std::vector<int> coveredBy(const std::vector<PlacedShape>& shapes);

/// The points whose hull the shape is; none for an ellipsoid, many for a cylinder's rims.
std::vector<Eigen::Vector3d> extremePoints(const CollisionShape& shape);

/// Largest distance between an ellipsoid's surface and the hull of shapes placed in its frame [m].
double fitError(const Eigen::Vector3d& radii, const std::vector<PlacedShape>& shapes_E);

/// Distance of a point outside an ellipsoid from its surface, 0 inside [m].
double distanceOutside(const Eigen::Vector3d& p_EQ, const Eigen::Vector3d& radii);

/// Fills the ellipsoids of every link of the vehicle by the rules above; shapes[i] belong to links[i].
void addEllipsoids(VehicleDescription& vehicle, const std::vector<std::vector<CollisionShape>>& shapes,
                   const std::vector<GroundWheel>& wheels, const ShapeRules& rules, std::vector<std::string>& notes);

}  // namespace ellipsoid_vehicle_sim
