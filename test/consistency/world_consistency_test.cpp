// The same question asked in another way must get the same answer: worlds turned, shifted and scaled, floors cut at
// random, an ellipsoid and its own fine mesh.
#include <gtest/gtest.h>

#include "ellipsoid_vehicle_sim/contact/find_contacts.h"
#include "support/contact_scenes.h"
#include "support/meshes.h"
#include "support/motions.h"
#include "support/random_contact_cases.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

const Vector3d kWheel(0.35, 0.12, 0.35);

EllipsoidContacts contactsOf(const PosedEllipsoid& ellipsoid, const Terrain& terrain, ContactsPerEllipsoid contacts) {
  ContactOptions options;
  options.contacts = contacts;
  options.memory = options.cache = false;
  ContactFinder finder;
  return findContacts(ellipsoid, {}, terrain, options, finder);
}

/// What the springs feel: the shares' sum along the normals [m].
Vector3d pushOf(const EllipsoidContacts& found) {
  Vector3d push = Vector3d::Zero();
  for (int c = 0; c < found.count; ++c)
    push += found.contact[c].share * found.contact[c].depth * found.contact[c].nhat_W;
  return push;
}

/// A world of hills and a kerb, 20 m wide, and the same after x -> scale R x + shift.
struct MovedWorld {
  Matrix3d R;
  Vector3d shift;
  double scale;
  std::shared_ptr<const Terrain> terrain;
  MovedWorld(const Matrix3d& turn, const Vector3d& offset, double factor) : R(turn), shift(offset), scale(factor) {
    TriangleSoup soup = gridSoup(
        40, 0.5, [](double x, double y) { return 0.3 * std::sin(0.9 * x) * std::cos(0.7 * y); }, {-10, -10, 0});
    addQuad(soup, {3, -10, 0.6}, {3, 10, 0.6}, {3, 10, -1}, {3, -10, -1});
    addQuad(soup, {3, -10, 0.6}, {5, -10, 0.6}, {5, 10, 0.6}, {3, 10, 0.6});
    for (Vector3d& v : soup.vertices) v = scale * (R * v) + shift;
    terrain = terrainOf(std::move(soup));
  }
  PosedEllipsoid moved(const PosedEllipsoid& e) const {
    return {scale * (R * e.p_WE) + shift, R * e.R_WE, scale * e.radii};
  }
};

/// Poses in the hills at which each world must agree with the first, to `tolerance` of the wheel's size.
void expectSameContacts(const std::vector<MovedWorld>& worlds, unsigned seed, double tolerance) {
  const MovedWorld plain(Matrix3d::Identity(), Vector3d::Zero(), 1.0);
  RandomContactCases random(seed);
  int touching = 0;
  for (int i = 0; i < 4000; ++i) {
    const Vector3d p(random.uniform(-8, 8), random.uniform(-8, 8), random.uniform(-0.2, 0.9));
    const PosedEllipsoid wheel(p, random.rotation(), kWheel);
    const EllipsoidContacts expected = contactsOf(wheel, *plain.terrain, ContactsPerEllipsoid::kValley);
    touching += expected.count > 0;
    for (const MovedWorld& world : worlds) {
      const EllipsoidContacts found = contactsOf(world.moved(wheel), *world.terrain, ContactsPerEllipsoid::kValley);
      ASSERT_EQ(found.count > 0, expected.count > 0) << "pose " << i << ", scale " << world.scale;
      if (found.count == 0) continue;
      ASSERT_NEAR(found.contact[0].depth / world.scale, expected.contact[0].depth, tolerance * 0.35) << "pose " << i;
      const Vector3d push = world.R.transpose() * pushOf(found) / world.scale;
      ASSERT_LE((push - pushOf(expected)).norm(), 100.0 * tolerance) << "pose " << i << ", scale " << world.scale;
    }
  }
  EXPECT_GT(touching, 1000);
}

TEST(WorldConsistency, TurnedWorldGivesTurnedContacts) {
  RandomContactCases random(421);
  std::vector<MovedWorld> worlds;
  for (int i = 0; i < 5; ++i) worlds.emplace_back(random.rotation(), Vector3d::Zero(), 1.0);
  // Corners up to 14 m from the origin are rounded to 2e-15 m.
  expectSameContacts(worlds, 422, 1e-12);
}

TEST(WorldConsistency, WorldAMillionMetresAwayGivesTheSameContacts) {
  // There a coordinate is rounded to 1.2e-10 m: that is what is left, times the few corners of a contact.
  expectSameContacts({MovedWorld(Matrix3d::Identity(), {1e6, -1e6, 1e6}, 1.0)}, 423, 2e-9);
}

TEST(WorldConsistency, WorldAThousandTimesSmallerOrLargerGivesScaledContacts) {
  std::vector<MovedWorld> worlds;
  for (const double scale : {1e-3, 0.0625, 30.0, 1e3})
    worlds.emplace_back(Matrix3d::Identity(), Vector3d::Zero(), scale);
  // Small worlds meet the absolute nanometre by which contacts count as the same: 1e-6 of a wheel of 0.35 mm.
  expectSameContacts(worlds, 424, 1e-8);
}

/// The square [-5, 5]^2 in the plane z = 0, cut at random: corners moved, diagonals turned, triangles cut again inside,
/// beside an edge (slivers of 1 : 1e6) and on an edge that the neighbour keeps whole (T-junctions); some come twice,
/// some once more from below.
TriangleSoup randomFloor(RandomContactCases& random, int cells) {
  TriangleSoup soup;
  const double step = 10.0 / cells;
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i) {
      const bool inside = i > 0 && j > 0 && i < cells && j < cells;
      const double dx = inside ? random.uniform(-0.3, 0.3) : 0.0, dy = inside ? random.uniform(-0.3, 0.3) : 0.0;
      soup.vertices.emplace_back(-5.0 + step * (i + dx), -5.0 + step * (j + dy), 0.0);
    }
  std::vector<std::array<std::uint32_t, 3>> whole;
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const auto a = static_cast<std::uint32_t>(j * (cells + 1) + i), b = a + 1;
      const std::uint32_t d = a + static_cast<std::uint32_t>(cells) + 1, c = d + 1;
      if (random.index(2) == 0) {
        whole.push_back({a, b, c});
        whole.push_back({a, c, d});
      } else {
        whole.push_back({a, b, d});
        whole.push_back({b, c, d});
      }
    }
  for (const auto& t : whole) {
    const Vector3d a = soup.vertices[t[0]], b = soup.vertices[t[1]], c = soup.vertices[t[2]];
    const auto last = static_cast<std::uint32_t>(soup.vertices.size());
    switch (random.index(5)) {
      case 0:  // inside, or a hair's breadth beside an edge
      case 1: {
        const double near = random.index(2) == 0 ? 1e-6 : 0.3;
        soup.vertices.push_back(near * c + (1.0 - near) * (0.6 * a + 0.4 * b));
        soup.triangles.insert(soup.triangles.end(), {{t[0], t[1], last}, {t[1], t[2], last}, {t[2], t[0], last}});
        break;
      }
      case 2:  // on an edge
        soup.vertices.push_back(0.5 * (a + b));
        soup.triangles.insert(soup.triangles.end(), {{t[0], last, t[2]}, {last, t[1], t[2]}});
        break;
      default:
        soup.triangles.push_back(t);
    }
    if (random.index(10) == 0) soup.triangles.push_back(t);
    if (random.index(10) == 0) soup.triangles.push_back({t[0], t[2], t[1]});
  }
  return soup;
}

TEST(WorldConsistency, FloorPushesAsOnePlaneHoweverItIsCut) {
  RandomContactCases random(425);
  const std::vector<Vector3d> shapes = {kWheel, Vector3d::Constant(0.3), {0.4, 0.4, 4e-7}, {0.5, 5e-7, 5e-7}};
  for (int floor = 0; floor < 8; ++floor) {
    TriangleSoup soup = randomFloor(random, 2 + 3 * floor);
    const Matrix3d R = floor % 2 == 0 ? Matrix3d::Identity() : random.rotation();
    for (Vector3d& v : soup.vertices) v = R * v;
    const auto terrain = terrainOf(soup);
    for (int i = 0; i < 2000; ++i) {
      const Vector3d& radii = shapes[static_cast<std::size_t>(i) % shapes.size()];
      const Matrix3d attitude = i % 5 == 0 ? R : Matrix3d(R * random.rotation());
      const double half = PosedEllipsoid(Vector3d::Zero(), attitude, radii).halfWidth(R.col(2));
      const double depth = half * random.logUniform(1e-4, 0.9);
      // Every fourth stands right above a corner of the cut.
      Vector3d foot(random.uniform(-3.5, 3.5), random.uniform(-3.5, 3.5), 0.0);
      const Vector3d corner =
          R.transpose() * soup.vertices[static_cast<std::size_t>(random.index(static_cast<int>(soup.vertices.size())))];
      if (i % 4 == 0 && corner.cwiseAbs().maxCoeff() < 4.0) foot = corner;
      const PosedEllipsoid ellipsoid(R * (foot + Vector3d(0.0, 0.0, half - depth)), attitude, radii);
      for (const auto contacts : {ContactsPerEllipsoid::kOne, ContactsPerEllipsoid::kValley}) {
        const Vector3d push = pushOf(contactsOf(ellipsoid, *terrain, contacts));
        // Level floors are exact. Turned, corners 7 m off are rounded to 9e-16 m, which turns the plane of a sliver of
        // 1e-7 m by some 1e-8 rad, seen over half a metre.
        const double tolerance = floor % 2 == 0 ? 1e-12 : 3e-8;
        ASSERT_NEAR(push.dot(R.col(2)), depth, tolerance) << "floor " << floor << ", pose " << i;
        ASSERT_LE((push - depth * R.col(2)).norm(), tolerance) << "floor " << floor << ", pose " << i;
      }
    }
  }
}

TEST(WorldConsistency, EllipsoidAndItsOwnFineMeshAgree) {
  // Points spread evenly over the unit sphere and scaled: no direction is further than `gap` from one of them, so the
  // mesh's half width is short of the ellipsoid's by 1 - cos(gap) at most.
  constexpr int kPoints = 40000;
  std::vector<Vector3d> sphere;
  for (int i = 0; i < kPoints; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / kPoints, angle = i * M_PI * (3.0 - std::sqrt(5.0));
    sphere.push_back({std::sqrt(1.0 - z * z) * std::cos(angle), std::sqrt(1.0 - z * z) * std::sin(angle), z});
  }
  const double gap = 3.0 / std::sqrt(kPoints);  // a point has 4 pi / N of the sphere to itself; the rest is margin
  RandomContactCases random(426);
  int touching = 0;
  for (int i = 0; i < 400; ++i) {
    const ContactCase c = random.next(random.radii(0.1), random.triangle(1e-2), random.logUniform(1e-3, 1.0));
    const TriangleContact contact = minimumTranslation(c.ellipsoid, c.triangle);
    if (!contact) continue;
    ++touching;
    const double slack = (1.0 - std::cos(gap)) * c.ellipsoid.radii.maxCoeff();
    const Matrix3d S = c.ellipsoid.R_WE * c.ellipsoid.radii.asDiagonal();
    /// Push of the mesh along u that clears the triangle.
    const auto clears = [&](const Vector3d& u) {
      double lowest = 1e300, highest = -1e300;
      const Vector3d along = S.transpose() * u;
      for (const Vector3d& p : sphere) lowest = std::min(lowest, along.dot(p));
      for (const Vector3d& v : c.triangle.v) highest = std::max(highest, u.dot(v));
      return highest - u.dot(c.ellipsoid.p_WE) - lowest;
    };
    const double along = clears(contact.nhat_W);
    EXPECT_LE(along, contact.depth + 1e-12) << "case " << i;
    EXPECT_GE(along, contact.depth - slack) << "case " << i;
    // No shorter push in a direction near it does, but by what the mesh is short of the ellipsoid.
    for (int k = 0; k < 12; ++k) {
      const Vector3d u = (contact.nhat_W + random.logUniform(1e-4, 1e-2) * random.unitVector()).normalized();
      EXPECT_GE(clears(u), contact.depth - slack) << "case " << i;
    }
  }
  EXPECT_GT(touching, 150);
}

/// A ball of 670 N and 0.3 m that rolls along +x; the ground's normal force at every step after it has settled [N].
std::vector<double> rollingForces(const std::shared_ptr<const Terrain>& terrain, const Vector3d& start, double speed,
                                  int steps) {
  constexpr double kRadius = 0.3, kMass = 670.0 / 9.80665;
  SimConfig config;
  config.integrator = IntegratorKind::kRk4;
  config.stiffness = 1e6;
  config.damping = 2.0 * 0.5 * std::sqrt(1e6 * kMass);
  Simulator ball = make(solidBody(Vector3d::Constant(kRadius), kMass), terrain, config);
  placeAt(ball, start + Vector3d(0.0, 0.0, kRadius - 670.0 / 1e6), {speed, 0.0, 0.0}, {0.0, speed / kRadius, 0.0});
  run(ball, 0.5);
  std::vector<double> forces;
  for (int i = 0; i < steps; ++i) {
    if (ball.step() != StepStatus::kOk) throw std::runtime_error("the simulation diverged");
    forces.push_back(groundForce(ball).normal);
  }
  return forces;
}

double ripple(const std::vector<double>& forces) {
  const auto [low, high] = std::minmax_element(forces.begin(), forces.end());
  return 0.5 * (*high - *low) / 670.0;
}

TEST(RollingRipple, BallOnAFlatHeightFieldFeelsNoSeam) {
  // Seams straight across, along and athwart: the ball meets a cell's border every 17th step and runs on diagonals.
  for (const double y : {0.0, 0.07, 0.25}) {
    const auto grid = terrainOf(gridSoup(40, 0.5, [](double, double) { return 0.0; }, {-10.0, -10.0, 0.0}));
    const double found = ripple(rollingForces(grid, {-4.0, y, 0.0}, 3.0, 2000));
    std::printf("flat height field, y = %g m: the force ripples by %.2e\n", y, found);
    EXPECT_LT(found, 1e-3);
    // Rounding is all there is.
    EXPECT_LT(found, 1e-9);
  }
}

TEST(RollingRipple, BallOnAFloorCutAtRandomFeelsNoSeam) {
  RandomContactCases random(427);
  const double found = ripple(rollingForces(terrainOf(randomFloor(random, 20)), {-4.0, 0.1, 0.0}, 3.0, 2000));
  std::printf("floor with slivers, T-junctions and duplicates: the force ripples by %.2e\n", found);
  EXPECT_LT(found, 1e-6);
}

TEST(RollingRipple, OnGentlyCurvedGroundTheForceIsThatOfTheFacetsAlone) {
  // A hump and a bowl of 50 m radius in facets of 0.5 m: as long strips, and as a height field with cells of 0.5 m.
  // Both are the same surface, so every bit of a difference would be a seam's doing.
  for (const double bend : {-1.0, 1.0}) {
    const auto height = [bend](double x) { return bend * (50.0 - std::sqrt(2500.0 - x * x)); };
    std::vector<Eigen::Vector2d> profile;
    for (int i = -20; i <= 20; ++i) profile.emplace_back(0.5 * i, height(0.5 * i));
    const auto strips = terrainOf(profileSoup(profile, 10.0));
    const auto field =
        terrainOf(gridSoup(40, 0.5, [&](double x, double) { return height(x - 10.0); }, {-10.0, -10.0, 0.0}));
    const Vector3d start(-3.2, 0.1, height(-3.2));
    const std::vector<double> facets = rollingForces(strips, start, 3.0, 1500),
                              cells = rollingForces(field, start, 3.0, 1500);
    double largest = 0.0;
    for (std::size_t i = 0; i < facets.size(); ++i) largest = std::max(largest, std::abs(facets[i] - cells[i]) / 670.0);
    std::printf("%s of 50 m radius: the force ripples by %.2g on facets, cells add %.2e\n",
                bend < 0.0 ? "hump" : "bowl", ripple(facets), largest);
    EXPECT_LT(largest, 1e-6);
    EXPECT_GT(ripple(facets), 1e-4);  // the facets are there
  }
}

TEST(RollingRipple, BallOverATessellatedCylinderFeelsItsFacets) {
  // A cylinder of radius 2 m in 64 facets, each a strip of cells. For a ball outside of a convex prism the push is its
  // radius less the distance to the polygon.
  constexpr int kFacets = 64, kCells = 20;
  constexpr double kCylinder = 2.0, kBall = 0.3;
  const auto corner = [&](int i, int j) {
    const double angle = 2.0 * M_PI * i / kFacets;
    return Vector3d(kCylinder * std::sin(angle), -2.0 + 4.0 * j / kCells, kCylinder * std::cos(angle));
  };
  TriangleSoup soup;
  for (int i = 0; i < kFacets; ++i)
    for (int j = 0; j < kCells; ++j)
      addQuad(soup, corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1));
  const auto terrain = terrainOf(soup);
  RandomContactCases random(428);
  double least = 1e300, most = 0.0;
  for (int i = 0; i < 5000; ++i) {
    const double angle = random.uniform(0.0, 2.0 * M_PI), away = kCylinder + kBall - 0.01;
    const Vector3d centre(away * std::sin(angle), random.uniform(-1.5, 1.5), away * std::cos(angle));
    double distance = 1e300;
    for (int k = 0; k < kFacets; ++k) {
      const Vector3d a = corner(k, 0), b = corner(k + 1, 0);
      const Eigen::Vector2d p(centre.x() - a.x(), centre.z() - a.z()), d(b.x() - a.x(), b.z() - a.z());
      distance = std::min(distance, (p - std::clamp(p.dot(d) / d.squaredNorm(), 0.0, 1.0) * d).norm());
    }
    const EllipsoidContacts found =
        contactsOf({centre, random.rotation(), Vector3d::Constant(kBall)}, *terrain, ContactsPerEllipsoid::kValley);
    ASSERT_EQ(found.count, 1);
    ASSERT_NEAR(found.contact[0].depth, kBall - distance, 1e-12);
    least = std::min(least, found.contact[0].depth);
    most = std::max(most, found.contact[0].depth);
  }
  // Between a corner of the polygon and the middle of a facet lies its rise.
  const double rise = kCylinder * (1.0 - std::cos(M_PI / kFacets));
  std::printf("cylinder of 64 facets: depths from %.4f to %.4f m, the facets' rise is %.4f m\n", least, most, rise);
  EXPECT_LE(most - least, rise + 1e-12);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
