#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

namespace ellipsoid_vehicle_sim {

/// Path of a real vehicle or world below the folder that the environment variable ELLIPSOID_VEHICLE_SIM_TEST_DATA names
/// (it holds vehicles/ and worlds/). These files belong to others and are not in this repository: without them the
/// calling test is reported as skipped, with the reason, and must return. Set but wrong is a failure, not a skip.
inline std::optional<std::string> testData(const std::string& relative) {
  const char* root = std::getenv("ELLIPSOID_VEHICLE_SIM_TEST_DATA");
  const auto skip = [&relative]() {
    GTEST_SKIP() << "skipped: needs the real-world file " << relative
                 << ", and ELLIPSOID_VEHICLE_SIM_TEST_DATA does not say where vehicles/ and worlds/ are";
  };
  if (root == nullptr || *root == '\0') {
    skip();
    return std::nullopt;
  }
  const std::filesystem::path path = std::filesystem::path(root) / relative;
  if (!std::filesystem::exists(path)) {
    ADD_FAILURE() << "ELLIPSOID_VEHICLE_SIM_TEST_DATA is " << root << ", but there is no " << path.string();
    return std::nullopt;
  }
  return path.string();
}

}  // namespace ellipsoid_vehicle_sim
