// What the memory of the last accepted pose must not change: motions without a jump. Source: notation.h
// [ContactDefinition], rule 6. What it is for is tested in contact_jump_test.cpp.
#include <gtest/gtest.h>

#include "support/contact_scenes.h"
#include "support/random_contact_cases.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

const Vector3d kWheel(0.35, 0.12, 0.35);
constexpr double kMass = 250.0;
// Damping ratio 0.3 with the whole mass; more where a hit off the centre feels less of it. Explicit Euler needs
// omega dt = 0.2 ... 0.36 < 2 zeta.
const double kDamping = 2.0 * 0.3 * std::sqrt(1e7 * kMass);

class MotionWithoutJump : public testing::TestWithParam<ContactSetting> {
 protected:
  SimConfig config(bool memory) const {
    SimConfig c = frictionless(GetParam().integrator, GetParam().dt, GetParam().contacts, kDamping);
    c.contact_memory = memory;
    return c;
  }
};

/// The same motion with and without memory, step by step; false (and a failure) at the first bit that differs.
class Twins {
 public:
  Twins(std::shared_ptr<const Terrain> terrain, const SimConfig& with, const SimConfig& without)
      : with_(solidBody(kWheel, kMass), terrain, with), without_(solidBody(kWheel, kMass), terrain, without) {}

  void place(const Vector3d& p, const Quaterniond& q, const Vector3d& v, const Vector3d& w) {
    with_.place(p, q, v, w);
    without_.place(p, q, v, w);
  }
  void settled() {
    with_.settled();
    without_.settled();
  }

  bool run(double seconds) {
    const auto steps = static_cast<std::int64_t>(std::llround(seconds / with_.config().dt));
    for (std::int64_t i = 0; i < steps; ++i) {
      const bool was_touching = with_.memory().count > 0;
      with_.step();
      without_.step();
      touches_ += !was_touching && with_.memory().count > 0 ? 1 : 0;
      deepest_ = std::max(deepest_, with_.memory().deepest);
      // The hash covers the motion and the memory: a slack above zero or another triangle counts as a difference.
      if (hashOf(with_.state()) == hashOf(without_.state())) continue;
      const ContactMemory &a = with_.memory(), &b = without_.memory();
      ADD_FAILURE() << "step " << i << ": slack " << a.slack << " m, contacts " << a.count << " and " << b.count
                    << ", triangles " << a.carried[0].triangle << " and " << b.carried[0].triangle << ", depths "
                    << a.carried[0].depth << " and " << b.carried[0].depth << " m, positions differ by "
                    << (with_.position() - without_.position()).norm() << " m; at " << with_.position().transpose();
      return false;
    }
    return true;
  }

  int touches() const { return touches_; }
  double deepest() const { return deepest_; }

 private:
  BareRun with_, without_;
  int touches_ = 0;
  double deepest_ = 0.0;
};

/// Falls with any attitude, 1 to 5 m/s and a spin, from just clear of the ground.
int bounce(Twins& twins, int falls, double height, double half_range, unsigned seed) {
  RandomContactCases random(seed);
  for (int i = 0; i < falls; ++i) {
    const Vector3d p(random.uniform(-half_range, half_range), random.uniform(-1.0, 1.0), height + 0.36);
    const Vector3d v(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), -random.uniform(1.0, 5.0));
    const Vector3d w = random.uniform(0.0, 3.0) * random.unitVector();
    twins.place(p, Quaterniond(random.rotation()), v, w);
    if (!twins.run(1.5)) break;
  }
  return twins.touches();
}

TEST_P(MotionWithoutJump, MemoryChangesNoBitOfBouncesOnAFloor) {
  Twins twins(flatFloor(50.0, 40), config(true), config(false));
  EXPECT_GE(bounce(twins, 6, 0.0, 2.0, 11), 12);
}

TEST_P(MotionWithoutJump, MemoryChangesNoBitOfBouncesOnASawtooth) {
  Twins twins(terrainOf(sawtoothSoup(20.0 * M_PI / 180.0, 0.8, 40)), config(true), config(false));
  EXPECT_GE(bounce(twins, 8, 0.8 * std::tan(20.0 * M_PI / 180.0), 2.0, 12), 12);
}

TEST_P(MotionWithoutJump, MemoryChangesNoBitOfBouncesOnAKerb) {
  Twins twins(terrainOf(kerbSoup(0.15)), config(true), config(false));
  EXPECT_GE(bounce(twins, 8, 0.15, 0.3, 13), 12);
}

TEST_P(MotionWithoutJump, MemoryChangesNoBitOfDrivesOverBends) {
  for (const double degrees : {-20.0, -5.0, 5.0, 20.0}) {
    Twins twins(terrainOf(bendSoup(degrees * M_PI / 180.0)), config(true), config(false));
    for (const double speed : {2.0, 5.0, 10.0, 20.0}) {
      // Upright, in its static sag, the last 10 cm and a fraction of a step before the bend; and across its axle.
      for (const double yaw : {0.0, 0.5, M_PI / 2.0}) {
        const double sag = kMass * 9.80665 / 1e7;
        twins.place({-0.1 - 0.37e-3 * speed, 0.0, 0.35 - sag}, Quaterniond(Eigen::AngleAxisd(yaw, Vector3d::UnitZ())),
                    {speed, 0.0, 0.0}, Vector3d::Zero());
        twins.settled();
        EXPECT_TRUE(twins.run(0.5)) << degrees << " degrees, " << speed << " m/s, yaw " << yaw;
      }
    }
    EXPECT_GT(twins.deepest(), 0.0);
  }
}

/// A driven car with springs, joints and brushes, with and without memory.
void expectSameDrive(const std::shared_ptr<const Terrain>& terrain, const SimConfig& config, double speed) {
  SimConfig off = config;
  off.contact_memory = false;
  Simulator with = make(car(), terrain, config), without = make(car(), terrain, off);
  for (Simulator* s : {&with, &without}) ASSERT_TRUE(s->setDown(-6.0, 0.3, 0.2).empty());
  for (int i = 0; i < 5000; ++i) {
    for (Simulator* s : {&with, &without}) {
      s->command({DriveCommand::Kind::kTwist, speed, i < 2500 ? 0.2 : -0.3, 0.0});
      ASSERT_EQ(s->step(), StepStatus::kOk);
    }
    ASSERT_EQ(with.stateHash(), without.stateHash())
        << "step " << i << ", positions differ by " << (with.rootPose().p - without.rootPose().p).norm() << " m";
  }
}

TEST(CarWithoutJump, MemoryChangesNoBitOfADriveOverHills) {
  TriangleSoup hills = floorSoup(30.0, 120);
  for (Vector3d& v : hills.vertices) v.z() = 0.1 * std::sin(0.9 * v.x()) * std::cos(0.7 * v.y());
  const auto terrain = terrainOf(hills);
  for (const IntegratorKind integrator : {IntegratorKind::kSemiImplicitEuler, IntegratorKind::kRk4})
    for (const ContactsPerEllipsoid contacts : {ContactsPerEllipsoid::kOne, ContactsPerEllipsoid::kValley}) {
      SimConfig config;
      config.integrator = integrator;
      config.contacts_per_ellipsoid = contacts;
      expectSameDrive(terrain, config, 5.0);
    }
}

TEST(CarWithoutJump, MemoryChangesNoBitOfADriveUpAKerb) {
  const auto terrain = terrainOf(kerbSoup(0.08));
  for (const ContactsPerEllipsoid contacts : {ContactsPerEllipsoid::kOne, ContactsPerEllipsoid::kValley})
    for (const double speed : {1.0, 4.0}) {
      SimConfig config;
      config.contacts_per_ellipsoid = contacts;
      expectSameDrive(terrain, config, speed);
    }
}

INSTANTIATE_TEST_SUITE_P(Settings, MotionWithoutJump, testing::ValuesIn(allContactSettings()), settingName);

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
