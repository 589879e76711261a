#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/geometry/problem.h"
#include "ellipsoid_vehicle_sim/sensors/lidar.h"
#include "ellipsoid_vehicle_sim/vehicle/vehicle_description.h"

namespace ellipsoid_vehicle_sim {

/// A lidar with its name, as a vehicle carries it.
struct NamedLidar {
  std::string name;
  LidarSpec spec;

  /// Where it is mounted, what it is called, with the defaults filled in.
  std::string link(const VehicleDescription& vehicle) const { return spec.link.empty() ? vehicle.root : spec.link; }
  std::string frame(const VehicleDescription& vehicle) const;
  std::string topic() const;
  std::uint64_t seed(std::uint64_t noise_seed) const;
};

/// The lidars named by `names` from `values`, of which it takes the keys "NAME/..." of these names; later calls for the
/// same lidars win. `where` stands before a key in messages.
Problems takeLidars(const std::vector<std::string>& names, const std::string& where, ParameterValues& values,
                    std::vector<NamedLidar>& lidars);
/// What is wrong with the names, and with each lidar's values together.
Problems checkLidars(const std::vector<std::string>& names, const std::vector<NamedLidar>& lidars);
/// What is wrong with them on this vehicle: a link that it has not, a frame that it has already.
Problems checkMounts(const std::vector<NamedLidar>& lidars, const VehicleDescription& vehicle);
/// One line for the log.
std::string lidarReport(const NamedLidar& lidar, const VehicleDescription& vehicle);

}  // namespace ellipsoid_vehicle_sim
