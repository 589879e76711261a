// Input made to take up time or memory: each ends in a message within seconds and in bounded memory.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstring>
#include <filesystem>

#include "ellipsoid_vehicle_sim/description/parameter_file.h"
#include "ellipsoid_vehicle_sim/description/urdf_loader.h"
#include "ellipsoid_vehicle_sim/description/world_file.h"
#include "ellipsoid_vehicle_sim/scene/scene.h"
#include "ellipsoid_vehicle_sim/world/mesh_file.h"
#include "support/bounded_child.h"
#include "support/meshes.h"
#include "support/temporary_files.h"

namespace ellipsoid_vehicle_sim {
namespace {

namespace fs = std::filesystem;

constexpr double kLongest = 20.0;      // [s]
constexpr double kMostMemory = 500.0;  // [MiB]

std::string repeated(const std::string& text, int times) {
  std::string result;
  result.reserve(text.size() * static_cast<std::size_t>(times));
  for (int i = 0; i < times; ++i) result += text;
  return result;
}

class ResourceBombs : public testing::Test {
 protected:
  /// What is said of a file by the loader of its kind: .urdf and .xacro, .stl, .obj and .dae, and by its name world*.yaml,
  /// scene*.yaml or any other .yaml for parameters.
  static std::string load(const std::string& path) {
    const std::string extension = fs::path(path).extension(), name = fs::path(path).filename();
    if (extension == ".urdf" || extension == ".xacro") {
      const Loaded<VehicleDescription> vehicle = loadUrdfFile(path);
      if (!vehicle) return problemText(vehicle.problems);
      Loaded<Terrain> ground = Terrain::build(flatSoup(4, 10.0));
      const Loaded<Simulator> simulator =
          Simulator::create(*vehicle.value, std::make_shared<const Terrain>(std::move(*ground.value)), SimConfig{});
      return simulator ? "loaded" : problemText(simulator.problems);
    }
    if (extension == ".yaml" && name.rfind("scene", 0) == 0) {
      const Loaded<Scene> scene = loadScene(path, PACKAGE_DIR);
      return scene ? said(loadSceneFiles(*scene.value, PACKAGE_DIR)) : problemText(scene.problems);
    }
    if (extension == ".yaml" && name.rfind("world", 0) != 0) return said(readParameterFile(path));
    Loaded<WorldDescription> world = loadWorld(path);
    return world ? said(Terrain::build(std::move(world.value->soup))) : problemText(world.problems);
  }

  template <typename T>
  static std::string said(const Loaded<T>& loaded) {
    return loaded ? "loaded" : problemText(loaded.problems);
  }

  /// The file is refused with these words, in time and in memory; with "loaded" it may also be fine.
  void expectMessage(const std::string& path, const std::string& words, bool may_load = false,
                     double most_memory = kMostMemory) {
    const ChildReport report = inChild([&] { return load(path); }, kLongest);
    EXPECT_TRUE(report.ended) << path << " ended without a message after " << report.seconds << " s";
    EXPECT_LT(report.peak_memory, memoryFactor() * most_memory) << path;
    if (may_load && report.text == "loaded") return;
    EXPECT_NE(report.text.find(words), std::string::npos) << path << " says: " << report.text.substr(0, 500);
    EXPECT_LT(report.text.size(), 100000u) << path << " says too much";
    RecordProperty(fs::path(path).filename(), std::to_string(report.seconds));
  }

  void expectRefusal(const std::string& name, const std::string& text, const std::string& words) {
    expectMessage(files_.write(name, text), words);
  }

  TemporaryFiles files_;
};

TEST_F(ResourceBombs, MoreTrianglesAnnouncedThanThereAre) {
  std::string stl(80, ' ');
  for (const std::uint32_t announced : {1000000000u, 0xffffffffu}) {
    std::string text = stl;
    text.append(reinterpret_cast<const char*>(&announced), sizeof announced);
    expectRefusal("a.stl", text + std::string(500, '\1'), "announces " + std::to_string(announced) + " triangles");
  }
  const auto dae = [](const std::string& array, const std::string& accessor, const std::string& primitive) {
    return "<COLLADA><library_geometries><geometry id=\"g\"><mesh><source id=\"p\"><float_array id=\"a\" " + array +
           "</float_array><technique_common><accessor source=\"#a\" " + accessor + "/></technique_common></source>"
           "<vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices>" + primitive +
           "</mesh></geometry></library_geometries><library_visual_scenes><visual_scene id=\"s\"><node><instance_geometry url=\"#g\"/>"
           "</node></visual_scene></library_visual_scenes><scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>";
  };
  const std::string array = "count=\"9\">0 0 0 1 0 0 0 1 0", accessor = "count=\"3\" stride=\"3\"";
  const std::string input = "<input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/>";
  const std::string triangle = "<triangles count=\"1\">" + input + "<p>0 1 2</p></triangles>";
  EXPECT_EQ(load(files_.write("good.dae", dae(array, accessor, triangle))), "loaded");
  expectRefusal("a.dae", dae("count=\"4000000000\">0 0 0", accessor, triangle), "count='4000000000'> holds 3 numbers");
  expectRefusal("a.dae", dae(array, "count=\"4000000000\" stride=\"3\"", triangle), "<accessor> reaches beyond the 9 numbers");
  expectRefusal("a.dae", dae(array, "count=\"2\" stride=\"4000000000\"", triangle), "<accessor> reaches beyond the 9 numbers");
  expectRefusal("a.dae", dae(array, "count=\"3\" offset=\"4000000000\"", triangle), "<accessor> reaches beyond the 9 numbers");
  expectRefusal("a.dae", dae(array, "count=\"3\" stride=\"0\"", triangle), "<accessor> reaches beyond the 9 numbers");
  expectRefusal("a.dae", dae(array, accessor, "<triangles count=\"4000000000\">" + input + "<p>0 1 2</p></triangles>"),
                "count='4000000000'> has 3 corners");
  expectRefusal("a.dae", dae(array, accessor, "<polylist count=\"1\">" + input + "<vcount>4000000000</vcount><p>0 1 2</p></polylist>"),
                "<vcount> asks for more corners");
  expectRefusal("a.dae", dae(array, accessor, "<triangles count=\"1\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"4000000000\"/>"
                             "<p>0 1 2</p></triangles>"), "<input offset='4000000000'>; allowed are 0 to 63");
  std::string doubled = "<node id=\"n0\"><instance_geometry url=\"#g\"/></node>";
  const std::string many = "<triangles count=\"20000\">" + input + "<p>" + repeated("0 1 2 ", 20000) + "</p></triangles>";
  for (int i = 1; i < 19; ++i) {
    const std::string before = "<instance_node url=\"#n" + std::to_string(i - 1) + "\"/>";
    doubled += "<node id=\"n" + std::to_string(i) + "\">" + before + before + "</node>";
  }
  std::string unfolding = dae(array, accessor, many);
  const std::string node = "<node><instance_geometry url=\"#g\"/></node>";
  unfolding.replace(unfolding.find(node), node.size(), doubled);
  expectMessage(files_.write("unfolding.dae", unfolding), "the scene unfolds into more than", false, 1500.0);
  expectRefusal("a.obj", "v 0 0 0\nf 1 2 4000000000\n", "face with vertex 4000000000");
}

TEST_F(ResourceBombs, SparseFilesOfATerabyte) {
  for (const char* name : {"a.stl", "a.obj", "a.dae", "a.urdf", "world.yaml", "scene.yaml", "parameters.yaml"}) {
    const std::string path = files_.write(name, "");
    fs::resize_file(path, std::uintmax_t{1} << 40);
    expectMessage(path, "has 1099511627776 bytes; allowed");
    fs::resize_file(path, std::uintmax_t{1} << 30);
    expectMessage(path, "");
  }
}

TEST_F(ResourceBombs, DeepNesting) {
  constexpr int kLevels = 100000;
  for (const char* element : {"a", "link", "node", "extra", "mesh", "source"}) {
    const std::string open = "<" + std::string(element) + ">", close = "</" + std::string(element) + ">";
    const std::string nested = repeated(open, kLevels) + repeated(close, kLevels);
    expectRefusal("a.urdf", "<robot name=\"r\">" + nested + "</robot>", "depth exceeded");
    for (const char* around : {"library_geometries", "library_visual_scenes", "library_effects", "asset"})
      expectRefusal("a.dae", "<COLLADA><" + std::string(around) + ">" + nested + "</" + around + "></COLLADA>", "nested deeper than");
  }
  std::string chain = "<node id=\"n0\"/>";
  for (int i = 1; i < kLevels; ++i)
    chain += "<node id=\"n" + std::to_string(i) + "\"><instance_node url=\"#n" + std::to_string(i - 1) + "\"/></node>";
  expectRefusal("chain.dae", "<COLLADA><library_nodes>" + chain + "</library_nodes><scene><instance_visual_scene url=\"#n" +
                std::to_string(kLevels - 1) + "\"/></scene></COLLADA>", "unfolds into more than 500 levels");

  for (const char* name : {"world.yaml", "scene.yaml", "parameters.yaml"}) {
    for (const char* open : {"[", "{a: ", "- ", "? ", "{? ", "[[{", "- - ? ", "a: [", "[\n", "{\n"}) {
      for (const char* key : {"", "meshes: "}) expectRefusal(name, key + repeated(open, kLevels), ".yaml:");
    }
    std::string stairs;
    for (int i = 0; i < 2000; ++i) stairs += std::string(static_cast<std::size_t>(i), ' ') + "a:\n";
    expectRefusal(name, stairs, "is nested deeper than 100 levels");
  }
  // A backslash at the end joins lines: no level deeper each.
  expectRefusal("a.obj", "v 0 0 0\nf 1 1 1" + repeated(" \\\n", kLevels) + " x\n", "face corner 'x'");
}

TEST_F(ResourceBombs, ExpandingEntitiesAndAliases) {
  std::string entities = "<!ENTITY a0 \"lol\">";
  for (int i = 1; i < 20; ++i)
    entities += "<!ENTITY a" + std::to_string(i) + " \"" + repeated("&a" + std::to_string(i - 1) + ";", 10) + "\">";
  const std::string doctype = "<?xml version=\"1.0\"?>\n<!DOCTYPE robot [" + entities + "]>\n";
  expectRefusal("a.urdf", doctype + "<robot name=\"&a19;\"><link name=\"&a19;\"/></robot>", "<!ENTITY>");
  expectRefusal("b.urdf", "<?xml version=\"1.0\"?>\n<!DOCTYPE robot [<!ENTITY x SYSTEM \"file:///dev/zero\">]>\n<robot name=\"&x;\"/>",
                "<!ENTITY>");
  expectRefusal("a.dae", doctype + "<COLLADA>&a19;</COLLADA>", "a document type definition");

  std::string aliases = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 30; ++i) {
    const std::string before = "*a" + std::to_string(i - 1);
    aliases += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [" + before + repeated(", " + before, 9) + "]\n";
  }
  for (const char* name : {"world.yaml", "scene.yaml", "parameters.yaml"}) {
    expectRefusal(name, aliases, ".yaml:2");
    expectRefusal(name, aliases + "meshes: *a29\nvehicle: *a29\nstart: *a29\ncommands: *a29\nmeasure: *a29\n", ".yaml:");
    expectRefusal(name, "&a [*a, *a]", ".yaml");
    expectRefusal(name, "meshes: &a {file: *a, meshes: *a}\ncommands: *a\n", ".yaml:");
  }
}

TEST_F(ResourceBombs, ProblemsWithoutEnd) {
  std::string keys;
  for (int i = 0; i < 50000; ++i) keys += "k" + std::to_string(i) + ": 1\n";
  for (const char* name : {"world.yaml", "scene.yaml"}) {
    expectRefusal(name, keys, "and more problems");
    expectRefusal(name, "? " + repeated("k", 1000000) + "\n: 1\n", "unknown key 'kkk");
  }
}

TEST_F(ResourceBombs, WhatIsNoFile) {
  for (const char* name : {"a.stl", "a.obj", "a.dae", "a.urdf", "a.urdf.xacro", "world.yaml", "scene.yaml", "parameters.yaml"}) {
    const std::string path = files_.folder("links") + "/" + name;
    const auto link = [&path](const char* to) {
      fs::remove(path);
      fs::create_symlink(to, path);
    };
    link("/dev/zero");
    expectMessage(path, "is a device, not a");
    link("/tmp");
    expectMessage(path, "is a folder, not a");
    link(name);
    expectMessage(path, "cannot be opened");
    fs::remove(path);
    ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
    expectMessage(path, "is a pipe, not a");
    fs::remove(path);
    expectMessage(path, "there is no such file");
  }
}

TEST_F(ResourceBombs, FilesThatNameThemselves) {
  expectRefusal("world.yaml", "meshes:\n  - file: world.yaml\n", "unknown mesh format '.yaml'");
  expectRefusal("scene.yaml", "vehicle: scene.yaml\nworld: scene.yaml\nduration: 1\n", ".yaml");
  // A program that stands for xacro, whatever it does: writes for ever, complains for ever.
  const std::string folder = files_.folder("bin");
  const std::string path = getenv("PATH");
  setenv("PATH", (folder + ":" + path).c_str(), 1);
  const std::string car = files_.write("a.urdf.xacro", "<robot/>");
  for (const auto& [body, words] : {std::pair{"yes '<a>'", "xacro writes more than"},
                                    {"head -c 200000000 /dev/zero | tr '\\0' e >&2; exit 1", "xacro cannot expand it; it says: eeee"},
                                    {"exec \"$0\" x", "xacro took longer"},
                                    {"kill -SEGV $$", "xacro cannot expand it"}}) {
    const std::string program = files_.write("bin/xacro", std::string("#!/bin/sh\n") + body + "\n");
    chmod(program.c_str(), 0755);
    if (std::strstr(body, "exec") != nullptr) continue;  // its patience is longer than a test's
    expectMessage(car, words);
  }
  setenv("PATH", path.c_str(), 1);
}

TEST_F(ResourceBombs, AbsurdScalesAndCoordinates) {
  const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  files_.write("a.obj", triangle);
  for (const char* scale : {"1e308", "-1e308", "0", "1e400", ".nan", ".inf", "[1, 0, 1]", "[1, 1]", "1e-300", "yes"})
    expectRefusal("world.yaml", "meshes:\n  - file: a.obj\n    scale: " + std::string(scale) + "\n", "world.yaml:3: 'scale' is");
  for (const char* place : {"1e308", "1e10", ".nan"})
    expectRefusal("world.yaml", "meshes:\n  - file: a.obj\n    pose: [0, 0, " + std::string(place) + ", 0, 0, 0]\n", "'pose' is");
  for (const char* far : {"1e308", "-1e308", "1e400", "nan"}) {
    const std::string text(far);
    expectRefusal("b.obj", "v 0 0 0\nv " + text + " 0 0\nv 0 1 0\nf 1 2 3\n", "");
    expectRefusal("b.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex " + text + " 0 0\nvertex 0 1 0\nendloop\n"
                  "endfacet\nendsolid a\n", "allowed are finite coordinates");
  }
  // Collision meshes of a vehicle, and its own numbers.
  const auto robot = [](const std::string& geometry) {
    return "<robot name=\"r\"><link name=\"a\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" "
           "iyz=\"0\" izz=\"1\"/></inertial><collision><geometry>" + geometry + "</geometry></collision></link></robot>";
  };
  for (const char* scale : {"1e308 1 1", "0 1 1", "-1 1 1", "nan 1 1", "1e400 1 1", "1 1", "1e-200 1e-200 1e-200"})
    expectRefusal("a.urdf", robot("<mesh filename=\"a.obj\" scale=\"" + std::string(scale) + "\"/>"), "a.urdf:1 link 'a'");
  for (const char* size : {"1e308", "0", "-1", "nan", "inf", "1e400", "1e-300"}) {
    expectRefusal("a.urdf", robot("<sphere radius=\"" + std::string(size) + "\"/>"), "a.urdf:1 link 'a'");
    expectRefusal("a.urdf", robot("<box size=\"1 1 " + std::string(size) + "\"/>"), "a.urdf:1 link 'a'");
  }
  files_.write("far.obj", "v 1e308 -1e308 0\nv 1e308 1 1\nv 0 1 1e308\nf 1 2 3\n");
  expectRefusal("a.urdf", robot("<mesh filename=\"far.obj\"/>"), "far.obj");
}

TEST_F(ResourceBombs, PolygonsThatTakeLongToCut) {
  // Combs: concave at every second corner.
  std::string text, face;
  for (int i = 0; i < 500; ++i) text += "v " + std::to_string(i) + " " + (i % 2 ? "1" : "9") + " 0\n";
  text += "v 499 0 0\nv 0 0 0\n";
  for (int i = 1; i <= 502; ++i) face += " " + std::to_string(i);
  expectMessage(files_.write("combs.obj", text + repeated("f" + face + "\n", 2000)), "", true);
  expectMessage(files_.write("one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf" + repeated(" 1 2 3", 500000) + "\n"), "", true);
}

TEST_F(ResourceBombs, VehiclesOfTooManyParts) {
  const std::string inertial =
      "<inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial>";
  const auto robot = [&](int count, bool chain, const std::string& type) {
    std::string text = "<robot name=\"r\"><link name=\"l0\">" + inertial + "</link>\n";
    for (int i = 1; i <= count; ++i) {
      const std::string name = std::to_string(i);
      text += "<link name=\"l" + name + "\">" + inertial + "<collision><geometry><sphere radius=\"0.1\"/></geometry></collision></link>"
              "<joint name=\"j" + name + "\" type=\"" + type + "\"><parent link=\"l" + std::to_string(chain ? i - 1 : 0) +
              "\"/><child link=\"l" + name + "\"/><axis xyz=\"0 1 0\"/></joint>\n";
    }
    return text + "</robot>";
  };
  for (const bool chain : {false, true}) {
    expectRefusal("wheels.urdf", robot(20000, chain, "continuous"), "20001 links; allowed are up to");
    expectRefusal("fixed.urdf", robot(20000, chain, "fixed"), "20001 links; allowed are up to");
    expectRefusal("joints.urdf", robot(900, chain, "continuous"), "900 joints that move; allowed are up to");
    expectMessage(files_.write("many.urdf", robot(900, chain, "fixed")), "", true);
    expectMessage(files_.write("most.urdf", robot(100, chain, "continuous")), "", true);
  }
  expectRefusal("shapes.urdf", "<robot name=\"r\"><link name=\"l\">" + inertial +
                repeated("<collision><geometry><sphere radius=\"0.1\"/></geometry></collision>\n", 50000) + "</link></robot>",
                "50000 collision shapes; allowed are up to");
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
