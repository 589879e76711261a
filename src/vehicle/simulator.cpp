#include "ellipsoid_vehicle_sim/vehicle/simulator.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "ellipsoid_vehicle_sim/vehicle/accuracy.h"
#include "ellipsoid_vehicle_sim/vehicle/drive.h"
#include "ellipsoid_vehicle_sim/vehicle/snapshot.h"
#include "explain_contact.h"
#include "fnv_hash.h"
#include "set_down.h"
#include "simulator_impl.h"

namespace ellipsoid_vehicle_sim {
using Eigen::Vector3d;

Simulator::Simulator(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Simulator::Simulator(Simulator&&) noexcept = default;
Simulator& Simulator::operator=(Simulator&&) noexcept = default;
Simulator::~Simulator() = default;

Loaded<Simulator> Simulator::create(const VehicleDescription& vehicle, std::shared_ptr<const Terrain> terrain,
                                    const SimConfig& config) {
  if (const std::optional<double> target = accuracyTarget(config.accuracy)) return createForAccuracy(vehicle, terrain, config, *target);
  Loaded<Simulator> result;
  Loaded<VehicleModel> model = compileVehicle(vehicle, config);
  result.notes = model.notes;
  if (!model) {
    result.problems = model.problems;
    return result;
  }
  auto impl = std::make_unique<Impl>();
  impl->config = config;
  impl->model = std::move(*model.value);
  impl->terrain = std::move(terrain);
  impl->load_report = impl->model.report;
  impl->allocate();
  impl->certifyVehicle();
  impl->tellTouchDown();
  result.problems = impl->checkStep();
  if (!result.problems.empty()) return result;
  result.value = Simulator(std::move(impl));
  if (result.value->isBeyondCertificate())
    result.value->impl_->load_report.emplace_back(
        "UNSTABLE: the step is larger than the integrator can hold, as allow_unstable permits; every output is marked");
  return result;
}

// The choice needs the certificate of the very vehicle, and that the step: asked first at a step that every vehicle bears,
// and then at the chosen one, which is made smaller where the vehicle's own constants follow it too far.
Loaded<Simulator> Simulator::createForAccuracy(const VehicleDescription& vehicle, std::shared_ptr<const Terrain> terrain,
                                               SimConfig config, double target) {
  const std::string asked = config.accuracy;
  config.accuracy.clear();
  config.allow_unstable = true;
  Loaded<Simulator> result = create(vehicle, terrain, config);
  if (!result) return result;
  const SceneKind kind = sceneKindOf(result.value->model(), result.value->terrain());
  const AccuracyChoice choice = chooseAccuracy(target, kind, result.value->certificate(), accuracyCurves());
  config.integrator = choice.integrator;
  config.dt = choice.dt;
  if (choice.substeps > 0.0) config.contact_substeps = choice.substeps;
  result = create(vehicle, terrain, config);
  std::string smaller;
  for (int i = 0; i < 20 && result && result.value->isBeyondCertificate(); ++i) {
    config.dt *= 0.5;
    smaller = "; at that step the vehicle's own constants ask for a smaller one";
    result = create(vehicle, terrain, config);
  }
  if (!result) return result;
  Impl& impl = *result.value->impl_;
  impl.config.accuracy = asked;
  impl.config.allow_unstable = false;
  impl.load_report.push_back("accuracy: " + asked + ": " + choice.reason + smaller);
  if (!smaller.empty()) {
    char text[80];
    std::snprintf(text, sizeof text, "accuracy: the step in use is %.6g s", config.dt);
    impl.load_report.emplace_back(text);
  }
  if (impl.config.dt > impl.certificate.largestStep(impl.config.integrator)) result.problems = impl.checkStep();
  return result;
}

Problems Simulator::setDown(double x, double y, double yaw) {
  VehicleState placed;
  const Problems problems = settle(impl_->model, impl_->config, *impl_->terrain, *impl_->observer, x, y, yaw, placed);
  impl_->observed_fresh = false;
  if (problems.empty()) impl_->becomeHome(placed);
  return problems;
}

Problems Simulator::place(const Pose& X_WR, const Vector3d& v_WR_W, const Vector3d& w_WR_W) {
  if (!X_WR.allFinite() || !v_WR_W.allFinite() || !w_WR_W.allFinite() || !(X_WR.q.norm() > 1e-6))
    return {{"place", "pose and velocities must be finite, the quaternion not zero"}};
  VehicleState placed = restState(impl_->model, *impl_->observer);
  const Pose X_WR_unit{X_WR.p, X_WR.q.normalized()};
  placed.motion.X_WB = X_WR_unit * impl_->model.X_BR.inverse();
  placed.motion.w_WB = w_WR_W;
  placed.motion.v_WB = v_WR_W + w_WR_W.cross(placed.motion.X_WB.p - X_WR.p);
  if (!isSane(placed.motion)) return {{"place", "position or velocity is out of all bounds"}};
  impl_->observer->beginStep(placed, 0.0);
  impl_->observer->accept(placed, 0.0);
  impl_->becomeHome(placed);
  return {};
}

void Simulator::reset() { impl_->restart(); }

bool Simulator::command(const DriveCommand& command) {
  // Written so that NaN fails it.
  const auto usable = [](double value) { return std::abs(value) <= kLargestCommand; };
  const auto bound = [](double value) { return value >= 0.0 && value <= kLargestCommand; };
  if (!usable(command.speed) || !usable(command.yaw_rate) || !usable(command.steering_angle) ||
      !bound(command.steering_angle_velocity) || !bound(command.acceleration) || !bound(command.jerk)) {
    ++impl_->events.rejected_commands;
    return false;
  }
  DriveState& drive = impl_->state.drive;
  drive.command = command;
  drive.has_command = true;
  drive.command_age = 0;
  return true;
}

Problems Simulator::commandJoints(const std::vector<JointRequest>& requests) {
  Problems problems = takeJointRequests(impl_->model, requests, impl_->state.drive);
  if (!problems.empty()) ++impl_->events.rejected_commands;
  return problems;
}

Problems Simulator::checkJoints(const std::vector<JointRequest>& requests) const {
  DriveState drive = impl_->state.drive;
  return takeJointRequests(impl_->model, requests, drive);
}

void Simulator::setFrictionScale(double scale) {
  impl_->friction_scale = scale;
  impl_->dynamics->scaleFriction(scale);
  impl_->observer->scaleFriction(scale);
  if (impl_->estimator) impl_->estimator->scaleFriction(scale);
  if (impl_->savings_check) impl_->savings_check->scaleFriction(scale);
  impl_->observed_fresh = false;
  impl_->resting = false;
}

double Simulator::frictionScale() const { return impl_->friction_scale; }

Snapshot Simulator::save() const {
  return {impl_->state, impl_->home, impl_->events, impl_->friction_scale, {}};
}

void Simulator::restore(const Snapshot& snapshot) {
  impl_->forgetOthers();
  impl_->state = impl_->previous = snapshot.state;
  impl_->home = snapshot.home;
  impl_->events = snapshot.events;
  impl_->status = StepStatus::kOk;
  impl_->estimate = ErrorEstimate{};
  setFrictionScale(snapshot.friction_scale);
  impl_->beginAccount();
}

StepStatus Simulator::step() { return impl_->step(); }

std::int64_t Simulator::stepCount() const { return impl_->step_count; }
double Simulator::time() const { return static_cast<double>(impl_->step_count) * impl_->config.dt; }
StepStatus Simulator::status() const { return impl_->status; }
const StepEvents& Simulator::events() const { return impl_->events; }
bool Simulator::commandInForce() const { return commandAge() <= impl_->config.command_timeout; }
double Simulator::commandAge() const {
  const DriveState& drive = impl_->state.drive;
  std::int64_t age = std::numeric_limits<std::int64_t>::max();
  if (drive.has_command) age = drive.command_age;
  for (const auto* commands : {&drive.wheel_command, &drive.profile_command})
    for (const JointCommand& command : *commands)
      if (command.kind != JointCommand::Kind::kNone) age = std::min(age, command.age);
  return age == std::numeric_limits<std::int64_t>::max() ? std::numeric_limits<double>::infinity()
                                                         : static_cast<double>(age) * impl_->config.dt;
}

Pose Simulator::rootPose() const { return impl_->state.motion.X_WB * impl_->model.X_BR; }
Vector3d Simulator::rootVelocity_W() const {
  const Motion& m = impl_->state.motion;
  return m.v_WB + m.w_WB.cross(m.X_WB.q * impl_->model.X_BR.p);
}
Vector3d Simulator::rootAngularVelocity_W() const { return impl_->state.motion.w_WB; }
Vector3d Simulator::rootAcceleration_W() const {
  impl_->observe();
  const Motion& m = impl_->state.motion;
  const Vector3d p_BR_W = m.X_WB.q * impl_->model.X_BR.p;
  return impl_->observed.a + impl_->observed.alpha.cross(p_BR_W) + m.w_WB.cross(m.w_WB.cross(p_BR_W));
}

const std::vector<std::string>& Simulator::jointNames() const { return impl_->joint_names; }

void Simulator::jointReadings(std::vector<JointReading>& out) const {
  Impl& s = *impl_;
  s.observe();
  out.resize(s.joint_names.size());
  std::size_t index = 0;
  for (std::size_t d = 0; d < s.model.description.joints.size(); ++d) {
    const JointDescription& joint = s.model.description.joints[d];
    if (joint.type == JointType::kFixed) continue;
    JointReading reading;
    reading.position = std::clamp(0.0, std::min(joint.lower, joint.upper), std::max(joint.lower, joint.upper));
    for (std::size_t j = 0; j < s.model.dynamic_joints.size(); ++j)
      if (s.model.dynamic_joints[j].description == static_cast<int>(d))
        reading = {s.state.motion.q[j], s.state.motion.qd[j], s.observer->jointEfforts()[j]};
    for (std::size_t p = 0; p < s.model.prescribed_joints.size(); ++p)
      if (s.model.prescribed_joints[p].description == static_cast<int>(d))
        reading = {s.state.profiles[p].position, s.state.profiles[p].velocity, s.state.profiles[p].effort};
    for (std::size_t t = 0; t < s.model.treads.size(); ++t)
      if (s.model.treads[t].description == static_cast<int>(d))
        reading = {s.state.treads[t].angle, s.state.treads[t].speed, 0.0};
    out[index++] = reading;
  }
}

void Simulator::contacts(std::vector<ContactReport>& out) const {
  impl_->observe();
  out.clear();
  for (const ActiveContact& active : impl_->observer->activeContacts()) {
    ContactReport report;
    report.ellipsoid = active.ellipsoid;
    report.triangle = active.contact.triangle;
    report.p_WC = active.contact.trianglePoint();
    report.nhat_W = active.contact.nhat_W;
    report.depth = active.contact.depth;
    report.normal_force = active.force.normal;
    report.friction_W = active.force.friction_W;
    report.friction_limit = active.force.friction_limit;
    report.sliding = active.force.sliding;
    out.push_back(report);
  }
  out.insert(out.end(), impl_->touched.begin(), impl_->touched.end());
}

void Simulator::posedEllipsoids(std::vector<PosedEllipsoid>& out) const {
  impl_->observer->poseAt(impl_->state);
  out = impl_->observer->posedEllipsoids();
}

ContactExplanation Simulator::explainContact(int ellipsoid) const {
  std::vector<ContactReport> reports;
  contacts(reports);
  const ContactOptions options{impl_->config.contact_rule, impl_->config.contacts_per_ellipsoid, impl_->config.contact_memory,
                               impl_->config.candidate_cache && impl_->config.saves()};
  return explain(impl_->state.memory[static_cast<std::size_t>(ellipsoid)],
                 impl_->previous.memory[static_cast<std::size_t>(ellipsoid)], *impl_->terrain, options, ellipsoid, reports);
}

const std::vector<EllipsoidPlacement>& Simulator::ellipsoids() const { return impl_->placements; }

double Simulator::largestPenetration() const {
  double deepest = 0.0;
  for (const ContactMemory& memory : impl_->state.memory) deepest = std::max(deepest, memory.deepest);
  return deepest;
}

double Simulator::energy() const {
  return impl_->energy();
}

EnergyBalance Simulator::energyBalance() const {
  if (!impl_->config.energy_balance) return {};
  const Work& work = impl_->state.motion.work;
  return {energy(), impl_->energy_at_start, work.lost, work.supplied};
}

Vector3d Simulator::momentum_W() const {
  impl_->observe();
  return impl_->observer->momentum(impl_->state.motion).linear.toEigen();
}

Vector3d Simulator::angularMomentum_W() const {
  impl_->observe();
  return impl_->observer->momentum(impl_->state.motion).angular.toEigen();
}

namespace {

// Rolling speed of a wheel unit as its encoder tells it, forward positive [m/s].
double encoder(const Simulator& simulator, const WheelUnit& wheel) {
  const VehicleState& state = simulator.state();
  const double omega = wheel.joint >= 0 ? state.motion.qd[wheel.joint] : state.treads[wheel.tread].speed;
  return wheel.forward_sign * omega * wheel.radius;
}

}  // namespace

double Simulator::encoderSpeed() const {
  // Wheels that do not steer tell the speed of the reference point; without any, all of them do, each along its heading.
  double sum = 0.0;
  int count = 0;
  for (const bool steered : {false, true}) {
    for (const WheelUnit& wheel : impl_->model.drive.wheels) {
      if (!wheel.braked || (wheel.steer >= 0) != steered) continue;
      const double angle = steered ? impl_->state.profiles[impl_->model.drive.steers[wheel.steer].prescribed].position : 0.0;
      sum += encoder(*this, wheel) * std::cos(angle);
      ++count;
    }
    if (count > 0) return sum / count;
  }
  return 0.0;
}

double Simulator::encoderYawRate() const {
  const DriveModel& drive = impl_->model.drive;
  if (drive.layout == DriveLayout::kAckermann) return encoderSpeed() * actualCurvature(impl_->model, impl_->state);
  // Least squares of v_i = v - w y_i over the driven wheels.
  double n = 0.0, y = 0.0, yy = 0.0, v = 0.0, vy = 0.0;
  for (const WheelUnit& wheel : drive.wheels) {
    if (!wheel.driven) continue;
    const double speed = encoder(*this, wheel);
    n += 1.0;
    y += wheel.p_FW.y();
    yy += wheel.p_FW.y() * wheel.p_FW.y();
    v += speed;
    vy += speed * wheel.p_FW.y();
  }
  const double det = n * yy - y * y;
  return det > 1e-12 ? (y * v - n * vy) / det : 0.0;
}

const SimConfig& Simulator::config() const { return impl_->config; }
const VehicleModel& Simulator::model() const { return impl_->model; }
const VehicleState& Simulator::state() const { return impl_->state; }
const Terrain& Simulator::terrain() const { return *impl_->terrain; }
const StabilityCertificate& Simulator::certificate() const { return impl_->certificate; }
bool Simulator::isBeyondCertificate() const {
  return impl_->config.dt > impl_->certificate.largestStep(impl_->config.integrator);
}
const ErrorEstimate& Simulator::errorEstimate() const { return impl_->estimate; }
bool Simulator::isResting() const { return impl_->resting; }
const std::vector<std::string>& Simulator::loadReport() const { return impl_->load_report; }
std::uint64_t Simulator::stateHash() const {
  FnvHash hash;
  hash.add(hashOf(impl_->state));
  hash.add(impl_->friction_scale);
  return hash.value();
}

}  // namespace ellipsoid_vehicle_sim
