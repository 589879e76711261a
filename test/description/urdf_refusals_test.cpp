#include <gtest/gtest.h>

#include <string>

#include "urdf_samples.h"

namespace ellipsoid_vehicle_sim {
namespace {

Loaded<VehicleDescription> loadBad(const std::string& name) { return loadUrdfFile(kTestUrdfFolder + name); }

// --- Files that are no URDF -----------------------------------------------------------------------------------------

TEST(UrdfRefusals, NoSuchFileAndAFolder) {
  EXPECT_TRUE(
      refusedWith(loadUrdfFile("/no/such/car.urdf"), {"/no/such/car.urdf", "there is no such file"}));
  EXPECT_TRUE(refusedWith(loadUrdfFile(kTestUrdfFolder), {"is a folder"}));
}

TEST(UrdfRefusals, AnEmptyFileAndOneOfBlanks) {
  EXPECT_TRUE(refusedWith(loadBad("bad_empty.urdf"), {"bad_empty.urdf", "the file is empty"}));
  EXPECT_TRUE(refusedWith(loadUrdfText(" \n\t", "blank.urdf"), {"blank.urdf", "the file is empty"}));
}

TEST(UrdfRefusals, AGitLfsPointerSaysHowToGetTheFile) {
  EXPECT_TRUE(refusedWith(loadBad("bad_git_lfs_pointer.urdf"), {"git-LFS pointer", "git lfs pull"}));
}

TEST(UrdfRefusals, MalformedXmlNamesTheLine) {
  EXPECT_TRUE(refusedWith(loadBad("bad_malformed.urdf"),
                          {"bad_malformed.urdf:15: malformed XML", "mismatched element", "link"}));
  EXPECT_TRUE(refusedWith(loadUrdfText("car", "x.urdf"), {"x.urdf", "malformed XML"}));
  EXPECT_TRUE(refusedWith(loadUrdfText("<robot name=\"a\"", "x.urdf"), {"x.urdf:1", "malformed XML"}));
  EXPECT_TRUE(refusedWith(loadUrdfText(std::string("<robot name=\"a\">\0</robot>", 25), "x.urdf"), {"zero bytes"}));
}

TEST(UrdfRefusals, EndlessNestingIsAMessageAndNoCrash) {
  std::string text;
  for (int i = 0; i < 100000; ++i) text += "<a>";
  EXPECT_TRUE(refusedWith(loadUrdfText(text, "deep.urdf"), {"malformed XML"}));
}

TEST(UrdfRefusals, XacroThatWasNotRun) {
  EXPECT_TRUE(refusedWith(loadBad("bad_xacro_left_over.urdf"),
                          {"bad_xacro_left_over.urdf:3", "xacro was not run", "<xacro:property>", "1 more"}));
  EXPECT_TRUE(refusedWith(loadText(linkText("base", "<inertial><mass value=\"${mass}\"/></inertial>")),
                          {"test.urdf:3", "xacro was not run", "<mass value=\"${mass}\">"}));
  EXPECT_TRUE(
      refusedWith(loadText("<gazebo><p>$(find car)/p.yaml</p></gazebo>" + baseText()), {"test.urdf:2", "$(find car)"}));
}

TEST(UrdfRefusals, AnotherRootElement) {
  EXPECT_TRUE(refusedWith(loadBad("bad_sdf.urdf"), {"bad_sdf.urdf:2", "<sdf>", "SDF file"}));
  EXPECT_TRUE(refusedWith(loadUrdfText("<html/>", "x.urdf"), {"<html>", "allowed is a URDF"}));
}

TEST(UrdfRefusals, NoLinkAndNoName) {
  EXPECT_TRUE(refusedWith(loadText(""), {"there is no <link>"}));
  EXPECT_TRUE(refusedWith(loadUrdfText("<robot>" + baseText() + "</robot>", "x.urdf"), {"x.urdf:1", "no name"}));
  EXPECT_TRUE(refusedWith(loadText("<link/>"), {"test.urdf:2 link", "the link has no name"}));
}

// --- Everything at once ---------------------------------------------------------------------------------------------

TEST(UrdfRefusals, EveryProblemOfAFileIsToldAtOnce) {
  const auto loaded = loadBad("bad_many.urdf");
  EXPECT_TRUE(refusedWith(loaded, {"bad_many.urdf:5 link 'base_link'", "<mass value=\"1,5\"> is no number"}));
  EXPECT_TRUE(refusedWith(loaded, {"bad_many.urdf:10 link 'base_link'", "<box size=\"1 0 1\">", "> 0"}));
  EXPECT_TRUE(
      refusedWith(loaded, {"bad_many.urdf:15 link 'base_link'", "<mesh scale=\"1 1 1 1\">", "4 numbers", "three"}));
  EXPECT_TRUE(refusedWith(loaded, {"bad_many.urdf:20 link 'arm'", "principal moments are -1, 1, 3"}));
  EXPECT_TRUE(refusedWith(loaded, {"bad_many.urdf:30 joint 'shoulder'", "<axis xyz=\"0 0 0\"> has no direction"}));
  EXPECT_TRUE(refusedWith(loaded, {"bad_many.urdf:31 joint 'shoulder'", "lower=1 above upper=-1"}));
  EXPECT_TRUE(refusedWith(loaded, {"bad_many.urdf:33 joint 'lift'", "prismatic joint has no <limit>"}));
  EXPECT_TRUE(refusedWith(loaded, {"bad_many.urdf:37 joint 'lift'", "mimics 'nobody', which does not exist"}));
  EXPECT_TRUE(refusedWith(loaded, {"bad_many.urdf:39 joint 'hover'", "\"floating\" is not simulated"}));
  EXPECT_EQ(loaded.problems.size(), 9u) << problemText(loaded.problems);
}

// --- Masses and inertias --------------------------------------------------------------------------------------------

TEST(UrdfRefusals, ImpossibleMasses) {
  EXPECT_TRUE(refusedWith(loadBad("bad_negative_mass.urdf"),
                          {"bad_negative_mass.urdf:17 link 'front_left_wheel'", "<mass value=\"-1\">", ">= 0"}));
  EXPECT_TRUE(refusedWith(loadBad("bad_nan_mass.urdf"),
                          {"bad_nan_mass.urdf:17", "<mass value=\"nan\"> is no number", "finite"}));
  EXPECT_TRUE(refusedWith(
      loadBad("bad_zero_mass.urdf"),
      {"bad_zero_mass.urdf:15 link 'front_left_wheel'", "moves on joint 'front_left_axle'", "weighs 0 kg", "> 0 kg"}));
}

TEST(UrdfRefusals, AWheelWithoutInertialWeighsNothing) {
  const std::string wheel = linkText("w", collisionText("<sphere radius=\"0.1\"/>")) +
                            jointText("w_axle", "continuous", "base", "w", "0 0.3 0", "0 1 0");
  EXPECT_TRUE(refusedWith(loadText(baseText() + wheel), {"link 'w'", "weighs 0 kg"}));
}

TEST(UrdfRefusals, AVehicleWithoutMass) {
  EXPECT_TRUE(refusedWith(loadText(linkText("base", collisionText("<sphere radius=\"0.1\"/>"))),
                          {"test.urdf:2 link 'base'", "weigh 0 kg"}));
}

TEST(UrdfRefusals, AnInertiaNoBodyCanHave) {
  EXPECT_TRUE(refusedWith(loadBad("bad_impossible_inertia.urdf"),
                          {"bad_impossible_inertia.urdf:16 link 'front_left_wheel'", "0.003, 0.003, 0.009", "0.006"}));
}

TEST(UrdfRefusals, AnIncompleteInertial) {
  const auto with = [](const std::string& inertial) {
    return loadText(linkText("base", "<inertial>" + inertial + "</inertial>"));
  };
  EXPECT_TRUE(refusedWith(with("<mass value=\"1\"/>"), {"<inertial> has no <inertia>"}));
  EXPECT_TRUE(refusedWith(with("<mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\"/>"),
                          {"<inertia> has no izz"}));
  EXPECT_TRUE(refusedWith(loadText(linkText("base", inertialText() + inertialText())), {"a second <inertial>"}));
}

// --- Shapes ---------------------------------------------------------------------------------------------------------

TEST(UrdfRefusals, ShapesOfNoSize) {
  EXPECT_TRUE(refusedWith(loadBad("bad_negative_radius.urdf"), {"bad_negative_radius.urdf:23 link 'front_left_wheel'",
                                                                "<cylinder radius=\"-0.1\">", "> 0"}));
  EXPECT_TRUE(refusedWith(loadBad("bad_infinite_radius.urdf"), {"<cylinder radius=\"inf\"> is no number"}));
  for (const char* shape : {"<sphere radius=\"0\"/>", "<cylinder radius=\"1\" length=\"0\"/>", "<box size=\"1 -1 1\"/>",
                            "<mesh filename=\"a.stl\" scale=\"1 0 1\"/>", "<mesh filename=\"a.stl\" scale=\"1 -1 1\"/>",
                            "<mesh filename=\"a.stl\" scale=\"1 inf 1\"/>"}) {
    EXPECT_TRUE(refusedWith(loadText(linkText("base", inertialText() + collisionText(shape))), {"link 'base'", "> 0"}))
        << shape;
  }
}

TEST(UrdfRefusals, ShapesThatAreIncomplete) {
  const auto with = [](const std::string& inside) { return loadText(linkText("base", inertialText() + inside)); };
  EXPECT_TRUE(refusedWith(with(collisionText("<sphere/>")), {"<sphere> has no radius"}));
  EXPECT_TRUE(refusedWith(with(collisionText("<box size=\"1 2\"/>")), {"holds 2 numbers", "three"}));
  EXPECT_TRUE(refusedWith(with(collisionText("<mesh filename=\"\"/>")), {"<mesh> has no filename"}));
  EXPECT_TRUE(refusedWith(with(collisionText("")), {"<geometry> is empty"}));
  EXPECT_TRUE(refusedWith(with("<collision/>"), {"<collision> has no <geometry>"}));
  EXPECT_TRUE(refusedWith(with(collisionText("<sphere radius=\"1\"/>", "0 0")), {"<origin xyz=\"0 0\">", "2 numbers"}));
}

TEST(UrdfRefusals, WhatUrdfdomDropsWithoutAWord) {
  EXPECT_TRUE(refusedWith(
      loadBad("bad_dropped_shape.urdf"),
      {"bad_dropped_shape.urdf:16 link 'base_link'", "unknown shape <capsule>", "box, cylinder, sphere, mesh"}));
  EXPECT_TRUE(refusedWith(
      loadText(linkText("base", inertialText() + collisionText("<sphere radius=\"1\"/><sphere radius=\"2\"/>"))),
      {"a second shape <sphere>", "allowed is one"}));
}

TEST(UrdfRefusals, ADifferenceToUrdfdomQuotesItsReason) {
  const auto loaded = loadBad("bad_dropped_visual.urdf");
  EXPECT_TRUE(refusedWith(loaded, {"bad_dropped_visual.urdf:3 link 'base_link'", "keeps 0 of 2 <visual>",
                                   "Visual material must contain a name"}));
  EXPECT_TRUE(refusedWith(loaded, {"keeps 0 of 1 <collision>"}));
}

TEST(UrdfRefusals, WhatUrdfdomRefusesAsAWhole) {
  const std::string incomplete = baseText() +
                                 linkText("w", inertialText() + collisionText("<sphere radius=\"0.1\"/>")) +
                                 jointText("j", "continuous", "base", "w", "0 0 0", "0 1 0", "<safety_controller/>");
  EXPECT_TRUE(refusedWith(loadText(incomplete), {"test.urdf: urdfdom", "refuses this file", "no k_velocity"}));
  const std::string red = "<material name=\"red\"><color rgba=\"1 0 0 1\"/></material>\n";
  EXPECT_TRUE(refusedWith(loadText(red + red + baseText()), {"test.urdf:3 material 'red'", "defined twice"}));
}

TEST(UrdfRefusals, UrdfdomsChatterDoesNotReachTheConsole) {
  testing::internal::CaptureStderr();
  loadBad("bad_dropped_visual.urdf");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(UrdfRefusals, CollisionMeshesThatCannotBeUsed) {
  EXPECT_TRUE(refusedWith(
      loadBad("bad_mesh_missing.urdf"),
      {"bad_mesh_missing.urdf:11 link 'base_link'", "cart_description/meshes/not_there.stl", "was not found"}));
  EXPECT_TRUE(refusedWith(loadBad("bad_mesh_empty.urdf"), {"bad_mesh_empty.urdf:11", "empty.stl", "is empty"}));
  EXPECT_TRUE(refusedWith(loadBad("bad_mesh_git_lfs.urdf"), {"bad_mesh_git_lfs.urdf:11", "git lfs pull"}));
  EXPECT_TRUE(refusedWith(loadBad("bad_mesh_nan.urdf"), {"bad_mesh_nan.urdf:11", "nan.stl", "finite"}));
}

TEST(UrdfRefusals, AMeshReaderThatThrowsOrLies) {
  UrdfOptions options;
  const std::string link = linkText("base", inertialText() + collisionText("<mesh filename=\"m.stl\"/>"));
  const UriResolver everything = [](const std::string& uri) { return std::optional<std::string>(uri); };
  options.read_mesh = [](const std::string&) -> Loaded<std::vector<Eigen::Vector3d>> {
    throw std::runtime_error("out of ink");
  };
  EXPECT_TRUE(refusedWith(loadUrdfText(robotText(link), "x.urdf", everything, options), {"x.urdf", "out of ink"}));
  options.read_mesh = [](const std::string&) {
    return Loaded<std::vector<Eigen::Vector3d>>{std::vector<Eigen::Vector3d>{{0, 0, std::nan("")}}, {}, {}};
  };
  EXPECT_TRUE(refusedWith(loadUrdfText(robotText(link), "x.urdf", everything, options), {"not finite"}));
  options.read_mesh = [](const std::string&) {
    return Loaded<std::vector<Eigen::Vector3d>>{std::vector<Eigen::Vector3d>{}, {}, {}};
  };
  EXPECT_TRUE(refusedWith(loadUrdfText(robotText(link), "x.urdf", everything, options), {"holds no triangles"}));
}

// --- Joints and the tree --------------------------------------------------------------------------------------------

TEST(UrdfRefusals, JointsThatAreNotSimulatedOrUnknown) {
  const std::string other = linkText("other", "");
  EXPECT_TRUE(refusedWith(loadText(baseText() + other + jointText("j", "planar", "base", "other", "0 0 0", "0 0 1")),
                          {"joint 'j'", "\"planar\" is not simulated"}));
  EXPECT_TRUE(refusedWith(loadText(baseText() + other + jointText("j", "hinge", "base", "other", "0 0 0", "0 0 1")),
                          {"joint 'j'", "unknown joint type \"hinge\"", "fixed, continuous, revolute, prismatic"}));
}

TEST(UrdfRefusals, LimitsThatAreNone) {
  const auto with = [](const std::string& limit) {
    return loadText(baseText() + linkText("arm", inertialText()) +
                    jointText("j", "revolute", "base", "arm", "0 0 0", "0 1 0", limit));
  };
  EXPECT_TRUE(refusedWith(with(""), {"joint 'j'", "revolute joint has no <limit>"}));
  EXPECT_TRUE(refusedWith(with("<limit lower=\"-1\" upper=\"1\" velocity=\"1\"/>"), {"<limit> has no effort"}));
  EXPECT_TRUE(refusedWith(with("<limit lower=\"-1\" upper=\"1\" effort=\"-5\" velocity=\"1\"/>"),
                          {"<limit effort=\"-5\">", ">= 0"}));
  EXPECT_TRUE(
      refusedWith(with("<limit lower=\"0.5\" effort=\"5\" velocity=\"1\"/>"), {"lower=0.5", "other is 0 by default"}));
  EXPECT_TRUE(
      refusedWith(with("<limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/><dynamics damping=\"-1\"/>"),
                  {"<dynamics damping=\"-1\">", ">= 0"}));
}

TEST(UrdfRefusals, NamesGivenTwice) {
  EXPECT_TRUE(refusedWith(loadText(baseText() + baseText()), {"link 'base'", "taken by the link in line 2"}));
  const std::string joint = jointText("j", "fixed", "base", "a", "0 0 0", "1 0 0");
  EXPECT_TRUE(refusedWith(loadText(baseText() + linkText("a", "") + joint + joint), {"joint 'j'", "name is taken"}));
}

TEST(UrdfRefusals, LinksThatMakeNoTree) {
  const std::string a = linkText("a", ""), b = linkText("b", "");
  const auto fixed = [](const std::string& parent, const std::string& child) {
    return jointText(parent + "_" + child, "fixed", parent, child, "0 0 0", "1 0 0");
  };
  EXPECT_TRUE(refusedWith(loadText(baseText() + fixed("base", "ghost")), {"child link 'ghost' does not exist"}));
  EXPECT_TRUE(refusedWith(loadText(baseText() + fixed("ghost", "base")), {"parent link 'ghost' does not exist"}));
  EXPECT_TRUE(refusedWith(loadText(baseText() + a), {"'base', 'a' hang on nothing", "one root"}));
  EXPECT_TRUE(refusedWith(loadText(a + b + fixed("a", "b") + fixed("b", "a")), {"joined in a loop"}));
  EXPECT_TRUE(refusedWith(loadText(baseText() + a + fixed("a", "a")), {"'a'", "joined in a loop"}));
  EXPECT_TRUE(refusedWith(loadText(baseText() + a + b + fixed("base", "a") + fixed("base", "b") + fixed("a", "b")),
                          {"joint 'a_b'", "link 'b' already hangs on joint 'base_b'"}));
}

TEST(UrdfRefusals, MimicsInACircle) {
  const std::string limit = "<limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/>";
  const auto arm = [&limit](const std::string& name, const std::string& other) {
    return linkText(name, inertialText()) + jointText(name + "_j", "revolute", "base", name, "0 0 0", "0 1 0",
                                                      limit + "<mimic joint=\"" + other + "_j\"/>");
  };
  EXPECT_TRUE(
      refusedWith(loadText(baseText() + arm("a", "b") + arm("b", "a")), {"joint 'a_j'", "in the end mimics it"}));
  EXPECT_TRUE(refusedWith(loadText(baseText() + arm("a", "a")), {"joint 'a_j'", "in the end mimics it"}));
}

TEST(UrdfRefusals, AnAttributeGivenTwice) {
  EXPECT_TRUE(
      refusedWith(loadText(linkText("base", inertialText() + "<collision><geometry><sphere radius=\"1\" radius=\"2\"/>"
                                                             "</geometry></collision>")),
                  {"test.urdf:4: malformed XML: parsing attribute", "sphere"}));
}

// --- The vehicle as a whole -----------------------------------------------------------------------------------------

TEST(UrdfRefusals, JointsButNoGroundWheel) {
  EXPECT_TRUE(refusedWith(loadBad("bad_no_wheel.urdf"), {"no ground wheel", "joint 'turning_axle'", "about z"}));
}

TEST(UrdfRefusals, NothingThatCollides) {
  EXPECT_TRUE(refusedWith(loadText(linkText("base", inertialText())), {"no link has a <collision>"}));
}

TEST(UrdfRefusals, OptionsThatNameNoJointOrTheWrongOne) {
  UrdfOptions options;
  options.roles = {{"fl_axel", JointRole::kDrive}, {"rl_axle", JointRole::kSuspension}};
  options.drive_joints = {"nobody"};
  EXPECT_TRUE(refusedWith(loadText(baseText() + rearAxleText(), options),
                          {"parameter roles", "no joint 'fl_axel'", "'rl_axle', 'rr_axle'"}));
  EXPECT_TRUE(refusedWith(loadText(baseText() + rearAxleText(), options), {"parameter drive_joints", "'nobody'"}));
  options = {};
  options.roles = {{"mast", JointRole::kSteer}};
  const std::string mast =
      linkText("m", inertialText()) + jointText("mast", "prismatic", "base", "m", "0 0 0", "0 0 1",
                                                "<limit lower=\"0\" upper=\"1\" effort=\"1\" velocity=\"1\"/>");
  EXPECT_TRUE(
      refusedWith(loadText(baseText() + rearAxleText() + mast, options), {"prismatic joint cannot be 'steer'"}));
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
