#include "rest.h"

#include <algorithm>
#include <cmath>

namespace ellipsoid_vehicle_sim {

bool isLeftAlone(const VehicleState& state) {
  const DriveState& drive = state.drive;
  if (drive.mode != DriveState::Mode::kBrake) return false;
  for (const OwnMode own : drive.own_mode)
    if (own != OwnMode::kNone && own != OwnMode::kBrake) return false;
  for (const ProfileState& profile : state.profiles)
    if (profile.velocity != 0.0 || profile.acceleration != 0.0 || profile.then != 0.0) return false;
  for (const TreadState& tread : state.treads)
    if (tread.speed != 0.0 || tread.acceleration != 0.0) return false;
  return true;
}

bool isStill(const VehicleState& state) {
  const Motion& x = state.motion;
  const double limit = kRestSpeed * kRestSpeed;
  if (x.v_WB.squaredNorm() > limit || x.w_WB.squaredNorm() > limit) return false;
  for (const double qd : x.qd)
    if (std::abs(qd) > kRestSpeed) return false;
  bool touches = false;
  for (const ContactMemory& memory : state.memory) {
    if (memory.fresh || memory.slack > 0.0) return false;
    touches = touches || memory.count > 0;
  }
  return touches;
}

bool isBalanced(const MotionRate& rate) {
  const double limit = kRestAcceleration * kRestAcceleration;
  if (rate.a.squaredNorm() > limit || rate.alpha.squaredNorm() > limit) return false;
  return std::all_of(rate.qd.begin(), rate.qd.end(), [](double qdd) { return std::abs(qdd) <= kRestAcceleration; });
}

}  // namespace ellipsoid_vehicle_sim
