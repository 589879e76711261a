#include "fuzz_target.h"

namespace ellipsoid_vehicle_sim::fuzz {

const std::vector<Target>& targets() {
  static const std::vector<Target> all = {
      {"commands", fuzzCommands}, {"dae", fuzzDae},     {"obj", fuzzObj},
      {"parameters", fuzzParameters}, {"scene", fuzzScene}, {"snapshot", fuzzSnapshot},
      {"stl", fuzzStl},           {"urdf", fuzzUrdf},   {"world", fuzzWorld},
      {"xacro", fuzzXacro},
  };
  return all;
}

}  // namespace ellipsoid_vehicle_sim::fuzz
