// What slows a vehicle down without touching friction's cone: rolling resistance of its wheels, and drag of the air. Both
// absent unless asked for, and then not paid for.
#include <algorithm>
#include <cmath>

#include "ellipsoid_vehicle_sim/vehicle/vehicle_dynamics.h"

namespace ellipsoid_vehicle_sim {
namespace {

// Below this speed the rolling resistance falls in proportion: what stands is not pushed [m/s].
constexpr double kRollingFrom = 0.02;

double share(double speed) { return std::clamp(speed / kRollingFrom, -1.0, 1.0); }

}  // namespace

// The moment c f_n R against the turning, from the ground on the wheel. A tread has no mass to turn: the moment is passed on
// as the force c f_n on its axle.
void VehicleDynamics::applyRollingResistance(const Motion& x) {
  for (const WheelUnit& wheel : model_.drive.wheels) {
    double normal = 0.0;
    const ActiveContact* deepest = nullptr;
    for (const ActiveContact& active : active_) {
      if (active.ellipsoid != wheel.ellipsoid || active.force.normal <= 0.0) continue;
      normal += active.force.normal;
      if (!deepest || active.force.normal > deepest->force.normal) deepest = &active;
    }
    if (!deepest) continue;
    const int body = model_.ellipsoids[wheel.ellipsoid].body;
    const double force = config_.rolling_resistance * normal;
    if (wheel.joint >= 0) {
      const double moment = force * wheel.radius * share(x.qd[wheel.joint] * wheel.radius);
      const BodyKinematics& k = tree_.kinematics(body);
      tree_.addMoment(body, -moment * k.axis.angular);
      resisted_.lost += moment * dot(k.axis.angular, k.velocity.angular);
      continue;
    }
    const Vec3 along = cross(axleOf(wheel.tread, body), Vec3::from(deepest->contact.nhat_W));
    const double length = norm(along);
    if (length < 1e-9) continue;
    const Vec3 direction = (1.0 / length) * along;
    const Vec3 p_OE = Vec3::from(posed_[wheel.ellipsoid].p_WE) - Vec3::from(x.X_WB.p);
    const bool turning = frozen_->treads[wheel.tread].mode == TreadState::Mode::kTurning;
    // Forward along `direction` means turning about the axle in the positive sense.
    const double speed = turning ? treadSpeed(wheel.tread) * wheel.radius : dot(direction, pointVelocity(x, body, p_OE));
    const Vec3 f_W = -force * share(speed) * direction;
    tree_.addForce(body, toFrame(R_WB_, p_OE), toFrame(R_WB_, f_W));
    resisted_.lost -= dot(f_W, pointVelocity(x, body, p_OE));
  }
}

// rho / 2 c_d A v^2 against the motion, at the centre of mass of the base; the air stands still.
void VehicleDynamics::applyDrag(const Motion& x) {
  const Vec3 v = Vec3::from(x.v_WB);
  const double resistance = 0.5 * config_.air_density * config_.drag_area * norm(v);
  tree_.addForce(0, Vec3{0.0, 0.0, 0.0}, toFrame(R_WB_, -resistance * v));
  resisted_.lost += resistance * squaredNorm(v);
}

}  // namespace ellipsoid_vehicle_sim
