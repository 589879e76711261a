#include <cmath>

#include "ellipsoid_vehicle_sim/fleet/fleet.h"
#include "fleet_impl.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr const char* kMark = "ellipsoid_vehicle_sim fleet";
constexpr std::uint64_t kVersion = 1;

std::string namesText(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "none" : text;
}

std::vector<std::string> namesOf(const Fleet& fleet) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < fleet.size(); ++i) names.push_back(fleet.name(i));
  return names;
}

}  // namespace

FleetSnapshot Fleet::save() const {
  FleetSnapshot snapshot;
  snapshot.names = namesOf(*this);
  for (std::size_t i = 0; i < size(); ++i) snapshot.vehicles.push_back(vehicle(i).save());
  snapshot.touching = impl_->memories;
  for (PairMemory& memory : snapshot.touching)
    for (int& vehicle : memory.vehicle) vehicle = findId(vehicle);
  return snapshot;
}

Problems Fleet::restore(const FleetSnapshot& snapshot) {
  if (snapshot.names != namesOf(*this))
    return {{"fleet", "was saved with the vehicles " + namesText(snapshot.names) + "; there are: " + namesText(namesOf(*this))}};
  for (std::size_t i = 0; i < size(); ++i) vehicle(i).restore(snapshot.vehicles[i]);
  impl_->memories = snapshot.touching;
  for (PairMemory& memory : impl_->memories)
    for (int& vehicle : memory.vehicle) vehicle = id(static_cast<std::size_t>(vehicle));
  // Nobody was put anywhere: they have been there before.
  for (FleetMember& member : impl_->members) member.times_placed = member.simulator->impl_->times_placed;
  if (size() > 1) {
    impl_->findIslands();
    impl_->tellAll();
  }
  return {};
}

std::vector<std::uint8_t> toBytes(const FleetSnapshot& snapshot, const Fleet& fleet) {
  ByteWriter out;
  out.add(std::string(kMark));
  out.add(kVersion);
  out.add(static_cast<std::uint64_t>(snapshot.names.size()));
  for (std::size_t i = 0; i < snapshot.names.size(); ++i) {
    out.add(snapshot.names[i]);
    out.add(toBytes(snapshot.vehicles[i], fleet.vehicle(i)));
  }
  out.add(static_cast<std::uint64_t>(snapshot.touching.size()));
  for (const PairMemory& memory : snapshot.touching) {
    for (int side = 0; side < 2; ++side) {
      out.add(static_cast<std::uint64_t>(memory.vehicle[side]));
      out.add(static_cast<std::uint64_t>(memory.ellipsoid[side]));
    }
    for (int k = 0; k < 3; ++k) out.add(memory.nhat_W[k]);
    out.add(memory.depth);
    out.add(memory.slack);
    for (int k = 0; k < 3; ++k) out.add(memory.anchor_W[k]);
  }
  out.add(snapshot.extra);
  return out.bytes();
}

Loaded<FleetSnapshot> fromBytes(const std::vector<std::uint8_t>& bytes, const Fleet& fleet, const std::string& where) {
  Loaded<FleetSnapshot> result;
  const auto refuse = [&](const std::string& message) {
    result.problems.push_back({where, message});
    return result;
  };
  ByteReader in(bytes.data(), bytes.data() + bytes.size());
  if (in.text() != kMark) return refuse("is no saved state of several vehicles (" + std::to_string(bytes.size()) + " bytes)");
  if (in.whole() != kVersion) return refuse("is of another format version than this simulator reads");
  FleetSnapshot snapshot;
  std::vector<std::vector<std::uint8_t>> blocks;
  for (std::uint64_t n = in.whole(); n > 0 && in.ok(); --n) {
    snapshot.names.push_back(in.text());
    blocks.push_back(in.block());
  }
  if (!in.ok()) return refuse("is damaged: it ends too early");
  if (snapshot.names != namesOf(fleet))
    return refuse("was saved with the vehicles " + namesText(snapshot.names) + "; there are: " + namesText(namesOf(fleet)));
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    Loaded<Snapshot> one = fromBytes(blocks[i], fleet.vehicle(i), where + ", vehicle '" + snapshot.names[i] + "'");
    result.problems.insert(result.problems.end(), one.problems.begin(), one.problems.end());
    if (one) snapshot.vehicles.push_back(std::move(*one.value));
  }
  if (!result.problems.empty()) return result;
  for (std::uint64_t n = in.whole(); n > 0 && in.ok(); --n) {
    PairMemory memory;
    bool fits = true;
    for (int side = 0; side < 2; ++side) {
      const std::uint64_t vehicle = in.whole(), ellipsoid = in.whole();
      fits = fits && vehicle < fleet.size() && ellipsoid < fleet.vehicle(vehicle).ellipsoids().size();
      memory.vehicle[side] = static_cast<int>(vehicle);
      memory.ellipsoid[side] = static_cast<int>(ellipsoid);
    }
    for (int k = 0; k < 3; ++k) memory.nhat_W[k] = in.number();
    memory.depth = in.number();
    memory.slack = in.number();
    for (int k = 0; k < 3; ++k) memory.anchor_W[k] = in.number();
    const double sum = memory.depth + memory.slack + memory.anchor_W.sum();
    if (!fits || memory.vehicle[0] >= memory.vehicle[1] || !std::isfinite(sum) || !(memory.depth >= 0.0) ||
        !(memory.slack >= 0.0) || !(std::abs(memory.nhat_W.norm() - 1.0) < 1e-9))
      return refuse("holds values that no state can have");
    snapshot.touching.push_back(memory);
  }
  snapshot.extra = in.block();
  if (!in.ok() || !in.atEnd()) return refuse("is damaged: it does not end where it should");
  result.value = std::move(snapshot);
  return result;
}

}  // namespace ellipsoid_vehicle_sim
