#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

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
std::shared_ptr<const Terrain> flatTerrain(int n, const char* surface = "ground") {
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
  soup.surfaces = {{surface, {}, {}}};
  return std::make_shared<const Terrain>(std::move(*Terrain::build(std::move(soup)).value));
}

std::size_t trianglesIn(const visualization_msgs::MarkerArray& markers) {
  std::size_t corners = 0;
  for (const Marker& marker : markers.markers) corners += marker.points.size();
  return corners / 6;  // front and back
}

/// The markers of one name space.
std::vector<Marker> inSpace(const visualization_msgs::MarkerArray& message, const std::string& name_space) {
  std::vector<Marker> markers;
  for (const Marker& marker : message.markers) {
    if (marker.ns == name_space) markers.push_back(marker);
  }
  return markers;
}

Eigen::Vector3d alongOf(const Marker& arrow) {
  const auto &a = arrow.points[0], &b = arrow.points[1];
  return {b.x - a.x, b.y - a.y, b.z - a.z};
}

TEST(ContactMarkers, LengthIsProportionalToTheForceAndIsCapped) {
  ContactMarkers markers("odom", 0.001, 2.0);
  const auto arrows =
      inSpace(markers.update({contactOf(0, 500.0, false), contactOf(1, 9000.0, false)}, ros::Time(1)), "normal");
  ASSERT_EQ(arrows.size(), 2u);
  EXPECT_DOUBLE_EQ(alongOf(arrows[0]).z(), 0.5);
  EXPECT_DOUBLE_EQ(alongOf(arrows[1]).z(), 2.0);
}

TEST(ContactMarkers, ColourTellsStickFromSlip) {
  ContactMarkers markers("odom", 0.001, 2.0);
  const auto arrows =
      inSpace(markers.update({contactOf(0, 500.0, false), contactOf(1, 500.0, true)}, ros::Time(1)), "normal");
  EXPECT_GT(arrows[0].color.g, arrows[0].color.r);
  EXPECT_GT(arrows[1].color.r, arrows[1].color.g);
}

TEST(ContactMarkers, ForceIsTheSumOfNormalAndFrictionInOneScale) {
  ContactMarkers markers("odom", 0.001, 2.0);
  ContactReport contact = contactOf(0, 400.0, false);
  contact.friction_W = {300.0, 0.0, 0.0};
  const auto message = markers.update({contact}, ros::Time(1));
  EXPECT_TRUE(alongOf(inSpace(message, "force").at(0)).isApprox(Eigen::Vector3d(0.3, 0.0, 0.4), 1e-12));
  EXPECT_TRUE(alongOf(inSpace(message, "friction").at(0)).isApprox(Eigen::Vector3d(0.3, 0.0, 0.0), 1e-12));
}

// The cone is drawn in the scale of the forces: a force on the edge of sliding ends on its rim.
TEST(ContactMarkers, ForceOfASlidingContactEndsOnTheRimOfItsCone) {
  ContactMarkers markers("odom", 0.001, 2.0);
  ContactReport contact = contactOf(0, 400.0, true);
  contact.friction_limit = 0.8 * 400.0;
  contact.friction_W = {0.0, -contact.friction_limit, 0.0};
  const auto message = markers.update({contact}, ros::Time(1));
  const Marker cone = inSpace(message, "friction cone").at(0);
  const auto tip = inSpace(message, "force").at(0).points[1];
  double nearest = 1e9;
  for (const auto& corner : cone.points) {
    nearest = std::min(nearest, std::hypot(corner.x - tip.x, corner.y - tip.y, corner.z - tip.z));
  }
  // A side of the rim's polygon is 2 r sin(7.5 degrees) long: no point of the circle is farther from a corner than
  // half.
  EXPECT_LE(nearest, 0.32 * std::sin(7.5 * M_PI / 180.0) * 1.01);
  EXPECT_LT(cone.color.a, 0.5);
}

TEST(ContactMarkers, IdBelongsToTheEllipsoidWhateverElseTouches) {
  ContactMarkers markers("odom", 0.001, 2.0);
  const auto with_others = markers.update({contactOf(0, 1.0, false), contactOf(3, 1.0, false)}, ros::Time(1));
  const auto alone = markers.update({contactOf(3, 1.0, false)}, ros::Time(2));
  EXPECT_EQ(inSpace(with_others, "normal")[1].id, inSpace(alone, "normal")[0].id);
}

TEST(ContactMarkers, EndedContactIsDeletedOnceInEveryNameSpace) {
  ContactMarkers markers("odom", 0.001, 2.0);
  ContactReport contact = contactOf(2, 100.0, false);
  contact.friction_limit = contact.friction_W.x() = 50.0;
  std::set<std::pair<std::string, int>> added, gone;
  for (const Marker& marker : markers.update({contact}, ros::Time(1)).markers) added.emplace(marker.ns, marker.id);
  EXPECT_EQ(added.size(), 4u);
  for (const Marker& marker : markers.update({}, ros::Time(1.1)).markers) {
    EXPECT_EQ(marker.action, Marker::DELETE);
    gone.emplace(marker.ns, marker.id);
  }
  EXPECT_EQ(gone, added);
  EXPECT_TRUE(markers.update({}, ros::Time(1.2)).markers.empty());
}

TEST(ContactMarkers, NoForceIsStillAnArrowThatRvizAccepts) {
  ContactMarkers markers("odom", 0.001, 2.0);
  const auto message = markers.update({contactOf(0, 0.0, false)}, ros::Time(1));
  ASSERT_EQ(message.markers.size(), 1u);
  EXPECT_GT(alongOf(message.markers[0]).z(), 0.0);
}

/// Drives contact 0 along x in steps of 0.1 m at 20 Hz, and returns the pieces of the trail, x only.
class TrailOf {
 public:
  TrailOf& to(double x, bool sliding = false) {
    ContactReport contact = contactOf(0, 1.0, sliding);
    contact.p_WC = {x, 0.0, 0.0};
    trail_.update({contact}, ros::Time(time_ += 0.05));
    return *this;
  }
  TrailOf& lifted() {
    trail_.update({}, ros::Time(time_ += 0.05));
    return *this;
  }
  TrailOf& pause(double seconds) {
    time_ += seconds;
    return *this;
  }
  Marker marker() const {
    Marker marker;
    trail_.draw(marker);
    return marker;
  }
  std::vector<double> xs() const {
    std::vector<double> xs;
    for (const auto& point : marker().points) xs.push_back(point.x);
    return xs;
  }

 private:
  ContactTrail trail_{0.1, 2.0};
  double time_ = 1.0;
};

TEST(ContactTrail, FollowsTheContactInPiecesOfAtLeastTheSpacing) {
  EXPECT_EQ(TrailOf().to(0.0).to(0.06).to(0.12).to(0.24).xs(), (std::vector<double>{0.0, 0.12, 0.12, 0.24}));
}

TEST(ContactTrail, BreaksWhereTheContactWasLiftedCarriedOrUnwatched) {
  EXPECT_TRUE(TrailOf().to(0.0).lifted().to(0.5).xs().empty());
  EXPECT_TRUE(TrailOf().to(0.0).to(2.5).xs().empty());
  EXPECT_TRUE(TrailOf().to(0.0).pause(1.0).to(0.5).xs().empty());
}

TEST(ContactTrail, APieceThatSlidAnywhereIsRed) {
  const Marker marker = TrailOf().to(0.0).to(0.05, true).to(0.1).to(0.2).marker();
  ASSERT_EQ(marker.colors.size(), 4u);
  EXPECT_GT(marker.colors[0].r, 4.0f * marker.colors[0].g);
  EXPECT_LT(marker.colors[2].r, 0.2f);
}

TEST(ContactTrail, OldPiecesGo) {
  TrailOf trail;
  for (int i = 0; i < 2000; ++i) trail.to(0.2 * i);
  const auto xs = trail.xs();
  EXPECT_EQ(xs.size(), 1600u);
  EXPECT_DOUBLE_EQ(xs.back(), 0.2 * 1999);
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

// Whoever looks knows grass from asphalt; a surface of any other name has a colour of the list.
TEST(WorldMarkers, KnownSurfacesHaveTheirColourWhateverTheirNumber) {
  WorldMarkers grass(flatTerrain(1, "Wet_Grass"), "odom", 500000), other(flatTerrain(1, "ground"), "odom", 500000);
  const auto green = grass.update(Eigen::Vector3d::Zero())->markers[0].colors[0];
  EXPECT_GT(green.g, 1.1f * green.r);
  EXPECT_GT(green.g, 1.5f * green.b);
  const auto grey = other.update(Eigen::Vector3d::Zero())->markers[0].colors[0];
  EXPECT_LT(grey.g, 1.1f * grey.r);
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
