#include "ellipsoid_vehicle_sim/sensors/lidar_mount.h"

#include <gtest/gtest.h>

namespace ellipsoid_vehicle_sim {
namespace {

/// Text of all problems that the lidars of these names have with these values.
std::string problemsOf(const std::vector<std::string>& names, ParameterValues values) {
  std::vector<NamedLidar> lidars;
  Problems problems = takeLidars(names, "~", values, lidars);
  for (const Problem& p : checkLidars(names, lidars)) problems.push_back(p);
  for (const auto& left : values) problems.push_back({left.first, "left"});
  return problemText(problems);
}

VehicleDescription cart() {
  VehicleDescription vehicle;
  vehicle.root = "base_link";
  vehicle.links.resize(2);
  vehicle.links[0].name = "base_link";
  vehicle.links[1].name = "laser";
  return vehicle;
}

std::string mountProblemsOf(const LidarSpec& spec) { return problemText(checkMounts({{"front", spec}}, cart())); }

TEST(LidarMount, DefaultsAreALidar) { EXPECT_EQ(problemsOf({"front"}, {}), ""); }

TEST(LidarMount, TakesItsOwnValuesAndLeavesTheOthers) {
  std::vector<NamedLidar> lidars;
  ParameterValues values = {{"front/samples", std::int64_t{3}}, {"frontal/samples", std::int64_t{5}}, {"dt", 0.001}};
  EXPECT_TRUE(takeLidars({"front"}, "~", values, lidars).empty());
  ASSERT_EQ(lidars.size(), 1u);
  EXPECT_EQ(lidars[0].spec.samples, 3.0);
  EXPECT_EQ(values.size(), 2u);
}

TEST(LidarMount, LaterSourceWinsKeyByKey) {
  std::vector<NamedLidar> lidars;
  ParameterValues vehicle = {{"front/samples", std::int64_t{3}}, {"front/rate", 10.0}}, server = {{"front/rate", 20.0}};
  takeLidars({"front"}, "car.yaml ", vehicle, lidars);
  takeLidars({"front"}, "~", server, lidars);
  ASSERT_EQ(lidars.size(), 1u);
  EXPECT_EQ(lidars[0].spec.samples, 3.0);
  EXPECT_EQ(lidars[0].spec.rate, 20.0);
}

TEST(LidarMount, EveryValueIsCheckedAndTold) {
  EXPECT_EQ(problemsOf({"front"}, {{"front/sampels", std::int64_t{3}}}),
            "~front/sampels: there is no such parameter (its value is '3'); did you mean 'samples'?\n");
  EXPECT_EQ(problemsOf({"front"}, {{"front/range_min", 40.0}}), "~front/range_min: '40' is not below range_max '30'\n");
  EXPECT_NE(problemsOf({"front"}, {{"front/noise", -0.1}}).find("~front/noise: '-0.1' is out of range"),
            std::string::npos);
  EXPECT_NE(problemsOf({"front"}, {{"front/samples", 2.5}}).find("no whole number"), std::string::npos);
  EXPECT_NE(problemsOf({"front"}, {{"front/samples", std::int64_t{1}}}).find("one ray has angle_min = angle_max"),
            std::string::npos);
  EXPECT_NE(problemsOf({"front"}, {{"front/angle_min", 3.0}, {"front/angle_max", -3.0}}).find("a full turn above it"),
            std::string::npos);
  EXPECT_NE(problemsOf({"front"}, {{"front/rate", 0.0}}).find("out of range"), std::string::npos);
  EXPECT_NE(problemsOf({"front"}, {{"front/pose", std::vector<double>{1.0, 2.0}}}).find("expected 6"),
            std::string::npos);
  EXPECT_NE(problemsOf({"front"}, {{"front/kind", std::string("flat")}}).find("allowed is planar | spatial"),
            std::string::npos);
}

TEST(LidarMount, VerticalAnglesBelongToSpatialOnes) {
  EXPECT_EQ(problemsOf({"top"}, {{"top/rings", std::int64_t{4}}}),
            "~top/rings: has no meaning with kind: planar; allowed with kind: spatial\n");
  const ParameterValue spatial = std::string("spatial");
  EXPECT_EQ(problemsOf({"top"}, {{"top/kind", spatial}, {"top/rings", std::int64_t{4}}}), "");
  EXPECT_NE(problemsOf({"top"}, {{"top/kind", spatial}, {"top/vertical_angle_min", 0.5}}).find("with one ring"),
            std::string::npos);
  EXPECT_NE(
      problemsOf({"top"},
                 {{"top/kind", spatial}, {"top/rings", std::int64_t{1024}}, {"top/samples", std::int64_t{100000}}})
          .find("rays a scan, allowed are 2000000"),
      std::string::npos);
}

TEST(LidarMount, NamesAreNamesAndDifferent) {
  EXPECT_NE(problemsOf({"1st"}, {}).find("'1st' is no name"), std::string::npos);
  EXPECT_NE(problemsOf({""}, {}).find("'' is no name"), std::string::npos);
  EXPECT_NE(problemsOf({"a", "a"}, {}).find("'a' stands there twice"), std::string::npos);
  const ParameterValue topic = std::string("scan");
  EXPECT_EQ(problemsOf({"a", "b"}, {{"a/topic", topic}, {"b/topic", topic}}), "~b/topic: 'scan' is lidar 'a's\n");
}

TEST(LidarMount, FrameIsTheLinksWithoutAPoseAndItsOwnWithOne) {
  NamedLidar lidar{"front", {}};
  EXPECT_EQ(lidar.frame(cart()), "base_link");
  EXPECT_EQ(lidar.topic(), "front/scan");
  lidar.spec.link = "laser";
  EXPECT_EQ(lidar.frame(cart()), "laser");
  lidar.spec.pose = {0.0, 0.0, 1.0, 0.0, 0.0, 0.0};
  EXPECT_EQ(lidar.frame(cart()), "front");
  lidar.spec.frame_id = "front_laser";
  EXPECT_EQ(lidar.frame(cart()), "front_laser");
}

TEST(LidarMount, LinkMustBeThereAndAFrameMustNot) {
  LidarSpec spec;
  spec.link = "lazer";
  EXPECT_EQ(mountProblemsOf(spec), "~front/link: the vehicle has no link 'lazer'; there are: base_link, laser\n");
  spec.link = "base_link";
  spec.pose = {0.0, 0.0, 1.0, 0.0, 0.0, 0.0};
  EXPECT_EQ(mountProblemsOf(spec), "");
  spec.frame_id = "laser";
  EXPECT_NE(mountProblemsOf(spec).find("'laser' is a link of the vehicle already"), std::string::npos);
  spec.pose.clear();
  EXPECT_NE(problemText(checkLidar(spec, "~front/")).find("without a pose"), std::string::npos);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
