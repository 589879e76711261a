// What libFuzzer calls, for the target that FUZZ_TARGET names.
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  namespace fuzz = ellipsoid_vehicle_sim::fuzz;
  static void (*const run)(const std::string&) = []() -> void (*)(const std::string&) {
    for (const fuzz::Target& target : fuzz::targets())
      if (target.name == FUZZ_TARGET) return target.run;
    std::abort();
  }();
  run(std::string(reinterpret_cast<const char*>(data), size));
  return 0;
}
