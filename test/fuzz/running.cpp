// What comes in while a simulator runs: commands and saved states.
#include "ellipsoid_vehicle_sim/description/joint_roles.h"
#include "ellipsoid_vehicle_sim/vehicle/snapshot.h"
#include "fuzz_target.h"
#include "promises.h"
#include "support/scenes.h"

namespace ellipsoid_vehicle_sim::fuzz {
namespace {

Simulator& standingCar() {
  static Simulator car = [] {
    Loaded<Simulator> made = Simulator::create(test::car(), flatGround(), SimConfig{});
    promise(static_cast<bool>(made), "the car of the tests loads: " + problemText(made.problems));
    promise(made.value->setDown(0.0, 0.0, 0.3).empty(), "it can be set down");
    return std::move(*made.value);
  }();
  return car;
}

/// FNV-1a, as at the end of a saved state.
std::uint64_t checksum(const std::vector<std::uint8_t>& bytes) {
  std::uint64_t hash = 14695981039346656037ull;
  for (const std::uint8_t byte : bytes) hash = (hash ^ byte) * 1099511628211ull;
  return hash;
}

/// Where the values of a saved state begin: behind all that says what it belongs to.
std::size_t valuesBegin(const std::vector<std::uint8_t>& bytes) {
  ByteReader in(bytes.data(), bytes.data() + bytes.size());
  std::size_t begin = 0;
  const auto text = [&] { begin += 8 + in.text().size(); };
  const auto whole = [&] { return begin += 8, in.whole(); };
  text();   // mark
  whole();  // version
  text();   // vehicle
  whole(), whole();
  for (std::uint64_t n = whole(); n > 0; --n) text(), text();
  return begin;
}

/// A state of the car with values changed, told as genuine: each ten bytes are the number of an 8-byte word and what it
/// becomes.
std::vector<std::uint8_t> forged(const std::string& input) {
  static const std::vector<std::uint8_t> genuine = toBytes(standingCar().save(), standingCar());
  std::vector<std::uint8_t> bytes(genuine.begin(), genuine.end() - 8);
  const std::size_t begin = valuesBegin(genuine), words = (bytes.size() - begin) / 8;
  for (std::size_t at = 0; at + 10 <= input.size(); at += 10) {
    const std::size_t word = (static_cast<unsigned char>(input[at]) | static_cast<unsigned char>(input[at + 1]) << 8) % words;
    for (std::size_t k = 0; k < 8; ++k) bytes[begin + 8 * word + k] = static_cast<std::uint8_t>(input[at + 2 + k]);
  }
  ByteWriter end;
  end.add(checksum(bytes));
  bytes.insert(bytes.end(), end.bytes().begin(), end.bytes().end());
  return bytes;
}

}  // namespace

void fuzzSnapshot(const std::string& input) {
  Simulator& car = standingCar();
  car.reset();
  if (input.empty()) return;
  const bool forge = input[0] != 'r';  // r for raw
  const std::vector<std::uint8_t> bytes =
      forge ? forged(input.substr(1)) : std::vector<std::uint8_t>(input.begin() + 1, input.end());
  const std::uint64_t before = car.stateHash();
  const Loaded<Snapshot> snapshot = fromBytes(bytes, car, "state");
  checkLoaded(snapshot);
  promise(car.stateHash() == before, "reading a state changes none");
  if (!snapshot) return;
  static const Snapshot genuine = car.save();
  car.restore(*snapshot.value);
  checkFinite(car);
  for (int i = 0; i < 3; ++i) car.step();
  checkFinite(car);
  car.reset();
  car.step();
  checkFinite(car);
  car.restore(genuine);
}

void fuzzCommands(const std::string& input) {
  const auto* begin = reinterpret_cast<const std::uint8_t*>(input.data());
  ByteReader in(begin, begin + input.size());
  Simulator& car = standingCar();
  static const Snapshot standing = car.save();
  car.restore(standing);
  // To settle takes a thousand times as long as a command: one input in sixteen may, once.
  bool settles = std::hash<std::string>()(input) % 16 == 0;
  for (int ticks = 0; ticks < 30 && in.ok() && !in.atEnd(); ++ticks) {
    const std::uint8_t kind = in.byte();
    if (kind % 4 == 0) {
      DriveCommand command;
      command.kind = static_cast<DriveCommand::Kind>(in.byte() % 3);
      for (double* value : {&command.speed, &command.yaw_rate, &command.steering_angle, &command.steering_angle_velocity,
                            &command.acceleration, &command.jerk})
        *value = in.number();
      car.command(command);
    } else if (kind % 4 == 1) {
      const std::vector<std::string>& names = car.jointNames();
      std::vector<JointRequest> requests;
      for (int n = in.byte() % 4; n >= 0; --n) {
        JointRequest request;
        const std::uint8_t which = in.byte();
        request.joint = which % 8 == 7 ? in.text() : names[which % names.size()];
        const std::uint8_t given = in.byte();
        if (given & 1) request.position = in.number();
        if (given & 2) request.velocity = in.number();
        if (given & 4) request.effort = in.number();
        requests.push_back(request);
      }
      const Problems checked = car.checkJoints(requests);
      const Problems problems = car.commandJoints(requests);
      checkProblems(problems);
      promise(problems.empty() == checked.empty(), "checking says what taking says");
    } else if (kind % 4 == 2) {
      Problems problems;
      const std::string word = in.text();
      rolesFromWords({word}, "joint_roles", problems);
      forwardFromWord(word, "forward", problems);
      checkProblems(problems);
    } else {
      const double x = in.number(), y = in.number(), yaw = in.number();
      if (settles) checkProblems(car.setDown(x, y, yaw));
      settles = false;
    }
    car.step();
    checkFinite(car);
  }
  if (std::hash<std::string>()(input) % 16 != 0) return;
  if (car.status() != StepStatus::kOk) car.reset();
  promise(car.setDown(0.0, 0.0, 0.3).empty(), "the car can be set down again");
}

}  // namespace ellipsoid_vehicle_sim::fuzz
