// A step takes nothing from the heap. Every allocation of the program is counted: C++ ones here, and with glibc those
// of malloc too, which Eigen calls itself.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "ellipsoid_vehicle_sim/fleet/fleet.h"
#include "support/meshes.h"
#include "support/motions.h"

namespace {

std::atomic<bool> counting{false};
std::atomic<long> allocations{0};

void count() {
  if (counting.load(std::memory_order_relaxed)) allocations.fetch_add(1, std::memory_order_relaxed);
}

}  // namespace

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
extern "C" void* __libc_malloc(std::size_t size);
extern "C" void* malloc(std::size_t size) {
  count();
  return __libc_malloc(size);
}
#endif

// Not inlined: the compiler would see free() take what operator new gave, and warn.
[[gnu::noinline]] void* operator new(std::size_t size) {
  count();
  if (void* p = std::malloc(size > 0 ? size : 1)) return p;
  throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  count();
  return std::malloc(size > 0 ? size : 1);
}
[[gnu::noinline]] void operator delete(void* p) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept { std::free(p); }

namespace ellipsoid_vehicle_sim::test {
namespace {

std::shared_ptr<const Terrain> rolling() {
  return terrainOf(gridSoup(120, 0.5, [](double x, double y) { return 0.1 * std::sin(0.9 * x) * std::cos(0.7 * y); },
                            {-30.0, -30.0, 0.0}));
}

long allocationsOf(Simulator& simulator, int steps, const DriveCommand& command) {
  allocations = 0;
  counting = true;
  bool ok = true;
  for (int i = 0; i < steps; ++i) {
    simulator.command(command);
    ok = ok && simulator.step() == StepStatus::kOk;
  }
  counting = false;
  EXPECT_TRUE(ok);
  return allocations;
}

TEST(NoAllocation, TheCounterCounts) {
  allocations = 0;
  counting = true;
  std::vector<double> some(100);
  counting = false;
  EXPECT_GE(allocations, 1);
  EXPECT_EQ(some.size(), 100u);
}

TEST(NoAllocation, AThousandStepsOverTrianglesTakeNone) {
  const auto terrain = rolling();
  for (const IntegratorKind kind : allIntegrators())
    for (const ContactsPerEllipsoid contacts : {ContactsPerEllipsoid::kOne, ContactsPerEllipsoid::kValley}) {
      SimConfig config;
      config.integrator = kind;
      config.contacts_per_ellipsoid = contacts;
      Simulator simulator = make(car(), terrain, config);
      standAt(simulator, -20.0, 0.0, 0.0);
      drive(simulator, twist(5.0, 0.3), 0.1);
      EXPECT_EQ(allocationsOf(simulator, 1000, twist(5.0, 0.3)), 0) << toString(kind);
    }
}

TEST(NoAllocation, VehiclesThatPushEachOtherTakeNoneOnceSized) {
  const auto terrain = rolling();
  for (const IntegratorKind kind : allIntegrators()) {
    SimConfig config;
    config.integrator = kind;
    config.allow_unstable = true;
    Fleet fleet(1);
    for (int i = 0; i < 3; ++i) {
      ASSERT_TRUE(fleet.add("car" + std::to_string(i), make(car(), terrain, config)).empty());
      ASSERT_TRUE(fleet.setDown(static_cast<std::size_t>(i), 5.5 * i - 15.0, 0.0, 0.0).empty());
    }
    // The last one brakes: the others drive into it.
    const auto run = [&fleet](int steps) {
      bool ok = true;
      std::size_t most = 0;
      for (int i = 0; i < steps; ++i) {
        fleet.vehicle(0).command(twist(3.0));
        fleet.vehicle(1).command(twist(3.0));
        ok = ok && fleet.step() == StepStatus::kOk;
        most = std::max(most, fleet.touching().size());
      }
      EXPECT_TRUE(ok);
      return most;
    };
    EXPECT_GT(run(1500), 0u) << toString(kind);
    allocations = 0;
    counting = true;
    const std::size_t touching = run(300);
    counting = false;
    EXPECT_GT(touching, 0u);
    EXPECT_EQ(allocations, 0) << toString(kind);
  }
}

TEST(NoAllocation, ReadingsTakeNoneOnceSized) {
  SimConfig config;
  Simulator simulator = make(car(), rolling(), config);
  standAt(simulator, 0.0, 0.0, 0.0);
  std::vector<JointReading> joints;
  std::vector<ContactReport> contacts;
  simulator.jointReadings(joints);
  contacts.reserve(64);
  simulator.contacts(contacts);
  drive(simulator, twist(2.0), 1.0);
  simulator.reset();
  drive(simulator, twist(2.0), 0.5);
  simulator.contacts(contacts);
  allocations = 0;
  counting = true;
  for (int i = 0; i < 100; ++i) {
    simulator.command(twist(2.0));
    simulator.step();
    simulator.jointReadings(joints);
    simulator.contacts(contacts);
    simulator.energy();
    simulator.stateHash();
  }
  counting = false;
  EXPECT_EQ(allocations, 0);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
