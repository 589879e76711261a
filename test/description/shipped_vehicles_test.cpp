#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "ellipsoid_vehicle_sim/description/collision_shape.h"
#include "ellipsoid_vehicle_sim/description/vehicle_tree.h"
#include "urdf_samples.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

Loaded<VehicleDescription> shipped(const std::string& name) {
  return loadUrdfFile(kShippedUrdfFolder + name + ".urdf");
}

Vector3d positionInRoot(const VehicleDescription& vehicle, const std::string& link) {
  const auto poses = linkPosesAtZero(vehicle);
  for (std::size_t l = 0; l < vehicle.links.size(); ++l) {
    if (vehicle.links[l].name == link) return poses[l].p;
  }
  ADD_FAILURE() << "no link " << link;
  return Vector3d::Zero();
}

class ShippedVehicle : public testing::TestWithParam<const char*> {};

TEST_P(ShippedVehicle, LoadsWithExactEllipsoidsAndNothingReplaced) {
  const auto loaded = shipped(GetParam());
  ASSERT_TRUE(isLoaded(loaded));
  for (const std::string& note : loaded.notes) EXPECT_NE(note.find("cannot be driven"), std::string::npos) << note;
  for (const LinkDescription& link : loaded.value->links) {
    for (const EllipsoidDescription& e : link.ellipsoids) EXPECT_EQ(e.fit_error, 0.0) << e.name;
  }
}

INSTANTIATE_TEST_SUITE_P(All, ShippedVehicle, testing::Values("car", "skid_steer", "compound_car", "rugby_ball"));

TEST(ShippedVehicles, TheUnitSphereThatRvizDrawsIsWhatItsNameSays) {
  const auto vertices = readMeshVertices(kShippedUrdfFolder + "../meshes/unit_sphere.stl");
  ASSERT_TRUE(vertices.value) << problemText(vertices.problems);
  const auto sphere = fitSphere(*vertices.value);
  ASSERT_TRUE(sphere);
  constexpr double kFloat = 1e-6;  // an STL holds floats
  EXPECT_NEAR(sphere->radius, 1.0, kFloat);
  EXPECT_NEAR(sphere->centre.norm(), 0.0, kFloat);
}

TEST(ShippedVehicles, TheCarIsTheOneOfTheBenchmark) {
  const auto loaded = shipped("car");
  ASSERT_TRUE(isLoaded(loaded));
  const VehicleDescription& car = *loaded.value;
  EXPECT_NEAR(massOf(car), 1200.0, 1e-9);
  EXPECT_EQ(car.layout, DriveLayout::kAckermann);
  EXPECT_EQ(countRole(car, JointRole::kSuspension), 4);
  EXPECT_EQ(countRole(car, JointRole::kSteer), 2);
  EXPECT_EQ(countRole(car, JointRole::kDrive), 2);
  EXPECT_EQ(countRole(car, JointRole::kFreeWheel), 2);
  EXPECT_EQ(jointOf(car, "rear_left_axle").role, JointRole::kDrive);
  for (const std::string wheel : {"front_left", "front_right", "rear_left", "rear_right"}) {
    EXPECT_EQ(linkOf(car, wheel + "_wheel").ellipsoids.at(0).radii, Vector3d(0.35, 0.12, 0.35));
    const JointDescription& spring = jointOf(car, wheel + "_suspension");
    EXPECT_EQ(spring.spring_stiffness, 25000.0);
    EXPECT_EQ(spring.damping, 2000.0);
    // At position zero it carries a quarter of what stands on the springs; the file has five digits.
    EXPECT_NEAR(25000.0 * -spring.spring_reference.value_or(0.0), 1100.0 / 4.0 * 9.80665, 0.2);
  }
  EXPECT_EQ(positionInRoot(car, "front_left_wheel"), Vector3d(1.3, 0.75, 0));
  EXPECT_EQ(positionInRoot(car, "rear_right_wheel"), Vector3d(-1.3, -0.75, 0));
}

TEST(ShippedVehicles, TheSkidSteerRobotDrivesAllFourWheels) {
  const auto loaded = shipped("skid_steer");
  ASSERT_TRUE(isLoaded(loaded));
  EXPECT_NEAR(massOf(*loaded.value), 50.0, 1e-9);
  EXPECT_EQ(loaded.value->layout, DriveLayout::kDifferential);
  EXPECT_EQ(countRole(*loaded.value, JointRole::kDrive), 4);
  EXPECT_EQ(linkOf(*loaded.value, "rear_left_wheel").ellipsoids.at(0).radii, Vector3d(0.165, 0.06, 0.165));
}

TEST(ShippedVehicles, TheCompoundIsTheSeedsFiveEllipsoids) {
  const auto loaded = shipped("compound_car");
  ASSERT_TRUE(isLoaded(loaded));
  EXPECT_NEAR(massOf(*loaded.value), 1000.0, 1e-9);
  EXPECT_EQ(linkOf(*loaded.value, "chassis").ellipsoids.at(0).radii, Vector3d(2.0, 0.8, 0.5));
  for (const auto& [wheel, x, y] : {std::tuple{"front_left_wheel", 1.3, 0.75},
                                    {"front_right_wheel", 1.3, -0.75},
                                    {"rear_left_wheel", -1.3, 0.75},
                                    {"rear_right_wheel", -1.3, -0.75}}) {
    EXPECT_EQ(positionInRoot(*loaded.value, wheel), Vector3d(x, y, -0.4));
    EXPECT_EQ(linkOf(*loaded.value, wheel).ellipsoids.at(0).radii, Vector3d(0.35, 0.12, 0.35));
  }
  EXPECT_EQ(countRole(*loaded.value, JointRole::kSteer), 2);
}

TEST(ShippedVehicles, TheRugbyBallIsASolidEllipsoid) {
  const auto loaded = shipped("rugby_ball");
  ASSERT_TRUE(isLoaded(loaded));
  const LinkDescription& ball = loaded.value->links.at(0);
  const double m = 5.0, a = 0.3, b = 0.15;
  EXPECT_EQ(ball.mass, m);
  EXPECT_EQ(ball.ellipsoids.at(0).radii, Vector3d(a, b, b));
  // I_x = m (ry^2 + rz^2) / 5 and so on.
  const Vector3d I(m * (b * b + b * b) / 5.0, m * (a * a + b * b) / 5.0, m * (a * a + b * b) / 5.0);
  EXPECT_NEAR((ball.I_cm_L - Eigen::Matrix3d(I.asDiagonal())).norm(), 0.0, 1e-12);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
