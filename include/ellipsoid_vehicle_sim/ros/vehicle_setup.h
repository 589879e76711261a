#pragma once

#include <ros/node_handle.h>

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/description/world_file.h"
#include "ellipsoid_vehicle_sim/ros/parameters.h"
#include "ellipsoid_vehicle_sim/ros/run_recorder.h"
#include "ellipsoid_vehicle_sim/vehicle/simulator.h"

namespace ellipsoid_vehicle_sim {

/// A vehicle as the node takes it in.
struct VehicleSetup {
  std::string name;                   ///< "": the only one, without a name space of its own.
  NodeOptions options;                ///< frames with their prefix.
  Simulator simulator;
  WorldStart start;                   ///< where it is to be set down.
  std::string base_frame;             ///< the URDF's root link, with the prefix.
  double vehicle_length = 1.0;        ///< largest distance across its ellipsoids, joints at zero [m].
  std::set<std::string> drawn_links;  ///< links with a visual that can be drawn.
  std::vector<std::string> files;     ///< that it is made from.
};

/// What a vehicle is made from.
struct VehicleRequest {
  std::string name;                      ///< "" as above.
  std::vector<ParameterSource> sources;  ///< of parameters; later ones win.
  std::string urdf;                      ///< as text, before anything else; may be empty.
  std::optional<WorldStart> start;       ///< before the parameter.
};

/// A vehicle's URDF, read: the first half of a set-up, which needs no world.
struct DescribedVehicle {
  NodeParameters parameters;
  std::optional<VehicleDescription> description;
  std::string urdf;                   ///< text; for robot_description.
  std::set<std::string> drawn_links;
  std::vector<std::string> files;
  bool sound_parameters = false;
  bool complete = false;              ///< parameters and description are both sound.
};

/// Words that stand before the keys of a vehicle's parameters: "~", or "~red/".
std::string parametersOf(const std::string& name);

/// Parameters of the file VEHICLE.yaml beside a vehicle, where there is one, to go before all others.
void addParametersBeside(const std::string& vehicle_file, std::vector<ParameterSource>& sources, Problems& problems,
                         std::vector<std::string>& notes);

/// Parameters and URDF; sets robot_description in the vehicle's name space where nobody has (`nh`).
DescribedVehicle describeVehicle(const ros::NodeHandle& nh, VehicleRequest request, Problems& problems,
                                 std::vector<std::string>& notes);

/// The vehicle compiled for `terrain`, not yet set down. Problems: none is returned.
std::optional<VehicleSetup> setUpVehicle(const VehicleRequest& request, DescribedVehicle described,
                                         std::shared_ptr<const Terrain> terrain, const WorldStart& world_start,
                                         Problems& problems, std::vector<std::string>& notes);

/// Why a vehicle cannot be called so; "" if it can. `taken`: names that are given already.
std::string nameRefusal(const std::string& name, const std::vector<std::string>& taken);

/// The record that ~record_folder asks for, if it does; a named vehicle's in a folder of its own below that.
std::optional<RunRecorder> openRecord(const VehicleSetup& setup, const Simulator& simulator,
                                      const std::vector<std::string>& world_files, Problems& problems);

void append(const Problems& more, Problems& problems);
void append(const std::vector<std::string>& more, std::vector<std::string>& notes);

}  // namespace ellipsoid_vehicle_sim
