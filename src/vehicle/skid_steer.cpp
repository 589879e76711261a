#include "ellipsoid_vehicle_sim/vehicle/skid_steer.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kMostSteps = 500;
constexpr double kBalanced = 1e-7;  // of the loads: what is left of the force
constexpr double kSlowest = 1e-6;   // rolling speed that still tells stretches apart [m/s]
constexpr double kCreep = 2e-3;     // of the fastest rim: slip at which what does not roll is at its cone, at the latest

// The forces are minus the gradient of a convex function of u = (v_x, v_y, w * size), the power that goes into slip: its
// minimum is the balance, and a damped Newton's method cannot miss it.
struct SlipPower {
  double value = 0.0;
  Vector3d gradient = Vector3d::Zero();
  Matrix3d curvature = Matrix3d::Zero();
};

SlipPower slipPower(const std::vector<SkiddingWheel>& wheels, double roll_of_free, double fastest, double size,
                    const Vector3d& u) {
  SlipPower sum;
  for (const SkiddingWheel& w : wheels) {
    // Slip over the ground, linear in u.
    Eigen::Matrix<double, 2, 3> S;
    S << 1.0, 0.0, -w.p.y() / size, 0.0, 1.0, w.p.x() / size;
    if (w.free) S.row(0).setZero();
    const Vector2d slip = S * u - Vector2d(w.free ? 0.0 : w.rim_speed, 0.0);
    // Without a brush any slip is soon at the cone.
    const bool brush = w.law.mode == FrictionMode::kBrush;
    const double roll = brush ? (w.free ? roll_of_free : std::abs(w.rim_speed)) : 0.0;
    const double limit = w.mu * w.load, speed = slip.norm();
    if (!(limit > 0.0)) continue;
    double gain = limit / (kCreep * fastest);
    if (brush) gain = std::min(gain, w.law.tangential_stiffness * w.law.brush_length / std::max(roll, kSlowest));
    if (gain * speed <= limit) {
      sum.value += 0.5 * gain * speed * speed;
      sum.gradient += gain * S.transpose() * slip;
      sum.curvature += gain * S.transpose() * S;
    } else {
      const Vector2d along = slip / speed;
      sum.value += limit * (speed - 0.5 * limit / gain);
      sum.gradient += limit * S.transpose() * along;
      sum.curvature += limit / speed * S.transpose() * (Matrix2d::Identity() - along * along.transpose()) * S;
    }
  }
  return sum;
}

}  // namespace

Vector2d forceOn(const SkiddingWheel& wheel, const PlanarVelocity& velocity) {
  const Vector3d u(velocity.v.x(), velocity.v.y(), velocity.yaw_rate);
  return -slipPower({wheel}, std::abs(velocity.v.x()), std::max(std::abs(wheel.rim_speed), velocity.v.norm()), 1.0, u).gradient.head<2>();
}

std::optional<PlanarVelocity> steadySkid(const std::vector<SkiddingWheel>& wheels) {
  // Length that turns the moment into a force of the same size [m].
  double size = 1e-3, load = 0.0, fastest = 1e-6, mean = 0.0;
  int driven = 0;
  for (const SkiddingWheel& w : wheels) {
    size = std::max(size, w.p.norm());
    load += w.mu * w.load;
    if (w.free) continue;
    fastest = std::max(fastest, std::abs(w.rim_speed));
    mean += w.rim_speed;
    ++driven;
  }
  if (!(load > 0.0) || driven == 0) return std::nullopt;
  mean /= driven;
  Vector3d u(mean, 0.0, 0.0);
  SlipPower at = slipPower(wheels, std::abs(mean), fastest, size, u);
  double damping = 1e-6 * load / fastest;
  for (int step = 0; step < kMostSteps && at.gradient.norm() > kBalanced * load; ++step) {
    const Vector3d next = u - (at.curvature + damping * Matrix3d::Identity()).ldlt().solve(at.gradient);
    const SlipPower there = slipPower(wheels, std::abs(mean), fastest, size, next);
    // Where the last digits of the power are rounding, the gradient goes on telling.
    const bool same = std::abs(there.value - at.value) <= 1e-12 * std::abs(at.value);
    const bool better = same ? there.gradient.norm() < at.gradient.norm() : there.value < at.value;
    if (next.allFinite() && better) {
      u = next;
      at = there;
      damping *= 0.2;
    } else {
      damping *= 5.0;
    }
  }
  if (!(at.gradient.norm() <= 1e-3 * load)) return std::nullopt;
  return PlanarVelocity{u.head<2>(), u.z() / size};
}

}  // namespace ellipsoid_vehicle_sim
