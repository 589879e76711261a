#include "ellipsoid_vehicle_sim/description/urdf_loader.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "urdf_samples.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string limitText(const std::string& attributes) { return "<limit " + attributes + "/>"; }

/// The cart with a joint to a second body of 1 kg.
Loaded<VehicleDescription> cartWithArm(const std::string& type, const std::string& rest,
                                       const std::string& axis = "0 1 0") {
  return loadText(baseText() + rearAxleText() + linkText("arm", inertialText()) +
                  jointText("arm_joint", type, "base", "arm", "0 0 0.3", axis, rest));
}

TEST(UrdfLoader, LoadsAFileWithItsLines) {
  const auto loaded = loadUrdfFile(kTestUrdfFolder + "cart.urdf");
  ASSERT_TRUE(isLoaded(loaded));
  const VehicleDescription& cart = *loaded.value;
  EXPECT_EQ(cart.name, "cart");
  EXPECT_EQ(cart.file, kTestUrdfFolder + "cart.urdf");
  EXPECT_EQ(cart.root, "base_link");
  EXPECT_EQ(linkOf(cart, "front_left_wheel").line, 15);
  EXPECT_EQ(jointOf(cart, "front_left_axle").line, 27);
  EXPECT_EQ(linkOf(cart, "base_link").ellipsoids.at(0).source, "box 0.6 x 0.4 x 0.2 (cart.urdf:11)");
}

TEST(UrdfLoader, OrdersParentsBeforeChildren) {
  // The file names the leaf first and the root last.
  const auto fixed = [](const std::string& parent, const std::string& child) {
    return jointText(parent + "_" + child, "fixed", parent, child, "0 0 0", "1 0 0");
  };
  const auto loaded = loadText(fixed("b", "c") + linkText("c", "") + linkText("b", "") + fixed("a", "b") +
                               fixed("base", "a") + linkText("a", "") + baseText());
  ASSERT_TRUE(isLoaded(loaded));
  const VehicleDescription& v = *loaded.value;
  ASSERT_EQ(v.links.size(), 4u);
  EXPECT_EQ(v.links[0].name, "base");
  for (std::size_t j = 0; j < v.joints.size(); ++j) {
    EXPECT_EQ(v.joints[j].child, v.links[j + 1].name);
    bool before = false;
    for (std::size_t l = 0; l <= j; ++l) before = before || v.links[l].name == v.joints[j].parent;
    EXPECT_TRUE(before) << v.joints[j].name;
  }
}

TEST(UrdfLoader, KeepsFixedJointsAsJoints) {
  const auto loaded = loadText(baseText() + linkText("imu", "") +
                               jointText("imu_joint", "fixed", "base", "imu", "0.1 0.2 0.3", "0 0 0"));
  ASSERT_TRUE(isLoaded(loaded));
  const JointDescription& joint = jointOf(*loaded.value, "imu_joint");
  EXPECT_EQ(joint.type, JointType::kFixed);
  EXPECT_EQ(joint.role, JointRole::kLocked);
  EXPECT_EQ(joint.X_PJ.p, Eigen::Vector3d(0.1, 0.2, 0.3));
}

TEST(UrdfLoader, TurnsTheInertiaIntoTheLinksAxes) {
  // Turned by 90 degrees about z, the tensor's x axis is the link's y axis.
  const auto loaded =
      loadText(linkText("base",
                        "<inertial><origin xyz=\"1 2 3\" rpy=\"0 0 1.5707963267948966\"/><mass value=\"5\"/>"
                        "<inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"2\" iyz=\"0\" izz=\"2.5\"/></inertial>" +
                            collisionText("<sphere radius=\"1\"/>")));
  ASSERT_TRUE(isLoaded(loaded));
  const LinkDescription& base = loaded.value->links[0];
  EXPECT_EQ(base.mass, 5.0);
  EXPECT_EQ(base.p_Lcm, Eigen::Vector3d(1, 2, 3));
  // A rotation by a rounded pi/2 leaves 1e-16 of a moment.
  EXPECT_NEAR((base.I_cm_L - Eigen::Matrix3d(Eigen::Vector3d(2, 1, 2.5).asDiagonal())).norm(), 0.0, 1e-15);
  EXPECT_EQ(base.I_cm_L, base.I_cm_L.transpose());
}

TEST(UrdfLoader, AxesAreUnitVectorsAndAMissingOneIsX) {
  const auto limit = limitText("lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"");
  const auto scaled = cartWithArm("revolute", limit, "0 0 -20");
  ASSERT_TRUE(isLoaded(scaled));
  EXPECT_EQ(jointOf(*scaled.value, "arm_joint").axis, Eigen::Vector3d(0, 0, -1));
  const auto missing = loadText(
      baseText() + rearAxleText() + linkText("arm", inertialText()) +
      "<joint name=\"arm_joint\" type=\"revolute\"><parent link=\"base\"/><child link=\"arm\"/>" + limit + "</joint>");
  EXPECT_TRUE(notedWith(missing, {"joint 'arm_joint'", "no <axis", "1 0 0"}));
  EXPECT_EQ(jointOf(*missing.value, "arm_joint").axis, Eigen::Vector3d(1, 0, 0));
}

TEST(UrdfLoader, ReadsLimitsAndDynamics) {
  const auto loaded = cartWithArm("revolute", limitText("lower=\"-0.5\" upper=\"1.5\" effort=\"7\" velocity=\"3\"") +
                                                  "<dynamics damping=\"0.25\" friction=\"0.125\"/>");
  ASSERT_TRUE(isLoaded(loaded));
  const JointDescription& joint = jointOf(*loaded.value, "arm_joint");
  EXPECT_EQ(joint.lower, -0.5);
  EXPECT_EQ(joint.upper, 1.5);
  EXPECT_EQ(joint.effort_limit, 7.0);
  EXPECT_EQ(joint.velocity_limit, 3.0);
  EXPECT_EQ(joint.damping, 0.25);
  EXPECT_EQ(joint.friction, 0.125);
  EXPECT_FALSE(joint.spring_stiffness);
}

TEST(UrdfLoader, AContinuousJointKeepsLimitsThatLeaveARange) {
  const auto limited = cartWithArm("continuous", limitText("lower=\"-0.8\" upper=\"0.8\" effort=\"7\" velocity=\"3\""));
  EXPECT_TRUE(notedWith(limited, {"arm_joint", "kept as limits"}));
  EXPECT_EQ(jointOf(*limited.value, "arm_joint").upper, 0.8);
  const auto zeros = cartWithArm("continuous", limitText("lower=\"0\" upper=\"0\" effort=\"7\" velocity=\"3\""));
  EXPECT_TRUE(notedWith(zeros, {"arm_joint", "taken as unlimited"}));
  EXPECT_EQ(jointOf(*zeros.value, "arm_joint").upper, kInfinity);
}

TEST(UrdfLoader, LimitsThatLeaveNoRoomLockTheJoint) {
  const auto loaded = cartWithArm("revolute", limitText("effort=\"7\" velocity=\"3\""));
  EXPECT_TRUE(notedWith(loaded, {"arm_joint", "lower and upper are both 0", "locked"}));
  EXPECT_EQ(jointOf(*loaded.value, "arm_joint").role, JointRole::kLocked);
}

TEST(UrdfLoader, EffortAndVelocityZeroAreUnlimitedWithANote) {
  const auto loaded = cartWithArm("revolute", limitText("lower=\"-1\" upper=\"1\" effort=\"0\" velocity=\"0.0\""));
  EXPECT_TRUE(notedWith(loaded, {"effort=\"0\" on joints 'arm_joint'", "unlimited"}));
  EXPECT_TRUE(notedWith(loaded, {"velocity=\"0\" on joints 'arm_joint'", "unlimited"}));
  EXPECT_EQ(jointOf(*loaded.value, "arm_joint").effort_limit, kInfinity);
  EXPECT_EQ(jointOf(*loaded.value, "arm_joint").velocity_limit, kInfinity);
  EXPECT_TRUE(notedWith(loaded, {"no <limit effort=...> on the driven joints 'rl_axle', 'rr_axle'"}));
}

TEST(UrdfLoader, ReadsSpringsFromDynamics) {
  const auto loaded =
      cartWithArm("prismatic", limitText("lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"") +
                                   "<dynamics damping=\"2000\" spring_stiffness=\"25000\" spring_reference=\"-0.1\"/>");
  ASSERT_TRUE(isLoaded(loaded));
  EXPECT_EQ(jointOf(*loaded.value, "arm_joint").spring_stiffness, 25000.0);
  EXPECT_EQ(jointOf(*loaded.value, "arm_joint").spring_reference, -0.1);
}

TEST(UrdfLoader, ReadsSpringsFromGazebo) {
  const std::string limit = limitText("lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"");
  const auto with = [&limit](const std::string& gazebo) {
    return loadText(baseText() + rearAxleText() + linkText("arm", inertialText()) +
                    jointText("arm_joint", "prismatic", "base", "arm", "0 0 0", "0 0 1", limit) +
                    "<gazebo reference=\"arm_joint\">" + gazebo + "</gazebo>");
  };
  const auto text = with("<springStiffness> 300 </springStiffness><springReference value=\"-0.02\"/>");
  ASSERT_TRUE(isLoaded(text));
  EXPECT_EQ(jointOf(*text.value, "arm_joint").spring_stiffness, 300.0);
  EXPECT_EQ(jointOf(*text.value, "arm_joint").spring_reference, -0.02);
  const auto none = with("<springStiffness>0</springStiffness>");
  ASSERT_TRUE(isLoaded(none));
  EXPECT_FALSE(jointOf(*none.value, "arm_joint").spring_stiffness);
  EXPECT_TRUE(refusedWith(with("<springStiffness>soft</springStiffness>"), {"gazebo 'arm_joint'", "\"soft\"", ">= 0"}));
}

TEST(UrdfLoader, ReadsMimic) {
  const auto loaded = cartWithArm("revolute", limitText("lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"") +
                                                  "<mimic joint=\"rl_axle\" multiplier=\"-2\" offset=\"0.5\"/>");
  EXPECT_TRUE(notedWith(loaded, {"arm_joint", "mimics 'rl_axle'"}));
  const auto& mimic = jointOf(*loaded.value, "arm_joint").mimic;
  ASSERT_TRUE(mimic);
  EXPECT_EQ(mimic->joint, "rl_axle");
  EXPECT_EQ(mimic->multiplier, -2.0);
  EXPECT_EQ(mimic->offset, 0.5);
}

TEST(UrdfLoader, ALinkWithoutInertialIsMassless) {
  const auto loaded =
      loadText(baseText() + linkText("frame", "") + jointText("f", "fixed", "base", "frame", "0 0 0", "1 0 0"));
  ASSERT_TRUE(isLoaded(loaded));
  EXPECT_EQ(linkOf(*loaded.value, "frame").mass, 0.0);
  EXPECT_TRUE(linkOf(*loaded.value, "frame").I_cm_L.isZero());
}

TEST(UrdfLoader, TheMassMaySitBehindAFixedJoint) {
  const auto loaded =
      loadText(linkText("base", collisionText("<sphere radius=\"0.1\"/>")) + linkText("inertia", inertialText(3.0)) +
               jointText("f", "fixed", "base", "inertia", "0 0 0", "1 0 0"));
  ASSERT_TRUE(isLoaded(loaded));
  EXPECT_EQ(massOf(*loaded.value), 3.0);
}

TEST(UrdfLoader, MassZeroWithAnInertiaIsNoted) {
  const auto loaded = loadText(baseText() +
                               linkText("dummy",
                                        "<inertial><mass value=\"0\"/><inertia ixx=\"1e-6\" ixy=\"0\" ixz=\"0\""
                                        " iyy=\"1e-6\" iyz=\"0\" izz=\"1e-6\"/></inertial>") +
                               jointText("f", "fixed", "base", "dummy", "0 0 0", "1 0 0"));
  EXPECT_TRUE(notedWith(loaded, {"link 'dummy'", "mass 0 with an inertia"}));
}

TEST(UrdfLoader, MissingPicturesAreOneNote) {
  const std::string visual = "<visual><geometry><mesh filename=\"package://nowhere/a.dae\"/></geometry></visual>";
  const auto loaded =
      loadText(linkText("base", inertialText() + visual + visual + collisionText("<sphere radius=\"0.1\"/>")));
  EXPECT_TRUE(notedWith(loaded, {"link 'base'", "package://nowhere/a.dae", "1 more visual meshes were not found"}));
  EXPECT_EQ(loaded.notes.size(), 2u);  // and the one that a ball cannot be driven
}

TEST(UrdfLoader, MirroredPicturesAreNobodysBusiness) {
  const auto loaded = loadText(
      linkText("base", inertialText() + collisionText("<sphere radius=\"0.1\"/>") +
                           "<visual><geometry><mesh filename=\"a.dae\" scale=\"1 -1 1\"/></geometry></visual>"));
  EXPECT_TRUE(isLoaded(loaded));
}

TEST(UrdfLoader, UnknownElementsAreNotedWithTheirLine) {
  const auto loaded =
      loadText(linkText("base", inertialText() + collisionText("<sphere radius=\"0.1\"/>") + "<collison/>"));
  EXPECT_TRUE(notedWith(loaded, {"test.urdf:5 link 'base'", "<collison> is ignored"}));
}

TEST(UrdfLoader, ABodyWithoutJointsNeedsNoWheels) {
  EXPECT_TRUE(notedWith(loadText(baseText()), {"no joints and no wheels"}));
}

TEST(UrdfLoader, TheSameTextGivesTheSameVehicle) {
  const auto a = loadUrdfFile(kTestUrdfFolder + "cart.urdf"), b = loadUrdfFile(kTestUrdfFolder + "cart.urdf");
  ASSERT_TRUE(isLoaded(a));
  EXPECT_EQ(a.notes, b.notes);
  ASSERT_EQ(a.value->links.size(), b.value->links.size());
  for (std::size_t l = 0; l < a.value->links.size(); ++l) {
    ASSERT_EQ(a.value->links[l].ellipsoids.size(), b.value->links[l].ellipsoids.size());
    for (std::size_t e = 0; e < a.value->links[l].ellipsoids.size(); ++e) {
      EXPECT_EQ(a.value->links[l].ellipsoids[e].radii, b.value->links[l].ellipsoids[e].radii);
      EXPECT_EQ(a.value->links[l].ellipsoids[e].fit_error, b.value->links[l].ellipsoids[e].fit_error);
    }
  }
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
