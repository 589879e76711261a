#include "ellipsoid_vehicle_sim/description/shapes_to_ellipsoids.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <set>

#include "urdf_samples.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

/// Rounding of a rotation by a decimal rpy, relative.
constexpr double kRounding = 1e-12;

EllipsoidDescription only(const Loaded<VehicleDescription>& loaded, const std::string& link) {
  if (!loaded || linkOf(*loaded.value, link).ellipsoids.size() != 1) {
    ADD_FAILURE() << "not one ellipsoid in " << link << "\n" << problemText(loaded.problems);
    return {};
  }
  return linkOf(*loaded.value, link).ellipsoids[0];
}

/// The ellipsoid that stands for one collision on a body without wheels.
EllipsoidDescription bodyOf(const std::string& collision, const UrdfOptions& options = {}) {
  const UriResolver everything = [](const std::string& uri) { return std::optional<std::string>(uri); };
  return only(loadUrdfText(robotText(linkText("base", inertialText() + collision)), "test.urdf", everything, options),
              "base");
}

/// Options whose every mesh has these vertices.
UrdfOptions withVertices(std::vector<Vector3d> vertices) {
  UrdfOptions options;
  options.read_mesh = [vertices](const std::string&) { return Loaded<std::vector<Vector3d>>{vertices, {}, {}}; };
  return options;
}

/// Rings of a sphere about `centre` with poles, as modelling programs write them.
std::vector<Vector3d> sphereVertices(const Vector3d& centre, double radius, int rings, int slices) {
  std::vector<Vector3d> vertices = {centre + Vector3d(0, 0, radius), centre - Vector3d(0, 0, radius)};
  for (int i = 1; i < rings; ++i) {
    for (int j = 0; j < slices; ++j) {
      const double a = M_PI * i / rings, b = 2.0 * M_PI * j / slices;
      vertices.push_back(centre + radius * Vector3d(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a)));
    }
  }
  return vertices;
}

/// Two rims of a wheel about y.
std::vector<Vector3d> rims(double radius, double half_width, int corners, double y = 0.0) {
  std::vector<Vector3d> vertices;
  for (int i = 0; i < corners; ++i) {
    const double a = 2.0 * M_PI * i / corners;
    for (double side : {-half_width, half_width})
      vertices.emplace_back(radius * std::cos(a), y + side, radius * std::sin(a));
  }
  return vertices;
}

/// The spheroid of one wheel of a two-wheeled cart whose wheels are made of these collisions.
Loaded<VehicleDescription> cartOn(const std::string& collisions, const std::string& axis = "0 1 0",
                                  const UrdfOptions& options = {}) {
  std::string text = linkText("base", inertialText(10.0));
  for (const auto& [name, y] : {std::pair{"l", "0.3"}, {"r", "-0.3"}}) {
    text += linkText(name, inertialText() + collisions) +
            jointText(std::string(name) + "_axle", "continuous", "base", name, "0 " + std::string(y) + " 0", axis);
  }
  const UriResolver everything = [](const std::string& uri) { return std::optional<std::string>(uri); };
  return loadUrdfText(robotText(text), "test.urdf", everything, options);
}

// --- Bodies ---------------------------------------------------------------------------------------------------------

TEST(BodyEllipsoids, ASphereIsItself) {
  const auto e = bodyOf(collisionText("<sphere radius=\"0.25\"/>", "1 2 3"));
  EXPECT_EQ(e.radii, Vector3d::Constant(0.25));
  EXPECT_EQ(e.X_LE.p, Vector3d(1, 2, 3));
  EXPECT_EQ(e.fit_error, 0.0);
  EXPECT_EQ(e.source, "sphere r=0.25 (test.urdf:4)");
}

TEST(BodyEllipsoids, TheUnitSphereMeshNeedsNoFile) {
  const auto loaded = loadText(linkText(
      "base",
      inertialText() +
          collisionText(
              "<mesh filename=\"package://ellipsoid_vehicle_sim/meshes/unit_sphere.stl\" scale=\"0.3 0.15 0.1\"/>",
              "0 0 1", "0 0 1.5707963267948966")));
  const auto e = only(loaded, "base");
  EXPECT_EQ(e.radii, Vector3d(0.3, 0.15, 0.1));
  EXPECT_EQ(e.X_LE.p, Vector3d(0, 0, 1));
  EXPECT_NEAR((e.X_LE.q * Vector3d::UnitX() - Vector3d::UnitY()).norm(), 0.0, kRounding);
  EXPECT_EQ(e.fit_error, 0.0);
}

TEST(BodyEllipsoids, ASphereLikeMeshIsRecognisedByGeometryWhereverItsCentre) {
  const auto options = withVertices(sphereVertices({0.5, -1.0, 2.0}, 0.25, 16, 24));
  const auto e = bodyOf(collisionText("<mesh filename=\"ball.obj\" scale=\"2 1 0.5\"/>"), options);
  EXPECT_NEAR((e.radii - Vector3d(0.5, 0.25, 0.125)).norm(), 0.0, kRounding);
  EXPECT_NEAR((e.X_LE.p - Vector3d(1.0, -1.0, 1.0)).norm(), 0.0, kRounding);
  EXPECT_EQ(e.fit_error, 0.0);
  EXPECT_NE(e.source.find("sphere mesh ball.obj"), std::string::npos) << e.source;
}

TEST(BodyEllipsoids, CornersOfACubeAndRimsOfAWheelAreNoSphere) {
  std::vector<Vector3d> cube;
  for (int repeat = 0; repeat < 3; ++repeat) {  // as STL repeats them
    for (int i = 0; i < 8; ++i) cube.emplace_back(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
  }
  EXPECT_FALSE(fitSphere(cube));
  EXPECT_FALSE(fitSphere(rims(1.0, 1.0, 64)));
  EXPECT_FALSE(fitSphere(rims(1.0, 0.0, 64)));
  EXPECT_TRUE(fitSphere(sphereVertices(Vector3d::Zero(), 1.0, 8, 12)));
}

TEST(BodyEllipsoids, TwoPerCentOutOfRoundIsNoSphere) {
  auto vertices = sphereVertices(Vector3d::Zero(), 1.0, 16, 24);
  for (Vector3d& v : vertices) v.x() *= 1.03;
  EXPECT_FALSE(fitSphere(vertices));
  for (Vector3d& v : vertices) v.x() *= 1.005 / 1.03;
  EXPECT_TRUE(fitSphere(vertices));
}

TEST(BodyEllipsoids, ABoxKeepsItsHalfExtentsAndTellsItsCornersDistance) {
  const auto e = bodyOf(collisionText("<box size=\"2 2 2\"/>", "0 0 0", "0.3 0.2 0.1"));
  EXPECT_EQ(e.radii, Vector3d(1, 1, 1));
  EXPECT_NEAR(e.fit_error, std::sqrt(3.0) - 1.0, 1e-9);  // a cube's corner from its inscribed sphere
}

TEST(BodyEllipsoids, ACylinderKeepsItsHalfExtents) {
  const auto e = bodyOf(collisionText("<cylinder radius=\"0.5\" length=\"1\"/>"));
  EXPECT_EQ(e.radii, Vector3d(0.5, 0.5, 0.5));
  EXPECT_NEAR(e.fit_error, 0.5 * (std::sqrt(2.0) - 1.0), 1e-9);  // its rim from the inscribed sphere
}

TEST(BodyEllipsoids, AMeshFillsTheBoxAroundIt) {
  const auto options = withVertices({{0, 0, 0}, {4, 0, 0}, {4, 2, 0}, {0, 2, 0}, {2, 1, 1}});
  const auto e = bodyOf(collisionText("<mesh filename=\"roof.stl\" scale=\"0.5 1 2\"/>", "0 0 10"), options);
  EXPECT_EQ(e.radii, Vector3d(1, 1, 1));
  EXPECT_EQ(e.X_LE.p, Vector3d(1, 1, 11));
  // The lower corners are (1, 1, 1) from the centre.
  EXPECT_NEAR(e.fit_error, std::sqrt(3.0) - 1.0, 1e-9);
}

TEST(BodyEllipsoids, AFlatMeshIsThickened) {
  const auto options = withVertices({{0, 0, 0}, {4, 0, 0}, {4, 2, 0}, {0, 2, 0}});
  const auto e = bodyOf(collisionText("<mesh filename=\"plate.stl\"/>"), options);
  EXPECT_EQ(e.radii, Vector3d(2, 1, 0.02));
}

TEST(BodyEllipsoids, NamesAreUnique) {
  const auto loaded = loadText(linkText("base", inertialText() + collisionText("<sphere radius=\"0.1\"/>", "2 0 0") +
                                                    collisionText("<box size=\"1 1 1\"/>") +
                                                    collisionText("<sphere radius=\"0.3\"/>", "-2 0 0")));
  ASSERT_TRUE(isLoaded(loaded));
  std::set<std::string> names;
  for (const auto& e : linkOf(*loaded.value, "base").ellipsoids) names.insert(e.name);
  EXPECT_EQ(names, (std::set<std::string>{"base/1", "base/2", "base/3"}));
}

TEST(BodyEllipsoids, AFitDoesNotReachBelowTheWheels) {
  // Half a cube, its cut face turned down and level: the shape ends at -0.05 m, the sphere in the cube at -0.15 m, the
  // wheels at -0.1 m.
  const double h = 0.1;
  const auto options = withVertices({{-h, -h, -h}, {-h, h, -h}, {h, -h, h}, {h, h, h}, {-h, -h, h}, {-h, h, h}});
  const std::string wedge = linkText("base", inertialText(10.0) + collisionText("<mesh filename=\"wedge.stl\"/>",
                                                                                "0 0 -0.05", "0 0.7853981633974483 0"));
  const UriResolver everything = [](const std::string& uri) { return std::optional<std::string>(uri); };
  const auto loaded = loadUrdfText(robotText(wedge + rearAxleText()), "test.urdf", everything, options);
  EXPECT_TRUE(notedWith(loaded, {"link 'base'", "0.05 m below the wheels; raised by 0.1 m"}));
  const auto e = only(loaded, "base");
  const double bottom = e.X_LE.p.z() - (e.X_LE.q.conjugate() * Vector3d::UnitZ()).cwiseProduct(e.radii).norm();
  EXPECT_NEAR(bottom, -0.05, kRounding);
}

TEST(BodyEllipsoids, AShapeBelowTheWheelsIsTold) {
  const std::string plough = linkText("plough", collisionText("<sphere radius=\"0.05\"/>", "0 0 -0.1")) +
                             jointText("p", "fixed", "base", "plough", "0 0 0", "1 0 0");
  EXPECT_TRUE(
      notedWith(loadText(baseText() + rearAxleText() + plough), {"link 'plough'", "reaches 0.05 m below the wheels"}));
}

// --- Wheels ---------------------------------------------------------------------------------------------------------

TEST(WheelEllipsoids, ACylinderKeepsRadiusAndWidthExactlyAboutTheAxis) {
  const auto e =
      only(cartOn(collisionText("<cylinder radius=\"0.1651\" length=\"0.1143\"/>", "0 0 0", "1.570795 0 0")), "l");
  EXPECT_EQ(e.radii, Vector3d(0.1651, 0.05715, 0.1651));
  EXPECT_EQ(e.X_LE.p, Vector3d::Zero());
  EXPECT_EQ(e.X_LE.q.coeffs(), Eigen::Quaterniond::Identity().coeffs());
}

TEST(WheelEllipsoids, TheResidualIsTold) {
  const auto loaded = cartOn(collisionText("<cylinder radius=\"0.1\" length=\"0.04\"/>", "0.002 0.03 0", "1.58 0 0"));
  EXPECT_TRUE(notedWith(loaded, {"wheel 'l'", "off the axis it was 0.002 m", "tilted 0.00920367 rad"}));
  const auto e = only(loaded, "l");
  EXPECT_EQ(e.X_LE.p, Vector3d(0, 0.03, 0));  // moved onto the axis, not along it
}

TEST(WheelEllipsoids, AWheelOnATurnedLinkHasItsShortAxisAlongTheJoint) {
  // The axis is the link's z, turned into the lateral one by the joint's origin.
  const std::string wheel =
      linkText("w", inertialText() + collisionText("<cylinder radius=\"0.1\" length=\"0.05\"/>")) +
      "<joint name=\"w_axle\" type=\"continuous\"><parent link=\"base\"/><child link=\"w\"/>"
      "<origin xyz=\"0 0.3 0\" rpy=\"1.57079633 0 0\"/><axis xyz=\"0 0 -1\"/></joint>";
  const auto e = only(loadText(baseText() + rearAxleText() + wheel), "w");
  EXPECT_EQ(e.radii, Vector3d(0.1, 0.1, 0.025));
}

TEST(WheelEllipsoids, AnObliqueAxisTurnsTheSpheroid) {
  // 10 degrees of toe.
  const double a = 10.0 * M_PI / 180.0;
  const std::string axis = std::to_string(std::sin(a)) + " " + std::to_string(std::cos(a)) + " 0";
  const auto loaded = cartOn(collisionText("<sphere radius=\"0.1\"/>"), axis);
  const auto e = only(loaded, "l");
  EXPECT_NEAR((e.X_LE.q * Vector3d::UnitY()).cross(jointOf(*loaded.value, "l_axle").axis).norm(), 0.0, kRounding);
}

TEST(WheelEllipsoids, ASphereStaysASphere) {
  EXPECT_EQ(only(cartOn(collisionText("<sphere radius=\"0.31265\"/>")), "l").radii, Vector3d::Constant(0.31265));
}

TEST(WheelEllipsoids, ABoxRollsOnItsHalfEdge) {
  EXPECT_EQ(only(cartOn(collisionText("<box size=\"0.3 0.1 0.3\"/>")), "l").radii, Vector3d(0.15, 0.05, 0.15));
}

TEST(WheelEllipsoids, TheUnitSphereMeshIsTakenAsItIs) {
  const auto loaded = cartOn(collisionText(
      "<mesh filename=\"package://ellipsoid_vehicle_sim/meshes/unit_sphere.stl\" scale=\"0.35 0.12 0.35\"/>"));
  const auto e = only(loaded, "l");
  EXPECT_EQ(e.radii, Vector3d(0.35, 0.12, 0.35));
  EXPECT_EQ(e.fit_error, 0.0);
  for (const std::string& note : loaded.notes) EXPECT_EQ(note.find("wheel 'l'"), std::string::npos) << note;
}

TEST(WheelEllipsoids, AMeshKeepsItsLargestRadiusAndItsTreadNotItsHub) {
  auto vertices = rims(0.2, 0.05, 36);
  for (const Vector3d& v : rims(0.03, 0.2, 12)) vertices.push_back(v);  // an axle stub, four times as wide
  const auto e = only(cartOn(collisionText("<mesh filename=\"wheel.dae\"/>"), "0 1 0", withVertices(vertices)), "l");
  EXPECT_NEAR((e.radii - Vector3d(0.2, 0.05, 0.2)).norm(), 0.0, kRounding);
}

TEST(WheelEllipsoids, SeveralShapesBecomeOneSpheroidOverTheLargestRadius) {
  const auto e = only(
      cartOn(collisionText("<cylinder radius=\"0.057\" length=\"0.07\"/>", "0 0.04485 0", "1.5707963267948966 0 0") +
             collisionText("<cylinder radius=\"0.0625\" length=\"0.04\"/>", "0 0.04485 0", "1.5707963267948966 0 0") +
             collisionText("<box size=\"0.02 0.3 0.02\"/>")),
      "l");
  EXPECT_NEAR((e.radii - Vector3d(0.0625, 0.035, 0.0625)).norm(), 0.0, kRounding);
  EXPECT_NEAR((e.X_LE.p - Vector3d(0, 0.04485, 0)).norm(), 0.0, kRounding);
}

TEST(WheelEllipsoids, ShapesFixedToTheWheelBelongToIt) {
  const std::string tyre =
      linkText("tyre", collisionText("<cylinder radius=\"0.2\" length=\"0.05\"/>", "0 0 0", "1.5707963267948966 0 0")) +
      jointText("f", "fixed", "rl", "tyre", "0 0 0", "1 0 0");
  const auto loaded = loadText(baseText() + wheelText("rl", "base", "-0.2 0.25 0") + tyre);
  ASSERT_TRUE(isLoaded(loaded));
  EXPECT_EQ(linkOf(*loaded.value, "rl").ellipsoids.at(0).radii.x(), 0.2);
  EXPECT_TRUE(linkOf(*loaded.value, "tyre").ellipsoids.empty());
}

// --- Distances ------------------------------------------------------------------------------------------------------

TEST(DistanceOutside, IsExactWhereItIsKnown) {
  EXPECT_EQ(distanceOutside({0.5, 0, 0}, {1, 2, 3}), 0.0);
  EXPECT_NEAR(distanceOutside({5, 0, 0}, {1, 2, 3}), 4.0, 1e-12);
  EXPECT_NEAR(distanceOutside({0, 0, -5}, {1, 2, 3}), 2.0, 1e-12);
  EXPECT_NEAR(distanceOutside({3, 4, 12}, {2, 2, 2}), 11.0, 1e-12);
}

TEST(DistanceOutside, FindsThePointAPlaneNormalLeadsBackFrom) {
  // From a surface point x outwards along its normal by d, the distance is d.
  for (const Vector3d& radii : {Vector3d(1, 2, 3), Vector3d(0.35, 0.12, 0.35), Vector3d(1, 1e-3, 1)}) {
    for (const Vector3d& direction : {Vector3d(1, 1, 1), Vector3d(-1, 0.2, 3), Vector3d(0, 1, 0.01)}) {
      const Vector3d x = radii.cwiseProduct(direction.normalized());
      const Vector3d n = x.cwiseQuotient(radii.cwiseAbs2()).normalized();
      for (double d : {1e-3, 1.0, 1e3}) EXPECT_NEAR(distanceOutside(x + d * n, radii), d, 1e-9 * (1.0 + d));
    }
  }
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
