#include "ellipsoid_vehicle_sim/contact/find_contacts.h"

#include <gtest/gtest.h>

#include "support/contact_scenes.h"
#include "support/random_contact_cases.h"
#include "support/same_contacts.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

const Vector3d kWheel(0.35, 0.12, 0.35);

ContactOptions options(ContactsPerEllipsoid contacts, bool memory = false) {
  ContactOptions result;
  result.contacts = contacts;
  result.memory = memory;
  return result;
}

EllipsoidContacts find(const PosedEllipsoid& ellipsoid, const Terrain& terrain, ContactsPerEllipsoid contacts,
                       const ContactMemory& memory = {}) {
  ContactFinder finder;
  return findContacts(ellipsoid, memory, terrain, options(contacts), finder);
}

/// The push of all contacts together, in metres of one spring.
Vector3d push(const EllipsoidContacts& contacts) {
  Vector3d p = Vector3d::Zero();
  for (int i = 0; i < contacts.count; ++i)
    p += contacts.contact[i].share * contacts.contact[i].pressed * contacts.contact[i].nhat_W;
  return p;
}

/// Triangles whose box meets the ellipsoid's are looked at; for deep contacts of thin bodies, those whose box meets
/// that of the ball around it.
bool boxesMeet(const PosedEllipsoid& ellipsoid, const Triangle& triangle, const Vector3d& half) {
  Eigen::AlignedBox3d box(ellipsoid.p_WE - half, ellipsoid.p_WE + half), other;
  for (const Vector3d& v : triangle.v) other.extend(v);
  return box.intersects(other);
}

/// A heap of triangles around the origin, each corner near it.
TriangleSoup heap(RandomContactCases& random, int count) {
  TriangleSoup soup;
  for (int i = 0; i < count; ++i) {
    const Triangle t = random.triangle(1e-2);
    const auto n = static_cast<std::uint32_t>(soup.vertices.size());
    for (const Vector3d& v : t.v) soup.vertices.push_back(0.3 * v);
    soup.triangles.push_back({n, n + 1, n + 2});
  }
  return soup;
}

TEST(FindContacts, TheDeepestTriangleWinsWhateverWasCarriedBefore) {
  RandomContactCases random(41);
  int touching = 0;
  for (int i = 0; i < 300; ++i) {
    const auto terrain = terrainOf(heap(random, 12));
    for (int j = 0; j < 10; ++j) {
      const PosedEllipsoid ellipsoid(0.6 * random.unitVector(), random.rotation(), random.radii(0.05));
      int winner = -1;
      TriangleContact deepest;
      const auto search = [&](const Vector3d& half) {
        for (int t = 0; t < terrain->triangleCount(); ++t) {
          if (!boxesMeet(ellipsoid, terrain->triangle(t), half)) continue;
          const TriangleContact contact = minimumTranslation(ellipsoid, terrain->triangle(t));
          if (contact.depth > deepest.depth || (contact.depth == deepest.depth && t < winner))
            deepest = contact, winner = t;
        }
      };
      search(ellipsoid.halfBox());
      const double thinnest = ellipsoid.radii.minCoeff(), widest = ellipsoid.radii.maxCoeff();
      if (deepest.depth > 2.0 * thinnest * thinnest / widest) search(Vector3d::Constant(widest));
      // The triangle looked at first must not matter.
      ContactMemory memory;
      memory.count = random.index(2);
      memory.carried[0].triangle = random.index(12);
      const EllipsoidContacts found = find(ellipsoid, *terrain, ContactsPerEllipsoid::kOne, memory);
      ASSERT_EQ(found.count, winner < 0 ? 0 : 1);
      if (winner < 0) continue;
      ++touching;
      EXPECT_EQ(found.contact[0].triangle, winner);
      EXPECT_EQ(found.contact[0].depth, deepest.depth);
      EXPECT_EQ(found.contact[0].nhat_W, deepest.nhat_W);
    }
  }
  EXPECT_GT(touching, 1000);
}

TEST(FindContacts, LooksAtEveryTriangleThatPushesByLessThanTwiceTheSmallestCurvatureRadius) {
  // The ball of radius r_min^2 / r_max that touches the ellipsoid in E from within lies in it, so T does up to twice
  // that depth. Deeper, an edge or a corner may push that the ellipsoid does not touch; those are seen or not by their
  // boxes.
  RandomContactCases random(50);
  int shallow = 0;
  for (int i = 0; i < 100000; ++i) {
    const ContactCase c = random.next();
    const TriangleContact contact = minimumTranslation(c.ellipsoid, c.triangle);
    const double r = c.ellipsoid.radii.minCoeff();
    if (!contact || contact.depth > 2.0 * r * r / c.ellipsoid.radii.maxCoeff()) continue;
    ++shallow;
    EXPECT_TRUE(boxesMeet(c.ellipsoid, c.triangle, c.ellipsoid.halfBox())) << "case " << i;
  }
  EXPECT_GT(shallow, 10000);
}

TEST(FindContacts, TiesGoToTheLowestIndexWhateverWasCarriedBefore) {
  // The same triangle four times, and T0 on the seam of a fan: all depths equal to the bit.
  TriangleSoup soup;
  for (int i = 0; i < 4; ++i) {
    const auto n = static_cast<std::uint32_t>(soup.vertices.size());
    soup.vertices.insert(soup.vertices.end(), {{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}});
    soup.triangles.push_back({n, n + 1, n + 2});
  }
  const auto same = terrainOf(soup);
  const auto fan = terrainOf(floorSoup(2.0, 2));
  const PosedEllipsoid on_seam(Vector3d(0.0, 0.0, 0.33), Matrix3d::Identity(), kWheel);
  for (const auto& terrain : {same, fan}) {
    int lowest = -1;
    for (int t = terrain->triangleCount(); t-- > 0;)
      if (minimumTranslation(on_seam, terrain->triangle(t)).depth == 0.35 - 0.33) lowest = t;
    ASSERT_GE(lowest, 0);
    for (int warm = -1; warm < terrain->triangleCount(); ++warm) {
      ContactMemory memory;
      memory.count = warm < 0 ? 0 : 1;
      memory.carried[0].triangle = warm;
      EXPECT_EQ(find(on_seam, *terrain, ContactsPerEllipsoid::kOne, memory).contact[0].triangle, lowest);
    }
  }
}

TEST(FindContacts, TrianglesPushFromTheirFrontOnly) {
  RandomContactCases random(42);
  const auto terrain = flatFloor(5.0, 7);
  for (int i = 0; i < 1000; ++i) {
    const PosedEllipsoid below(Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), -random.logUniform(1e-6, 0.5)),
                               random.rotation(), kWheel);
    for (const auto contacts : {ContactsPerEllipsoid::kOne, ContactsPerEllipsoid::kValley})
      EXPECT_EQ(find(below, *terrain, contacts).count, 0);
  }
  const PosedEllipsoid above(Vector3d(0.1, 0.2, 1e-6), Matrix3d::Identity(), kWheel);
  EXPECT_EQ(find(above, *terrain, ContactsPerEllipsoid::kOne).contact[0].nhat_W, Vector3d::UnitZ());
}

TEST(FindContacts, FarAwayIsNoContact) {
  const auto terrain = flatFloor(5.0, 3);
  for (const Vector3d& p : {Vector3d(0, 0, 0.3500001), Vector3d(0, 0, 1e6), Vector3d(1e6, 0, 0.1)})
    EXPECT_EQ(find(PosedEllipsoid(p, Matrix3d::Identity(), kWheel), *terrain, ContactsPerEllipsoid::kValley).count, 0);
}

TEST(FindContacts, ValleyHoldsAWheelByGroundAndWall) {
  // Each face pushes with its own depth: at right angles neither takes from the other. Whatever the cut.
  for (const int cells : {1, 10, 300}) {
    TriangleSoup soup = floorSoup(6.0, cells);
    const TriangleSoup wall = floorSoup(6.0, cells);
    const auto n = static_cast<std::uint32_t>(soup.vertices.size());
    for (const Vector3d& v : wall.vertices) soup.vertices.emplace_back(0.5, v.y(), v.x());
    for (const auto& t : wall.triangles) soup.triangles.push_back({n + t[0], n + t[1], n + t[2]});
    const auto terrain = terrainOf(soup);
    ASSERT_NEAR(terrain->triangle(terrain->triangleCount() - 1).nhat_W.x(), -1.0, 1e-15);

    for (const double ground : {0.02, 1e-3, 0.05})
      for (const double side : {0.03, 1e-3, 0.002}) {
        // Only triangles that are touched where the wheel stands count. The finest cut has none left of a shallow face
        // once the deep face's push leads out of the patch in which the wheel touches it, sqrt(2 R d) to either side.
        const double patch = std::sqrt(2.0 * 0.12 * 0.12 / 0.35 * std::min(ground, side));
        if (cells == 300 && std::max(ground, side) > patch) continue;
        const PosedEllipsoid wheel({0.5 - 0.35 + side, 0.01, 0.35 - ground}, Matrix3d::Identity(), kWheel);
        const EllipsoidContacts found = find(wheel, *terrain, ContactsPerEllipsoid::kValley);
        EXPECT_EQ(found.count, 2) << cells << " cells, depths " << ground << ", " << side;
        EXPECT_LE((push(found) - Vector3d(-side, 0.0, ground)).norm(), 1e-12);
        // One contact has only the deeper of the two.
        const EllipsoidContacts one = find(wheel, *terrain, ContactsPerEllipsoid::kOne);
        EXPECT_NEAR(push(one).norm(), std::max(ground, side), 1e-12);
      }
  }
}

TEST(FindContacts, ValleyPushesByTheShortestWayOut) {
  // Two planes. With both faces pressed by d1 and d2 the push is the one of the little program; where the faces oppose
  // each other (beyond 90 degrees) it takes more than their depths, and each pushes with its own depth, not more.
  int both = 0;
  for (const double degrees : {1.0, 5.0, 20.0, 45.0, 90.0, 120.0, 150.0}) {
    const double angle = degrees * M_PI / 180.0;
    const auto terrain = terrainOf(bendSoup(angle));
    const Vector3d up = Vector3d::UnitZ(), tilted(-std::sin(angle), 0.0, std::cos(angle));
    for (const double d1 : {0.01, 0.02})
      for (const double d2 : {0.01, 0.015}) {
        // Sphere of 0.3 m, pressed by d1 into the ground and by d2 into the slope.
        const double r = 0.3, z = r - d1;
        const double x = -(r - d2 - std::cos(angle) * z) / std::sin(angle);
        const PosedEllipsoid sphere({x, 0.2, z}, Matrix3d::Identity(), Vector3d::Constant(r));
        const Vector3d p = push(find(sphere, *terrain, ContactsPerEllipsoid::kValley));
        // Where both foot points lie on their faces; else the push is that of one face.
        const double foot_ground = x, foot_slope = x * std::cos(angle) + z * std::sin(angle);
        if (foot_ground > 0.0 || foot_slope < 0.0) continue;
        if (degrees > 90.0) {
          EXPECT_LE((p - d1 * up - d2 * tilted).norm(), 1e-14) << degrees;
          continue;
        }
        ++both;
        EXPECT_GE(p.dot(up), d1 - 1e-12) << degrees;
        EXPECT_GE(p.dot(tilted), d2 - 1e-12) << degrees;
        const double c = std::cos(angle), s2 = 1.0 - c * c;
        const double a1 = (d1 - c * d2) / s2, a2 = (d2 - c * d1) / s2;
        const Vector3d expected = a1 <= 0.0   ? Vector3d(d2 * tilted)
                                  : a2 <= 0.0 ? Vector3d(d1 * up)
                                              : Vector3d(a1 * up + a2 * tilted);
        // Rounding of 1e-16 m over the sine of the angle.
        EXPECT_LE((p - expected).norm(), 1e-14 / s2) << degrees;
      }
  }
  EXPECT_GE(both, 12);
}

TEST(FindContacts, ValleyHoldsAKerbsEdgeBesideTheGround) {
  // A wheel stands on the ground against a kerb 10 cm high, met square on: the edge touches the wheel's rim.
  const auto terrain = terrainOf(kerbSoup(0.1));
  const double sag = 0.002, press = 0.0018, r = 0.35;
  // (Pressed by less than 0.0014 m it would be cleared by the ground's own push.)
  const double z = r - sag;
  // Distance of centre and edge r - press: the edge is pressed by that along the line to the centre.
  const double x = -std::sqrt((r - press) * (r - press) - (z - 0.1) * (z - 0.1));
  const PosedEllipsoid wheel({x, 0.0, z}, Matrix3d::Identity(), kWheel);
  const EllipsoidContacts found = find(wheel, *terrain, ContactsPerEllipsoid::kValley);
  ASSERT_EQ(found.count, 2);
  const Vector3d u = Vector3d(x, 0.0, z - 0.1).normalized(), p = push(found);
  EXPECT_NEAR(p.dot(Vector3d::UnitZ()), sag, 1e-12);
  // The edge is met anew after the ground's push, which turns its normal: second order in that push across the normal.
  const double across = sag * std::sqrt(1.0 - u.z() * u.z());
  EXPECT_NEAR(p.dot(u), press, across * across / (2.0 * r));
  EXPECT_EQ(find(wheel, *terrain, ContactsPerEllipsoid::kOne).contact[0].nhat_W, Vector3d::UnitZ());
}

TEST(FindContacts, ThreeFacesOfACornerEachPushWithTheirOwnDepth) {
  for (const int cells : {1, 20}) {
    TriangleSoup soup;
    // Three squares facing inwards from the planes x = 0, y = 0, z = 0.
    for (int axis = 0; axis < 3; ++axis) {
      const TriangleSoup face = floorSoup(6.0, cells);
      const auto n = static_cast<std::uint32_t>(soup.vertices.size());
      for (const Vector3d& v : face.vertices) {
        Vector3d turned = Vector3d::Zero();
        turned[(axis + 1) % 3] = v.x();
        turned[(axis + 2) % 3] = v.y();
        soup.vertices.push_back(turned);
      }
      for (const auto& t : face.triangles) soup.triangles.push_back({n + t[0], n + t[1], n + t[2]});
    }
    const auto terrain = terrainOf(soup);
    RandomContactCases random(43);
    for (int i = 0; i < 200; ++i) {
      const PosedEllipsoid still(Vector3d::Zero(), random.rotation(), kWheel);
      const Vector3d depth(random.logUniform(1e-5, 0.01), random.logUniform(1e-5, 0.01), random.logUniform(1e-5, 0.01));
      const PosedEllipsoid ellipsoid(still.halfBox() - depth, still.R_WE, kWheel);
      const EllipsoidContacts found = find(ellipsoid, *terrain, ContactsPerEllipsoid::kValley);
      EXPECT_EQ(found.count, 3);
      EXPECT_LE((push(found) - depth).norm(), 1e-12) << i;
    }
  }
}

/// Valley and one agree to the bit in poses of a wheel pressed into the given world from above, by up to `deepest`.
template <typename Surface>
void expectValleyIsOne(const Terrain& terrain, const Surface& height, double deepest, unsigned seed) {
  RandomContactCases random(seed);
  for (int i = 0; i < 1500; ++i) {
    const Matrix3d R = random.rotation();
    const double x = random.uniform(-0.6, 0.6), y = random.uniform(-0.6, 0.6), depth = random.logUniform(1e-5, deepest);
    const auto at = [&](double z) { return PosedEllipsoid({x, y, z}, R, kWheel); };
    // The height at which it is pressed that deep.
    double low = height(x, y) + 0.02, high = 0.4;
    for (int k = 0; k < 40; ++k) {
      const double z = 0.5 * (low + high);
      const EllipsoidContacts found = find(at(z), terrain, ContactsPerEllipsoid::kOne);
      (found.count > 0 && found.contact[0].depth > depth ? low : high) = z;
    }
    const EllipsoidContacts one = find(at(low), terrain, ContactsPerEllipsoid::kOne);
    ASSERT_EQ(one.count, 1);
    expectSameBits(find(at(low), terrain, ContactsPerEllipsoid::kValley), one);
  }
}

TEST(FindContacts, OnFlatGroundValleyIsOneToTheLastBit) {
  const auto level = [](double, double) { return 0.0; };
  expectValleyIsOne(*flatFloor(2.0, 1), level, 0.1, 44);
  expectValleyIsOne(*flatFloor(2.0, 40), level, 0.1, 45);
}

TEST(FindContacts, OnConvexGroundValleyIsOneToTheLastBit) {
  // Ridge and pyramid, less deep than the smallest radius of curvature of the wheel (4.1 cm).
  const auto ridge = [](double x, double) { return std::min(0.0, -x * std::tan(0.3)); };
  expectValleyIsOne(*terrainOf(bendSoup(-0.3)), ridge, 0.03, 46);
  TriangleSoup pyramid;
  pyramid.vertices = {{-2, -2, -0.5}, {2, -2, -0.5}, {2, 2, -0.5}, {-2, 2, -0.5}, {0, 0, 0}};
  pyramid.triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  const auto flanks = [](double x, double y) { return -0.25 * std::max(std::abs(x), std::abs(y)); };
  expectValleyIsOne(*terrainOf(pyramid), flanks, 0.03, 47);
}

TEST(FindContacts, RememberedContactsAreThoseThatWereFound) {
  RandomContactCases random(48);
  const auto terrain = terrainOf(groundAndWallSoup());
  int several = 0;
  for (int i = 0; i < 2000; ++i) {
    const PosedEllipsoid ellipsoid({-random.uniform(0.1, 0.4), random.uniform(-1, 1), random.uniform(0.1, 0.4)},
                                   random.rotation(), kWheel);
    ContactMemory known;
    known.fresh = false;
    known.posed = PosedEllipsoid(ellipsoid.p_WE + Vector3d(-1.0, 0.0, 1.0), ellipsoid.R_WE, kWheel);
    ContactFinder finder;
    const ContactOptions with_memory = options(ContactsPerEllipsoid::kValley, true);
    const EllipsoidContacts found = findContacts(ellipsoid, known, *terrain, with_memory, finder);
    several += found.count > 1;
    const ContactMemory memory = rememberContacts(ellipsoid, found, known, with_memory, 1e-3);
    const EllipsoidContacts remembered = rememberedContacts(memory, with_memory);
    ASSERT_EQ(remembered.count, found.count);
    for (int j = 0; j < found.count; ++j) {
      EXPECT_EQ(remembered.contact[j].nhat_W, found.contact[j].nhat_W);
      EXPECT_EQ(remembered.contact[j].depth, found.contact[j].depth);
      // E from the normal, or from the solver and pushed back again: rounding of lengths below 1 m.
      EXPECT_LE((remembered.contact[j].p_WE_lowest - found.contact[j].p_WE_lowest).norm(), 1e-12);
    }
  }
  EXPECT_GT(several, 100);
}

TEST(FindContacts, ClampedPointRuleFindsTheSameFaces) {
  const auto terrain = flatFloor(5.0, 9);
  RandomContactCases random(49);
  for (int i = 0; i < 300; ++i) {
    const PosedEllipsoid ellipsoid({random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(0.05, 0.3)},
                                   random.rotation(), kWheel);
    ContactOptions clamped = options(ContactsPerEllipsoid::kOne);
    clamped.rule = ContactRule::kClampedPoint;
    ContactFinder finder;
    const EllipsoidContacts found = findContacts(ellipsoid, {}, *terrain, clamped, finder);
    const double depth = ellipsoid.halfBox().z() - ellipsoid.p_WE.z();
    ASSERT_EQ(found.count, depth > 0.0 ? 1 : 0);
    if (found.count == 0) continue;
    EXPECT_NEAR(found.contact[0].depth, depth, 1e-14);
  }
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
