#include <gtest/gtest.h>

#include <cmath>

#include "ellipsoid_vehicle_sim/description/shapes_to_ellipsoids.h"
#include "urdf_samples.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

CollisionShape boxOf(const Vector3d& half) {
  CollisionShape shape;
  shape.kind = CollisionShape::Kind::kBox;
  shape.half = half;
  return shape;
}

TEST(BodyCompound, ABoxIsCutIntoCellsAsNearToCubesAsTheNumberAllows) {
  const CollisionShape box = boxOf({2.0, 1.0, 0.5});
  const std::vector<Cell> cells = compoundOf(box, 8);
  ASSERT_EQ(cells.size(), 8u);
  double bottom = 1.0, reach = 0.0;
  for (const Cell& cell : cells) {
    EXPECT_TRUE(cell.radii.isApprox(Vector3d(0.5, 0.5, 0.5), 1e-12));
    bottom = std::min(bottom, cell.centre_S.z() - cell.radii.z());
    reach = std::max(reach, cell.centre_S.x() + cell.radii.x());
  }
  EXPECT_NEAR(bottom, -0.5, 1e-12);
  EXPECT_NEAR(reach, 2.0, 1e-12);
  // Of eight spheres in two rows a corner is as far as a cube's from the sphere inside it.
  EXPECT_NEAR(compoundError(cells, box), 0.5 * (std::sqrt(3.0) - 1.0), 1e-9);
}

TEST(BodyCompound, MoreEllipsoidsFitBetterAndNeverMoreThanAskedFor) {
  const CollisionShape box = boxOf({1.0, 0.4, 0.3});
  double before = compoundError({{Vector3d::Zero(), box.half}}, box);
  for (const int count : {4, 16, 64}) {
    const std::vector<Cell> cells = compoundOf(box, count);
    EXPECT_LE(cells.size(), static_cast<std::size_t>(count));
    const double error = compoundError(cells, box);
    EXPECT_LT(error, before) << count;
    before = error;
  }
}

// A wedge: low at one end. No cell stands where the shape is not.
TEST(BodyCompound, CellsFillWhatTheHullFills) {
  CollisionShape wedge;
  wedge.kind = CollisionShape::Kind::kMesh;
  wedge.half = {1.0, 0.5, 0.5};
  wedge.vertices_S = std::make_shared<std::vector<Vector3d>>(std::vector<Vector3d>{
      {-1, -0.5, -0.5}, {-1, 0.5, -0.5}, {1, -0.5, -0.5}, {1, 0.5, -0.5}, {-1, -0.5, 0.5}, {-1, 0.5, 0.5}});
  const std::vector<Cell> cells = compoundOf(wedge, 16);
  ASSERT_GT(cells.size(), 4u);
  for (const Cell& cell : cells) {
    EXPECT_GE(cell.centre_S.z() - cell.radii.z(), -0.5 - 1e-9);
    // The slope: z <= -x / 2, felt at five points a cell, so within a quarter of one.
    EXPECT_LT(cell.centre_S.z() + cell.radii.z(), -0.5 * (cell.centre_S.x() - cell.radii.x()) + 0.13);
  }
  EXPECT_LT(compoundError(cells, wedge), compoundError({{Vector3d::Zero(), wedge.half}}, wedge));
}

TEST(BodyCompound, TheLoaderMakesAsManyAsTheOptionsSay) {
  UrdfOptions options;
  options.body_ellipsoids = 6;
  const auto loaded = loadText(baseText() + rearAxleText() + wheelText("f", "base", "0.2 0 0"), options);
  ASSERT_TRUE(isLoaded(loaded));
  EXPECT_EQ(linkOf(*loaded.value, "base").ellipsoids.size(), 6u);
  EXPECT_TRUE(notedWith(loaded, {"box 0.6 x 0.4 x 0.2", "6 ellipsoids", "fit error"}));
  EXPECT_EQ(linkOf(*loaded.value, "rl").ellipsoids.size(), 1u);
}

// Two wheels carry no vehicle: what it tips onto keeps its flat underside.
TEST(BodyCompound, AVehicleOnTwoWheelsLeansOnACompound) {
  const auto loaded = loadText(linkText("base", inertialText(10.0) + collisionText("<box size=\"0.6 0.4 0.2\"/>", "0 0 0.01")) +
                               wheelText("l", "base", "0 0.25 0") + wheelText("r", "base", "0 -0.25 0"));
  ASSERT_TRUE(isLoaded(loaded));
  EXPECT_GE(linkOf(*loaded.value, "base").ellipsoids.size(), 4u);
}

TEST(BodyCompound, WhatIsThereTwiceOrInsideIsDroppedAndTold) {
  const auto loaded = loadText(linkText("base", inertialText(10.0) + collisionText("<box size=\"0.6 0.4 0.2\"/>") +
                                                    collisionText("<box size=\"0.6 0.4 0.2\"/>") +
                                                    collisionText("<sphere radius=\"0.05\"/>", "0.1 0 0") +
                                                    collisionText("<sphere radius=\"0.05\"/>", "0.9 0 0")) +
                               linkText("lid", collisionText("<cylinder radius=\"0.1\" length=\"0.1\"/>")) +
                               jointText("f", "fixed", "base", "lid", "0 0 0", "1 0 0"));
  ASSERT_TRUE(isLoaded(loaded));
  EXPECT_EQ(linkOf(*loaded.value, "base").ellipsoids.size(), 2u);
  EXPECT_TRUE(linkOf(*loaded.value, "lid").ellipsoids.empty());
  EXPECT_TRUE(notedWith(loaded, {"link 'base'", "box 0.6 x 0.4 x 0.2 lies inside box 0.6 x 0.4 x 0.2", "one stands for both"}));
  EXPECT_TRUE(notedWith(loaded, {"link 'lid'", "lies inside box", "of link 'base'"}));
}

TEST(BodyCompound, ShapesOfBodiesThatMoveAgainstEachOtherStay) {
  const auto loaded = loadText(
      linkText("base", inertialText(10.0) + collisionText("<box size=\"0.6 0.4 0.2\"/>")) + rearAxleText() +
      linkText("mast", inertialText() + collisionText("<sphere radius=\"0.05\"/>")) +
      jointText("m", "prismatic", "base", "mast", "0 0 0", "0 0 1", "<limit lower=\"0\" upper=\"1\" effort=\"1\" velocity=\"1\"/>"));
  ASSERT_TRUE(isLoaded(loaded));
  EXPECT_EQ(linkOf(*loaded.value, "mast").ellipsoids.size(), 1u);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
