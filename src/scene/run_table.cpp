#include <cstdio>

#include "ellipsoid_vehicle_sim/scene/run_record.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

void put(std::string& line, double value) {
  char text[32];
  // 17 digits: reading gives the same bits. No "-0": it is the same number.
  std::snprintf(text, sizeof text, "%.17g", value == 0.0 ? 0.0 : value);
  line += text;
  line += ',';
}

void put(std::string& line, const Vector3d& v) {
  for (int i = 0; i < 3; ++i) put(line, v[i]);
}

void put(std::string& line, std::int64_t value) { line += std::to_string(value) + ','; }

double wheelSpeed(const VehicleState& state, const WheelUnit& wheel) {
  return wheel.forward_sign * (wheel.joint >= 0 ? state.motion.qd[wheel.joint] : state.treads[wheel.tread].speed);
}

std::string commandName(const Simulator& simulator) {
  const DriveState& drive = simulator.state().drive;
  if (!drive.has_command) return "none";
  if (!simulator.commandInForce()) return "expired";
  switch (drive.command.kind) {
    case DriveCommand::Kind::kTwist:
      return "twist";
    case DriveCommand::Kind::kAckermann:
      return "ackermann";
    case DriveCommand::Kind::kCoast:
      return "coast";
  }
  return "unknown";
}

/// Names in the header: a comma or a line end in a name would make another column.
std::string columnName(std::string name) {
  for (char& c : name)
    if (c == ',' || c == '"' || c == '\n' || c == '\r') c = '_';
  return name;
}

}  // namespace

Loaded<RunTable> RunTable::create(const std::string& path, const Simulator& simulator, std::int64_t every) {
  Loaded<RunTable> result;
  RunTable table;
  table.path_ = path;
  table.every_ = std::max<std::int64_t>(1, every);
  table.out_.open(path, std::ios::binary | std::ios::trunc);
  table.told_ = simulator.events();
  std::string header = "step,time,x,y,z,qx,qy,qz,qw,vx,vy,vz,wx,wy,wz,";
  for (const WheelUnit& wheel : simulator.model().drive.wheels) header += "wheel_speed:" + columnName(wheel.name) + ",";
  header +=
      "command,command_speed,command_yaw_rate,command_steering_angle,penetration,contacts,normal_force,energy,";
  if (simulator.config().energy_balance) header += "energy_lost,energy_supplied,energy_unaccounted,";
  header += "events,step_time\n";
  table.out_ << header;
  if (!table.out_) {
    result.problems.push_back({path, "cannot be written"});
    return result;
  }
  result.value = std::move(table);
  return result;
}

void RunTable::add(const Simulator& simulator, double step_time) {
  // A run that broke down is told at once, whatever line is due.
  const bool broke = simulator.status() != status_told_;
  if (calls_++ % every_ != 0 && !broke) return;
  line_.clear();
  put(line_, simulator.stepCount());
  put(line_, simulator.time());
  const Pose X_WR = simulator.rootPose();
  put(line_, X_WR.p);
  put(line_, Vector3d(X_WR.q.x(), X_WR.q.y(), X_WR.q.z()));
  put(line_, X_WR.q.w());
  const Eigen::Quaterniond q_RW = X_WR.q.conjugate();
  put(line_, Vector3d(q_RW * simulator.rootVelocity_W()));
  put(line_, Vector3d(q_RW * simulator.rootAngularVelocity_W()));
  for (const WheelUnit& wheel : simulator.model().drive.wheels) put(line_, wheelSpeed(simulator.state(), wheel));

  const DriveCommand& command = simulator.state().drive.command;
  line_ += commandName(simulator) + ',';
  put(line_, command.speed);
  put(line_, command.yaw_rate);
  put(line_, command.steering_angle);

  simulator.contacts(contacts_);
  double normal_force = 0.0;
  for (const ContactReport& contact : contacts_) normal_force += contact.normal_force;
  put(line_, simulator.largestPenetration());
  put(line_, static_cast<std::int64_t>(contacts_.size()));
  put(line_, normal_force);
  put(line_, simulator.energy());
  if (simulator.config().energy_balance) {
    const EnergyBalance balance = simulator.energyBalance();
    put(line_, balance.lost);
    put(line_, balance.supplied);
    put(line_, balance.error());
  }

  const StepEvents& now = simulator.events();
  std::string events;
  const auto tell = [&events](const char* name, std::int64_t count) {
    // After a reset the counts start again.
    if (count <= 0) return;
    events += (events.empty() ? "" : " ") + std::string(name) + (count > 1 ? "=" + std::to_string(count) : "");
  };
  tell("passed_through", now.passed_through - told_.passed_through);
  tell("effort_exceeded", now.effort_exceeded - told_.effort_exceeded);
  tell("command_timeouts", now.command_timeouts - told_.command_timeouts);
  tell("floor_steps", now.floor_steps - told_.floor_steps);
  tell("savings_differences", now.savings_differences - told_.savings_differences);
  tell("rejected_commands", now.rejected_commands - told_.rejected_commands);
  if (broke && simulator.status() == StepStatus::kDiverged) tell("diverged", 1);
  if (simulator.isBeyondCertificate()) events += (events.empty() ? "" : " ") + std::string("unstable");
  told_ = now;
  status_told_ = simulator.status();
  line_ += events + ',';

  put(line_, step_time);
  line_.back() = '\n';
  out_ << line_;
}

Problems RunTable::close() {
  out_.close();
  if (out_) return {};
  return {{path_, "could not be written to its end"}};
}

}  // namespace ellipsoid_vehicle_sim
