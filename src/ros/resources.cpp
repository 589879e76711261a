#include "ellipsoid_vehicle_sim/ros/resources.h"

#include <ros/package.h>

#include "ellipsoid_vehicle_sim/description/shipped_files.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr const char* kPackage = "ellipsoid_vehicle_sim";

}  // namespace

std::string shareFolder() {
  const std::string beside = shareFolderBesideProgram();
  return beside.empty() ? ros::package::getPath(kPackage) : beside;
}

Loaded<std::string> findVehicle(const std::string& name_or_path, const std::string& where) {
  return findShipped(shippedVehicles(shareFolder()), "vehicle", name_or_path, where);
}

Loaded<std::string> findWorld(const std::string& name_or_path, const std::string& where) {
  return findShipped(shippedWorlds(shareFolder()), "world", name_or_path, where);
}

UriResolver packageResolver(std::vector<std::string> package_dirs, const std::string& file) {
  return shippedResolver(std::move(package_dirs), file, shareFolder(), ros::package::getPath);
}

}  // namespace ellipsoid_vehicle_sim
