// Every input that once got the better of a loader, and the seeds of scripts/fuzz, through the same checks. No clang needed.
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>

#include "fuzz_target.h"
#include "promises.h"
#include "support/bounded_child.h"

namespace ellipsoid_vehicle_sim::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr double kLongest = 10.0;  // [s], for a single input

std::string contentOf(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

class FuzzReplay : public testing::TestWithParam<Target> {};

TEST_P(FuzzReplay, KeepsItsPromises) {
  int count = 0;
  for (const auto& entry : fs::directory_iterator(fs::path(TEST_DATA_DIR) / "fuzz" / GetParam().name)) {
    const std::string input = contentOf(entry.path());
    const ChildReport report = inChild(
        [&] {
          GetParam().run(input);
          return std::string("done");
        },
        kLongest);
    EXPECT_TRUE(report.ended) << entry.path() << " after " << report.seconds << " s";
    EXPECT_LT(report.peak_memory, memoryFactor() * 1000.0) << entry.path();
    ++count;
  }
  EXPECT_GT(count, 0) << "a target without inputs";
}

INSTANTIATE_TEST_SUITE_P(Targets, FuzzReplay, testing::ValuesIn(targets()),
                         [](const testing::TestParamInfo<Target>& sheet) { return sheet.param.name; });

TEST(FuzzTargets, AreTheOnesThatScriptsFuzzKnows) {
  std::string names;
  std::set<std::string> known;
  for (const Target& target : targets()) {
    names += target.name + "\n";
    known.insert(target.name);
  }
  EXPECT_EQ(names, contentOf(fs::path(PACKAGE_DIR) / "test/fuzz/targets.txt"));
  for (const auto& entry : fs::directory_iterator(fs::path(TEST_DATA_DIR) / "fuzz"))
    EXPECT_EQ(known.count(entry.path().filename()), 1u) << entry.path() << " belongs to no target";
}

TEST(FuzzTargets, ABrokenPromiseEndsTheProgram) {
  EXPECT_FALSE(inChild([] { return promise(false, "on purpose"), std::string("done"); }, kLongest).ended);
  EXPECT_TRUE(inChild([] { return promise(true, "kept"), std::string("done"); }, kLongest).ended);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::fuzz
