#include "ellipsoid_vehicle_sim/vehicle/snapshot.h"

#include <cmath>
#include <cstring>
#include <type_traits>

#include "ellipsoid_vehicle_sim/vehicle/parameter_table.h"
#include "fnv_hash.h"
#include "state_check.h"
#include "state_fields.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr const char* kMark = "ellipsoid_vehicle_sim state";
constexpr std::uint64_t kVersion = 3;
constexpr double kLargestFrictionScale = 1e6;

/// What a snapshot belongs to.
struct Identity {
  std::string vehicle;  ///< its name.
  std::uint64_t vehicle_hash = 0;
  std::uint64_t world_hash = 0;
  std::map<std::string, std::string> parameters;
};

std::uint64_t hashOf(const VehicleDescription& vehicle) {
  FnvHash hash;
  const auto add = [&hash](const auto& matrix) {
    for (Eigen::Index i = 0; i < matrix.size(); ++i) hash.add(static_cast<double>(matrix.data()[i]));
  };
  const auto addPose = [&](const Pose& X) {
    add(X.p);
    add(X.q.coeffs());
  };
  const auto addOptional = [&hash](const std::optional<double>& value) {
    hash.add(static_cast<std::uint64_t>(value.has_value()));
    hash.add(value.value_or(0.0));
  };
  hash.add(vehicle.name);
  hash.add(static_cast<std::uint64_t>(vehicle.layout));
  for (const LinkDescription& link : vehicle.links) {
    hash.add(link.name);
    hash.add(link.mass);
    add(link.p_Lcm);
    add(link.I_cm_L);
    for (const EllipsoidDescription& ellipsoid : link.ellipsoids) {
      hash.add(ellipsoid.name);
      addPose(ellipsoid.X_LE);
      add(ellipsoid.radii);
    }
  }
  for (const JointDescription& joint : vehicle.joints) {
    hash.add(joint.name);
    hash.add(joint.parent);
    hash.add(static_cast<std::uint64_t>(joint.type));
    hash.add(static_cast<std::uint64_t>(joint.role));
    addPose(joint.X_PJ);
    add(joint.axis);
    for (const double value :
         {joint.lower, joint.upper, joint.effort_limit, joint.velocity_limit, joint.damping, joint.friction})
      hash.add(value);
    addOptional(joint.spring_stiffness);
    addOptional(joint.spring_reference);
  }
  return hash.value();
}

std::uint64_t hashOf(const Terrain& terrain) {
  FnvHash hash;
  hash.add(static_cast<std::uint64_t>(terrain.triangleCount()));
  for (int i = 0; i < terrain.triangleCount(); ++i) {
    for (const Eigen::Vector3d& v : terrain.triangle(i).v)
      for (int k = 0; k < 3; ++k) hash.add(v[k]);
    hash.add(static_cast<std::uint64_t>(terrain.surfaceIndex(i)));
  }
  for (const Surface& surface : terrain.surfaces()) {
    hash.add(surface.mu_static.value_or(-1.0));
    hash.add(surface.mu_kinetic.value_or(-1.0));
  }
  return hash.value();
}

Identity identityOf(const Simulator& simulator) {
  Identity identity;
  identity.vehicle = simulator.model().description.name;
  identity.vehicle_hash = hashOf(simulator.model().description);
  identity.world_hash = hashOf(simulator.terrain());
  for (const auto& row : simConfigParameters()) {
    const auto value = row.get(simulator.config());
    identity.parameters[row.spec.key] = value ? valueText(*value) : "derived";
  }
  return identity;
}

/// The fields of a state, written.
class FieldWriter {
 public:
  explicit FieldWriter(ByteWriter& out) : out_(out) {}
  void size(std::size_t n) { out_.add(static_cast<std::uint64_t>(n)); }
  void operator()(double value) { out_.add(value); }
  template <typename Whole>
  void operator()(const Whole& value) {
    out_.add(static_cast<std::uint64_t>(value));
  }

 private:
  ByteWriter& out_;
};

/// The fields of a state, read into one of the right sizes.
class FieldReader {
 public:
  explicit FieldReader(ByteReader& in) : in_(in) {}
  void size(std::size_t n) { fits_ = in_.whole() == n && fits_; }
  void operator()(double& value) { value = in_.number(); }
  template <typename Whole>
  void operator()(Whole& value) {
    value = static_cast<Whole>(in_.whole());
  }
  bool fits() const { return fits_ && in_.ok(); }

 private:
  ByteReader& in_;
  bool fits_ = true;
};

std::uint64_t checksum(const std::uint8_t* begin, const std::uint8_t* end) {
  FnvHash hash;
  for (; begin != end; ++begin) hash.add(*begin);
  return hash.value();
}

/// "dt 0.001 (here 0.002), ..."
std::string differences(const std::map<std::string, std::string>& saved,
                        const std::map<std::string, std::string>& here) {
  std::string text;
  const auto add = [&text](const std::string& words) { text += (text.empty() ? "" : ", ") + words; };
  for (const auto& [key, value] : saved) {
    const auto found = here.find(key);
    if (found == here.end()) {
      add(key + " " + value + " (unknown here)");
    } else if (found->second != value) {
      add(key + " " + value + " (here " + found->second + ")");
    }
  }
  for (const auto& [key, value] : here)
    if (saved.count(key) == 0) add(key + " missing (here " + value + ")");
  return text;
}

Problems compare(const Identity& saved, const Identity& here, const std::string& where) {
  Problems problems;
  if (saved.vehicle != here.vehicle) {
    problems.push_back(
        {where, "was saved with the vehicle '" + saved.vehicle + "', this one is '" + here.vehicle + "'"});
  } else if (saved.vehicle_hash != here.vehicle_hash) {
    problems.push_back(
        {where, "was saved with another version of the vehicle '" + here.vehicle + "': its description differs"});
  }
  if (saved.world_hash != here.world_hash)
    problems.push_back({where, "was saved in another world: its triangles differ"});
  if (const std::string text = differences(saved.parameters, here.parameters); !text.empty())
    problems.push_back({where, "was saved with other parameters: " + text});
  return problems;
}

}  // namespace

void ByteWriter::add(std::uint64_t value) {
  for (int i = 0; i < 8; ++i) bytes_.push_back(static_cast<std::uint8_t>(value >> (8 * i) & 0xffu));
}

void ByteWriter::add(double value) {
  std::uint64_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  add(bits);
}

void ByteWriter::add(const std::string& text) {
  add(static_cast<std::uint64_t>(text.size()));
  bytes_.insert(bytes_.end(), text.begin(), text.end());
}

void ByteWriter::add(const std::vector<std::uint8_t>& bytes) {
  add(static_cast<std::uint64_t>(bytes.size()));
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
}

std::uint8_t ByteReader::byte() {
  if (!ok_ || next_ == end_) {
    ok_ = false;
    return 0;
  }
  return *next_++;
}

std::uint64_t ByteReader::whole() {
  std::uint64_t value = 0;
  for (int i = 0; i < 8; ++i) value |= static_cast<std::uint64_t>(byte()) << (8 * i);
  return ok_ ? value : 0;
}

double ByteReader::number() {
  const std::uint64_t bits = whole();
  double value;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

std::vector<std::uint8_t> ByteReader::block() {
  const std::uint64_t size = whole();
  if (size > static_cast<std::uint64_t>(end_ - next_)) {
    ok_ = false;
    return {};
  }
  std::vector<std::uint8_t> bytes(next_, next_ + size);
  next_ += size;
  return bytes;
}

std::string ByteReader::text() {
  const std::vector<std::uint8_t> bytes = block();
  return std::string(bytes.begin(), bytes.end());
}

std::vector<std::uint8_t> toBytes(const Snapshot& snapshot, const Simulator& simulator) {
  const Identity identity = identityOf(simulator);
  ByteWriter out;
  out.add(std::string(kMark));
  out.add(kVersion);
  out.add(identity.vehicle);
  out.add(identity.vehicle_hash);
  out.add(identity.world_hash);
  out.add(static_cast<std::uint64_t>(identity.parameters.size()));
  for (const auto& [key, value] : identity.parameters) {
    out.add(key);
    out.add(value);
  }
  FieldWriter fields(out);
  visitFields(snapshot.state, fields);
  visitFields(snapshot.home, fields);
  const StepEvents& events = snapshot.events;
  for (const std::int64_t count :
       {events.passed_through, events.effort_exceeded, events.command_timeouts, events.rejected_commands,
        events.floor_steps, events.savings_differences})
    out.add(count);
  out.add(snapshot.friction_scale);
  out.add(snapshot.extra);
  out.add(checksum(out.bytes().data(), out.bytes().data() + out.bytes().size()));
  return out.bytes();
}

Loaded<Snapshot> fromBytes(const std::vector<std::uint8_t>& bytes, const Simulator& simulator,
                           const std::string& where) {
  Loaded<Snapshot> result;
  const auto refuse = [&](const std::string& message) {
    result.problems.push_back({where, message});
    return result;
  };
  constexpr std::size_t kChecksumSize = 8;
  ByteReader in(bytes.data(), bytes.data() + (bytes.size() > kChecksumSize ? bytes.size() - kChecksumSize : 0));
  if (in.text() != kMark)
    return refuse("is no saved state of this simulator (" + std::to_string(bytes.size()) + " bytes)");
  const std::uint64_t version = in.whole();
  if (version != kVersion)
    return refuse("is of format version " + std::to_string(version) + ", this simulator reads " +
                  std::to_string(kVersion));
  ByteReader end(bytes.data() + bytes.size() - kChecksumSize, bytes.data() + bytes.size());
  if (end.whole() != checksum(bytes.data(), bytes.data() + bytes.size() - kChecksumSize))
    return refuse("is damaged: its checksum is wrong");

  Identity saved;
  saved.vehicle = in.text();
  saved.vehicle_hash = in.whole();
  saved.world_hash = in.whole();
  for (std::uint64_t n = in.whole(); n > 0 && in.ok(); --n) {
    const std::string key = in.text();
    saved.parameters[key] = in.text();
  }
  result.problems = compare(saved, identityOf(simulator), where);
  if (!result.problems.empty()) return result;

  // Of the right sizes: those of this simulator.
  Snapshot snapshot;
  snapshot.state = snapshot.home = simulator.state();
  FieldReader fields(in);
  visitFields(snapshot.state, fields);
  visitFields(snapshot.home, fields);
  StepEvents& events = snapshot.events;
  for (std::int64_t* count :
       {&events.passed_through, &events.effort_exceeded, &events.command_timeouts, &events.rejected_commands,
        &events.floor_steps, &events.savings_differences})
    *count = static_cast<std::int64_t>(in.whole());
  snapshot.friction_scale = in.number();
  snapshot.extra = in.block();
  if (!fields.fits() || !in.ok() || !in.atEnd()) return refuse("does not fit this vehicle");
  for (const VehicleState* state : {&snapshot.state, &snapshot.home}) {
    const std::string fault = faultOf(*state, simulator);
    if (!fault.empty()) return refuse("holds values that no state can have: " + fault);
  }
  if (!(snapshot.friction_scale >= 0.0 && snapshot.friction_scale <= kLargestFrictionScale))
    return refuse("holds values that no state can have: a friction scale of " + std::to_string(snapshot.friction_scale));
  result.value = std::move(snapshot);
  return result;
}

}  // namespace ellipsoid_vehicle_sim
