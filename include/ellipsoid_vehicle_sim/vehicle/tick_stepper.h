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

/// Room for the stages of a step, and for its end.
template <typename State, typename Rate>
struct StepBuffers {
  Rate k[4], stages[dormand_prince::kStages], sum, error;
  State trial, scratch;
};

/// How a contact presses.
struct Touch {
  bool known = false;  ///< there is one.
  double depth = 0.0;  ///< that the spring feels [m].
  double push = 0.0;   ///< force over stiffness, negative where the damper would pull [m].
  double speed = 0.0;  ///< of the depth [m/s].
};

/// Takes a state over one tick with the configured integrator. Steps within the tick begin and end in it; the contact
/// memory changes where a step is accepted, commands only with the tick. Nothing is kept from tick to tick: the same state
/// gives the same bits. Takes no memory.
class TickStepper {
 public:
  using Buffers = StepBuffers<Motion, MotionRate>;

  /// The arguments must outlive it.
  TickStepper(const VehicleModel& model, const SimConfig& config, VehicleDynamics& dynamics);

  /// The drive of `state` is that of the tick already (updateDrive). `before` gets the contact memory of the tick's start
  /// (what stood there is room for a new one). Where the outcome is not sane, that is also put back into the state; its
  /// motion, paths and treads are then of no use. `ends_tick` false: paths and treads go on accelerating after it.
  TickOutcome advance(VehicleState& state, std::vector<ContactMemory>& before, bool ends_tick = true);

  // The rest is this vehicle's part of a step, for those who put steps together: one_vehicle.h, and island_stepper.h for several
  // vehicles at once. "At the last rate" is where the dynamics were evaluated last.

  /// Takes over `next` as the end of a step of h seconds, worked out with these dynamics. The tick's first gives `before` its
  /// contact memory.
  void accept(VehicleState& state, const Motion& next, double h, bool ends_tick, std::vector<ContactMemory>& before,
              TickOutcome& outcome);
  /// After an outcome that is not sane: what advance() says of `before` and the state.
  static void giveUp(VehicleState& state, std::vector<ContactMemory>& before, const TickOutcome& outcome);
  Buffers& buffers() { return buffers_; }

  /// What a step got wrong, as a length [m]: displacement of the base and of what turns with it, of the joints and of the
  /// friction, and what an error of the speeds moves in a while.
  double errorOf(const MotionRate& error, double h) const;

  // rk4_events (contact_events.cpp): which ellipsoids press, and how.
  /// The step starts at the last rate, x.
  void noteContacts(const Motion& x);
  bool anyPressedAtStart() const { return pressed_ != 0; }
  bool pressedAtStart(int ellipsoid) const;
  const Touch& touchAtStart(int ellipsoid) const { return start_touch_[static_cast<std::size_t>(ellipsoid)]; }
  /// At the last rate the same ones press as at the start.
  bool pressAsNoted() const { return pressing() == pressed_; }
  /// The first that does not; -1: none.
  int firstChanged() const;
  /// Of the ellipsoid's deepest contact at the last rate, x.
  Touch touchOf(const Motion& x, int ellipsoid) const;
  /// Joints may be stiff without any contact, too.
  bool hasJoints() const { return !model_.dynamic_joints.empty(); }

  // linearly_implicit (linearly_implicit.cpp): the base's velocity, its angular velocity, the joints' speeds.
  int speeds() const { return matrix_.size(); }
  DenseSystem& matrix() { return matrix_; }
  /// What a unit of speed j moves within a step of h from `start`, where k[0] is the rate: as a rate that comes about over h,
  /// by a difference of `delta`. beginDirections() before the first of a step.
  void beginDirections() { buffers_.k[2] = buffers_.k[0]; }
  void findDirection(const Motion& start, double h, double delta, int j);
  const MotionRate& direction(int j) const { return directions_[static_cast<std::size_t>(j)]; }
  /// What is left of v1 - v0 = h a(p1, v1) at the trial, whose rate k[1] is, over the largest change of a speed: both as speeds
  /// of points of the vehicle.
  double residual(const Motion& start, double h) const;

 private:
  bool takeFlight(VehicleState& state, std::vector<ContactMemory>& before, bool ends_tick, TickOutcome& outcome);
  std::uint64_t pressing() const;

  const VehicleModel& model_;
  const SimConfig& config_;
  VehicleDynamics& dynamics_;
  Buffers buffers_;
  std::vector<double> joint_arm_;        // what a joint's turn moves, times this [m]
  double reach_ = 0.0;                   // from the base to the farthest point of the vehicle, about [m]
  std::uint64_t pressed_ = 0;            // ellipsoids that press at the start of the step, a bit each
  std::vector<Touch> start_touch_;       // and how they do
  DenseSystem matrix_;
  FreeFlight flight_;
  std::vector<MotionRate> directions_;   // linearly_implicit alone
};

/// Speed i of TickStepper::speeds(), and its rate.
inline double speedOf(const Motion& x, int i) {
  if (i < 3) return x.v_WB[i];
  if (i < 6) return x.w_WB[i - 3];
  return x.qd[static_cast<std::size_t>(i - 6)];
}
inline double speedOf(const MotionRate& k, int i) {
  if (i < 3) return k.a[i];
  if (i < 6) return k.alpha[i - 3];
  return k.qd[static_cast<std::size_t>(i - 6)];
}
inline double& speedOf(MotionRate& k, int i) {
  if (i < 3) return k.a[i];
  if (i < 6) return k.alpha[i - 3];
  return k.qd[static_cast<std::size_t>(i - 6)];
}

}  // namespace ellipsoid_vehicle_sim
