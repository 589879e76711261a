#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <set>

#include "ellipsoid_vehicle_sim/ros/collision_shapes.h"
#include "ellipsoid_vehicle_sim/ros/contact_markers.h"
#include "ellipsoid_vehicle_sim/ros/world_markers.h"

namespace ellipsoid_vehicle_sim {
namespace {

using visualization_msgs::Marker;

ContactReport contactOf(int ellipsoid, double normal_force, bool sliding) {
  ContactReport contact;
  contact.ellipsoid = ellipsoid;
  contact.p_WC = {1.0, 2.0, 3.0};
  contact.nhat_W = Eigen::Vector3d::UnitZ();
  contact.normal_force = normal_force;
  contact.friction_W = Eigen::Vector3d::Zero();
  contact.sliding = sliding;
  return contact;
}

/// Flat square of n by n cells of 1 m around the origin.
std::shared_ptr<const Terrain> flatTerrain(int n) {
  TriangleSoup soup;
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) soup.vertices.emplace_back(i - 0.5 * n, j - 0.5 * n, 0.0);
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const auto a = static_cast<std::uint32_t>(i * (n + 1) + j);
      const auto b = static_cast<std::uint32_t>(a + static_cast<std::uint32_t>(n) + 1);
      soup.triangles.push_back({a, b, b + 1});
      soup.triangles.push_back({a, b + 1, a + 1});
    }
  }
  soup.surface.assign(soup.triangles.size(), 0);
  soup.surfaces = {{"ground", {}, {}}};
  return std::make_shared<const Terrain>(std::move(*Terrain::build(std::move(soup)).value));
}

std::size_t trianglesIn(const visualization_msgs::MarkerArray& markers) {
  std::size_t corners = 0;
  for (const Marker& marker : markers.markers) corners += marker.points.size();
  return corners / 6;  // front and back
}

TEST(ContactMarkers, LengthIsProportionalToTheForceAndIsCapped) {
  ContactMarkers markers("odom", 0.001, 2.0);
  const auto arrows = markers.update({contactOf(0, 500.0, false), contactOf(1, 9000.0, false)}, ros::Time(1)).markers;
  ASSERT_EQ(arrows.size(), 2u);
  EXPECT_DOUBLE_EQ(arrows[0].points[1].z - arrows[0].points[0].z, 0.5);
  EXPECT_DOUBLE_EQ(arrows[1].points[1].z - arrows[1].points[0].z, 2.0);
}

TEST(ContactMarkers, ColourTellsStickFromSlip) {
  ContactMarkers markers("odom", 0.001, 2.0);
  const auto arrows = markers.update({contactOf(0, 500.0, false), contactOf(1, 500.0, true)}, ros::Time(1)).markers;
  EXPECT_GT(arrows[0].color.g, arrows[0].color.r);
  EXPECT_GT(arrows[1].color.r, arrows[1].color.g);
}

TEST(ContactMarkers, IdBelongsToTheEllipsoidWhateverElseTouches) {
  ContactMarkers markers("odom", 0.001, 2.0);
  const int with_others =
      markers.update({contactOf(0, 1.0, false), contactOf(3, 1.0, false)}, ros::Time(1)).markers[1].id;
  const int alone = markers.update({contactOf(3, 1.0, false)}, ros::Time(2)).markers[0].id;
  EXPECT_EQ(with_others, alone);
}

TEST(ContactMarkers, EndedContactIsDeletedOnce) {
  ContactMarkers markers("odom", 0.001, 2.0);
  const int id = markers.update({contactOf(2, 1.0, false)}, ros::Time(1)).markers[0].id;
  const auto gone = markers.update({}, ros::Time(2)).markers;
  ASSERT_EQ(gone.size(), 1u);
  EXPECT_EQ(gone[0].action, Marker::DELETE);
  EXPECT_EQ(gone[0].id, id);
  EXPECT_TRUE(markers.update({}, ros::Time(3)).markers.empty());
}

TEST(ContactMarkers, NoForceIsStillAnArrowThatRvizAccepts) {
  ContactMarkers markers("odom", 0.001, 2.0);
  const auto arrows = markers.update({contactOf(0, 0.0, false)}, ros::Time(1)).markers;
  EXPECT_GT(arrows[0].points[1].z, arrows[0].points[0].z);
}

TEST(CollisionShapes, NameSpacesTellWheelsAndDrawnLinks) {
  EllipsoidPlacement wheel, body;
  wheel.link = "wheel";
  wheel.ground_wheel = true;
  wheel.radii = body.radii = {0.3, 0.1, 0.3};
  body.link = "base";
  const auto markers = collisionShapeMarkers({wheel, body}, {"base"}).markers;
  EXPECT_EQ(markers[0].ns, "wheels");
  EXPECT_EQ(markers[1].ns, "drawn bodies");
  EXPECT_TRUE(markers[0].frame_locked);
  EXPECT_DOUBLE_EQ(markers[0].scale.x, 0.6);
}

TEST(WorldMarkers, WholeWorldInChunksAndOnlyOnce) {
  WorldMarkers world(flatTerrain(200), "odom", 500000);  // 80,000 triangles, each drawn twice
  const auto markers = world.update(Eigen::Vector3d::Zero());
  ASSERT_TRUE(markers);
  EXPECT_FALSE(world.partial());
  EXPECT_EQ(markers->markers.size(), 2u);
  EXPECT_EQ(trianglesIn(*markers), 80000u);
  for (const Marker& marker : markers->markers) EXPECT_LE(marker.colors.size(), 100000u);
  EXPECT_FALSE(world.update({50.0, 0.0, 0.0}));
}

TEST(WorldMarkers, BackSideIsTurnedRoundAndBehindTheFront) {
  WorldMarkers world(flatTerrain(1), "odom", 500000);
  const Marker marker = world.update(Eigen::Vector3d::Zero())->markers[0];
  EXPECT_EQ(marker.points[0].z, 0.0);
  EXPECT_LT(marker.points[3].z, 0.0);
  EXPECT_EQ(marker.points[1].x, marker.points[5].x);
  EXPECT_GT(marker.colors[0].g, 2.0f * marker.colors[1].g);
}

TEST(WorldMarkers, LargeWorldShowsWhatIsAroundTheVehicleAndFollowsIt) {
  WorldMarkers world(flatTerrain(200), "odom", 2000);
  const auto first = world.update(Eigen::Vector3d::Zero());
  ASSERT_TRUE(first);
  EXPECT_TRUE(world.partial());
  EXPECT_LE(trianglesIn(*first), 2000u);
  EXPECT_GT(trianglesIn(*first), 1000u);
  EXPECT_FALSE(world.update({0.1 * world.halfEdge(), 0.0, 0.0}));
  const auto second = world.update({40.0, 0.0, 0.0});
  ASSERT_TRUE(second);
  double least_x = 1e9;
  for (const auto& point : second->markers[0].points) least_x = std::min(least_x, point.x);
  EXPECT_GT(least_x, 40.0 - world.halfEdge() - 1.0 - 1e-9);
}

TEST(WorldMarkers, OffTheEdgeOfALargeWorldNothingIsAdded) {
  WorldMarkers world(flatTerrain(200), "odom", 2000);
  world.update(Eigen::Vector3d::Zero());
  const auto markers = world.update({0.0, 0.0, 1e6});
  if (!markers) return;
  for (const Marker& marker : markers->markers) {
    EXPECT_TRUE(!marker.points.empty() || marker.action == Marker::DELETE);
  }
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
