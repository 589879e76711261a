#pragma once

#include "ellipsoid_vehicle_sim/vehicle/vehicle_model.h"
#include "ellipsoid_vehicle_sim/vehicle/vehicle_state.h"

namespace ellipsoid_vehicle_sim {

// Paths of prescribed joints: to the target as fast as the limits of speed and acceleration allow, the same path whatever the
// tick. Within a tick the acceleration is constant, or changes once.

/// Where a joint on a path is `ahead` seconds from the moment of the state, within the tick.
struct ProfilePoint {
  double position, velocity, acceleration;
};
inline ProfilePoint profileAt(const ProfileState& p, double ahead) {
  const double first = ahead < p.until ? ahead : p.until, rest = ahead - first;
  const double position = p.position + first * (p.velocity + 0.5 * first * p.acceleration);
  const double velocity = p.velocity + first * p.acceleration;
  return {position + rest * (velocity + 0.5 * rest * p.then), velocity + rest * p.then, ahead < p.until ? p.acceleration : p.then};
}

/// Takes the path on by h seconds, within the tick or to its end.
void carryProfile(double h, bool ends_tick, ProfileState& profile);

/// Chooses the acceleration of the coming tick for the profile's target; `max_speed` may be less than the joint's own. The
/// path is the fastest one (full acceleration, full speed, full deceleration), its corners where they belong and not at the
/// next tick. Where more than one corner falls into the tick (moves of a tick or two) and at the very end it is dead-beat:
/// without overshoot, and exactly at the target.
void planProfile(const PrescribedJoint& joint, double max_speed, double dt, ProfileState& profile);

/// One acceleration for all of the coming tick.
void setProfile(double acceleration, ProfileState& profile);

/// How the rate of any quantity must change over a tick to bring `distance` to zero within the limits of both; dead-beat near
/// the end, later than the fastest path by up to two ticks.
double profileChange(double distance, double rate, double max_rate, double max_change, double dt);

}  // namespace ellipsoid_vehicle_sim
