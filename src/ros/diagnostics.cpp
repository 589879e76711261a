#include "ellipsoid_vehicle_sim/ros/diagnostics.h"

#include <cmath>
#include <cstdio>

#include "ellipsoid_vehicle_sim/ros/simulator_services.h"

namespace ellipsoid_vehicle_sim {
namespace {

class Values {
 public:
  explicit Values(diagnostic_msgs::DiagnosticStatus& status) : status_(status) {}

  void add(const char* key, const std::string& value) {
    diagnostic_msgs::KeyValue pair;
    pair.key = key;
    pair.value = value;
    status_.values.push_back(pair);
  }
  void add(const char* key, double value) {
    char text[40];
    std::snprintf(text, sizeof text, "%.6g", value);
    add(key, std::string(text));
  }
  void add(const char* key, std::int64_t value) { add(key, std::to_string(value)); }

 private:
  diagnostic_msgs::DiagnosticStatus& status_;
};

void setLevel(const Simulator& simulator, const RunFacts& facts, diagnostic_msgs::DiagnosticStatus& status) {
  if (simulator.status() != StepStatus::kOk) {
    status.level = diagnostic_msgs::DiagnosticStatus::ERROR;
    status.message = "diverged: frozen at the last good state, ~reset starts again";
    return;
  }
  if (simulator.isBeyondCertificate()) {
    status.level = diagnostic_msgs::DiagnosticStatus::WARN;
    status.message = "UNSTABLE: the step is beyond the stability certificate, as allow_unstable permits";
    return;
  }
  if (simulator.events().passed_through > 0) {
    status.level = diagnostic_msgs::DiagnosticStatus::WARN;
    status.message = "an ellipsoid went through the ground";
    return;
  }
  status.message = facts.paused                 ? "paused"
                   : facts.waiting              ? "waiting for a command"
                   : simulator.commandInForce() ? "driven"
                                                : "braked: no command";
}

/// What the dial chose and why: the line of the load report.
std::string accuracyReason(const Simulator& simulator) {
  for (const std::string& line : simulator.loadReport())
    if (line.rfind("accuracy: ", 0) == 0) return line.substr(10);
  return simulator.config().accuracy;
}

}  // namespace

diagnostic_msgs::DiagnosticStatus diagnosticStatus(const Simulator& simulator, const RunStatistics& statistics,
                                                   const RunFacts& facts) {
  diagnostic_msgs::DiagnosticStatus status;
  status.name = facts.node + ": simulation";
  status.hardware_id = facts.hardware;
  setLevel(simulator, facts, status);
  const StepEvents& events = simulator.events();
  const SimConfig& config = simulator.config();
  Values values(status);
  values.add("simulated time [s]", simulator.time());
  values.add("step", simulator.stepCount());
  values.add("real-time factor", facts.recent_factor);
  values.add("real-time factor, mean", facts.mean_factor);
  values.add("behind the wall clock [s]", facts.lost);
  values.add("step time mean [us]", 1e6 * statistics.meanStepTime());
  values.add("step time p99 [us]", 1e6 * statistics.stepTimeQuantile(0.99));
  values.add("penetration [mm]", 1e3 * simulator.largestPenetration());
  values.add("largest penetration [mm]", 1e3 * statistics.largestPenetration());
  values.add("energy [J]", simulator.energy());
  if (config.energy_balance) {
    const EnergyBalance balance = simulator.energyBalance();
    values.add("energy lost [J]", balance.lost);
    values.add("energy supplied [J]", balance.supplied);
    values.add("energy unaccounted [J]", balance.error());
  }
  // Infinite before the first command; a number that plots is wanted here.
  const double age = simulator.commandAge();
  values.add("command age [s]", std::isfinite(age) ? age : -1.0);
  values.add("integrator", std::string(toString(config.integrator)));
  values.add("step size [s]", config.dt);
  values.add("accuracy", config.accuracy.empty() ? "not asked for" : accuracyReason(simulator));
  values.add("unstable", std::string(simulator.isBeyondCertificate() ? "true" : "false"));
  values.add("resting", std::string(simulator.isResting() ? "true" : "false"));
  // -1: not estimated.
  const ErrorEstimate& local = simulator.errorEstimate();
  const bool estimated = local.step >= 0;
  values.add("local error, position [m]", estimated ? local.position_W.norm() : -1.0);
  values.add("local error, rotation [rad]", estimated ? local.rotation_W.norm() : -1.0);
  values.add("local error, velocity [m/s]", estimated ? local.velocity_W.norm() : -1.0);
  values.add("local error, angular velocity [rad/s]", estimated ? local.angular_velocity_W.norm() : -1.0);
  values.add("stability margin", simulator.certificate().largestStep(config.integrator) / config.dt);
  values.add("friction scale", simulator.frictionScale());
  values.add("passed through", events.passed_through);
  values.add("effort exceeded", events.effort_exceeded);
  values.add("floor steps", events.floor_steps);
  if (simulator.config().exact_savings == ExactSavings::kCheck) values.add("savings differences", events.savings_differences);
  values.add("command timeouts", events.command_timeouts);
  values.add("dropped commands", facts.dropped_commands);
  values.add("last dropped command", facts.last_refusal.empty() ? "none" : facts.last_refusal);
  values.add("jumps of the followed clock", facts.clock_jumps);
  values.add("state hash", hashText(simulator.stateHash()));
  return status;
}

}  // namespace ellipsoid_vehicle_sim
