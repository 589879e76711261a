#include "ellipsoid_vehicle_sim/vehicle/profile.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ellipsoid_vehicle_sim {
namespace {

// Shorter parts of a path are rounding: in parts of the tick, and of the time that the distance's own rounding stands for.
constexpr double kNoTime = 1e-6, kRoundings = 4.0;

// The parts of a path that lie within the coming tick, at most two of them; more are counted only.
struct Parts {
  double acceleration[2] = {0.0, 0.0};
  double until = 0.0;  // the first one's end [s]
  int count = 0;
  double left = 0.0;      // of the tick [s]
  double shortest = 0.0;  // [s]

  void add(double a, double duration) {
    if (duration < shortest || left <= 0.0) return;
    if (count < 2) acceleration[count] = a;
    if (count == 0) until = duration;
    ++count;
    left -= duration;
  }
};

// Its parts from here on; `rounding` is that of the distance.
Parts fastestPath(double distance, double v, double V, double A, double dt, double rounding) {
  // Towards the place where the target can be met from: forward from here on, s = 1, or back.
  const double s = distance - 0.5 * v * std::abs(v) / A >= 0.0 ? 1.0 : -1.0;
  const double x = s * distance, w = s * v;
  Parts parts;
  parts.left = dt;
  parts.shortest = std::max(kNoTime * dt, kRoundings * std::sqrt(rounding / A));
  if (w > V * (1.0 + 1e-12)) {
    parts.add(-s * A, (w - V) / A);
    parts.add(0.0, (x - 0.5 * w * w / A) / V);
  } else {
    const double peak = std::sqrt(std::max(0.0, A * x + 0.5 * w * w));
    const double top = std::min(peak, V);
    parts.add(s * A, (top - w) / A);
    if (peak > V) parts.add(0.0, (x - (V * V - 0.5 * w * w) / A) / V);
    parts.add(-s * A, top / A);
  }
  parts.add(0.0, std::max(dt, parts.shortest));
  return parts;
}

}  // namespace

void carryProfile(double h, bool ends_tick, ProfileState& profile) {
  const ProfilePoint end = profileAt(profile, h);
  profile.position = end.position;
  profile.velocity = end.velocity;
  profile.until = std::max(0.0, profile.until - h);
  if (ends_tick) setProfile(0.0, profile);
}

void setProfile(double acceleration, ProfileState& profile) {
  profile.acceleration = profile.then = acceleration;
  profile.until = 0.0;
}

void planProfile(const PrescribedJoint& joint, double max_speed, double dt, ProfileState& profile) {
  const double distance = profile.target - profile.position, A = joint.max_acceleration;
  if (std::isfinite(A) && A > 0.0 && max_speed > 0.0) {
    const double rounding = std::numeric_limits<double>::epsilon() * std::max(std::abs(profile.target), std::abs(profile.position));
    const Parts parts = fastestPath(distance, profile.velocity, max_speed, A, dt, rounding);
    if (parts.count == 1) return setProfile(parts.acceleration[0], profile);
    if (parts.count == 2) {
      profile.acceleration = parts.acceleration[0];
      profile.until = parts.until;
      profile.then = parts.acceleration[1];
      return;
    }
  }
  setProfile(profileChange(distance, profile.velocity, max_speed, A, dt), profile);
}

double profileChange(double distance, double rate, double max_rate, double max_change, double dt) {
  const double A = max_change;
  // Rate at the end of the tick from which the quantity can still stop at its target: what is left after this tick, with
  // one more tick at that rate, is the braking distance v^2 / (2 A). Solved for v; near the target it is dead-beat.
  const double left = distance - 0.5 * rate * dt;
  const double v = std::copysign(A * (std::sqrt(dt * dt + 2.0 * std::abs(left) / A) - dt), left);
  const double wanted = std::clamp(v, -max_rate, max_rate);
  return std::clamp((wanted - rate) / dt, -A, A);
}

}  // namespace ellipsoid_vehicle_sim
