#include "ellipsoid_vehicle_sim/vehicle/link_poses.h"

#include <gtest/gtest.h>

#include "ellipsoid_vehicle_sim/description/urdf_loader.h"
#include "support/meshes.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

class DrivenVehicle : public testing::TestWithParam<const char*> {};

// On a flat floor the depth of a contact is h(n) - n . (c - p): so deep is the posed ellipsoid below the floor. After a
// turn suspensions have moved and wheels are steered and turned; the contacts come from the dynamics, which know
// nothing of links.
TEST_P(DrivenVehicle, EllipsoidsOnTheirLinksAreThoseThatTouchTheGround) {
  const Loaded<VehicleDescription> vehicle = loadUrdfFile(std::string(SHARE_DIR) + "/urdf/" + GetParam() + ".urdf");
  ASSERT_TRUE(vehicle) << problemText(vehicle.problems);
  const TriangleSoup ground = gridSoup(20, 10.0, [](double, double) { return 0.0; }, {-100.0, -100.0, 0.0});
  SimConfig config;
  config.solid_compound = std::string(GetParam()) == "compound_car";
  Loaded<Simulator> loaded = Simulator::create(
      *vehicle.value, std::make_shared<const Terrain>(std::move(*Terrain::build(ground).value)), config);
  ASSERT_TRUE(loaded) << problemText(loaded.problems);
  Simulator& simulator = *loaded.value;
  ASSERT_TRUE(simulator.setDown(0.0, 0.0, 0.4).empty());
  for (int i = 0; i < 1500; ++i) {
    DriveCommand command;
    command.speed = 4.0;
    command.yaw_rate = 0.5;
    if (i % 100 == 0) {
      ASSERT_TRUE(simulator.command(command));
    }
    ASSERT_EQ(simulator.step(), StepStatus::kOk);
  }
  LinkPoses links(simulator.model().description);
  std::vector<PosedEllipsoid> ellipsoids;
  appendPosedEllipsoids(simulator, links, ellipsoids);
  ASSERT_EQ(ellipsoids.size(), simulator.ellipsoids().size());
  std::vector<ContactReport> contacts;
  simulator.contacts(contacts);
  ASSERT_GE(contacts.size(), 3u);
  for (const ContactReport& contact : contacts) {
    const PosedEllipsoid& e = ellipsoids[static_cast<std::size_t>(contact.ellipsoid)];
    EXPECT_NEAR(e.halfWidth(contact.nhat_W) - contact.nhat_W.dot(e.p_WE - contact.p_WC), contact.depth, 1e-10);
  }
  EXPECT_EQ(links.find("no such link"), -1);
  EXPECT_TRUE(links.poses()[static_cast<std::size_t>(links.find(simulator.model().description.root))].p.isApprox(
      simulator.rootPose().p, 1e-15));
}

INSTANTIATE_TEST_SUITE_P(All, DrivenVehicle, testing::Values("car", "skid_steer", "compound_car"));

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
