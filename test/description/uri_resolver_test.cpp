#include "ellipsoid_vehicle_sim/description/uri_resolver.h"

#include <gtest/gtest.h>

#include <unistd.h>
#include <filesystem>
#include <fstream>

namespace ellipsoid_vehicle_sim {
namespace {

namespace fs = std::filesystem;

class UriResolution : public testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::temp_directory_path() / ("uri_resolver_test_" + std::to_string(::getpid()));
    write("cart_description/meshes/a.stl", "a");
    write("checkout/package.xml", "<package format=\"2\"><name> cart_description </name></package>");
    write("checkout/meshes/b.stl", "b");
    write("checkout/cart.urdf", "<robot/>");
  }
  void TearDown() override { fs::remove_all(root_); }
  void write(const std::string& file, const std::string& text) {
    fs::create_directories((root_ / file).parent_path());
    std::ofstream(root_ / file) << text;
  }
  std::string at(const std::string& file) const { return (root_ / file).string(); }
  static std::string normal(const std::optional<std::string>& path) {
    return path ? fs::path(*path).lexically_normal().string() : "";
  }
  fs::path root_;
};

TEST_F(UriResolution, FindsAPackageBesideTheFile) {
  const auto resolve = fileResolver({root_.string()}, root_.string());
  EXPECT_EQ(normal(resolve("package://cart_description/meshes/a.stl")), at("cart_description/meshes/a.stl"));
}

TEST_F(UriResolution, FindsAPackageWhoseFolderIsTheDirectoryItself) {
  const auto resolve = fileResolver({at("cart_description/")}, ".");
  EXPECT_EQ(normal(resolve("package://cart_description/meshes/a.stl")), at("cart_description/meshes/a.stl"));
}

TEST_F(UriResolution, FindsAPackageByThePackageXmlOfACheckoutOfAnotherName) {
  const auto resolve = fileResolver(at("checkout/cart.urdf"));
  EXPECT_EQ(normal(resolve("package://cart_description/meshes/b.stl")), at("checkout/meshes/b.stl"));
}

TEST_F(UriResolution, FindsFileUrisAbsoluteAndRelativePaths) {
  const auto resolve = fileResolver(at("checkout/cart.urdf"));
  EXPECT_EQ(normal(resolve("file://" + at("checkout/meshes/b.stl"))), at("checkout/meshes/b.stl"));
  EXPECT_EQ(normal(resolve(at("checkout/meshes/b.stl"))), at("checkout/meshes/b.stl"));
  EXPECT_EQ(normal(resolve("meshes/b.stl")), at("checkout/meshes/b.stl"));
  EXPECT_EQ(normal(resolve("../cart_description/meshes/a.stl")), at("cart_description/meshes/a.stl"));
}

TEST_F(UriResolution, FindsNothingWhereThereIsNoFile) {
  const auto resolve = fileResolver(at("checkout/cart.urdf"));
  for (const char* uri :
       {"package://cart_description/meshes/c.stl", "package://other/meshes/b.stl", "package://", "package://x",
        "package:///meshes/b.stl", "file:///no/such/file", "http://example.org/b.stl", "", "meshes"}) {
    EXPECT_FALSE(resolve(uri)) << uri;
  }
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim
