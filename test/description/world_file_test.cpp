#include "ellipsoid_vehicle_sim/description/world_file.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/temporary_files.h"
#include "support/test_data.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

class WorldFile : public testing::Test {
 protected:
  WorldFile() {
    files_.write("meshes/tri.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    files_.write("bad.stl", "hello");
  }

  Loaded<WorldDescription> load(const std::string& yaml) { return loadWorld(files_.write("world.yaml", yaml)); }

  WorldDescription loaded(const std::string& yaml) {
    Loaded<WorldDescription> world = load(yaml);
    EXPECT_TRUE(world) << problemText(world.problems);
    return world ? *world.value : WorldDescription();
  }

  std::string problemsOf(const std::string& yaml) {
    const Loaded<WorldDescription> world = load(yaml);
    EXPECT_FALSE(world);
    return files_.withoutFolder(problemText(world.problems));
  }

  TemporaryFiles files_;
};

const std::string kMesh = "meshes:\n  - file: meshes/tri.obj\n";

TEST_F(WorldFile, AMeshFileIsAWorldAsItIs) {
  const Loaded<WorldDescription> world = loadWorld(files_.write("hill.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
  ASSERT_TRUE(world) << problemText(world.problems);
  EXPECT_EQ(world.value->name, "hill");
  EXPECT_EQ(world.value->soup.triangles.size(), 1u);
  ASSERT_EQ(world.value->soup.surfaces.size(), 1u);
  EXPECT_EQ(world.value->soup.surfaces[0].name, "hill");
  EXPECT_FALSE(world.value->soup.surfaces[0].mu_static);
}

TEST_F(WorldFile, ScalesThenTurnsThenMoves) {
  const WorldDescription world =
      loaded(kMesh + "    scale: [2, 3, 4]\n    pose: [10, 20, 30, 0, 0, 1.5707963267948966]\n");
  EXPECT_TRUE(world.soup.vertices[0].isApprox(Vector3d(10, 20, 30), 1e-15));
  EXPECT_TRUE(world.soup.vertices[1].isApprox(Vector3d(10, 22, 30), 1e-15));
  EXPECT_TRUE(world.soup.vertices[2].isApprox(Vector3d(7, 20, 30), 1e-15));
}

TEST_F(WorldFile, AMirrorKeepsTheFrontOutside) {
  const WorldDescription world = loaded(kMesh + "    scale: [-1, 1, 1]\n");
  EXPECT_EQ(world.soup.triangles[0], (std::array<std::uint32_t, 3>{0, 2, 1}));
  EXPECT_EQ(loaded(kMesh + "    scale: [-1, 1, -1]\n").soup.triangles[0], (std::array<std::uint32_t, 3>{0, 1, 2}));
}

TEST_F(WorldFile, SurfacesAreNamedAndCarryTheirFriction) {
  const WorldDescription world = loaded(
      "meshes:\n"
      "  - {file: meshes/tri.obj, mu_static: 0.9, mu_kinetic: 0.8, surface: road}\n"
      "  - {file: meshes/tri.obj}\n"
      "  - {file: meshes/tri.obj, mu_static: 0.9, mu_kinetic: 0.8, surface: road}\n"
      "  - {file: meshes/tri.obj, mu_static: 0.5, surface: ice}\n"
      "start: [1, -2, 0.5]\n");
  ASSERT_EQ(world.soup.surfaces.size(), 3u);
  EXPECT_EQ(world.soup.surface, (std::vector<std::uint16_t>{0, 1, 0, 2}));
  EXPECT_EQ(world.soup.surfaces[0].name, "road");
  EXPECT_EQ(world.soup.surfaces[0].mu_kinetic, 0.8);
  EXPECT_EQ(world.soup.surfaces[1].name, "tri");
  EXPECT_FALSE(world.soup.surfaces[1].mu_static);
  EXPECT_EQ(world.soup.surfaces[2].mu_kinetic, 0.5);
  EXPECT_EQ(world.start.x, 1.0);
  EXPECT_EQ(world.start.y, -2.0);
  EXPECT_EQ(world.start.yaw, 0.5);
  EXPECT_EQ(world.name, "world");
}

TEST_F(WorldFile, PackagesAreFoundByTheResolver) {
  const std::string path = files_.write("world.yaml", "meshes:\n  - file: package://maps/tri.obj\n");
  const std::string mesh = files_.write("elsewhere/tri.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const Loaded<WorldDescription> world = loadWorld(path, [&](const std::string& uri) -> std::optional<std::string> {
    return uri == "package://maps/tri.obj" ? std::make_optional(mesh) : std::nullopt;
  });
  EXPECT_TRUE(world) << problemText(world.problems);
  EXPECT_EQ(files_.withoutFolder(problemText(loadWorld(path, nullptr).problems)),
            "world.yaml:2: 'package://maps/tri.obj' is not found: no such package, or no such file in it\n");
}

TEST_F(WorldFile, TellsEveryProblemAtOnceWithItsLine) {
  EXPECT_EQ(problemsOf("meshes:\n"
                       "  - fiel: meshes/tri.obj\n"
                       "  - file: meshes/tri.obj\n"
                       "    scale: 0\n"
                       "    pose: [0, 0, 0]\n"
                       "    mu_static: -1\n"
                       "  - file: meshes/tri.obj\n"
                       "    scale: [1, 2, .nan]\n"
                       "    pose: [0, 0, .inf, 0, 0, 0]\n"
                       "    mu_static: [1]\n"
                       "    surface: {a: b}\n"
                       "  - 7\n"
                       "  - {file: meshes/tri.obj, file: meshes/tri.obj}\n"
                       "  - {file: meshes/tri.obj, mu_static: 0.5, mu_kinetic: 0.6}\n"
                       "  - {file: meshes/tri.obj, mu_kinetic: 0.6}\n"
                       "start: [0, 0]\n"
                       "strat: [0, 0, 0]\n"),
            "world.yaml:2: unknown key 'fiel'; known are file, scale, pose, mu_static, mu_kinetic, surface\n"
            "world.yaml:2: a mesh without 'file'\n"
            "world.yaml:4: 'scale' is 0; allowed is a size between 1e-6 and 1e6, negative to mirror\n"
            "world.yaml:5: 'pose' is not [x, y, z, roll, pitch, yaw]\n"
            "world.yaml:6: 'mu_static' is -1; allowed is between 0 and 100\n"
            "world.yaml:8: 'scale' is no number: .nan; allowed is a size between 1e-6 and 1e6, negative to mirror\n"
            "world.yaml:9: 'pose' is no number: .inf; allowed is between -1e9 and 1e9\n"
            "world.yaml:10: 'mu_static' is not a number; allowed is between 0 and 100\n"
            "world.yaml:11: 'surface' is not a text\n"
            "world.yaml:12: a mesh is a dictionary with the key file\n"
            "world.yaml:13: 'file' is given twice\n"
            "world.yaml:14: mu_kinetic 0.6 is more than mu_static 0.5; allowed is up to it\n"
            "world.yaml:15: mu_kinetic 0.6 without mu_static; give both or mu_static alone\n"
            "world.yaml:16: 'start' is not [x, y, yaw]\n"
            "world.yaml:17: unknown key 'strat'; known are meshes, start\n");
}

TEST_F(WorldFile, NamesTheMeshesThatCannotBeRead) {
  EXPECT_EQ(
      problemsOf("meshes:\n  - file: gone.stl\n  - file: bad.stl\n"),
      "world.yaml:2: gone.stl: there is no such file\n"
      "world.yaml:3: bad.stl: neither a text STL (those begin with 'solid') nor a binary one: 5 bytes, the header "
      "alone has 84\n");
}

TEST_F(WorldFile, RefusesOneSurfaceWithTwoFrictions) {
  EXPECT_EQ(problemsOf(kMesh + "    mu_static: 0.9\n  - file: meshes/tri.obj\n"),
            "world.yaml:4: surface 'tri' has another friction further up; name it by another 'surface'\n");
}

TEST_F(WorldFile, RefusesWhatIsNoWorld) {
  EXPECT_EQ(problemsOf(""), "world.yaml: is empty, or cannot be read\n");
  EXPECT_EQ(problemsOf("- a\n"), "world.yaml:1: a world is a dictionary with the keys meshes and start\n");
  EXPECT_EQ(problemsOf("start: [0, 0, 0]\n"), "world.yaml:1: no 'meshes': a world is made of at least one\n");
  EXPECT_EQ(problemsOf("meshes: []\n"), "world.yaml:1: 'meshes' is not a list of at least one mesh\n");
  EXPECT_NE(problemsOf("meshes: [\n").find("world.yaml:2: no YAML: "), std::string::npos);
  EXPECT_EQ(problemText(loadWorld("/no/such.yaml").problems), "/no/such.yaml: there is no such file\n");
  EXPECT_EQ(problemText(loadWorld("/no/such.stl").problems), "/no/such.stl: there is no such file\n");
  EXPECT_NE(problemText(loadWorld(files_.folder("a.yaml")).problems).find("is a folder"), std::string::npos);
}

/// A real world with the scale its authors use it at.
Terrain realWorld(const std::string& path, const std::string& scale) {
  const TemporaryFiles files;
  const Loaded<WorldDescription> world =
      loadWorld(files.write("real.yaml", "meshes:\n  - file: " + path + "\n    scale: " + scale + "\n"));
  EXPECT_TRUE(world) << problemText(world.problems);
  Loaded<Terrain> terrain = Terrain::build(world.value->soup);
  EXPECT_TRUE(terrain) << problemText(terrain.problems);
  return std::move(*terrain.value);
}

struct Height {
  double z;
  bool faces_up;
};

void expectHeights(const Terrain& terrain, double x, double y, const std::vector<Height>& expected) {
  const std::vector<HeightHit> hits = terrain.heights(x, y);
  ASSERT_EQ(hits.size(), expected.size()) << "at " << x << " " << y;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    // The reference heights are given to 1e-4 m.
    EXPECT_NEAR(hits[i].z, expected[i].z, 0.6e-4) << "at " << x << " " << y;
    EXPECT_EQ(hits[i].faces_up, expected[i].faces_up) << "at " << x << " " << y;
  }
}

constexpr bool kUp = true, kDown = false;

TEST(RealWorld, ObstacleHasItsReferenceHeights) {
  const auto path = testData("worlds/obstacle/obstacle_world.stl");
  if (!path) return;
  const Terrain terrain = realWorld(*path, "1");
  expectHeights(terrain, 3.11, 2.07, {{0.1525, kUp}, {0.0001, kDown}});
  expectHeights(terrain, 0.05, 4.02, {{2.5909, kUp}, {0.0001, kDown}});
}

TEST(RealWorld, InspectionHasItsReferenceHeights) {
  const auto path = testData("worlds/inspection/inspection_world.dae");
  if (!path) return;
  const Terrain terrain = realWorld(*path, "[2, 2, 1]");
  expectHeights(terrain, 1, 1, {{-0.7594, kUp}});
  expectHeights(terrain, 20, -13, {{0.0235, kUp}});
  expectHeights(terrain, 40, 80, {{6.7106, kDown}, {3.6276, kUp}});
  expectHeights(terrain, -11, 17, {{0.9397, kUp}, {0.7669, kDown}, {0.7523, kUp}, {0.3598, kUp}});
}

TEST(RealWorld, CloverleafHasItsReferenceHeights) {
  const auto path = testData("worlds/cloverleaf/cloverleaf.obj");
  if (!path) return;
  const Terrain terrain = realWorld(*path, "0.0254");
  expectHeights(terrain, 0.5, 0.3, {{5.4863, kUp}, {4.9723, kDown}, {3.2881, kDown}, {0.0, kUp}});
  expectHeights(terrain, 3, 60, {{3.7112, kUp}});
  expectHeights(terrain, 40, 25, {{0.9622, kUp}});
  expectHeights(terrain, -80, 80, {});
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
