#pragma once

#include <cstdint>
#include <vector>

#include "ellipsoid_vehicle_sim/dynamics/dense_solve.h"
#include "ellipsoid_vehicle_sim/dynamics/embedded_pair.h"
#include "ellipsoid_vehicle_sim/vehicle/free_flight.h"
#include "ellipsoid_vehicle_sim/vehicle/vehicle_dynamics.h"

namespace ellipsoid_vehicle_sim {

/// What came of a tick.
struct TickOutcome {
  bool sane = true;          ///< false: the state is not to be used.
  int passed_through = 0;    ///< ellipsoid centres that went through a triangle.
  int effort_exceeded = 0;   ///< prescribed joints that needed more than their limit.
  int steps = 0;             ///< accepted steps; 1 for the methods that take the tick as a whole.
  int floor_steps = 0;       ///< of these, taken at the smallest size although they did not hold what the method promises.
};

/// Takes a state over one tick with the configured integrator. Steps within the tick begin and end in it; the contact
/// memory changes where a step is accepted, commands only with the tick. Nothing is kept from tick to tick: the same state
/// gives the same bits. Takes no memory.
class TickStepper {
 public:
  /// The arguments must outlive it.
  TickStepper(const VehicleModel& model, const SimConfig& config, VehicleDynamics& dynamics);

  /// The drive of `state` is that of the tick already (updateDrive). `before` gets the contact memory of the tick's start
  /// (what stood there is room for a new one). Where the outcome is not sane, that is also put back into the state; its
  /// motion, paths and treads are then of no use. `ends_tick` false: paths and treads go on accelerating after it.
  TickOutcome advance(VehicleState& state, std::vector<ContactMemory>& before, bool ends_tick = true);

  /// Takes over `next` as the end of a step of h seconds that was worked out elsewhere, with these dynamics; what else
  /// advance() says of `before` and of an outcome that is not sane holds.
  void endStep(VehicleState& state, const Motion& next, double h, std::vector<ContactMemory>& before, TickOutcome& outcome);

 private:
  bool takeFlight(VehicleState& state, TickOutcome& outcome);
  void takeWhole(VehicleState& state, TickOutcome& outcome);
  void takeDormandPrince(VehicleState& state, TickOutcome& outcome);
  void takeRk4Events(VehicleState& state, TickOutcome& outcome);          // contact_events.cpp
  // linearly_implicit.cpp
  void takeLinearlyImplicit(VehicleState& state, TickOutcome& outcome);
  bool implicitStep(const VehicleState& state, double h);
  double implicitResidual(const VehicleState& state, double h) const;

  // Takes over `next` as the end of a step of h seconds.
  void accept(VehicleState& state, const Motion& next, double h, bool last, TickOutcome& outcome);
  static void giveUp(VehicleState& state, std::vector<ContactMemory>& before, const TickOutcome& outcome);
  double errorOf(double h) const;

  // What a trial step of rk4_events met.
  struct Trial {
    bool smooth = false;         // nothing began or ceased to press on its way
    bool ends_as_begun = false;  // and at its end the same contacts press as at its start
    int changed = -1;            // the first ellipsoid that does not, -1 without
  };
  struct Touch {
    bool known = false;  // the ellipsoid touches the ground
    double depth = 0.0;  // that the spring feels [m]
    double push = 0.0;   // force over stiffness, negative where the damper would pull [m]
    double speed = 0.0;  // of the depth [m/s]
  };
  std::uint64_t pressing() const;
  Touch touchOf(const Motion& x, int ellipsoid) const;
  bool rk4From(const VehicleState& state, double h);
  Trial tryStep(const VehicleState& state, double h);
  double locate(const VehicleState& state, int ellipsoid, double h, double& after);
  double nextStep(const VehicleState& state, double h, double& crossing, TickOutcome& outcome);

  const VehicleModel& model_;
  const SimConfig& config_;
  VehicleDynamics& dynamics_;
  std::vector<ContactMemory>* before_ = nullptr;
  bool ends_tick_ = true;
  MotionRate k_[4], stages_[dormand_prince::kStages], sum_, error_;
  Motion trial_, scratch_;
  std::vector<double> joint_arm_;        // what a joint's turn moves, times this [m]
  double reach_ = 0.0;                   // from the base to the farthest point of the vehicle, about [m]
  bool always_substep_;                  // joints may be stiff without any contact, too
  std::uint64_t pressed_ = 0;            // ellipsoids that press at the start of the step, a bit each
  std::vector<Touch> start_touch_;       // and how they do
  double trial_length_ = 0.0;            // of the step that trial_ ends [s]
  int located_ = 0;                      // events in this tick
  DenseSystem implicit_;
  FreeFlight flight_;
  std::vector<MotionRate> directions_;   // linearly_implicit: what a unit of each speed moves
};

}  // namespace ellipsoid_vehicle_sim
