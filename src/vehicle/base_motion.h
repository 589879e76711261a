#pragma once

#include <Eigen/Core>

#include "ellipsoid_vehicle_sim/geometry/pose.h"

namespace ellipsoid_vehicle_sim {

// The base's part of Motion and MotionRate, and the arithmetic of steps on it: written once, so that the whole model and a
// flight without it agree to the last bit. Templates take both.

struct BaseMotion {
  Pose X_WB;
  Eigen::Vector3d v_WB, w_WB;
};
struct BaseRate {
  Eigen::Vector3d v, w, a, alpha;
};

/// Weights of the classical method, as those sum them that do not combine in place.
constexpr double kRk4Weights[4] = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0};

/// exp(r) q, a unit quaternion like q. What is off by rounding needs no root: one step of Newton's method for 1 / |q|.
inline Eigen::Quaterniond turnedBy(const Eigen::Vector3d& r, const Eigen::Quaterniond& q) {
  Eigen::Quaterniond turned = quaternionFromRotationVector(r) * q;
  turned.coeffs() *= 1.5 - 0.5 * turned.squaredNorm();
  return turned;
}

// A call for each stage is a twentieth of a flight's time.
template <typename State, typename Rate>
[[gnu::always_inline]] inline void retractBase(const State& x, double h, const Rate& k, State& result) {
  result.X_WB.p = x.X_WB.p + h * k.v;
  result.X_WB.q = turnedBy(h * k.w, x.X_WB.q);
  result.v_WB = x.v_WB + h * k.a;
  result.w_WB = x.w_WB + h * k.alpha;
}

template <typename State, typename Rate>
void advanceBaseVelocities(double h, const Rate& k, State& x) {
  x.v_WB += h * k.a;
  x.w_WB += h * k.alpha;
}

template <typename State, typename Rate>
void advanceBasePositions(double h, const Rate& k, State& x) {
  x.X_WB.p += h * k.v;
  x.X_WB.q = turnedBy(h * k.w, x.X_WB.q);
}

/// (a + 2 b + 2 c + d) / 6, of numbers and vectors.
template <typename Value>
Value rk4Mean(const Value& a, const Value& b, const Value& c, const Value& d) {
  return (1.0 / 6.0) * ((a + d) + 2.0 * (b + c));
}

template <typename Rate>
void combineBase(Rate (&k)[4]) {
  k[0].v = rk4Mean(k[0].v, k[1].v, k[2].v, k[3].v);
  k[0].w = rk4Mean(k[0].w, k[1].w, k[2].w, k[3].w);
  k[0].a = rk4Mean(k[0].a, k[1].a, k[2].a, k[3].a);
  k[0].alpha = rk4Mean(k[0].alpha, k[1].alpha, k[2].alpha, k[3].alpha);
}

/// sum = w value for the `first`, else sum += w value.
template <typename Value>
void addWeighted(double w, const Value& value, bool first, Value& sum) {
  if (first) {
    sum = w * value;
  } else {
    sum += w * value;
  }
}

template <typename Rate>
void addBase(double w, const Rate& k, bool first, Rate& sum) {
  addWeighted(w, k.v, first, sum.v);
  addWeighted(w, k.w, first, sum.w);
  addWeighted(w, k.a, first, sum.a);
  addWeighted(w, k.alpha, first, sum.alpha);
}

}  // namespace ellipsoid_vehicle_sim
