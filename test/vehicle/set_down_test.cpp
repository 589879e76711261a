#include <gtest/gtest.h>

#include <cmath>

#include "description/urdf_samples.h"
#include "ellipsoid_vehicle_sim/vehicle/simulator.h"
#include "support/scenes.h"

// Where a vehicle can be set down, and why not elsewhere.

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

std::string cartText() {
  return linkText("base", inertialText(20.0) + collisionText("<box size=\"0.5 0.4 0.1\"/>", "0 0 0.1")) +
         wheelText("fl", "base", "0.2 0.25 0") + wheelText("fr", "base", "0.2 -0.25 0") + rearAxleText();
}

Simulator simulatorOf(const std::string& text, std::shared_ptr<const Terrain> terrain) {
  const auto vehicle = loadText(text);
  EXPECT_TRUE(vehicle) << problemText(vehicle.problems);
  auto simulator = Simulator::create(*vehicle.value, std::move(terrain), SimConfig{});
  EXPECT_TRUE(simulator) << problemText(simulator.problems);
  return std::move(*simulator.value);
}

double leanOf(const Simulator& simulator) {
  return std::acos(std::min(1.0, (simulator.rootPose().q * Vector3d::UnitZ()).z()));
}

TEST(SetDown, LeansAsTheSlopeDoesWhicheverWayItFaces) {
  const double slope = 15.0 * M_PI / 180.0;
  Simulator cart = simulatorOf(cartText(), test::terrainOf(test::floorSoup(50.0, 4, slope)));
  for (const double yaw : {0.0, 0.7, 1.5707963267948966, 3.0}) {
    const Problems problems = cart.setDown(1.0, -2.0, yaw);
    ASSERT_TRUE(problems.empty()) << problemText(problems);
    EXPECT_NEAR(leanOf(cart), slope, 0.02) << yaw;
  }
}

// Two wheels and a ball: the slope is told by what else hangs low.
TEST(SetDown, TwoWheelsAndABallLeanLikewise) {
  const double slope = 10.0 * M_PI / 180.0;
  const std::string text = baseText() + wheelText("l", "base", "0 0.25 0") + wheelText("r", "base", "0 -0.25 0") +
                           linkText("caster", collisionText("<sphere radius=\"0.03\"/>")) +
                           jointText("c", "fixed", "base", "caster", "-0.25 0 -0.07", "1 0 0");
  const std::string heavy_behind = linkText("battery", inertialText(10.0)) +
                                   jointText("b", "fixed", "base", "battery", "-0.15 0 0", "1 0 0");
  Simulator cart = simulatorOf(text + heavy_behind, test::terrainOf(test::floorSoup(50.0, 4, -slope)));
  const Problems problems = cart.setDown(0.0, 0.0, 0.0);
  ASSERT_TRUE(problems.empty()) << problemText(problems);
  EXPECT_NEAR(leanOf(cart), slope, 0.03);
}

// Down a slope that is too steep, and over its lower edge: said when it is below all there is.
TEST(SetDown, OffTheGroundItIsFollowedNoFurther) {
  const double slope = 48.0 * M_PI / 180.0;
  Simulator cart = simulatorOf(cartText(), test::terrainOf(test::floorSoup(1.0, 2, slope)));
  const Problems problems = cart.setDown(0.5 * std::cos(slope), 0.0, 0.0);
  ASSERT_EQ(problems.size(), 1u);
  const std::string& text = problems.front().message;
  EXPECT_NE(text.find("fallen off"), std::string::npos) << text;
}

TEST(SetDown, InsideAnObstacleIsRefusedAndSaysWhichPartIsInWhat) {
  TriangleSoup soup = test::floorSoup(20.0, 2);
  soup.surfaces = {Surface{"ground", {}, {}}};
  // A block of 1 m, its corner under the vehicle's.
  test::addQuad(soup, {0.1, 0.1, 1.0}, {1.1, 0.1, 1.0}, {1.1, 1.1, 1.0}, {0.1, 1.1, 1.0});
  test::addQuad(soup, {0.1, 0.1, 0.0}, {1.1, 0.1, 0.0}, {1.1, 0.1, 1.0}, {0.1, 0.1, 1.0});
  test::addQuad(soup, {0.1, 1.1, 0.0}, {0.1, 0.1, 0.0}, {0.1, 0.1, 1.0}, {0.1, 1.1, 1.0});
  Simulator cart = simulatorOf(cartText(), test::terrainOf(soup));
  const Problems problems = cart.setDown(0.0, 0.0, 0.0);
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_NE(problems[0].text().find("inside geometry"), std::string::npos) << problems[0].text();
  EXPECT_NE(problems[0].text().find("surface 'ground'"), std::string::npos) << problems[0].text();
  EXPECT_TRUE(cart.setDown(-2.0, -2.0, 0.0).empty());
}

TEST(SetDown, OverAVoidIsRefused) {
  Simulator cart = simulatorOf(cartText(), test::terrainOf(test::floorSoup(5.0, 2)));
  const Problems problems = cart.setDown(30.0, 0.0, 0.0);
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_NE(problems[0].text().find("no ground below"), std::string::npos) << problems[0].text();
}

// A bank that rises beside the body, above its underside but clear of it, is no obstacle.
TEST(SetDown, ABankBesideTheBodyIsNoReasonToRefuse) {
  TriangleSoup soup = test::floorSoup(20.0, 2);
  test::addQuad(soup, {-5.0, 0.45, 0.0}, {5.0, 0.45, 0.0}, {5.0, 1.5, 0.6}, {-5.0, 1.5, 0.6});
  Simulator cart = simulatorOf(cartText(), test::terrainOf(soup));
  const Problems problems = cart.setDown(0.0, 0.0, 0.0);
  EXPECT_TRUE(problems.empty()) << problemText(problems);
  EXPECT_LT(leanOf(cart), 0.01);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
