#include "ellipsoid_vehicle_sim/vehicle/snapshot.h"

#include <gtest/gtest.h>

#include <limits>

#include "ellipsoid_vehicle_sim/vehicle/parameter_table.h"
#include "support/motions.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// A car on bumpy ground, so that contact memory, anchors and springs are all at work.
std::shared_ptr<const Terrain> bumps() {
  TriangleSoup soup = floorSoup(50.0, 100);
  for (Eigen::Vector3d& v : soup.vertices) v.z() += 0.05 * std::sin(1.3 * v.x()) * std::cos(0.9 * v.y());
  return terrainOf(std::move(soup));
}

Simulator startedCar(const SimConfig& config = {}) {
  Simulator simulator = make(car(), bumps(), config);
  standAt(simulator, 0.0, 0.0, 0.3);
  return simulator;
}

/// Commands of every kind, by the tick; returns the hash after each.
std::vector<std::uint64_t> driveOn(Simulator& simulator, int from, int to) {
  std::vector<std::uint64_t> hashes;
  for (int i = from; i < to; ++i) {
    if (i % 20 == 0 && i < 1200) {
      DriveCommand command = ackermann(4.0 * std::sin(0.004 * i), 0.3 * std::cos(0.002 * i));
      command.acceleration = 2.0;
      command.jerk = i < 600 ? 8.0 : 0.0;
      command.steering_angle_velocity = 0.4;
      simulator.command(command);
    }
    if (i % 50 == 7 && i > 400 && i < 900) {
      JointRequest wheel, steer;
      wheel.joint = "rear_left_axle";
      wheel.velocity = 5.0;
      wheel.effort = 10.0;
      steer.joint = "front_right_steer";
      steer.velocity = 0.1;
      simulator.commandJoints({wheel, steer});
    }
    simulator.step();
    hashes.push_back(simulator.stateHash());
  }
  return hashes;
}

TEST(Snapshot, GoesOnBitForBitAlsoInAnotherSimulator) {
  for (const IntegratorKind kind : {IntegratorKind::kSemiImplicitEuler, IntegratorKind::kRk4}) {
    SimConfig config;
    config.integrator = kind;
    Simulator simulator = startedCar(config);
    // In the middle of everything: ramps, own commands, braking after the last command.
    for (const int middle : {555, 1450}) {
      simulator.reset();
      driveOn(simulator, 0, middle);
      const Bytes bytes = toBytes(simulator.save(), simulator);
      const StepEvents events = simulator.events();
      const std::vector<std::uint64_t> expected = driveOn(simulator, middle, middle + 700);

      Simulator fresh = startedCar(config);
      for (Simulator* other : {&simulator, &fresh}) {
        const std::int64_t steps = other->stepCount();
        const Loaded<Snapshot> snapshot = fromBytes(bytes, *other, "bytes");
        ASSERT_TRUE(snapshot) << problemText(snapshot.problems);
        other->restore(*snapshot.value);
        EXPECT_EQ(other->stepCount(), steps) << "the clock goes on";
        EXPECT_EQ(other->events().command_timeouts, events.command_timeouts);
        EXPECT_EQ(driveOn(*other, middle, middle + 700), expected) << toString(kind) << " " << middle;
      }
    }
  }
}

TEST(Snapshot, HoldsTheFrictionScaleAndTheStart) {
  Simulator simulator = startedCar();
  simulator.setFrictionScale(0.3);
  driveOn(simulator, 0, 100);
  Snapshot snapshot = simulator.save();
  snapshot.extra = {1, 2, 3};
  const Bytes bytes = toBytes(snapshot, simulator);
  Simulator other = startedCar();
  standAt(other, 5.0, 5.0, 0.0);
  const Loaded<Snapshot> read = fromBytes(bytes, other, "bytes");
  ASSERT_TRUE(read) << problemText(read.problems);
  EXPECT_EQ(read.value->extra, (Bytes{1, 2, 3}));
  other.restore(*read.value);
  EXPECT_EQ(other.frictionScale(), 0.3);
  other.reset();
  simulator.reset();
  EXPECT_EQ(other.stateHash(), simulator.stateHash());
}

std::string refusal(const Bytes& bytes, const Simulator& simulator) {
  const Loaded<Snapshot> snapshot = fromBytes(bytes, simulator, "the file");
  EXPECT_FALSE(snapshot);
  return problemText(snapshot.problems);
}

TEST(Snapshot, DamagedBytesAreRefusedWhereverTheyAre) {
  Simulator simulator = startedCar();
  const Bytes bytes = toBytes(simulator.save(), simulator);
  // Each byte in turn would take minutes; every 37th meets every part of the format.
  for (std::size_t i = 0; i < bytes.size(); i += 37) {
    Bytes damaged = bytes;
    damaged[i] = static_cast<std::uint8_t>(damaged[i] ^ 0x10u);
    EXPECT_FALSE(fromBytes(damaged, simulator, "the file")) << "byte " << i;
  }
  Bytes damaged = bytes;
  damaged[bytes.size() / 2] ^= 1;
  EXPECT_EQ(refusal(damaged, simulator), "the file: is damaged: its checksum is wrong\n");
  for (const std::size_t size : {std::size_t{0}, std::size_t{7}, std::size_t{40}, bytes.size() - 1})
    EXPECT_FALSE(
        fromBytes(Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)), simulator, "the file"))
        << size << " bytes";
  EXPECT_NE(refusal({'h', 'e', 'l', 'l', 'o'}, simulator).find("is no saved state"), std::string::npos);
}

TEST(Snapshot, AnotherVersionIsNamed) {
  Simulator simulator = startedCar();
  Bytes bytes = toBytes(simulator.save(), simulator);
  // The version stands behind the mark: a length of eight bytes and its letters.
  bytes[8 + bytes[0]] = 9;
  EXPECT_EQ(refusal(bytes, simulator), "the file: is of format version 9, this simulator reads 3\n");
}

TEST(Snapshot, AnotherVehicleWorldOrParameterIsRefusedByName) {
  Simulator simulator = startedCar();
  const Bytes bytes = toBytes(simulator.save(), simulator);
  const Simulator body = make(fourFeet(50.0), bumps(), SimConfig{});
  EXPECT_NE(refusal(bytes, body).find("was saved with the vehicle 'car', this one is 'block'"), std::string::npos);
  CarShape heavier;
  heavier.mass = 1300.0;
  const Simulator other = make(car(heavier), bumps(), SimConfig{});
  EXPECT_NE(refusal(bytes, other).find("another version of the vehicle 'car'"), std::string::npos);
  const Simulator elsewhere = make(car(), flatFloor(), SimConfig{});
  EXPECT_NE(refusal(bytes, elsewhere).find("another world"), std::string::npos);
  SimConfig config;
  config.dt = 5e-4;
  config.mu_static = 0.95;
  const Simulator finer = make(car(), bumps(), config);
  const std::string text = refusal(bytes, finer);
  EXPECT_NE(text.find("dt 0.001 (here 0.0005)"), std::string::npos) << text;
  EXPECT_NE(text.find("mu_static 0.9 (here 0.95)"), std::string::npos) << text;
}

TEST(ParameterTable, ValidateKnowsTheSameRangesAsTheReaders) {
  for (const auto& row : simConfigParameters()) {
    if (row.spec.kind != ParameterKind::kNumber) continue;
    for (const double bad : {row.spec.maximum * 1.01, std::nextafter(row.spec.minimum, -1e300), std::nan("")}) {
      SimConfig config;
      row.set(config, bad);
      const std::string text = problemText(config.validate());
      EXPECT_NE(text.find("parameter '" + row.spec.key + "'"), std::string::npos) << row.spec.key << " " << bad;
      EXPECT_NE(text.find(rangeText(row.spec)), std::string::npos) << text;
    }
  }
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
