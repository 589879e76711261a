#pragma once

#include "ellipsoid_vehicle_sim/vehicle/vehicle_state.h"

namespace ellipsoid_vehicle_sim {

/// Hands every value of the state to `field`, in a fixed order: the one list that the hash and the snapshots are made
/// from. `field` takes double&, bool&, std::int64_t&, int& and enumerations, const where the state is; `field.size(n)`
/// is told the length of each list before its items. What a step works out anew from these is left out.
template <typename State, typename Field>
void visitFields(State& state, Field& field) {
  const auto vector3 = [&field](auto& v) {
    for (int i = 0; i < 3; ++i) field(v[i]);
  };
  const auto pose = [&](auto& X) {
    vector3(X.p);
    for (int i = 0; i < 4; ++i) field(X.q.coeffs()[i]);
  };
  const auto numbers = [&field](auto& values) {
    field.size(values.size());
    for (auto& value : values) field(value);
  };

  auto& motion = state.motion;
  pose(motion.X_WB);
  vector3(motion.v_WB);
  vector3(motion.w_WB);
  numbers(motion.q);
  numbers(motion.qd);
  numbers(motion.stretch);
  field.size(motion.anchor.size());
  for (auto& anchors : motion.anchor)
    for (auto& z : anchors) vector3(z);

  field.size(state.memory.size());
  for (auto& memory : state.memory) {
    field(memory.fresh);
    if (!memory.fresh) {  // otherwise there is no pose yet
      vector3(memory.posed.p_WE);
      for (int i = 0; i < 9; ++i) field(memory.posed.R_WE.data()[i]);
      vector3(memory.posed.radii);
      for (int i = 0; i < 9; ++i) field(memory.posed.A.data()[i]);
    }
    field(memory.count);
    for (auto& carried : memory.carried) {
      field(carried.triangle);
      vector3(carried.nhat_W);
      field(carried.depth);
      field(carried.half_width);
    }
    field(memory.deepest);
    vector3(memory.push);
    field(memory.slack);
  }

  field.size(state.profiles.size());
  for (auto& profile : state.profiles) {
    field(profile.position);
    field(profile.velocity);
    field(profile.target);
    field(profile.acceleration);
    field(profile.until);
    field(profile.then);
    field(profile.effort);
  }
  field.size(state.treads.size());
  for (auto& tread : state.treads) {
    field(tread.mode);
    field(tread.angle);
    field(tread.speed);
    field(tread.acceleration);
  }

  auto& drive = state.drive;
  field(drive.mode);
  field(drive.command.kind);
  field(drive.command.speed);
  field(drive.command.yaw_rate);
  field(drive.command.steering_angle);
  field(drive.command.steering_angle_velocity);
  field(drive.command.acceleration);
  field(drive.command.jerk);
  field(drive.has_command);
  field(drive.command_age);
  field(drive.speed);
  field(drive.yaw_rate);
  numbers(drive.wheel_speed);
  numbers(drive.wheel_acceleration);
  numbers(drive.integral);
  numbers(drive.integral_gain);
  numbers(drive.angle);
  field(drive.steering);
  field(drive.acceleration);
  numbers(drive.own_mode);
  const auto commands = [&field](auto& list) {
    field.size(list.size());
    for (auto& command : list) {
      field(command.kind);
      field(command.value);
      field(command.effort);
      field(command.age);
    }
  };
  commands(drive.wheel_command);
  commands(drive.profile_command);
}

}  // namespace ellipsoid_vehicle_sim
