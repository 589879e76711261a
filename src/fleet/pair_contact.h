#pragma once

#include "ellipsoid_vehicle_sim/contact/contact_force.h"
#include "ellipsoid_vehicle_sim/fleet/fleet.h"
#include "ellipsoid_vehicle_sim/geometry/ellipsoid_ellipsoid.h"
#include "ellipsoid_vehicle_sim/vehicle/tick_stepper.h"
#include "ellipsoid_vehicle_sim/vehicle/vehicle_dynamics.h"

namespace ellipsoid_vehicle_sim {

/// One side of a pair while it is evaluated.
struct PairSide {
  const VehicleDynamics* dynamics = nullptr;
  const Motion* motion = nullptr;
  int ellipsoid = 0;

  const PosedEllipsoid& posed() const { return dynamics->posedEllipsoids()[ellipsoid]; }
};

/// Two ellipsoids of two vehicles that could touch within the tick.
struct PairCandidate {
  int member[2] = {0, 0};   ///< places in the fleet, the lower id first.
  int at[2] = {0, 0};       ///< and among the vehicles of its island.
  bool known = false;       ///< touched at the last accepted step: memory holds.
  PairMemory memory;        ///< names the pair in any case.
  Eigen::Vector3d p_start = Eigen::Vector3d::Zero();  ///< first centre from the second at the step's start [m].

  bool pressed_at_start = false;  ///< of a step of rk4_events,
  Touch touch_at_start;           ///< and how.

  // Of the last evaluation.
  EllipsoidPairContact contact;
  double pressed = 0.0;               ///< what the spring feels of the depth [m].
  ContactForce force;                 ///< on the first.
  Eigen::Vector3d p_WC, f_W;          ///< where both springs meet, and the whole force on the first there.
};

/// Law of a contact between two ellipsoids: both springs in series, see Fleet.
ContactLaw pairLaw(const ContactLaw& first, const ContactLaw& second);
FrictionCoefficients pairFriction(const FrictionCoefficients& first, const FrictionCoefficients& second);

/// Contact and force at the poses and velocities that both sides were last posed at; `anchor_W` is the stretch as it
/// integrates. False: they do not touch.
bool evaluatePair(const PairSide& first, const PairSide& second, const Eigen::Vector3d& anchor_W, PairCandidate& pair);

/// Only the force anew, for other velocities at the same poses.
void updatePairForce(const PairSide& first, const PairSide& second, const Eigen::Vector3d& anchor_W, PairCandidate& pair);

/// Ends a step of h seconds: memory, slack and anchor at the new poses. Afterwards the force is that of the new state.
void acceptPair(const PairSide& first, const PairSide& second, const Eigen::Vector3d& anchor_W, double h,
                PairCandidate& pair);

/// How the pair presses, as last evaluated.
Touch touchOf(const PairSide& first, const PairSide& second, const PairCandidate& pair);

/// A vehicle was put where it is: an overlap is taken with slack.
void takeWithSlack(const PosedEllipsoid& first, const PosedEllipsoid& second, PairCandidate& pair);

/// The first's centre went through the second in this step without having been stopped.
bool passedThrough(const PosedEllipsoid& first, const PosedEllipsoid& second, const PairCandidate& pair,
                   const Eigen::Vector3d& nhat_before_W, bool known_before);

/// Elastic energy of a contact as last evaluated [J].
double pairEnergy(const PairCandidate& pair, const ContactLaw& law);

}  // namespace ellipsoid_vehicle_sim
