#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "ellipsoid_vehicle_sim/contact/contact.h"
#include "ellipsoid_vehicle_sim/geometry/pose.h"
#include "ellipsoid_vehicle_sim/vehicle/drive_command.h"

namespace ellipsoid_vehicle_sim {

/// Friction stretches of one ellipsoid's carried contacts [m], in W.
using Anchors = std::array<Eigen::Vector3d, kMaxContactsPerEllipsoid>;

/// Work since the account began [J], or as a rate the power [W]. Kept only with SimConfig::energy_balance.
struct Work {
  double lost = 0.0;      ///< to friction, dampers, brakes, resistance: never to come back.
  double supplied = 0.0;  ///< by motors, prescribed joints and forces from outside.

  Work& operator+=(const Work& o) {
    lost += o.lost;
    supplied += o.supplied;
    return *this;
  }
};
inline Work operator+(Work a, const Work& b) { return a += b; }
inline Work operator*(double s, const Work& a) { return {s * a.lost, s * a.supplied}; }
inline Work operator/(const Work& a, double s) { return {a.lost / s, a.supplied / s}; }

/// What integrates. The base's frame B stands in the base's centre of mass, with the root link's axes.
struct Motion {
  Pose X_WB;
  Eigen::Vector3d v_WB = Eigen::Vector3d::Zero();  ///< in W [m/s].
  Eigen::Vector3d w_WB = Eigen::Vector3d::Zero();  ///< in W [rad/s].
  std::vector<double> q, qd;                       ///< dynamic joints [rad, m].
  std::vector<double> stretch;                     ///< of the joints' holds (brakes, dry friction) [rad, m].
  std::vector<Anchors> anchor;                     ///< per ellipsoid.
  Work work;                                       ///< moves nothing: no part of what is hashed, saved or compared.

  bool allFinite() const;
};

/// Derivative of Motion; the base's rotation by its angular velocity in W.
struct MotionRate {
  Eigen::Vector3d v = Eigen::Vector3d::Zero(), w = Eigen::Vector3d::Zero();
  Eigen::Vector3d a = Eigen::Vector3d::Zero(), alpha = Eigen::Vector3d::Zero();
  std::vector<double> q, qd, stretch;
  std::vector<Anchors> anchor;
  Work power;
};

/// Path of a prescribed joint within a tick: constant acceleration.
struct ProfileState {
  double position = 0.0, velocity = 0.0, target = 0.0;
  double acceleration = 0.0;  ///< from here on for `until` seconds, `then` until the end of the tick.
  double until = 0.0, then = 0.0;
  double effort = 0.0;  ///< that the last tick needed [N m] or [N].
};

/// What a tread does during a tick.
struct TreadState {
  enum class Mode : unsigned char { kFree, kTurning };
  Mode mode = Mode::kFree;
  double angle = 0.0;         ///< [rad].
  double speed = 0.0;         ///< at the start of the tick [rad/s].
  double acceleration = 0.0;  ///< during it [rad/s^2].
};

/// What a wheel does by a command of its own, whatever the vehicle as a whole is asked for.
enum class OwnMode : unsigned char { kNone, kBrake, kVelocity, kEffort };

/// The drive's memory; changes at ticks only.
struct DriveState {
  enum class Mode : unsigned char { kBrake, kCoast, kDrive };
  Mode mode = Mode::kBrake;
  DriveCommand command;             ///< the last accepted.
  bool has_command = false;
  std::int64_t command_age = 0;     ///< ticks since it came; restarts with it.
  double speed = 0.0;               ///< the speed asked of the wheels now, after the acceleration limit [m/s].
  double yaw_rate = 0.0;            ///< likewise, differential layouts [rad/s].
  std::vector<double> wheel_speed;  ///< target of each wheel unit [rad/s], sign of its joint, at this moment.
  std::vector<double> wheel_acceleration;  ///< of that target until the end of the tick [rad/s^2].
  std::vector<double> integral;     ///< of each wheel unit's servo [N m], at this moment.
  std::vector<double> integral_gain;       ///< that it grows with until the end of the tick [N m/rad].
  std::vector<double> angle;        ///< of each wheel unit's joint at this moment, where a servo grows [rad].
  double steering = 0.0;            ///< angle of the virtual front wheel asked for now [rad], Ackermann layout.
  double acceleration = 0.0;        ///< of `speed` during the last tick [m/s^2].
  std::vector<OwnMode> own_mode;             ///< of each wheel unit during the coming tick.
  std::vector<JointCommand> wheel_command;   ///< of each wheel unit by itself.
  std::vector<JointCommand> profile_command; ///< of each prescribed joint by itself.

  OwnMode own(int wheel) const {
    const auto i = static_cast<std::size_t>(wheel);
    return i < own_mode.size() ? own_mode[i] : OwnMode::kNone;
  }
};

/// Everything that changes from step to step, apart from the clock: copy it and the run can be continued bit for bit.
struct VehicleState {
  Motion motion;
  std::vector<ContactMemory> memory;    ///< per ellipsoid, frozen within a step.
  std::vector<ProfileState> profiles;   ///< per prescribed joint.
  std::vector<TreadState> treads;
  DriveState drive;
};

/// x advanced along `rate` for h seconds; rotation on its manifold. `x` and `result` may not be the same object.
void retract(const Motion& x, double h, const MotionRate& rate, Motion& result);

/// sum = w0 k0 + ... + w(n-1) k(n-1); weights of zero are skipped.
void weightedSum(const double* weights, const MotionRate* k, int n, MotionRate& sum);

/// Finite, and not beyond what any vehicle does: an exploded state is recognised before it overflows.
bool isSane(const Motion& x);

/// FNV-1a over every bit of the state [FowlerNollVo].
std::uint64_t hashOf(const VehicleState& state);

}  // namespace ellipsoid_vehicle_sim
