#include "ellipsoid_vehicle_sim/description/parameter_file.h"

#include <gtest/gtest.h>

#include "support/temporary_files.h"

namespace ellipsoid_vehicle_sim {
namespace {

TEST(ParameterFile, WhatStandsInADictionaryHasItsNameBeforeTheKey) {
  TemporaryFiles files;
  const auto loaded = readParameterFile(files.write("car.yaml", "lidars: [front]\nfront: {rate: 10, kind: planar}\nmax_speed: 3.5\n"));
  ASSERT_TRUE(loaded) << problemText(loaded.problems);
  EXPECT_EQ(loaded.value->size(), 4u);
  EXPECT_EQ(numberOf(loaded.value->at("front/rate")), 10.0);
  EXPECT_EQ(std::get<std::string>(loaded.value->at("front/kind")), "planar");
  EXPECT_EQ(numberOf(loaded.value->at("max_speed")), 3.5);
}

TEST(ParameterFile, WhatNoParameterIsIsRefusedWithItsLine) {
  TemporaryFiles files;
  const std::string path = files.write("car.yaml", "a: 1\nfront:\n  rate: 10\n  deep: {x: 1}\n  rate: 20\nb:\na: 2\n");
  EXPECT_EQ(problemText(readParameterFile(path).problems),
            path + ":4 front/deep: is empty, a dictionary or a mixed list, which no parameter is\n" +
                path + ":5 front/rate: is given twice\n" + path + ":6 b: is empty or a mixed list, which no parameter is\n" +
                path + ":7 a: is given twice\n");
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
