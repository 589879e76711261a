#include <gtest/gtest.h>

#include <map>

#include "ellipsoid_vehicle_sim/description/vehicle_tree.h"
#include "support/test_data.h"
#include "urdf_samples.h"

// Vehicles nobody here wrote. What is claimed about them stands in the notes that come with them.

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

/// Lowest z of the ground wheels in the root link's frame.
double wheelBottom(const VehicleDescription& vehicle) {
  const auto X_RL = linkPosesAtZero(vehicle);
  double bottom = std::numeric_limits<double>::infinity();
  for (std::size_t j = 0; j < vehicle.joints.size(); ++j) {
    if (vehicle.joints[j].role != JointRole::kDrive && vehicle.joints[j].role != JointRole::kFreeWheel) continue;
    for (const EllipsoidDescription& e : vehicle.links[j + 1].ellipsoids) {
      const Pose X_RE = X_RL[j + 1] * e.X_LE;
      bottom = std::min(bottom, X_RE.p.z() - (X_RE.q.conjugate() * Vector3d::UnitZ()).cwiseProduct(e.radii).norm());
    }
  }
  return bottom;
}

struct Expected {
  double mass, bottom;
  DriveLayout layout;
  std::map<std::string, JointRole> roles;
};

void expectVehicle(const std::string& path, const Expected& expected) {
  const auto file = testData(path);
  if (!file) return;
  const auto loaded = loadUrdfFile(*file);
  ASSERT_TRUE(isLoaded(loaded));
  EXPECT_NEAR(massOf(*loaded.value), expected.mass, 1e-3 * expected.mass);
  EXPECT_NEAR(wheelBottom(*loaded.value), expected.bottom, 1e-4);  // their notes give four digits
  EXPECT_EQ(loaded.value->layout, expected.layout);
  std::size_t movable = 0;
  for (const JointDescription& joint : loaded.value->joints) {
    if (joint.type == JointType::kFixed) continue;
    ++movable;
    const auto role = expected.roles.find(joint.name);
    if (role == expected.roles.end()) {
      ADD_FAILURE() << joint.name << " is " << toString(joint.role) << ", nothing was expected";
    } else {
      EXPECT_STREQ(toString(joint.role), toString(role->second)) << joint.name << ": " << joint.role_reason;
    }
  }
  EXPECT_EQ(movable, expected.roles.size());
  for (const LinkDescription& link : loaded.value->links) {
    for (const EllipsoidDescription& e : link.ellipsoids) {
      EXPECT_TRUE(e.radii.allFinite() && e.radii.minCoeff() > 0.0 && e.X_LE.allFinite() && std::isfinite(e.fit_error))
          << e.name;
    }
  }
}

TEST(RealVehicles, HuskyIsAFourWheelSkidSteer) {
  using R = JointRole;
  expectVehicle("vehicles/husky/husky.urdf", {56.58,
                                              -0.1323,
                                              DriveLayout::kDifferential,
                                              {{"front_left_wheel", R::kDrive},
                                               {"front_right_wheel", R::kDrive},
                                               {"rear_left_wheel", R::kDrive},
                                               {"rear_right_wheel", R::kDrive}}});
}

TEST(RealVehicles, HuskysCylindersAreSpheroidsAndItsBoxesEllipsoids) {
  const auto file = testData("vehicles/husky/husky.urdf");
  if (!file) return;
  const auto loaded = loadUrdfFile(*file);
  ASSERT_TRUE(isLoaded(loaded));
  for (const char* wheel :
       {"front_left_wheel_link", "front_right_wheel_link", "rear_left_wheel_link", "rear_right_wheel_link"}) {
    EXPECT_EQ(linkOf(*loaded.value, wheel).ellipsoids.at(0).radii, Vector3d(0.1651, 0.05715, 0.1651));
  }
  const auto& base = linkOf(*loaded.value, "base_link").ellipsoids;
  ASSERT_EQ(base.size(), 2u);
  EXPECT_EQ(base[0].radii, 0.5 * Vector3d(0.9874, 0.5709, 0.12375));
  EXPECT_EQ(base[1].X_LE.p.z(), 0.17562499999999998);
  // All of its pictures are absent, and that is one note.
  int missing = 0;
  for (const std::string& note : loaded.notes) missing += note.find("visual mesh") != std::string::npos;
  EXPECT_EQ(missing, 1);
}

TEST(RealVehicles, PriusSteersWithContinuousJointsAndNotWithItsSteeringWheel) {
  using R = JointRole;
  expectVehicle("vehicles/prius/prius.urdf", {1423.0,
                                              -0.0126,
                                              DriveLayout::kAckermann,
                                              {{"steering_joint", R::kPrescribed},
                                               {"front_left_steer_joint", R::kSteer},
                                               {"front_right_steer_joint", R::kSteer},
                                               {"front_left_wheel_joint", R::kFreeWheel},
                                               {"front_right_wheel_joint", R::kFreeWheel},
                                               {"rear_left_wheel_joint", R::kDrive},
                                               {"rear_right_wheel_joint", R::kDrive}}});
}

TEST(RealVehicles, Em3905HasShocksSteeringAndFourDrivenWheels) {
  using R = JointRole;
  expectVehicle("vehicles/em_3905/em_3905.urdf", {4.961,
                                                  -0.0965,
                                                  DriveLayout::kAckermann,
                                                  {{"left_front_shock", R::kSuspension},
                                                   {"right_front_shock", R::kSuspension},
                                                   {"left_rear_shock", R::kSuspension},
                                                   {"right_rear_shock", R::kSuspension},
                                                   {"left_steering_joint", R::kSteer},
                                                   {"right_steering_joint", R::kSteer},
                                                   {"left_front_axle", R::kDrive},
                                                   {"right_front_axle", R::kDrive},
                                                   {"left_rear_axle", R::kDrive},
                                                   {"right_rear_axle", R::kDrive}}});
}

TEST(RealVehicles, LeoRocksOnTwoLateralJoints) {
  using R = JointRole;
  expectVehicle("vehicles/leo/leo_sim.urdf", {5.495,
                                              0.0,
                                              DriveLayout::kDifferential,
                                              {{"rocker_L_joint", R::kPassive},
                                               {"rocker_R_joint", R::kPassive},
                                               {"wheel_FL_joint", R::kDrive},
                                               {"wheel_RL_joint", R::kDrive},
                                               {"wheel_FR_joint", R::kDrive},
                                               {"wheel_RR_joint", R::kDrive}}});
}

TEST(RealVehicles, LeosThreeShapesAWheelAreOneSpheroid) {
  const auto file = testData("vehicles/leo/leo_sim.urdf");
  if (!file) return;
  const auto loaded = loadUrdfFile(*file);
  ASSERT_TRUE(isLoaded(loaded));
  const auto& wheel = linkOf(*loaded.value, "wheel_FL_link").ellipsoids;
  ASSERT_EQ(wheel.size(), 1u);
  EXPECT_EQ(wheel[0].radii.x(), 0.0625);
  ASSERT_TRUE(jointOf(*loaded.value, "rocker_R_joint").mimic);
  EXPECT_EQ(jointOf(*loaded.value, "rocker_R_joint").mimic->joint, "rocker_L_joint");
}

TEST(RealVehicles, Mir100DrivesTwoWheelsAndTrailsFourCasters) {
  using R = JointRole;
  Expected expected{
      69.24, 0.0, DriveLayout::kDifferential, {{"left_wheel_joint", R::kDrive}, {"right_wheel_joint", R::kDrive}}};
  for (const std::string corner : {"fl", "fr", "bl", "br"}) {
    expected.roles[corner + "_caster_rotation_joint"] = R::kPassive;
    expected.roles[corner + "_caster_wheel_joint"] = R::kFreeWheel;
  }
  expectVehicle("vehicles/mir100/mir100.urdf", expected);
}

TEST(RealVehicles, AgvsSteersAndDrivesBothEndsAndLiftsItsPlatform) {
  using R = JointRole;
  expectVehicle("vehicles/agvs/agvs.urdf", {270.0,
                                            -0.005,
                                            DriveLayout::kAckermann,
                                            {{"joint_back_motor_wheel", R::kSteer},
                                             {"joint_front_motor_wheel", R::kSteer},
                                             {"joint_back_wheel", R::kDrive},
                                             {"joint_front_wheel", R::kDrive},
                                             {"joint_side_wheel_left", R::kFreeWheel},
                                             {"joint_side_wheel_right", R::kFreeWheel},
                                             {"elevator_joint", R::kPrescribed}}});
}

TEST(RealVehicles, AgvsWheelsAreThinAlongTheirAxisWhateverUpAxisTheFileClaims) {
  const auto file = testData("vehicles/agvs/agvs.urdf");
  if (!file) return;
  const auto loaded = loadUrdfFile(*file);
  ASSERT_TRUE(isLoaded(loaded));
  const Vector3d radii = linkOf(*loaded.value, "front_wheel").ellipsoids.at(0).radii;
  EXPECT_NEAR(radii.x(), 0.11, 1e-5);
  EXPECT_NEAR(radii.y(), 0.035, 1e-5);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
