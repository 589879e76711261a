#include "ellipsoid_vehicle_sim/world/mesh_file.h"

#include <gtest/gtest.h>

#include <clocale>
#include <cmath>
#include <cstring>
#include <limits>

#include "ellipsoid_vehicle_sim/world/terrain.h"
#include "support/temporary_files.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;
using Corners = std::array<Vector3d, 3>;

class MeshFile : public testing::Test {
 protected:
  Loaded<MeshData> read(const std::string& name, const std::string& text) {
    return readMeshFile(files_.write(name, text));
  }

  std::vector<Corners> triangles(const std::string& name, const std::string& text) {
    const Loaded<MeshData> mesh = read(name, text);
    EXPECT_TRUE(mesh) << problemText(mesh.problems);
    std::vector<Corners> result;
    if (!mesh) return result;
    for (const auto& t : mesh.value->triangles) {
      result.push_back({mesh.value->vertices[t[0]], mesh.value->vertices[t[1]], mesh.value->vertices[t[2]]});
    }
    return result;
  }

  /// The one problem of a bad file, with the folder taken out.
  std::string problemOf(const std::string& name, const std::string& text) {
    const Loaded<MeshData> mesh = read(name, text);
    EXPECT_FALSE(mesh);
    EXPECT_EQ(mesh.problems.size(), 1u) << problemText(mesh.problems);
    return files_.withoutFolder(problemText(mesh.problems));
  }

  TemporaryFiles files_;
};

const Corners kFirst = {Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(0, 1, 0)};
const Corners kSecond = {Vector3d(1, 0, 0), Vector3d(1, 1, 0), Vector3d(0, 1, 0)};

std::string binaryStl(const std::vector<Corners>& facets, std::uint32_t announced, const std::string& header = "") {
  std::string text = header;
  text.resize(80, ' ');
  const auto append = [&text](const auto& value) { text.append(reinterpret_cast<const char*>(&value), sizeof value); };
  append(announced);
  for (const Corners& facet : facets) {
    for (int k = 0; k < 3; ++k) append(0.0f);
    for (const Vector3d& v : facet) {
      for (int k = 0; k < 3; ++k) append(static_cast<float>(v[k]));
    }
    append(std::uint16_t{0});
  }
  return text;
}

const std::string kFacet =
    "facet normal 0 0 1\n outer loop\n vertex 0 0 0\n vertex 1 0 0\n vertex 0 1 0\n endloop\nendfacet\n";

std::string dae(const std::string& unit, const std::string& nodes,
                const std::string& primitives =
                    "<triangles count=\"1\"><input semantic=\"VERTEX\" source=\"#v\" "
                    "offset=\"0\"/><p>0 1 3</p></triangles>",
                const std::string& positions = "0 0 0 1 0 0 1 1 0 0 1 0") {
  return "<?xml version=\"1.0\"?>\n<COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\">\n"
         "<asset>" +
         unit +
         "<up_axis>Y_UP</up_axis></asset>\n<library_geometries><geometry id=\"g\"><mesh>"
         "<source id=\"p\"><float_array id=\"pa\" count=\"12\">" +
         positions +
         "</float_array><technique_common>"
         "<accessor source=\"#pa\" count=\"4\" stride=\"3\"><param name=\"X\" type=\"float\"/><param name=\"Y\" "
         "type=\"float\"/><param name=\"Z\" type=\"float\"/></accessor></technique_common></source>"
         "<vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices>" +
         primitives + "</mesh></geometry></library_geometries>\n<library_visual_scenes><visual_scene id=\"s\">\n" +
         nodes +
         "\n</visual_scene></library_visual_scenes><scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>\n";
}

const std::string kNode = "<node id=\"n\"><instance_geometry url=\"#g\"/></node>";

TEST_F(MeshFile, ReadsABinaryStlInOrderWithItsDegenerateTriangles) {
  const Corners nothing = {Vector3d(0, 0, 0), Vector3d(0, 0, 0), Vector3d(1, 1, 1)};
  EXPECT_EQ(triangles("a.stl", binaryStl({kFirst, nothing, kSecond}, 3)),
            (std::vector<Corners>{kFirst, nothing, kSecond}));
}

TEST_F(MeshFile, ReadsABinaryStlThatBeginsWithSolid) {
  EXPECT_EQ(triangles("a.stl", binaryStl({kFirst, kSecond}, 2, "solid from a CAD program")).size(), 2u);
}

TEST_F(MeshFile, ReadsABinaryStlWithBytesBehindAndSaysSo) {
  for (const std::string header : {"", "solid"}) {
    const Loaded<MeshData> mesh = read("a.STL", binaryStl({kFirst}, 1, header + std::string(1, '\0')) + "1234567");
    ASSERT_TRUE(mesh) << problemText(mesh.problems);
    EXPECT_EQ(mesh.value->triangles.size(), 1u);
    ASSERT_EQ(mesh.notes.size(), 1u);
    EXPECT_NE(mesh.notes[0].find("7 bytes after the last triangle ignored"), std::string::npos);
  }
}

TEST_F(MeshFile, RefusesABinaryStlThatIsCutOff) {
  EXPECT_EQ(
      problemOf("a.stl", binaryStl({kFirst, kSecond}, 3)),
      "a.stl: binary STL announces 3 triangles (234 bytes) but the file has 184 bytes, enough for 2: cut off, or not "
      "an STL file\n");
}

TEST_F(MeshFile, RefusesAnAbsurdAnnouncementWithoutReservingIt) {
  EXPECT_NE(problemOf("a.stl", binaryStl({kFirst}, 0xffffffffu)).find("announces 4294967295 triangles"),
            std::string::npos);
}

TEST_F(MeshFile, ReadsTextStlHoweverItIsWritten) {
  std::string capitals = "SOLID A\n" + kFacet + "ENDSOLID A\n";
  for (char& c : capitals) c = static_cast<char>(std::toupper(c));
  std::string windows = "solid a\n" + kFacet + "endsolid a\n";
  for (std::size_t at = 0; (at = windows.find('\n', at)) != std::string::npos; at += 2) windows.replace(at, 1, "\r\n");
  for (const std::string& text : {"solid a b c\n" + kFacet + "endsolid\n", "\n  solid\n" + kFacet + "endsolid\n",
                                  capitals, windows, "solid facet vertex\n" + kFacet + "endsolid facet\n"}) {
    EXPECT_EQ(triangles("a.stl", text), std::vector<Corners>{kFirst});
  }
  EXPECT_EQ(triangles("a.stl", "solid a\n" + kFacet + "endsolid\nsolid b\n" + kFacet + "endsolid\n").size(), 2u);
}

TEST_F(MeshFile, KeepsAllDigitsOfATextWhateverTheLocale) {
  const char* before = std::setlocale(LC_NUMERIC, nullptr);
  const std::string old = before ? before : "C";
  std::setlocale(LC_NUMERIC, "de_DE.UTF-8");
  const std::vector<Corners> obj = triangles("a.obj", "v 4512345.678 -1.5e-3 .25\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const std::vector<Corners> stl = triangles("a.stl",
                                             "solid\nfacet normal 0 0 1 outer loop vertex 4512345.678 -1.5e-3 .25 "
                                             "vertex 1 0 0 vertex 0 1 0 endloop endfacet\nendsolid\n");
  std::setlocale(LC_NUMERIC, old.c_str());
  ASSERT_EQ(obj.size(), 1u);
  EXPECT_EQ(obj[0][0], Vector3d(4512345.678, -1.5e-3, .25));
  EXPECT_EQ(obj, stl);
}

TEST_F(MeshFile, RefusesABadTextStlByLine) {
  EXPECT_EQ(problemOf("a.stl", "solid a\n" + kFacet + "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0"),
            "a.stl:12: the file ends inside a facet: cut off\n");
  EXPECT_EQ(problemOf("a.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 x 0\n"),
            "a.stl:4: vertex coordinate 'x' is not a number\n");
  EXPECT_EQ(problemOf("a.stl",
                      "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\n"
                      "vertex 0 1 0\nendloop\nendfacet\nendsolid\n"),
            "a.stl:8: facet with 4 corners; allowed is 3\n");
  EXPECT_EQ(problemOf("a.stl", "solid a\n<html>\n"), "a.stl:2: '<html>' is not a word of a text STL\n");
  EXPECT_EQ(
      problemOf("a.stl", "hello\n"),
      "a.stl: neither a text STL (those begin with 'solid') nor a binary one: 6 bytes, the header alone has 84\n");
}

TEST_F(MeshFile, ReadsObjWithAllKindsOfIndicesAndLineEnds) {
  const std::vector<Corners> expected = {kFirst, kSecond};
  EXPECT_EQ(triangles("a.obj",
                      "v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nv\t1 1 0 0.1 0.2 0.3\r\nvt 0 0\r\nvn 0 0 1\r\nusemtl a\r\n"
                      "f 1/1/1 2/1/1 3/1/1\r\nusemtl b\r\nf -3//1 -1//1 -2//1\r\n"),
            expected);
  EXPECT_EQ(triangles("a.obj", "f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n# end"), std::vector<Corners>{kFirst});
  EXPECT_EQ(triangles("a.obj", "v 0 0 0\rv 1 0 0\rv 0 1 \\\r0\rf 1 2 \\\r3"), std::vector<Corners>{kFirst});
}

TEST_F(MeshFile, KeepsTheOrderOfAnObjAcrossMaterialsGroupsAndObjects) {
  const std::vector<Corners> read = triangles("a.obj",
                                              "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nusemtl a\nf 1 2 3\nusemtl b\n"
                                              "f 2 4 3\no x\nusemtl a\nf 2 4 3\ng y\nusemtl b\nf 1 2 3\n");
  EXPECT_EQ(read, (std::vector<Corners>{kFirst, kSecond, kSecond, kFirst}));
}

TEST_F(MeshFile, OnlyNotesWhatAnObjHasBesidesTriangles) {
  const Loaded<MeshData> mesh =
      read("a.obj", "mtllib gone.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\np 1\ncurv 0 1 2\nf 1 2 3\n");
  ASSERT_TRUE(mesh) << problemText(mesh.problems);
  ASSERT_EQ(mesh.notes.size(), 3u);
  EXPECT_EQ(files_.withoutFolder(mesh.notes[0]), "a.obj:1: material file 'gone.mtl' is missing; only colours are lost");
  EXPECT_EQ(files_.withoutFolder(mesh.notes[1]), "a.obj: 2 points and lines ignored");
  EXPECT_EQ(files_.withoutFolder(mesh.notes[2]), "a.obj:7: 'curv' is not known, ignored (1 lines such)");
}

TEST_F(MeshFile, CutsConcavePolygonsInsideAndKeepsTheirArea) {
  // An arrow head: the diagonal from corner 1 would run outside.
  const std::vector<Corners> arrow = triangles("a.obj", "v 0 0 5\nv 2 2 5\nv 0 1 5\nv -2 2 5\nf 1 2 3 4\n");
  double area = 0.0;
  for (const Corners& t : arrow) {
    EXPECT_GT(doubleAreaVector(t).z(), 0.0);
    area += 0.5 * doubleAreaVector(t).z();
  }
  EXPECT_EQ(arrow.size(), 2u);
  EXPECT_DOUBLE_EQ(area, 2.0);
  // A comb of 41 corners standing upright.
  std::string comb, face = "f";
  for (int i = 0; i < 20; ++i) comb += "v 0 " + std::to_string(i) + (i % 2 ? " 1\n" : " 9\n");
  comb += "v 0 19 0\nv 0 0 0\n";
  for (int i = 1; i <= 22; ++i) face += " " + std::to_string(i);
  area = 0.0;
  for (const Corners& t : triangles("a.obj", comb + face + "\n")) {
    EXPECT_LE(doubleAreaVector(t).x(), 0.0);
    area -= 0.5 * doubleAreaVector(t).x();
  }
  EXPECT_DOUBLE_EQ(area, 19.0 * 5.0);
}

TEST_F(MeshFile, RefusesABadObjByLineAndNamesAllOfIt) {
  EXPECT_EQ(problemOf("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 9\n"),
            "a.obj:5: face with vertex 9; allowed are 1 to 3, or negative ones counted back from here\n");
  EXPECT_EQ(problemOf("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n"),
            "a.obj:4: face with vertex -4; allowed are 1 to 3, or negative ones counted back from here\n");
  EXPECT_EQ(problemOf("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n"),
            "a.obj:4: face with vertex 0; allowed are 1 to 3, or negative ones counted back from here\n");
  const Loaded<MeshData> mesh = read("a.obj", "v 0 0 nan\nv 1 zero 0\nv 0 1\nf 1 2\nf 1 2 x\n");
  EXPECT_EQ(files_.withoutFolder(problemText(mesh.problems)),
            "a.obj:1: vertex coordinate 'nan' is not a finite number\n"
            "a.obj:2: vertex coordinate 'zero' is not a finite number\n"
            "a.obj:3: vertex with 2 coordinates; it needs 3\n"
            "a.obj:4: face with 2 corners; it needs 3\n"
            "a.obj:5: face corner 'x' is not a vertex number\n");
}

TEST_F(MeshFile, AppliesTheNodeMatricesOfADaeWithScaleAndRotation) {
  const std::vector<Corners> read =
      triangles("a.dae", dae("",
                             "<node id=\"a\"><scale>2 3 4</scale><node id=\"b\"><rotate>0 0 1 90</rotate>"
                             "<translate>10 0 1</translate><instance_geometry url=\"#g\"/></node></node>"));
  ASSERT_EQ(read.size(), 1u);
  // p -> diag(2, 3, 4) Rz(90 deg) (p + (10, 0, 1)); float matrices, 1e-6 of 30 m.
  EXPECT_TRUE(read[0][0].isApprox(Vector3d(0, 30, 4), 1e-6)) << read[0][0].transpose();
  EXPECT_TRUE(read[0][1].isApprox(Vector3d(0, 33, 4), 1e-6)) << read[0][1].transpose();
  EXPECT_TRUE(read[0][2].isApprox(Vector3d(-2, 30, 4), 1e-6)) << read[0][2].transpose();
}

TEST_F(MeshFile, AppliesTheUnitOfADaeButNotItsUpAxis) {
  const std::vector<Corners> read = triangles("a.dae", dae("<unit name=\"inch\" meter=\"0.0254\"/>", kNode));
  ASSERT_EQ(read.size(), 1u);
  EXPECT_TRUE(read[0][1].isApprox(Vector3d(0.0254, 0, 0), 1e-6)) << read[0][1].transpose();
  EXPECT_TRUE(read[0][2].isApprox(Vector3d(0, 0.0254, 0), 1e-6)) << read[0][2].transpose();
}

TEST_F(MeshFile, KeepsTheFrontOfAMirroredDaeOutside) {
  const std::vector<Corners> read = triangles(
      "a.dae",
      dae("",
          "<node id=\"n\"><matrix>-1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix><instance_geometry url=\"#g\"/></node>"));
  ASSERT_EQ(read.size(), 1u);
  EXPECT_EQ(read[0], (Corners{Vector3d(0, 0, 0), Vector3d(0, 1, 0), Vector3d(-1, 0, 0)}));
}

TEST_F(MeshFile, ReadsPolygonsOfADaeAndNotesItsLines) {
  const std::string input = "<input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/>";
  const Loaded<MeshData> mesh = read("a.dae", dae("", kNode,
                                                  "<polylist count=\"1\">" + input +
                                                      "<vcount>4</vcount><p>0 1 2 3</p></polylist>"
                                                      "<lines count=\"1\">" +
                                                      input + "<p>0 1</p></lines>"));
  ASSERT_TRUE(mesh) << problemText(mesh.problems);
  EXPECT_EQ(mesh.value->triangles.size(), 2u);
  ASSERT_EQ(mesh.notes.size(), 1u);
  EXPECT_EQ(files_.withoutFolder(mesh.notes[0]), "a.dae: 1 points and lines ignored");
}

TEST_F(MeshFile, RefusesABadDae) {
  const std::string input = "<input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/>";
  EXPECT_EQ(problemOf("a.dae", dae("", kNode, "<triangles count=\"1\">" + input + "<p>0 1 9</p></triangles>")),
            "a.dae:4: vertex number 9 of 4\n");
  EXPECT_EQ(problemOf("a.dae", dae("", kNode, "<triangles count=\"1\">" + input + "<p>0 1 -1</p></triangles>")),
            "a.dae:4: '-1' in <p> is not a vertex number\n");
  EXPECT_EQ(problemOf("a.dae", dae("<unit meter=\"0\"/>", kNode)),
            "a.dae:3: unit meter='0'; allowed is a length > 0 in metres\n");
  EXPECT_EQ(problemOf("a.dae", dae("<unit meter=\"abc\"/>", kNode)),
            "a.dae:3: unit meter='abc'; allowed is a length > 0 in metres\n");
  EXPECT_EQ(problemOf("a.dae", dae("", "")), "a.dae: holds no triangles\n");
  EXPECT_EQ(problemOf("a.dae", dae("", "<node id=\"n\"><instance_geometry url=\"#gone\"/></node>")),
            "a.dae:6: <instance_geometry> of 'gone', which is not in the file\n");
  EXPECT_EQ(
      problemOf("a.dae", dae("", "<node id=\"n\"><instance_geometry url=\"#g\"/><instance_node url=\"#n\"/></node>")),
      "a.dae: node 'n' contains itself through <instance_node>\n");
  EXPECT_NE(problemOf("a.dae", dae("", kNode).substr(0, 700)).find("malformed XML"), std::string::npos);
  std::string deep;
  for (int i = 0; i < 501; ++i) deep += "<node>";
  EXPECT_EQ(problemOf("a.dae", dae("", deep)), "a.dae:6: elements nested deeper than 500\n");
}

TEST_F(MeshFile, RefusesADaeThatUnfoldsIntoMillions) {
  std::string nodes = "<node id=\"n0\"><instance_geometry url=\"#g\"/></node>";
  for (int i = 1; i <= 30; ++i) {
    const std::string inner = "<instance_node url=\"#n" + std::to_string(i - 1) + "\"/>";
    nodes += "<node id=\"n" + std::to_string(i) + "\">" + inner + inner + "</node>";
  }
  EXPECT_NE(problemOf("a.dae", dae("", nodes)).find("unfold into more than a million nodes"), std::string::npos);
}

TEST_F(MeshFile, RefusesNotANumberAndInfinityByTriangle) {
  Corners bad = kFirst;
  bad[1].y() = std::nan("");
  EXPECT_EQ(problemOf("a.stl", binaryStl({kFirst, bad}, 2)),
            "a.stl: triangle 1 (counted from 0) has the corner (1, nan, 0); allowed are finite coordinates\n");
  const std::string triangle =
      "<triangles count=\"1\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><p>0 1 3</p></triangles>";
  EXPECT_NE(problemOf("a.dae", dae("", kNode, triangle, "0 0 0 INF 0 0 1 1 0 0 1 0"))
                .find("a.dae: triangle 0 (counted from 0) has the corner (inf"),
            std::string::npos);
}

TEST_F(MeshFile, RefusesWhatIsNoMeshFile) {
  EXPECT_EQ(problemOf("a.stl", ""), "a.stl: is empty (0 bytes)\n");
  EXPECT_EQ(problemOf("a.stl", "version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n"),
            "a.stl: is a git-lfs pointer, not the mesh itself; run 'git lfs pull' in its repository\n");
  EXPECT_EQ(problemOf("a.step", "x"), "a.step: unknown mesh format '.step'; known are .stl, .obj and .dae\n");
  EXPECT_EQ(problemOf("a.obj", "v 0 0 0\n"), "a.obj: holds no triangles\n");
  EXPECT_EQ(problemOf("a.stl", binaryStl({}, 0)), "a.stl: holds no triangles\n");
  EXPECT_EQ(problemText(readMeshFile("/no/such.stl").problems), "/no/such.stl: there is no such file\n");
  EXPECT_EQ(files_.withoutFolder(problemText(readMeshFile(files_.folder("folder.stl")).problems)),
            "folder.stl: is a folder, not a mesh file\n");
}

TEST_F(MeshFile, NotesWhenFloatIsCoarseAtTheseCoordinates) {
  Corners far = kFirst;
  for (Vector3d& v : far) v.x() += 4e6;
  const Loaded<MeshData> mesh = read("a.stl", binaryStl({far}, 1));
  ASSERT_EQ(mesh.notes.size(), 1u);
  EXPECT_NE(mesh.notes[0].find("coordinates up to 4e+06 are read as float, in steps of 0.477"), std::string::npos);
}

TEST_F(MeshFile, NeverThrowsOnAnyCutOrChangedByte) {
  for (const auto& [name, text] :
       std::vector<std::pair<std::string, std::string>>{{"a.stl", binaryStl({kFirst, kSecond}, 2)},
                                                        {"b.stl", "solid a\n" + kFacet + "endsolid a\n"},
                                                        {"a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"},
                                                        {"a.dae", dae("<unit meter=\"1\"/>", kNode)}}) {
    const std::size_t step = text.size() > 500 ? 7 : 1;
    for (std::size_t i = 0; i < text.size(); i += step) {
      EXPECT_NO_THROW(read(name, text.substr(0, i)));
      std::string changed = text;
      changed[i] = static_cast<char>(changed[i] ^ (1 << (i % 8)));
      EXPECT_NO_THROW(read(name, changed));
    }
  }
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
