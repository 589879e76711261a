// How finely a floor is cut must not be felt: one touch counts once, seams do not push.
#include <gtest/gtest.h>

#include "support/contact_scenes.h"
#include "support/random_contact_cases.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

const Vector3d kWheel(0.35, 0.12, 0.35);
constexpr double kHalfSize = 60.0;
// Cells per side: the floor as 2, 200 and 20,000 triangles.
constexpr int kCuts[] = {1, 10, 100};

TEST(Tessellation, SameStateSameForceHoweverTheFloorIsCut) {
  // A plane that stands askew and off the origin, so that every number is rounded.
  const Eigen::AngleAxisd turn(0.7, Vector3d(0.3, -0.5, 0.2).normalized());
  const Vector3d offset(3.1, -2.7, 1.3);
  const Vector3d normal = turn * Vector3d::UnitZ();
  std::vector<std::shared_ptr<const Terrain>> terrains;
  for (const int cells : kCuts) {
    TriangleSoup soup = floorSoup(kHalfSize, cells);
    for (Vector3d& v : soup.vertices) v = turn * v + offset;
    terrains.push_back(terrainOf(soup));
  }
  RandomContactCases random(61);
  for (const ContactsPerEllipsoid contacts : {ContactsPerEllipsoid::kOne, ContactsPerEllipsoid::kValley})
    for (int i = 0; i < 2000; ++i) {
      const Eigen::Matrix3d R = random.rotation();
      const double depth = random.logUniform(1e-3, 0.3);
      const double half = PosedEllipsoid(Vector3d::Zero(), R, kWheel).halfWidth(normal);
      if (depth >= half) continue;
      const Vector3d p = turn * Vector3d(random.uniform(-20, 20), random.uniform(-20, 20), half - depth) + offset;
      for (const auto& terrain : terrains) {
        ContactOptions options;
        options.contacts = contacts;
        ContactFinder finder;
        const EllipsoidContacts found = findContacts(PosedEllipsoid(p, R, kWheel), {}, *terrain, options, finder);
        Vector3d push = Vector3d::Zero();
        for (int c = 0; c < found.count; ++c)
          push += found.contact[c].share * found.contact[c].pressed * found.contact[c].nhat_W;
        // 1e-12 of the depth, and what the corners carry: 100 m off they are rounded to 1e-14 m.
        EXPECT_LE((push - depth * normal).norm(), 3e-14 + 1e-12 * depth) << terrain->triangleCount() << " triangles";
      }
    }
}

TEST(Tessellation, LevelFloorPushesWithTheSameBitsHoweverCut) {
  std::vector<std::shared_ptr<const Terrain>> terrains;
  for (const int cells : kCuts) terrains.push_back(flatFloor(kHalfSize, cells));
  RandomContactCases random(62);
  for (int i = 0; i < 3000; ++i) {
    // Every third pose has its lowest point right on a seam or a corner of the finest cut.
    const Eigen::Matrix3d R = i % 3 == 0 ? Eigen::Matrix3d::Identity() : random.rotation();
    const double x = i % 3 == 0 ? 1.2 * random.index(30) : random.uniform(-20, 20);
    const double y = i % 2 == 0 ? x : random.uniform(-20, 20);
    const PosedEllipsoid wheel({x, y, random.uniform(0.02, 0.34)}, R, kWheel);
    const double depth = wheel.halfBox().z() - wheel.p_WE.z();
    Vector3d first = Vector3d::Zero();
    for (std::size_t t = 0; t < terrains.size(); ++t) {
      ContactFinder finder;
      const EllipsoidContacts found = findContacts(wheel, {}, *terrains[t], {}, finder);
      ASSERT_EQ(found.count, depth > 0.0 ? 1 : 0);
      if (found.count == 0) continue;
      EXPECT_EQ(found.contact[0].nhat_W, Vector3d::UnitZ());
      EXPECT_NEAR(found.contact[0].depth, depth, 1e-12 * depth + 1e-16);
      if (t == 0) first = found.contact[0].depth * found.contact[0].nhat_W;
      EXPECT_LE((found.contact[0].depth * found.contact[0].nhat_W - first).norm(), 1e-12 * depth);
    }
  }
}

TEST(Tessellation, DroppedBodyFollowsTheSamePathHoweverTheFloorIsCut) {
  for (const IntegratorKind integrator : allIntegrators()) {
    std::vector<Vector3d> end;
    for (const int cells : kCuts) {
      SimConfig config;
      config.integrator = integrator;
      // It rocks on its belly without damping, which explicit Euler amplifies at any step, by a little: part of the
      // path.
      config.allow_unstable = integrator == IntegratorKind::kExplicitEuler;
      Simulator body = make(solidBody({0.3, 0.25, 0.12}, 100.0), flatFloor(kHalfSize, cells), config);
      Pose start;
      start.p = {0.13, -0.21, 1.0};
      start.q = Quaterniond(Eigen::AngleAxisd(0.6, Vector3d(1.0, 2.0, 0.5).normalized()));
      ASSERT_TRUE(body.place(start, {1.0, 0.5, 0.0}, {0.5, 2.0, -0.3}).empty());
      run(body, 5.0);
      end.push_back(body.rootPose().p);
    }
    for (const Vector3d& p : end) EXPECT_LE((p - end[0]).norm(), 1e-9) << toString(integrator);
  }
}

TEST(Tessellation, CarFollowsTheSamePathAndSeamsNeverTilt) {
  std::vector<std::vector<Vector3d>> path;
  for (const int cells : kCuts) {
    Simulator vehicle = make(car(), flatFloor(kHalfSize, cells), SimConfig{});
    ASSERT_TRUE(vehicle.setDown(0.3, -0.2, 0.4).empty());
    std::vector<ContactReport> contacts;
    std::vector<Vector3d> positions;
    for (int i = 0; i < 20000; ++i) {
      // Away, round to the left, to the right, and brake.
      const double t = 1e-3 * i, yaw_rate = t < 5.0 ? 0.0 : t < 10.0 ? 0.4 : t < 16.0 ? -0.5 : 0.0;
      if (i % 100 == 0) vehicle.command({DriveCommand::Kind::kTwist, t < 18.0 ? 6.0 : 0.0, yaw_rate, 0.0});
      ASSERT_EQ(vehicle.step(), StepStatus::kOk);
      if (i % 20 == 0) {
        vehicle.contacts(contacts);
        ASSERT_GE(contacts.size(), 3u);
        for (const ContactReport& contact : contacts)
          ASSERT_EQ(contact.nhat_W, Vector3d::UnitZ()) << "at " << t << " s";
        positions.push_back(vehicle.rootPose().p);
      }
    }
    EXPECT_GT((positions.back() - positions.front()).norm(), 10.0);
    path.push_back(positions);
  }
  for (std::size_t cut = 1; cut < path.size(); ++cut)
    for (std::size_t i = 0; i < path[0].size(); ++i)
      ASSERT_LE((path[cut][i] - path[0][i]).norm(), 1e-9)
          << "cut " << cut << ", " << 0.02 * static_cast<double>(i) << " s";
}

TEST(Tessellation, CarPassesABackFaceWithoutAKick) {
  // A board in the road, seen from behind: slow and fast through it the wheels' loads stay as on the bare road.
  for (const double speed : {0.3, 10.0}) {
    std::vector<Vector3d> end;
    for (const bool board : {false, true}) {
      TriangleSoup soup = floorSoup(kHalfSize, 10);
      if (board) addQuad(soup, {2, -20, -1}, {2, 20, -1}, {2, 20, 3}, {2, -20, 3});
      Simulator vehicle = make(car(), terrainOf(soup), SimConfig{});
      const double start = speed < 1.0 ? 1.0 : -15.0;
      ASSERT_TRUE(vehicle.setDown(start - 1.3 - 0.4, 0.0, 0.0).empty());
      std::vector<ContactReport> contacts;
      const int steps = speed < 1.0 ? 8000 : 5000;
      for (int i = 0; i < steps; ++i) {
        vehicle.command({DriveCommand::Kind::kTwist, speed, 0.0, 0.0});
        ASSERT_EQ(vehicle.step(), StepStatus::kOk);
        vehicle.contacts(contacts);
        for (const ContactReport& contact : contacts)
          ASSERT_EQ(contact.nhat_W, Vector3d::UnitZ()) << speed << " m/s, step " << i;
      }
      end.push_back(vehicle.rootPose().p);
    }
    EXPECT_GT(end[0].x(), speed < 1.0 ? 1.0 : 6.0);
    EXPECT_LE((end[1] - end[0]).norm(), 1e-12) << speed << " m/s";
  }
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
