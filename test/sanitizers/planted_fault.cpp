// planted_fault race | overflow | undefined | leak: does what it is called, for the tests that a run with sanitizers sees it.
#include <climits>
#include <cstdio>
#include <cstring>
#include <string>
#include <thread>
#include <vector>

namespace ellipsoid_vehicle_sim {
namespace {

/// As a core that is shared by threads would be: written by both, without a lock.
struct SharedState {
  double position = 0.0;
};

void race() {
  SharedState state;
  std::thread other([&state] {
    for (int i = 0; i < 1000; ++i) state.position += 1.0;
  });
  for (int i = 0; i < 1000; ++i) state.position -= 1.0;
  other.join();
  std::printf("%g\n", state.position);
}

void overflow(std::size_t size) {
  std::vector<double> values(size);
  volatile double* first = values.data();
  first[size] = 1.0;
}

void undefined(int largest) { std::printf("%d\n", largest + 1); }

void leak() {
  volatile char* memory = new char[1000];
  memory[0] = 1;
  memory = nullptr;
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim

int main(int argc, char** argv) {
  const std::string kind = argc == 2 ? argv[1] : "";
  if (kind == "race") ellipsoid_vehicle_sim::race();
  if (kind == "overflow") ellipsoid_vehicle_sim::overflow(3 + static_cast<std::size_t>(argc));
  if (kind == "undefined") ellipsoid_vehicle_sim::undefined(INT_MAX - 2 + argc);
  if (kind == "leak") ellipsoid_vehicle_sim::leak();
  return 0;
}
