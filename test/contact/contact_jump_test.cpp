// What the memory of the last accepted pose is for: one-sided triangles that an ellipsoid comes upon from behind,
// overlaps it is spawned in, and contacts that jump. Source: notation.h [ContactDefinition], rule 6.
#include <gtest/gtest.h>

#include "support/contact_scenes.h"
#include "support/random_contact_cases.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

const Vector3d kWheel(0.35, 0.12, 0.35);
constexpr double kGravity = 9.80665;

/// Explicit Euler needs omega dt < 2 zeta.
double damping(double mass, double ratio = 0.3) { return 2.0 * ratio * std::sqrt(1e7 * mass); }

class MotionWithJump : public testing::TestWithParam<ContactSetting> {
 protected:
  SimConfig config(double mass) const {
    return frictionless(GetParam().integrator, GetParam().dt, GetParam().contacts, damping(mass));
  }
};

TEST_P(MotionWithJump, SphereFromBehindKeepsItsEnergy) {
  SimConfig free = config(100.0);
  free.gravity = 0.0;
  BareRun run(solidBody(Vector3d::Constant(0.1), 100.0), flatFloor(5.0), free);
  run.place({0.3, 0.2, -0.2 + 1e-4}, Quaterniond::Identity(), {0.0, 0.0, 5.0});
  run.run(0.1);
  EXPECT_GT(run.position().z(), 0.25);
  // No force ever acts: 100 kg at 5 m/s, to the last bit.
  EXPECT_EQ(run.velocity(), Vector3d(0.0, 0.0, 5.0));
  EXPECT_EQ(run.kineticEnergy(), 1250.0);
}

TEST_P(MotionWithJump, WithoutMemoryASphereFromBehindIsShotOut) {
  // Half the stiffness times the depth squared at which the front is first seen: up to 10 cm, less up to a step's way,
  // 50 kJ at most. Without damping, or the damper would eat part of it; explicit Euler then makes more of it, never
  // less; linearly_implicit damps by itself.
  SimConfig free = frictionless(GetParam().integrator, GetParam().dt, GetParam().contacts, 0.0);
  free.gravity = 0.0;
  free.contact_memory = false;
  BareRun run(solidBody(Vector3d::Constant(0.1), 100.0), flatFloor(5.0), free);
  run.place({0.3, 0.2, -0.2 + 1e-4}, Quaterniond::Identity(), {0.0, 0.0, 5.0});
  run.run(0.1);
  EXPECT_GT(run.kineticEnergy(), GetParam().integrator == IntegratorKind::kLinearlyImplicit ? 30e3 : 40e3);
}

TEST_P(MotionWithJump, ABackFaceIsPassedAsIfItWereNotThere) {
  // A wheel stands on the ground and slides through a wall, or a 5 mm board, that it meets from behind.
  const double mass = 250.0, weight = mass * kGravity;
  for (const double bottom : {0.0, -1.0})
    for (const double speed : {0.2, 1.0, 5.0, 20.0})
      for (const double yaw : {0.0, 0.4}) {
        TriangleSoup soup = floorSoup(50.0, 1);
        addQuad(soup, {0, -20, bottom}, {0, 20, bottom}, {0, 20, 3}, {0, -20, 3});
        const double sag = weight / 1e7;
        BareRun run(solidBody(kWheel, mass), terrainOf(soup), config(mass));
        run.place({-0.4, 0.0, 0.35 - sag}, Quaterniond(Eigen::AngleAxisd(yaw, Vector3d::UnitZ())), {speed, 0.0, 0.0});
        run.settled();
        const double energy = run.energy();
        const auto steps = static_cast<int>(0.9 / speed / run.config().dt);
        for (int i = 0; i < steps; ++i) {
          run.step();
          // Its static sag carries it; rounding of the sag's 16 digits times the stiffness is 1e-9 N.
          ASSERT_LE((run.contactForce() - Vector3d(0.0, 0.0, weight)).norm(), 1e-6 * weight)
              << speed << " m/s, wall from " << bottom << ", x = " << run.position().x();
        }
        EXPECT_GT(run.position().x(), 0.36);
        EXPECT_NEAR(run.energy(), energy, 1e-9 * energy);
        EXPECT_EQ(run.memory().slack, 0.0);
      }
}

TEST_P(MotionWithJump, SpawnedInAnOverlapItRisesSlowly) {
  const double mass = 250.0;
  for (const double deep : {0.01, 0.21}) {
    BareRun run(solidBody(kWheel, mass), flatFloor(5.0), config(mass));
    run.place({0.0, 0.0, 0.35 - deep});
    const double start = run.position().z();
    double fastest = 0.0, z_at_half = 0.0;
    const auto steps = static_cast<int>(std::llround(0.9 / run.config().dt));
    for (int i = 0; i < steps; ++i) {
      run.step();
      fastest = std::max(fastest, run.velocity().norm());
      if (i == steps / 2) z_at_half = run.position().z();
    }
    // The weight has first to find its sag of 0.25 mm: a fall of up to g / omega = 0.049 m/s.
    EXPECT_LE(fastest, 0.05) << deep;
    EXPECT_NEAR((run.position().z() - z_at_half) / 0.45, 0.01, 1e-4) << deep;
    EXPECT_LT(run.position().z() - start, 0.9 * 0.01) << deep;
  }
}

TEST_P(MotionWithJump, SpawnedInAnOverlapItEndsInItsStaticSag) {
  const double mass = 250.0, sag = mass * kGravity / 1e7;
  BareRun run(solidBody(kWheel, mass), flatFloor(5.0), config(mass));
  run.place({0.0, 0.0, 0.35 - 0.01});
  run.run(1.5);
  EXPECT_NEAR(run.position().z(), 0.35 - sag, 1e-8);
  EXPECT_EQ(run.memory().slack, 0.0);
}

TEST_P(MotionWithJump, WithoutMemoryASpawnedOverlapIsAnExplosion) {
  SimConfig off = config(250.0);
  off.contact_memory = false;
  BareRun run(solidBody(kWheel, 250.0), flatFloor(50.0), off);
  run.place({0.0, 0.0, 0.35 - 0.21});
  double fastest = 0.0;
  for (int i = 0; i < 100; ++i) {
    run.step();
    fastest = std::max(fastest, run.velocity().z());
  }
  // 0.21 m of a spring of 1e7 N/m under 250 kg with e = 0.29 or better: more than 10 m/s.
  EXPECT_GT(fastest, 10.0);
}

INSTANTIATE_TEST_SUITE_P(Settings, MotionWithJump, testing::ValuesIn(allContactSettings()), settingName);

/// Work of the contact force on a wheel that is led round the edge of a table: down beside it, inwards below its top,
/// where the shallow contact with the edge turns into the deep one with the face, and up again. Gained, where the face
/// pushes back what the edge never took.
struct LoopResult {
  double work = 0.0;   ///< on the wheel [J].
  double creep = 0.0;  ///< what the release of slack may have added: its speed times the integral of the force [J].
};

LoopResult loopRoundAnEdge(const ContactOptions& options, double duration, double dt, double depth) {
  const auto terrain = terrainOf(profileSoup({{-50.0, 0.0}, {0.0, 0.0}, {0.0, -50.0}}));
  ContactFinder finder;
  ContactMemory memory;
  const double stiffness = 1e7;
  const auto force = [&](const EllipsoidContacts& contacts) {
    Vector3d f = Vector3d::Zero();
    for (int i = 0; i < contacts.count; ++i)
      f += contacts.contact[i].share * stiffness * contacts.contact[i].pressed * contacts.contact[i].nhat_W;
    return f;
  };
  // Centre: above and outside, down, inwards, up. Far enough out that the way down touches the edge alone.
  const std::vector<Vector3d> corners = {
      {0.05, 0.0, 0.40}, {0.05, 0.0, 0.35 - depth}, {-0.1, 0.0, 0.35 - depth}, {-0.1, 0.0, 0.40}, {0.05, 0.0, 0.40}};
  double length = 0.0;
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) length += (corners[i + 1] - corners[i]).norm();
  const auto steps = static_cast<int>(std::llround(duration / dt));
  const auto position = [&](int step) {
    double s = length * step / steps;
    for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
      const double side = (corners[i + 1] - corners[i]).norm();
      if (s <= side || i + 2 == corners.size()) return Vector3d(corners[i] + s / side * (corners[i + 1] - corners[i]));
      s -= side;
    }
    return corners.back();
  };
  LoopResult result;
  // The thin side of the wheel rolls along the edge: its smallest radius of curvature there, 4.1 cm, is far below the
  // depth.
  const Eigen::Matrix3d R = Eigen::AngleAxisd(M_PI / 2.0, Vector3d::UnitZ()).toRotationMatrix();
  Vector3d before = Vector3d::Zero();
  for (int i = 0; i <= steps; ++i) {
    const PosedEllipsoid posed(position(i), R, kWheel);
    const EllipsoidContacts contacts = findContacts(posed, memory, *terrain, options, finder);
    const Vector3d after = force(contacts);
    if (i > 0) result.work += 0.5 * (before + after).dot(position(i) - position(i - 1));
    memory = rememberContacts(posed, contacts, memory, options, dt);
    before = force(rememberedContacts(memory, options));
    result.creep += kSlackRelease * before.norm() * dt;
  }
  return result;
}

TEST(PrescribedLoop, RoundAnEdgeGainsNothingButTheCreep) {
  for (const ContactsPerEllipsoid contacts : {ContactsPerEllipsoid::kOne, ContactsPerEllipsoid::kValley}) {
    ContactOptions options;
    options.contacts = contacts;
    options.memory = true;
    for (const double dt : {1e-3, 0.25e-3})
      for (const double duration : {0.05, 0.1, 0.2, 0.5, 1.0}) {
        const LoopResult loop = loopRoundAnEdge(options, duration, dt, 0.10);
        EXPECT_LT(loop.work, loop.creep) << duration << " s in steps of " << dt << " s";
        if (duration > 0.1) continue;
        EXPECT_LT(loop.work, 0.0) << duration << " s in steps of " << dt << " s";
      }
  }
}

TEST(PrescribedLoop, WithoutMemoryGainsWhatTheJumpAdds) {
  for (const ContactsPerEllipsoid contacts : {ContactsPerEllipsoid::kOne, ContactsPerEllipsoid::kValley}) {
    ContactOptions options;
    options.contacts = contacts;
    options.memory = false;
    // The edge's depth where T0 comes over it is 7.8 cm of the face's 10: half k (0.1^2 - 0.078^2) = 19.6 kJ.
    EXPECT_NEAR(loopRoundAnEdge(options, 0.2, 1e-3, 0.10).work, 19.7e3, 0.3e3);
  }
}

TEST(PrescribedLoop, ShallowLoopRoundAnEdgeGainsAndLosesNothing) {
  // 3 cm is less than the radius of curvature: no jump, the force has a potential.
  for (const bool memory : {false, true}) {
    ContactOptions options;
    options.memory = memory;
    // Trapezoidal sum of a force with corners: second order in a step of a tenth of a millimetre.
    EXPECT_NEAR(loopRoundAnEdge(options, 1.0, 0.1e-3, 0.03).work, 0.0, 0.5);
  }
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
