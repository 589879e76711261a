#include "ellipsoid_vehicle_sim/vehicle/free_flight.h"

#include <algorithm>
#include <cmath>

#include "base_motion.h"
#include "ellipsoid_vehicle_sim/dynamics/integrator.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

// The air is asked for this many ticks ahead, not further than this many times the body's own size; and again so many
// ticks after it was not free.
constexpr double kTicksAhead = 50.0, kSizesAhead = 4.0;
constexpr int kPatience = 8;
// Room for rounding and for what the parabola bends within a tick, in parts of the body's reach.
constexpr double kMargin = 1e-3;

// One rigid body, its base alone; see integrator.h for what the names mean.
class FlightSystem {
 public:
  using State = BaseMotion;
  using Rate = BaseRate;

  FlightSystem(const FreeTurning& turning, const Vector3d& gravity_W) : turning_(turning), gravity_W_(gravity_W) {}

  void rate(const State& x, double, Rate& k) const {
    k.v = x.v_WB;
    k.w = x.w_WB;
    k.a = gravity_W_;
    k.alpha = turning_.acceleration(columns(x.X_WB.q.toRotationMatrix()), Vec3::from(x.w_WB)).toEigen();
  }
  void positionRates(const State& x, Rate& k) const {
    k.v = x.v_WB;
    k.w = x.w_WB;
  }
  void advance(const State& x, double h, const Rate& k, State& result) const { retractBase(x, h, k, result); }
  void advanceVelocities(State& x, double h, const Rate& k) const { advanceBaseVelocities(h, k, x); }
  void advancePositions(State& x, double h, const Rate& k) const { advanceBasePositions(h, k, x); }
  void toTangent(double h, const Rate& previous, Rate& k) const { k.w = rotationVectorRate(h * previous.w, k.w); }
  void combine(Rate (&k)[4]) const { combineBase(k); }

 private:
  const FreeTurning& turning_;
  Vector3d gravity_W_;
};

// As rk4_events sums its stages; otherwise rk4Step.
void rk4StepOfEvents(const FlightSystem& system, BaseMotion& x, double h, BaseRate (&k)[4], BaseMotion& scratch) {
  system.rate(x, 0.0, k[0]);
  for (int stage = 1; stage < 4; ++stage) {
    const double fraction = stage < 3 ? 0.5 : 1.0;
    system.advance(x, fraction * h, k[stage - 1], scratch);
    system.rate(scratch, fraction, k[stage]);
    system.toTangent(fraction * h, k[stage - 1], k[stage]);
  }
  BaseRate sum;
  for (int s = 0; s < 4; ++s) addBase(kRk4Weights[s], k[s], s == 0, sum);
  scratch = x;
  system.advance(scratch, h, sum, x);
}

}  // namespace

FreeTurning::FreeTurning(const Symmetric3& I)
    : I_(I), principal_(I.xy == 0.0 && I.xz == 0.0 && I.yz == 0.0), lyx_(I.xy / I.xx), lzx_(I.xz / I.xx), inverse_x_(1.0 / I.xx) {
  const double dy = I.yy - lyx_ * I.xy;
  inverse_y_ = 1.0 / dy;
  lzy_ = (I.yz - lzx_ * I.xy) * inverse_y_;
  inverse_z_ = 1.0 / (I.zz - lzx_ * I.xz - lzy_ * lzy_ * dy);
  ratio_ = {(I.yy - I.zz) / I.xx, (I.zz - I.xx) / I.yy, (I.xx - I.yy) / I.zz};
}

Vec3 FreeTurning::acceleration(const Frame3& R_WB, const Vec3& w_W) const {
  const Vec3 w = toFrame(R_WB, w_W);
  if (principal_) return fromFrame(R_WB, Vec3{ratio_.x * (w.y * w.z), ratio_.y * (w.z * w.x), ratio_.z * (w.x * w.y)});
  const Vec3 b = cross(I_ * w, w);
  const double by = b.y - lyx_ * b.x;
  const double z = (b.z - lzx_ * b.x - lzy_ * by) * inverse_z_;
  const double y = by * inverse_y_ - lzy_ * z;
  return fromFrame(R_WB, Vec3{b.x * inverse_x_ - lyx_ * y - lzx_ * z, y, z});
}

FreeFlight::FreeFlight(const VehicleModel& model, const SimConfig& config, const Terrain& terrain)
    : config_(config), terrain_(terrain), turning_(Symmetric3::from(model.bodies[0].inertia.I_cm_A)) {
  const bool whole = config.integrator != IntegratorKind::kDormandPrince && config.integrator != IntegratorKind::kLinearlyImplicit;
  possible_ = config.saves() && whole && model.bodies.size() == 1 && config.drag_area == 0.0;
  for (const ModelEllipsoid& e : model.ellipsoids) reach_ = std::max(reach_, e.X_BE.p.norm() + e.radii.maxCoeff());
}

// Whether no triangle's box meets the body's ball on its way.
bool FreeFlight::isFree(const Motion& x, double dt) {
  const Vector3d& p = x.X_WB.p;
  const Vector3d way = dt * x.v_WB;
  const double room = reach_ * (1.0 + kMargin) + config_.gravity * dt * dt;
  Eigen::AlignedBox3d swept(Vector3d(p.array() - room), Vector3d(p.array() + room));
  swept.extend(Vector3d((p + way).array() - room)).extend(Vector3d((p + way).array() + room));
  if (empty_.contains(swept)) return true;
  if (patience_ > 0) {
    --patience_;
    return false;
  }
  Eigen::AlignedBox3d ahead = swept;
  const double most = kSizesAhead * room;
  const Vector3d further = (kTicksAhead * way).cwiseMin(most).cwiseMax(-most);
  ahead.extend(Vector3d(swept.min() + further)).extend(Vector3d(swept.max() + further));
  if (!terrain_.mayMeet(ahead)) {
    empty_ = ahead;
    return true;
  }
  if (!terrain_.mayMeet(swept)) {
    empty_ = swept;
    return true;
  }
  patience_ = kPatience;
  return false;
}

bool FreeFlight::advance(VehicleState& state) {
  if (!possible_) return false;
  for (const ContactMemory& memory : state.memory)
    if (memory.fresh || memory.count > 0) return false;
  Motion& motion = state.motion;
  if (!isFree(motion, config_.dt)) return false;
  const FlightSystem system(turning_, {0.0, 0.0, -config_.gravity});
  BaseMotion x{motion.X_WB, motion.v_WB, motion.w_WB}, scratch;
  BaseRate k[4];
  switch (config_.integrator) {
    case IntegratorKind::kExplicitEuler: explicitEulerStep(system, x, config_.dt, k, scratch); break;
    case IntegratorKind::kSemiImplicitEuler: semiImplicitEulerStep(system, x, config_.dt, k, scratch); break;
    case IntegratorKind::kRk4: rk4Step(system, x, config_.dt, k, scratch); break;
    default: rk4StepOfEvents(system, x, config_.dt, k, scratch); break;
  }
  motion.X_WB = x.X_WB;
  motion.v_WB = x.v_WB;
  motion.w_WB = x.w_WB;
  return true;
}

}  // namespace ellipsoid_vehicle_sim
