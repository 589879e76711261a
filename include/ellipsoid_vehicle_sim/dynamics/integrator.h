#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace ellipsoid_vehicle_sim {

/// Rate of the rotation vector r of q = exp(r) q0 when q turns with the angular velocity w, both in the fixed frame:
/// the inverse of the exponential's derivative, r' = w - r x w / 2 + c r x (r x w) [Iserles2000, eq. B.10].
inline Eigen::Vector3d rotationVectorRate(const Eigen::Vector3d& r, const Eigen::Vector3d& w) {
  const double angle2 = r.squaredNorm();
  // c = 1/angle^2 - cot(angle/2) / (2 angle); its series where the difference would lose its digits.
  double c = 1.0 / 12.0 + angle2 * (1.0 / 720.0);
  if (angle2 > 1e-3) {
    const double angle = std::sqrt(angle2);
    c = (1.0 - 0.5 * angle / std::tan(0.5 * angle)) / angle2;
  }
  const Eigen::Vector3d rw = r.cross(w);
  return w - 0.5 * rw + c * r.cross(rw);
}

/// One-step methods over a System that knows its own states. No physics in here. System must provide:
///   using State, Rate;
///   void rate(const State& x, double fraction, Rate& k)          k = f(x) at `fraction` of the step, 0 ... 1
///   void positionRates(const State& x, Rate& k)                  only the position-like part of k, from x's
///   velocities,
///                                                                everything else as in the last rate()
///   void advance(const State& x, double h, const Rate& k, State& result)     result = x "+" h k on the manifold
///   void advanceVelocities(State& x, double h, const Rate& k), advancePositions(State& x, double h, const Rate& k)
///   void toTangent(double h, const Rate& previous, Rate& k)      k as a rate of the increment, at the increment h
///   previous void combine(Rate (&k)[4])                                   k0 = (k0 + 2 k1 + 2 k2 + k3) / 6

/// Order 1: x + dt f(x). Unstable for every step on an undamped oscillator: the baseline whose drift is to be seen.
template <typename System>
void explicitEulerStep(System& system, typename System::State& x, double dt, typename System::Rate (&k)[4],
                       typename System::State& scratch) {
  system.rate(x, 0.0, k[0]);
  scratch = x;
  system.advance(scratch, dt, k[0], x);
}

/// Order 1, symplectic for conservative forces: velocities first, positions with the new velocities.
template <typename System>
void semiImplicitEulerStep(System& system, typename System::State& x, double dt, typename System::Rate (&k)[4],
                           typename System::State&) {
  system.rate(x, 0.0, k[0]);
  system.advanceVelocities(x, dt, k[0]);
  system.positionRates(x, k[0]);
  system.advancePositions(x, dt, k[0]);
}

/// Order 4, the classical method; on the rotation as a Runge-Kutta-Munthe-Kaas method [MuntheKaas1999].
template <typename System>
void rk4Step(System& system, typename System::State& x, double dt, typename System::Rate (&k)[4],
             typename System::State& scratch) {
  system.rate(x, 0.0, k[0]);
  system.advance(x, 0.5 * dt, k[0], scratch);
  system.rate(scratch, 0.5, k[1]);
  system.toTangent(0.5 * dt, k[0], k[1]);
  system.advance(x, 0.5 * dt, k[1], scratch);
  system.rate(scratch, 0.5, k[2]);
  system.toTangent(0.5 * dt, k[1], k[2]);
  system.advance(x, dt, k[2], scratch);
  system.rate(scratch, 1.0, k[3]);
  system.toTangent(dt, k[2], k[3]);
  system.combine(k);
  scratch = x;
  system.advance(scratch, dt, k[0], x);
}

}  // namespace ellipsoid_vehicle_sim
