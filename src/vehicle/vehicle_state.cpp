#include "ellipsoid_vehicle_sim/vehicle/vehicle_state.h"

#include <cmath>
#include <cstring>

namespace ellipsoid_vehicle_sim {
namespace {

bool finite(const std::vector<double>& values) {
  for (const double value : values)
    if (!std::isfinite(value)) return false;
  return true;
}

// FNV-1a, 64 bit [FowlerNollVo]. Values are added one by one: padding bytes never count.
class Hash {
 public:
  void add(double value) {
    std::uint64_t bits;
    std::memcpy(&bits, &value, sizeof bits);
    add(bits);
  }
  void add(std::uint64_t bits) {
    for (int i = 0; i < 8; ++i) {
      hash_ ^= (bits >> (8 * i)) & 0xffu;
      hash_ *= 1099511628211ull;
    }
  }
  void add(const Eigen::Vector3d& v) {
    for (int i = 0; i < 3; ++i) add(v[i]);
  }
  void add(const Pose& X) {
    add(X.p);
    for (int i = 0; i < 4; ++i) add(X.q.coeffs()[i]);
  }
  void add(const std::vector<double>& values) {
    for (const double value : values) add(value);
  }
  std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 14695981039346656037ull;
};

}  // namespace

bool Motion::allFinite() const {
  if (!X_WB.allFinite() || !v_WB.allFinite() || !w_WB.allFinite() || !finite(q) || !finite(qd) || !finite(stretch))
    return false;
  for (const Anchors& anchors : anchor)
    for (const Eigen::Vector3d& z : anchors)
      if (!z.allFinite()) return false;
  return true;
}

void retract(const Motion& x, double h, const MotionRate& rate, Motion& result) {
  result.X_WB.p = x.X_WB.p + h * rate.v;
  result.X_WB.q = (quaternionFromRotationVector(h * rate.w) * x.X_WB.q).normalized();
  result.v_WB = x.v_WB + h * rate.a;
  result.w_WB = x.w_WB + h * rate.alpha;
  for (std::size_t i = 0; i < x.q.size(); ++i) {
    result.q[i] = x.q[i] + h * rate.q[i];
    result.qd[i] = x.qd[i] + h * rate.qd[i];
    result.stretch[i] = x.stretch[i] + h * rate.stretch[i];
  }
  for (std::size_t i = 0; i < x.anchor.size(); ++i)
    for (int j = 0; j < kMaxContactsPerEllipsoid; ++j) result.anchor[i][j] = x.anchor[i][j] + h * rate.anchor[i][j];
}

std::uint64_t hashOf(const VehicleState& state) {
  Hash hash;
  const Motion& m = state.motion;
  hash.add(m.X_WB);
  hash.add(m.v_WB);
  hash.add(m.w_WB);
  hash.add(m.q);
  hash.add(m.qd);
  hash.add(m.stretch);
  for (const Anchors& anchors : m.anchor)
    for (const Eigen::Vector3d& z : anchors) hash.add(z);
  for (const ContactMemory& memory : state.memory) {
    hash.add(static_cast<std::uint64_t>(memory.fresh));
    hash.add(static_cast<std::uint64_t>(memory.count));
    for (int i = 0; i < memory.count; ++i) {
      hash.add(static_cast<std::uint64_t>(memory.carried[i].triangle));
      hash.add(memory.carried[i].nhat_W);
      hash.add(memory.carried[i].depth);
    }
    hash.add(memory.push);
    hash.add(memory.slack);
  }
  for (const ProfileState& profile : state.profiles) {
    hash.add(profile.position);
    hash.add(profile.velocity);
    hash.add(profile.target);
    hash.add(profile.effort);
  }
  for (const TreadState& tread : state.treads) {
    hash.add(static_cast<std::uint64_t>(tread.mode));
    hash.add(tread.angle);
    hash.add(tread.speed);
  }
  const DriveState& drive = state.drive;
  hash.add(static_cast<std::uint64_t>(drive.mode));
  hash.add(static_cast<std::uint64_t>(drive.has_command));
  hash.add(static_cast<std::uint64_t>(drive.command_age));
  hash.add(static_cast<std::uint64_t>(drive.command.kind));
  hash.add(drive.command.speed);
  hash.add(drive.command.yaw_rate);
  hash.add(drive.command.steering_angle);
  hash.add(drive.speed);
  hash.add(drive.yaw_rate);
  hash.add(drive.wheel_speed);
  hash.add(drive.integral);
  return hash.value();
}

}  // namespace ellipsoid_vehicle_sim
