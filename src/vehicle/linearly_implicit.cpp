#include "linearly_implicit.h"

#include "ellipsoid_vehicle_sim/vehicle/tick_stepper.h"

namespace ellipsoid_vehicle_sim {
namespace {

// A change of the speeds below this is none [m/s].
constexpr double kLeastChange = 1e-6;

void clear(MotionRate& k) {
  k.v.setZero();
  k.w.setZero();
  k.a.setZero();
  k.alpha.setZero();
  k.power = Work{};
  std::fill(k.q.begin(), k.q.end(), 0.0);
  std::fill(k.qd.begin(), k.qd.end(), 0.0);
  std::fill(k.stretch.begin(), k.stretch.end(), 0.0);
  for (Anchors& anchors : k.anchor)
    for (Eigen::Vector3d& z : anchors) z.setZero();
}

}  // namespace

double TickStepper::residual(const Motion& start, double h) const {
  double left = 0.0, change = kLeastChange;
  for (int i = 0; i < speeds(); ++i) {
    const double arm = i < 3 ? 1.0 : i < 6 ? reach_ : joint_arm_[static_cast<std::size_t>(i - 6)];
    const double gained = speedOf(buffers_.trial, i) - speedOf(start, i);
    left = std::max(left, arm * std::abs(gained - h * speedOf(buffers_.k[1], i)));
    change = std::max(change, arm * std::abs(gained));
  }
  return left / change;
}

void TickStepper::findDirection(const Motion& start, double h, double delta, int j) {
  MotionRate &sum = buffers_.sum, &direction = directions_[static_cast<std::size_t>(j)];
  clear(sum);
  speedOf(sum, j) = 1.0;
  buffers_.scratch = start;
  dynamics_.advanceVelocities(buffers_.scratch, delta, sum);
  dynamics_.positionRates(buffers_.scratch, buffers_.k[1]);
  const double difference[2] = {1.0 / delta, -1.0 / delta};
  dynamics_.weightedSum(difference, buffers_.k + 1, 2, direction);
  // Within the step a unit of speed stays one: as a rate, it comes about over h.
  direction.a = sum.a / h;
  direction.alpha = sum.alpha / h;
  for (std::size_t i = 0; i < direction.qd.size(); ++i) direction.qd[i] = sum.qd[i] / h;
}

}  // namespace ellipsoid_vehicle_sim
