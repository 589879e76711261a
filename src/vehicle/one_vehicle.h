#pragma once

#include "ellipsoid_vehicle_sim/vehicle/tick_stepper.h"

namespace ellipsoid_vehicle_sim {

/// One vehicle within a tick, as the methods see it that size their steps within it (error_control.h, contact_events.h,
/// linearly_implicit.h). IslandStepper offers the same for vehicles that touch each other:
///   System, State, Rate, Buffers     as in integrator.h, embedded_pair.h and tick_stepper.h
///   start(), beginStep(h)            the motion that the step starts from; what is frozen for a step of h seconds
///   accept(x, h, last)               takes x over as the end of the step; false: it cannot be used, the tick is over
///   noteContacts() ... touchOf()     which contacts press, by a number each; at the start, and at the last rate()
///   speed(), findDirections(), findColumn()    all speeds by a number each; see LinearlyImplicit
class OneVehicle {
 public:
  using System = VehicleDynamics;
  using State = Motion;
  using Rate = MotionRate;
  using Buffers = TickStepper::Buffers;

  /// The drive of `state` is that of the tick. All arguments must outlive it.
  OneVehicle(TickStepper& stepper, VehicleDynamics& dynamics, const SimConfig& config, VehicleState& state,
             std::vector<ContactMemory>& before, bool ends_tick, TickOutcome& outcome)
      : stepper_(stepper),
        dynamics_(dynamics),
        config_(config),
        state_(state),
        before_(before),
        ends_tick_(ends_tick),
        outcome_(outcome) {}

  System& system() { return dynamics_; }
  Buffers& buffers() { return stepper_.buffers(); }
  double tickLength() const { return config_.dt; }
  int vehicles() const { return 1; }
  const State& start() const { return state_.motion; }
  void beginStep(double h) { dynamics_.beginStep(state_, h); }
  bool isSound(const State& x) const { return isSane(x); }
  void countFloorStep() { ++outcome_.floor_steps; }
  bool accept(const State& end, double h, bool last) {
    stepper_.accept(state_, end, h, last && ends_tick_, before_, outcome_);
    return outcome_.sane;
  }

  // dormand_prince.
  double tolerance() const { return config_.error_tolerance; }
  double errorOf(const Rate& error, double h) const { return stepper_.errorOf(error, h); }

  // rk4_events. A contact's number is its ellipsoid.
  double contactSubsteps() const { return config_.contact_substeps; }
  bool hasJoints() const { return stepper_.hasJoints(); }
  void noteContacts() { stepper_.noteContacts(state_.motion); }
  bool anyPressedAtStart() const { return stepper_.anyPressedAtStart(); }
  bool pressedAtStart(int contact) const { return stepper_.pressedAtStart(contact); }
  const Touch& touchAtStart(int contact) const { return stepper_.touchAtStart(contact); }
  bool pressAsNoted() const { return stepper_.pressAsNoted(); }
  int firstChanged() const { return stepper_.firstChanged(); }
  Touch touchOf(const State& x, int contact) const { return stepper_.touchOf(x, contact); }

  // linearly_implicit.
  DenseSystem& matrix() { return stepper_.matrix(); }
  double& speed(Rate& k, int i) const { return speedOf(k, i); }
  double speed(const State& x, int i) const { return speedOf(x, i); }
  void findDirections(double h, double delta) {
    stepper_.beginDirections();
    for (int j = 0; j < stepper_.speeds(); ++j) stepper_.findDirection(state_.motion, h, delta, j);
  }
  void beginColumns() {}
  /// Column j of the matrix becomes the speeds' rates at the trial moved along what a unit of speed j does, by `way`.
  void findColumn(int j, double way) {
    Buffers& b = stepper_.buffers();
    dynamics_.advance(b.trial, way, stepper_.direction(j), b.scratch);
    dynamics_.rate(b.scratch, 1.0, b.k[1]);
    for (int i = 0; i < stepper_.speeds(); ++i) stepper_.matrix().at(i, j) = speedOf(b.k[1], i);
  }
  void keepWork(double h) { stepper_.buffers().trial.work = state_.motion.work + h * stepper_.buffers().k[1].power; }
  double residual(double h) const { return stepper_.residual(state_.motion, h); }

 private:
  TickStepper& stepper_;
  VehicleDynamics& dynamics_;
  const SimConfig& config_;
  VehicleState& state_;
  std::vector<ContactMemory>& before_;
  bool ends_tick_;
  TickOutcome& outcome_;
};

}  // namespace ellipsoid_vehicle_sim
