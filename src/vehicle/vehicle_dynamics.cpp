#include "ellipsoid_vehicle_sim/vehicle/vehicle_dynamics.h"

#include <algorithm>
#include <cmath>

#include "ellipsoid_vehicle_sim/contact/shortest_push.h"
#include "ellipsoid_vehicle_sim/dynamics/integrator.h"
#include "ellipsoid_vehicle_sim/vehicle/drive.h"
#include "base_motion.h"
#include "ellipsoid_vehicle_sim/vehicle/profile.h"

namespace ellipsoid_vehicle_sim {

using Eigen::Vector3d;

VehicleDynamics::VehicleDynamics(const VehicleModel& model, const SimConfig& config, const Terrain& terrain)
    : model_(model),
      config_(config),
      terrain_(terrain),
      options_{config.contact_rule, config.contacts_per_ellipsoid, config.contact_memory, config.candidate_cache && config.saves()},
      tree_(model.bodies, model.couplings),
      saves_(config.saves()),
      counts_(config.energy_balance),
      gravity_W_{0.0, 0.0, -config.gravity},
      prescribed_(std::max(model.prescribed_joints.size(), model.bodies.size())),
      posed_(model.ellipsoids.size()),
      retired_(model.ellipsoids.size()),
      contacts_(model.ellipsoids.size()),
      finder_(model.ellipsoids.size()),
      joint_effort_(model.dynamic_joints.size(), 0.0),
      motor_torque_(model.drive.wheels.size(), 0.0),
      hold_limit_(model.dynamic_joints.size(), 0.0) {
  if (model.bodies.size() == 1 && !hasDrag()) turning_.emplace(Symmetric3::from(model.bodies[0].inertia.I_cm_A));
  active_.reserve(model.ellipsoids.size() * kMaxContactsPerEllipsoid);
  for (const ModelEllipsoid& ellipsoid : model.ellipsoids) {
    // Of a body that no joint turns this holds for good.
    const BodyKinematics& k = tree_.kinematics(ellipsoid.body);
    const Vec3 p_BE = Vec3::from(ellipsoid.X_BE.p);
    mounts_.push_back({p_BE, fromFrame(k.R_OB, p_BE), fromFrame(k.R_OB, columns(ellipsoid.R_BE))});
    if (std::find(touching_bodies_.begin(), touching_bodies_.end(), ellipsoid.body) == touching_bodies_.end())
      touching_bodies_.push_back(ellipsoid.body);
  }
  moving_W_.resize(model.bodies.size());
  overrideFriction(std::nullopt);
  posed_at_.assign(7 + model.dynamic_joints.size() + model.prescribed_joints.size(), std::nan(""));
  moving_at_.assign(3 + model.dynamic_joints.size() + model.prescribed_joints.size(), std::nan(""));
  scaleFriction(1.0);
}

void VehicleDynamics::overrideFriction(std::optional<FrictionMode> mode) {
  laws_.clear();
  for (const ModelEllipsoid& ellipsoid : model_.ellipsoids) {
    laws_.push_back(ellipsoid.law);
    if (mode) laws_.back().mode = *mode;
  }
}

FrictionCoefficients VehicleDynamics::ownFriction(int ellipsoid) const {
  FrictionCoefficients mu;
  const double own = model_.ellipsoids[ellipsoid].mu;
  mu.mu_static = friction_scale_ * std::min(own, config_.mu_static);
  mu.mu_kinetic = friction_scale_ * std::min(own, config_.mu_kinetic);
  mu.stribeck_speed = config_.stribeck_speed;
  return mu;
}

void VehicleDynamics::scaleFriction(double scale) {
  friction_scale_ = scale;
  friction_.clear();
  friction_row_.clear();
  std::vector<double> rows;  // coefficients of their own that ellipsoids have
  for (const ModelEllipsoid& ellipsoid : model_.ellipsoids) {
    const auto found = std::find(rows.begin(), rows.end(), ellipsoid.mu);
    friction_row_.push_back(static_cast<std::size_t>(found - rows.begin()) * terrain_.surfaces().size());
    if (found == rows.end()) rows.push_back(ellipsoid.mu);
  }
  for (const double own : rows)
    for (const Surface& surface : terrain_.surfaces()) {
      FrictionCoefficients mu;
      mu.mu_static = scale * std::min(own, surface.mu_static.value_or(surface.mu_kinetic.value_or(config_.mu_static)));
      mu.mu_kinetic = scale * std::min(own, surface.mu_kinetic.value_or(surface.mu_static.value_or(config_.mu_kinetic)));
      mu.stribeck_speed = config_.stribeck_speed;
      friction_.push_back(mu);
    }
}

Motion VehicleDynamics::makeMotion() const {
  Motion x;
  const std::size_t n = model_.dynamic_joints.size();
  x.q.assign(n, 0.0);
  x.qd.assign(n, 0.0);
  x.stretch.assign(n, 0.0);
  x.anchor.assign(model_.ellipsoids.size(), Anchors{Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero()});
  return x;
}

MotionRate VehicleDynamics::makeRate() const {
  MotionRate k;
  const Motion x = makeMotion();
  k.q = k.qd = k.stretch = x.q;
  k.anchor = x.anchor;
  return k;
}

void VehicleDynamics::beginStep(const VehicleState& frozen, double dt) {
  frozen_ = &frozen;
  memory_ = &frozen.memory;
  dt_ = dt;
  for (std::size_t j = 0; j < hold_limit_.size(); ++j) hold_limit_[j] = model_.dynamic_joints[j].friction;
  for (const WheelUnit& wheel : model_.drive.wheels)
    if (wheel.joint >= 0) hold_limit_[wheel.joint] += brakeTorque(wheel, frozen.drive);
}

void VehicleDynamics::prescribe(double fraction) {
  fraction_ = fraction;
  const double t = fraction * dt_;
  for (std::size_t i = 0; i < frozen_->profiles.size(); ++i) {
    const ProfilePoint p = profileAt(frozen_->profiles[i], t);
    prescribed_[i] = {p.position, p.velocity, p.acceleration};
  }
}

namespace {

// Writes a value of the key, and tells by `same` if it was another.
void put(double*& key, double value, bool& same) {
  same = same && *key == value;
  *key++ = value;
}

}  // namespace

// A step ends at the state that the next one begins with: what was worked out there is kept.
void VehicleDynamics::pose(const Motion& x) {
  bool same = true;
  double* key = posed_at_.data();
  for (int i = 0; i < 3; ++i) put(key, x.X_WB.p[i], same);
  for (int i = 0; i < 4; ++i) put(key, x.X_WB.q.coeffs()[i], same);
  for (const double q : x.q) put(key, q, same);
  for (std::size_t i = 0; i < frozen_->profiles.size(); ++i) put(key, prescribed_[i].position, same);
  if (same && saves_) return;

  std::fill(moving_at_.begin(), moving_at_.end(), std::nan(""));
  R_WB_ = columns(x.X_WB.q.toRotationMatrix());
  tree_.positions(x.q.data(), prescribed_.data());
  for (std::size_t i = 0; i < posed_.size(); ++i) {
    const ModelEllipsoid& ellipsoid = model_.ellipsoids[i];
    const BodyKinematics& k = tree_.kinematics(ellipsoid.body);
    const bool steady = tree_.isSteady(ellipsoid.body);
    const Mount& mount = mounts_[i];
    const Vec3 p_OE = k.p_OB + (steady ? mount.p_BE_O : fromFrame(k.R_OB, mount.p_BE));
    const Frame3 R_OE = steady ? mount.R_OE : fromFrame(k.R_OB, columns(ellipsoid.R_BE));
    posed_[i] = PosedEllipsoid((Vec3::from(x.X_WB.p) + fromFrame(R_WB_, p_OE)).toEigen(), fromFrame(R_WB_, R_OE),
                               ellipsoid.radii);
  }
}

// After pose().
void VehicleDynamics::move(const Motion& x) {
  bool same = true;
  double* key = moving_at_.data();
  for (int i = 0; i < 3; ++i) put(key, x.w_WB[i], same);
  for (const double qd : x.qd) put(key, qd, same);
  for (std::size_t i = 0; i < frozen_->profiles.size(); ++i) put(key, prescribed_[i].velocity, same);
  if (same && saves_) return;
  tree_.velocities(toFrame(R_WB_, Vec3::from(x.w_WB)), x.qd.data(), prescribed_.data());
  for (const int body : touching_bodies_) {
    const Spatial& v = tree_.kinematics(body).velocity;
    moving_W_[body] = {fromFrame(R_WB_, v.angular), fromFrame(R_WB_, v.linear)};
  }
}

void VehicleDynamics::findAll(bool at_remembered_pose) {
  for (std::size_t i = 0; i < posed_.size(); ++i) {
    const ContactMemory& memory = (*memory_)[i];
    if (at_remembered_pose && !memory.fresh) {
      rememberedContacts(memory, options_, contacts_[i]);
    } else {
      findContacts(posed_[i], memory, terrain_, options_, finder_[i], contacts_[i]);
    }
  }
}

double VehicleDynamics::treadSpeed(int tread) const {
  const TreadState& t = frozen_->treads[tread];
  return t.speed + fraction_ * dt_ * t.acceleration;
}

// A solid compound's wheel does not turn: its tread runs about the axle, which the steering turns.
Vec3 VehicleDynamics::axleOf(int index, int body) const {
  const Tread& tread = model_.treads[index];
  Vector3d axle_B = tread.axle_B;
  if (tread.steer >= 0)
    axle_B = Eigen::AngleAxisd(prescribed_[tread.steer].position, tread.steer_axis_B) * axle_B;
  return fromFrame(R_WB_, fromFrame(tree_.kinematics(body).R_OB, Vec3::from(axle_B)));
}

SurfaceMotion VehicleDynamics::surfaceMotion(const Motion& x, ActiveContact& active) const {
  const ModelEllipsoid& ellipsoid = model_.ellipsoids[active.ellipsoid];
  const Vec3 radius = Vec3::from(active.contact.p_WE_lowest) - Vec3::from(posed_[active.ellipsoid].p_WE);
  SurfaceMotion surface{pointVelocity(x, ellipsoid.body, Vec3::from(active.p_OC)),
                        cross(moving_W_[ellipsoid.body].angular, radius)};
  active.roll_axis = Vector3d(0.0, 0.0, 0.0);
  if (ellipsoid.tread < 0) return surface;

  const Vec3 axle_W = axleOf(ellipsoid.tread, ellipsoid.body);
  if (frozen_->treads[ellipsoid.tread].mode == TreadState::Mode::kTurning) {
    const Vec3 running = treadSpeed(ellipsoid.tread) * cross(axle_W, radius);
    surface.v += running;
    surface.v_roll += running;
    return surface;
  }
  // Free and without mass: it gives way to whatever pulls along the rolling direction.
  const Vec3 along = cross(axle_W, Vec3::from(active.contact.nhat_W));
  const double length = norm(along);
  if (length < 1e-9) return surface;
  const Vec3 axis = (1.0 / length) * along;
  active.roll_axis = axis.toEigen();
  const Vec3 given = dot(axis, surface.v) * axis;
  surface.v -= given;
  surface.v_roll -= given;
  return surface;
}

// The friction's stretch of a contact: that of a carried contact with about its normal, turned to this one's.
Vec3 VehicleDynamics::anchorOf(const Motion& x, const ActiveContact& active) const {
  if (active.from < 0) return {0.0, 0.0, 0.0};
  const Vector3d& carried = (*memory_)[active.ellipsoid].carried[active.from].nhat_W;
  const Vector3d& z = x.anchor[active.ellipsoid][active.from];
  const Vec3 u = Vec3::from(active.contact.nhat_W);
  // At the start of a step the normal is the carried one, and turning changes nothing.
  const Vec3 turned = Vec3::from(carried == active.contact.nhat_W ? z : turnedWithNormal(z, carried, active.contact.nhat_W));
  Vec3 anchor = turned - dot(u, turned) * u;
  const Vec3 roll_axis = Vec3::from(active.roll_axis);
  if (!active.roll_axis.isZero(0.0)) anchor -= dot(roll_axis, anchor) * roll_axis;
  return anchor;
}

ContactForce VehicleDynamics::forceOf(const ActiveContact& active, const SurfaceMotion& surface) const {
  return contactForce(lawOf(active.ellipsoid), frictionOf(active.ellipsoid, active.contact.triangle), active.contact.nhat_W,
                      active.contact.pressed, active.contact.share, surface.v.toEigen(), surface.v_roll.toEigen(),
                      active.anchor_W);
}

// The slot with the nearest normal (cosine above one half) that is not taken yet. A contact that finds none, but stands beside
// one of about its own normal, begins with that one's stretch: it is the same rubber that rolls over the crease, and as the one
// takes over the other's share, the friction must not drop.
void VehicleDynamics::findStretch(ActiveContact& active, const ContactMemory& memory, unsigned& taken) const {
  constexpr double kSame = 0.5, kBeside = 0.9;
  double best = kSame, beside = kBeside;
  for (int i = 0; i < memory.count; ++i) {
    const double cosine = active.contact.nhat_W.dot(memory.carried[i].nhat_W);
    if ((taken >> i & 1u) == 0 && cosine > best) {
      active.slot = i;
      best = cosine;
    }
    if (cosine > beside) {
      active.from = i;
      beside = cosine;
    }
  }
  if (active.slot < 0) return;
  active.from = active.slot;
  taken |= 1u << active.slot;
}

void VehicleDynamics::applyContacts(const Motion& x) {
  active_.clear();
  tree_.clearForces();
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    unsigned taken = 0;
    for (int j = 0; j < contacts_[i].count; ++j) {
      active_.emplace_back(static_cast<int>(i), contacts_[i].contact[j]);
      ActiveContact& active = active_.back();
      findStretch(active, (*memory_)[i], taken);
      active.p_OC = active.contact.p_WE_lowest - x.X_WB.p;
      const SurfaceMotion surface = surfaceMotion(x, active);
      active.anchor_W = anchorOf(x, active).toEigen();
      active.force = forceOf(active, surface);
      const Vector3d f_W = active.force.normal * active.contact.nhat_W + active.force.friction_W;
      tree_.addForce(model_.ellipsoids[i].body, toFrame(R_WB_, Vec3::from(active.p_OC)), toFrame(R_WB_, Vec3::from(f_W)));
    }
  }
}

void VehicleDynamics::jointForces(const Motion& x, MotionRate& k, bool rates_only) {
  if (!rates_only) driveTorques(model_, config_, frozen_->drive, fraction_ * dt_, x.q, x.qd, motor_torque_);
  for (std::size_t j = 0; j < model_.dynamic_joints.size(); ++j) {
    const DynamicJoint& joint = model_.dynamic_joints[j];
    k.q[j] = x.qd[j];
    k.stretch[j] = hold_limit_[j] > 0.0 ? x.qd[j] : 0.0;
    if (rates_only) continue;
    double effort = -joint.damping * x.qd[j] - joint.stiffness * (x.q[j] - joint.reference);
    // Stops push only, and only inwards.
    if (x.q[j] > joint.upper)
      effort += std::min(0.0, -joint.stop_stiffness * (x.q[j] - joint.upper) - joint.stop_damping * x.qd[j]);
    if (x.q[j] < joint.lower)
      effort += std::max(0.0, -joint.stop_stiffness * (x.q[j] - joint.lower) - joint.stop_damping * x.qd[j]);
    // Brake and dry friction: a spring and damper that slips at its limit, so that what stands still stays.
    if (hold_limit_[j] > 0.0) {
      const double spring = std::clamp(joint.hold.stiffness * x.stretch[j], -hold_limit_[j], hold_limit_[j]);
      effort -= std::clamp(spring + joint.hold.damping * x.qd[j], -hold_limit_[j], hold_limit_[j]);
    }
    joint_effort_[j] = effort;
  }
  if (rates_only) return;
  for (std::size_t i = 0; i < motor_torque_.size(); ++i)
    if (model_.drive.wheels[i].joint >= 0) joint_effort_[model_.drive.wheels[i].joint] += motor_torque_[i];
}

void VehicleDynamics::anchorRates(MotionRate& k) const {
  for (Anchors& anchors : k.anchor)
    for (Vector3d& z : anchors) z.setZero();
  for (const ActiveContact& active : active_) {
    if (active.slot < 0) continue;
    Vector3d rate = active.force.anchor_rate_W;
    if (!active.roll_axis.isZero(0.0)) rate -= active.roll_axis.dot(rate) * active.roll_axis;
    k.anchor[active.ellipsoid][active.slot] = rate;
  }
}

void VehicleDynamics::beginRate(const Motion& x, double fraction, MotionRate& k) {
  pushed_ = false;
  resisted_ = Work{};
  prescribe(fraction);
  pose(x);
  move(x);
  // The step starts at the pose the memory was taken at: its contacts are known.
  findAll(fraction == 0.0);
  applyContacts(x);
  if (config_.rolling_resistance > 0.0) applyRollingResistance(x);
  if (hasDrag()) applyDrag(x);
  jointForces(x, k, false);
  anchorRates(k);
}

void VehicleDynamics::addForce(const Motion& x, const ExternalForce& force) {
  pushed_ = true;
  const Vec3 p_OC = Vec3::from(force.p_W) - Vec3::from(x.X_WB.p);
  const int body = model_.ellipsoids[force.ellipsoid].body;
  tree_.addForce(body, toFrame(R_WB_, p_OC), toFrame(R_WB_, Vec3::from(force.f_W)));
  if (counts_) resisted_.supplied += dot(Vec3::from(force.f_W), pointVelocity(x, body, p_OC));
}

void VehicleDynamics::endRate(const Motion& x, MotionRate& k) {
  if (turning_ && active_.empty() && !pushed_) {
    k.v = x.v_WB;
    k.w = x.w_WB;
    k.a = gravity_W_.toEigen();
    k.alpha = turning_->acceleration(R_WB_, Vec3::from(x.w_WB)).toEigen();
    k.power = drained_ = Work{};
    return;
  }
  const Spatial base =
      tree_.accelerations(joint_effort_.data(), prescribed_.data(), toFrame(R_WB_, gravity_W_), k.qd.data());
  k.v = x.v_WB;
  k.w = x.w_WB;
  k.a = fromFrame(R_WB_, base.linear).toEigen();
  k.alpha = fromFrame(R_WB_, base.angular).toEigen();
  if (!counts_) return;
  k.power = drained_ = drainedPower(x);
  k.power.lost -= stretchPower(x, k);
}

void VehicleDynamics::positionRates(const Motion& x, MotionRate& k) {
  move(x);
  // The forces that changed the speeds, at the mean of the old and the new ones, did just the work that the kinetic energy shows.
  if (counts_) k.power = 0.5 * (drained_ + drainedPower(x));
  // Positions, and with them the stretches, are those of the last rate().
  for (ActiveContact& active : active_) active.force = forceOf(active, surfaceMotion(x, active));
  jointForces(x, k, true);
  anchorRates(k);
  k.v = x.v_WB;
  k.w = x.w_WB;
  if (counts_) k.power.lost -= stretchPower(x, k);
}

void VehicleDynamics::advanceVelocities(Motion& x, double h, const MotionRate& k) const {
  advanceBaseVelocities(h, k, x);
  for (std::size_t i = 0; i < x.qd.size(); ++i) x.qd[i] += h * k.qd[i];
  couple(x);
}

void VehicleDynamics::advancePositions(Motion& x, double h, const MotionRate& k) const {
  advanceBasePositions(h, k, x);
  x.work += h * k.power;
  for (std::size_t i = 0; i < x.q.size(); ++i) {
    x.q[i] += h * k.q[i];
    x.stretch[i] += h * k.stretch[i];
  }
  couple(x);
  for (std::size_t i = 0; i < x.anchor.size(); ++i)
    for (int j = 0; j < kMaxContactsPerEllipsoid; ++j) x.anchor[i][j] += h * k.anchor[i][j];
}

void VehicleDynamics::toTangent(double h, const MotionRate& previous, MotionRate& k) const {
  k.w = rotationVectorRate(h * previous.w, k.w);
}

void VehicleDynamics::combine(MotionRate (&k)[4]) const {
  const auto mix = [](auto& a, const auto& b, const auto& c, const auto& d) { a = rk4Mean(a, b, c, d); };
  combineBase(k);
  mix(k[0].power, k[1].power, k[2].power, k[3].power);
  for (std::size_t i = 0; i < k[0].q.size(); ++i) {
    mix(k[0].q[i], k[1].q[i], k[2].q[i], k[3].q[i]);
    mix(k[0].qd[i], k[1].qd[i], k[2].qd[i], k[3].qd[i]);
    mix(k[0].stretch[i], k[1].stretch[i], k[2].stretch[i], k[3].stretch[i]);
  }
  for (std::size_t i = 0; i < k[0].anchor.size(); ++i)
    for (int j = 0; j < kMaxContactsPerEllipsoid; ++j)
      mix(k[0].anchor[i][j], k[1].anchor[i][j], k[2].anchor[i][j], k[3].anchor[i][j]);
}

// The paths of the tick, and what is asked of wheels, end exactly where their formula says.
void VehicleDynamics::carryEnds(VehicleState& state, double dt, bool ends_tick) const {
  for (ProfileState& p : state.profiles) carryProfile(dt, ends_tick, p);
  for (TreadState& tread : state.treads) {
    tread.angle += dt * (tread.speed + 0.5 * dt * tread.acceleration);
    tread.speed += dt * tread.acceleration;
    if (ends_tick) tread.acceleration = 0.0;
  }
  carryDrive(model_, dt, state.motion.q, ends_tick, state.drive);
}

// Anchors move to the new contacts, turned with the normal, and shortened to what the cone carries there.
Anchors VehicleDynamics::acceptContacts(const Motion& x, int ellipsoid, const ContactMemory& old, ContactMemory& memory,
                                        double dt) {
  const EllipsoidContacts& contacts = contacts_[ellipsoid];
  rememberContacts(posed_[ellipsoid], contacts, old, options_, dt, memory);
  Anchors anchors{Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero()};
  unsigned taken = 0;
  for (int j = 0; j < contacts.count; ++j) {
    ActiveContact active(ellipsoid, contacts.contact[j]);
    findStretch(active, old, taken);
    if (active.from < 0 || x.anchor[ellipsoid][active.from].isZero(0.0)) continue;
    active.p_OC = active.contact.p_WE_lowest - x.X_WB.p;
    // The slack of the new memory is the one the next step will feel.
    const double pressed = std::max(0.0, active.contact.depth - (options_.memory ? memory.slack : 0.0));
    const SurfaceMotion surface = surfaceMotion(x, active);
    const Vec3 anchor = anchorOf(x, active);
    const double limit =
        stretchLimit(lawOf(ellipsoid), frictionOf(active.ellipsoid, active.contact.triangle), active.contact.nhat_W, pressed,
                     active.contact.share, surface.v.toEigen(), surface.v_roll.toEigen());
    const double length = norm(anchor);
    anchors[j] = (length > limit ? (limit / length) * anchor : anchor).toEigen();
  }
  return anchors;
}

// Of a tread that gives way to whatever pulls: that of the ground below it [rad/s]. Its ellipsoid touches.
double VehicleDynamics::freeTreadSpeed(const Motion& x, int ellipsoid) const {
  ActiveContact active(ellipsoid, contacts_[ellipsoid].contact[0]);
  active.p_OC = active.contact.p_WE_lowest - x.X_WB.p;
  surfaceMotion(x, active);
  const Vec3 v = pointVelocity(x, model_.ellipsoids[ellipsoid].body, Vec3::from(active.p_OC));
  const double radius = (active.contact.p_WE_lowest - posed_[ellipsoid].p_WE).norm();
  return radius > 0.0 ? dot(Vec3::from(active.roll_axis), v) / radius
                      : frozen_->treads[model_.ellipsoids[ellipsoid].tread].speed;
}

// The new pose, with paths and drive as they are there; the old memory in `before`.
void VehicleDynamics::standAtEnd(VehicleState& state, double dt, std::vector<ContactMemory>& before, bool ends_tick) {
  carryEnds(state, dt, ends_tick);
  before.resize(state.memory.size());
  before.swap(state.memory);
  frozen_ = &state;
  prescribe(0.0);
  pose(state.motion);
}

int VehicleDynamics::accept(VehicleState& state, double dt, std::vector<ContactMemory>& before, bool ends_tick) {
  Motion& x = state.motion;
  standAtEnd(state, dt, before, ends_tick);
  memory_ = &before;
  move(x);
  findAll(false);
  double stored = 0.0;
  if (counts_) {
    applyContacts(x);
    stored = potentialEnergy(x) + anchorsLetGo(x);
  }

  int passed = 0;
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const int ellipsoid = static_cast<int>(i);
    const ContactMemory& old = before[i];
    // A centre that went through a triangle is behind it now, or has moved too far to tell from the triangles around it.
    if (!old.fresh) {
      const Vec3 way = Vec3::from(posed_[i].p_WE) - Vec3::from(old.posed.p_WE);
      const double far = 0.5 * posed_[i].radii.minCoeff();
      if ((finder_[i].behind_any || squaredNorm(way) > far * far) &&
          terrain_.firstFrontCrossing(old.posed.p_WE, posed_[i].p_WE))
        ++passed;
    }
    x.anchor[i] = acceptContacts(x, ellipsoid, old, state.memory[i], dt);
    // A tread that runs free keeps the speed of the ground below it, for the day it is braked or driven.
    const int tread = model_.ellipsoids[i].tread;
    if (tread >= 0 && state.treads[tread].mode == TreadState::Mode::kFree && contacts_[i].count > 0)
      state.treads[tread].speed = freeTreadSpeed(x, ellipsoid);
  }
  memory_ = &state.memory;

  for (std::size_t j = 0; j < x.stretch.size(); ++j) {
    const JointHold& hold = model_.dynamic_joints[j].hold;
    const double limit = hold.stiffness > 0.0 ? hold_limit_[j] / hold.stiffness : 0.0;
    x.stretch[j] = std::clamp(x.stretch[j], -limit, limit);
  }
  if (counts_) {
    // Stretches cut to what the cone carries are work done on it. What is found the other way round is nobody's work.
    findAll(true);
    applyContacts(x);
    x.work.lost += std::max(0.0, stored - potentialEnergy(x));
  }
  return passed;
}

void VehicleDynamics::acceptFlight(VehicleState& state, double dt, std::vector<ContactMemory>& before, bool ends_tick) {
  Motion& x = state.motion;
  standAtEnd(state, dt, before, ends_tick);
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    contacts_[i].count = 0;
    rememberContacts(posed_[i], contacts_[i], before[i], options_, dt, state.memory[i]);
    for (Vector3d& z : x.anchor[i]) z.setZero();
  }
  memory_ = &state.memory;
}

void VehicleDynamics::evaluate(const VehicleState& state, MotionRate& k, const std::vector<ExternalForce>& outside) {
  beginStep(state, 0.0);
  beginRate(state.motion, 0.0, k);
  for (const ExternalForce& force : outside) addForce(state.motion, force);
  endRate(state.motion, k);
}

void VehicleDynamics::poseAt(const VehicleState& state) {
  beginStep(state, 0.0);
  prescribe(0.0);
  pose(state.motion);
  move(state.motion);
}

Spatial VehicleDynamics::momentum(const Motion& x) const {
  const Spatial own = tree_.momentum(toFrame(R_WB_, Vec3::from(x.v_WB)));
  const Vec3 linear = fromFrame(R_WB_, own.linear);
  return {fromFrame(R_WB_, own.angular) + cross(Vec3::from(x.X_WB.p), linear), linear};
}

double VehicleDynamics::prescribedEffort(int prescribed) const {
  const int body = model_.prescribed_joints[prescribed].body;
  return body < 0 ? 0.0 : tree_.prescribedEffort(body);
}

double VehicleDynamics::potentialEnergy(const Motion& x) const {
  const Vec3 moment = model_.mass * Vec3::from(x.X_WB.p) + fromFrame(R_WB_, tree_.massMoment());
  double energy = -dot(gravity_W_, moment);
  for (std::size_t j = 0; j < model_.dynamic_joints.size(); ++j) {
    const DynamicJoint& joint = model_.dynamic_joints[j];
    const double s = x.q[j] - joint.reference;
    energy += 0.5 * joint.stiffness * s * s + 0.5 * joint.hold.stiffness * x.stretch[j] * x.stretch[j];
    const double beyond = std::max({0.0, x.q[j] - joint.upper, joint.lower - x.q[j]});
    energy += 0.5 * joint.stop_stiffness * beyond * beyond;
  }
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    EllipsoidContacts contacts = contacts_[i];
    energy += 0.5 * model_.ellipsoids[i].law.stiffness * assignShares(contacts).squaredNorm();
  }
  for (const ActiveContact& active : active_) {
    if (active.from < 0) continue;
    const ContactLaw& law = lawOf(active.ellipsoid);
    if (law.mode == FrictionMode::kViscous) continue;
    energy += 0.5 * active.contact.share * law.tangential_stiffness *
              x.anchor[active.ellipsoid][active.from].squaredNorm();
  }
  return energy;
}

}  // namespace ellipsoid_vehicle_sim
