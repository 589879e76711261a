#pragma once

#include <memory>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/vehicle/simulator.h"
#include "ellipsoid_vehicle_sim/vehicle/tick_stepper.h"
#include "ellipsoid_vehicle_sim/vehicle/vehicle_dynamics.h"
#include "local_error.h"
#include "savings_check.h"

namespace ellipsoid_vehicle_sim {

/// A vehicle in its world. A tick is beginTick(), then restTick(), or the way over it and endTick(): a fleet takes vehicles
/// that may touch each other that way together, and leaves each what it feels of the others.
struct Simulator::Impl {
  SimConfig config;
  VehicleModel model;
  std::shared_ptr<const Terrain> terrain;
  StabilityCertificate certificate;
  std::unique_ptr<VehicleDynamics> dynamics;   // of the steps
  std::unique_ptr<VehicleDynamics> observer;   // of the readings: asking changes nothing
  VehicleState state, previous, home;
  std::unique_ptr<TickStepper> stepper;
  MotionRate observed;
  std::int64_t step_count = 0;
  StepStatus status = StepStatus::kOk;
  StepEvents events;
  double friction_scale = 1.0;
  double energy_at_start = 0.0;  // with energy_balance only
  std::vector<std::string> joint_names;
  std::vector<EllipsoidPlacement> placements;
  std::vector<std::string> load_report;
  bool observed_fresh = false;
  std::unique_ptr<LocalErrorEstimator> estimator;  // with error_estimate_every, or beside one that has it
  ErrorEstimate estimate;
  std::unique_ptr<SavingsCheck> savings_check;  // with exact_savings: checked, or beside one that has it
  bool resting = false;
  bool driven = true;  // there is something that a command could move
  std::vector<ContactReport> touched;    // contacts with other vehicles at the present state
  std::vector<ExternalForce> outside;    // and what they press with
  std::int64_t times_placed = 0;         // the motion did not come about by itself so often

  void allocate();
  void certifyVehicle();
  void tellTouchDown();
  Problems checkStep() const;

  StepStatus step();
  /// Takes the command for the tick and decides whether the vehicle rests in it. True: the command got too old in it.
  bool beginTick();
  void restTick(bool timed_out);
  /// The state is that of the tick's end already, if the outcome is sane; otherwise it becomes that of its start.
  StepStatus endTick(const TickOutcome& outcome, bool timed_out);
  bool estimatesNow() const {
    return config.error_estimate_every > 0.0 && (step_count + 1) % static_cast<std::int64_t>(config.error_estimate_every) == 0;
  }
  bool checksSavings() const { return config.exact_savings == ExactSavings::kCheck; }
  /// Made where they are not there yet: this vehicle takes the tick with one that asks for them.
  LocalErrorEstimator& needEstimator();
  SavingsCheck& needSavingsCheck();

  /// Asked where everything is still: once, for nothing changes then.
  bool balanced();
  void observe();
  void becomeHome(const VehicleState& placed);
  void restart();
  void beginAccount();
  double energy();
  /// What was felt of other vehicles is of another place.
  void forgetOthers();
};

}  // namespace ellipsoid_vehicle_sim
