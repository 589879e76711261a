#include "ellipsoid_vehicle_sim/trade/measured_run.h"

#include <time.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "ellipsoid_vehicle_sim/description/number_text.h"
#include "ellipsoid_vehicle_sim/trade/closed_forms.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

// Contacts, energy and forces are looked at so often [s], or twice a thousandth of a long scene.
constexpr double kLookInterval = 1e-3;
constexpr double kLooks = 2000.0;

// Largest distance across the ellipsoids as the vehicle stands.
double lengthOf(const Simulator& simulator) {
  double length = 0.0;
  for (const ModelEllipsoid& a : simulator.model().ellipsoids) {
    length = std::max(length, 2.0 * a.radii.maxCoeff());
    if (a.body != 0) continue;
    for (const ModelEllipsoid& b : simulator.model().ellipsoids)
      if (b.body == 0)
        length = std::max(length, (a.X_BE.p - b.X_BE.p).norm() + a.radii.maxCoeff() + b.radii.maxCoeff());
  }
  return length;
}

double coefficient(const Simulator& simulator, const ContactReport& contact) {
  const SimConfig& config = simulator.config();
  const Surface& surface = simulator.terrain().surface(contact.triangle);
  // The larger of the two: a force above it is outside the cone whatever the slip.
  return std::max(surface.mu_static.value_or(surface.mu_kinetic.value_or(config.mu_static)),
                  surface.mu_kinetic.value_or(surface.mu_static.value_or(config.mu_kinetic)));
}

/// Gathers OwnErrors while a run goes on.
class Watcher {
 public:
  Watcher(const LoadedScene& scene, const Simulator& simulator)
      : measures_(scene.scene.measures),
        duration_(scene.scene.duration),
        horizon_(scene.scene.horizon),
        check_(makeClosedFormCheck(scene, simulator)),
        energy_at_start_(simulator.energy()),
        momentum_at_start_(momentum(simulator)) {}

  bool wanted() const {
    return check_ || measures_.energy || measures_.momentum || measures_.contact_quality || measures_.creep;
  }

  void tick(const Simulator& simulator, double time) {
    if (check_) check_->watch(simulator, time);
    if (measures_.contact_quality) deepest_ = std::max(deepest_, simulator.largestPenetration());
  }

  void look(const Simulator& simulator, double time) {
    if (time <= horizon_ * (1.0 + 1e-9)) {
      if (measures_.energy) {
        const Vector3d v = simulator.state().motion.v_WB;
        drift_ = std::max(drift_, std::abs(simulator.energy() - energy_at_start_));
        // The scale: the translation's kinetic energy, which is what a fall turns the drop into.
        kinetic_ = std::max(kinetic_, 0.5 * simulator.model().mass * v.squaredNorm() + rotation(simulator));
      }
      if (measures_.momentum) {
        const Vector3d p = momentum(simulator);
        momentum_drift_ = std::max(momentum_drift_, (p - momentum_at_start_).head<2>().norm());
        momentum_scale_ = std::max(momentum_scale_, p.norm());
      }
    }
    if (!measures_.contact_quality && !measures_.creep) return;
    const bool second_half = time >= 0.5 * duration_;
    if (measures_.creep && second_half) {
      const Vector3d p = simulator.rootPose().p;
      if (!standing_) standing_ = p;
      moved_ = (p - *standing_).norm();
    }
    if (!measures_.contact_quality) return;
    simulator.contacts(contacts_);
    double force = 0.0;
    for (const ContactReport& contact : contacts_) {
      force += contact.normal_force;
      const double limit = coefficient(simulator, contact) * contact.normal_force;
      const double tangential = contact.friction_W.norm();
      // A millionth of a newton is rounding.
      if (tangential > limit + 1e-6) cone_ = std::max(cone_, limit > 0.0 ? tangential / limit - 1.0 : 1.0);
    }
    if (!second_half) return;
    force_sum_ += force;
    force_squares_ += force * force;
    ++forces_;
  }

  OwnErrors errors() const {
    OwnErrors e;
    if (check_) e.closed_form = check_->error();
    if (measures_.energy && kinetic_ > 0.0) e.energy = drift_ / kinetic_;
    if (measures_.momentum && momentum_scale_ > 0.0) e.momentum = momentum_drift_ / momentum_scale_;
    if (measures_.creep && standing_) e.creep = moved_ / (0.5 * duration_);
    if (measures_.contact_quality) {
      e.penetration = deepest_;
      e.cone = cone_;
      const double mean = forces_ > 0 ? force_sum_ / forces_ : 0.0;
      if (mean > 0.0) e.ripple = std::sqrt(std::max(0.0, force_squares_ / forces_ - mean * mean)) / mean;
    }
    return e;
  }

 private:
  static Vector3d momentum(const Simulator& simulator) {
    return simulator.model().mass * simulator.state().motion.v_WB;
  }
  static double rotation(const Simulator& simulator) {
    const Vector3d w_B = simulator.state().motion.X_WB.q.conjugate() * simulator.state().motion.w_WB;
    double energy = 0.0;
    for (const LinkDescription& link : simulator.model().description.links) energy += 0.5 * w_B.dot(link.I_cm_L * w_B);
    return energy;
  }

  SceneMeasures measures_;
  double duration_, horizon_;
  std::unique_ptr<ClosedFormCheck> check_;
  double energy_at_start_, drift_ = 0.0, kinetic_ = 0.0;
  Vector3d momentum_at_start_;
  double momentum_drift_ = 0.0, momentum_scale_ = 0.0;
  double deepest_ = 0.0, cone_ = 0.0, force_sum_ = 0.0, force_squares_ = 0.0, moved_ = 0.0;
  int forces_ = 0;
  std::optional<Vector3d> standing_;
  std::vector<ContactReport> contacts_;
};

void sample(const Simulator& simulator, MeasuredPath& path) {
  const Pose X_WR = simulator.rootPose();
  path.p_WR.push_back(X_WR.p);
  path.q_WR.push_back(X_WR.q);
}

/// One run from the start; false: it broke down, and `time` says when.
bool runOnce(const Scene& scene, Simulator& simulator, MeasuredPath* path, double& cpu, double& broke_at) {
  simulator.reset();
  const double dt = simulator.config().dt;
  const std::int64_t ticks = sceneTicks(scene, dt);
  const std::int64_t per_sample = std::max<std::int64_t>(1, std::llround(kPathInterval / dt));
  if (path) sample(simulator, *path);
  const double begun = threadTime();
  for (std::int64_t tick = 0; tick < ticks; ++tick) {
    commandScene(scene, static_cast<double>(tick) * dt, dt, simulator);
    if (simulator.step() != StepStatus::kOk) {
      broke_at = static_cast<double>(tick) * dt;
      cpu = threadTime() - begun;
      return false;
    }
    if (path && (tick + 1) % per_sample == 0) sample(simulator, *path);
  }
  cpu = threadTime() - begun;
  return true;
}

/// One run from where the simulator returns to on reset.
void lookOnce(const LoadedScene& loaded, Simulator& simulator, OwnErrors& errors) {
  simulator.reset();
  Watcher watcher(loaded, simulator);
  if (!watcher.wanted()) return;
  const Scene& scene = loaded.scene;
  const double dt = simulator.config().dt;
  const std::int64_t ticks = sceneTicks(scene, dt);
  const double interval = std::max(kLookInterval, scene.duration / kLooks);
  const std::int64_t per_look = std::max<std::int64_t>(1, std::llround(interval / dt));
  for (std::int64_t tick = 0; tick < ticks; ++tick) {
    commandScene(scene, static_cast<double>(tick) * dt, dt, simulator);
    if (simulator.step() != StepStatus::kOk) return;
    const double time = static_cast<double>(tick + 1) * dt;
    watcher.tick(simulator, time);
    if ((tick + 1) % per_look == 0) watcher.look(simulator, time);
  }
  errors = watcher.errors();
}

void takeWorse(const std::optional<double>& other, std::optional<double>& error) {
  if (other && !(error && *error >= *other)) error = other;
}

void look(const LoadedScene& loaded, Simulator& simulator, OwnErrors& errors) {
  lookOnce(loaded, simulator, errors);
  const SceneStart& start = loaded.scene.start;
  for (int i = 1; i < loaded.scene.headings; ++i) {
    // A heading in which it cannot stand is not an error of the step, and the others still count.
    if (!simulator.setDown(start.x, start.y, start.yaw + 2.0 * M_PI * i / loaded.scene.headings).empty()) continue;
    OwnErrors other;
    lookOnce(loaded, simulator, other);
    takeWorse(other.closed_form, errors.closed_form);
    takeWorse(other.penetration, errors.penetration);
    takeWorse(other.ripple, errors.ripple);
    takeWorse(other.creep, errors.creep);
    takeWorse(other.cone, errors.cone);
    takeWorse(other.energy, errors.energy);
    takeWorse(other.momentum, errors.momentum);
  }
}

}  // namespace

double threadTime() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double MeasuredPath::distance(double time) const {
  double way = 0.0;
  const auto samples = static_cast<std::size_t>(std::llround(time / kPathInterval));
  for (std::size_t i = 1; i < p_WR.size() && i <= samples; ++i) way += (p_WR[i] - p_WR[i - 1]).norm();
  return way;
}

PathError pathError(const MeasuredPath& path, const MeasuredPath& reference, double time) {
  PathError error;
  // The instant before or at the horizon.
  const auto last = static_cast<std::size_t>(time / kPathInterval + 1e-6);
  if (path.p_WR.size() <= last || reference.p_WR.size() <= last) {
    error.largest = error.at_end = error.angle = std::numeric_limits<double>::infinity();
    return error;
  }
  for (std::size_t i = 0; i <= last; ++i) {
    error.at_end = (path.p_WR[i] - reference.p_WR[i]).norm();
    error.largest = std::max(error.largest, error.at_end);
    // By the sine of the half angle: its cosine knows no angle below 1e-8.
    const Eigen::Quaterniond turned = path.q_WR[i] * reference.q_WR[i].conjugate();
    error.angle = std::max(error.angle, 2.0 * std::asin(std::min(1.0, turned.vec().norm())));
  }
  return error;
}

MeasuredRun measureRun(const LoadedScene& loaded, SimConfig config, const MeasureOptions& options) {
  MeasuredRun run;
  config.allow_unstable = true;
  Loaded<Simulator> started = startScene(loaded, config);
  if (!started) {
    for (const Problem& p : started.problems) run.reason += (run.reason.empty() ? "" : "; ") + p.text();
    return run;
  }
  Simulator& simulator = *started.value;
  run.started = true;
  run.step_limit = simulator.certificate().largestStep(config.integrator);
  run.beyond_limit = config.dt > run.step_limit;
  for (const StabilityMode& mode : simulator.certificate().modes) run.fastest = std::max(run.fastest, mode.frequency);
  run.length = loaded.scene.length.value_or(lengthOf(simulator));

  std::vector<double> costs;
  double spent = 0.0, broke_at = 0.0;
  do {
    double cpu = 0.0;
    run.finished = runOnce(loaded.scene, simulator, costs.empty() ? &run.path : nullptr, cpu, broke_at);
    costs.push_back(cpu / loaded.scene.duration);
    spent += cpu;
  } while (run.finished && static_cast<int>(costs.size()) < options.most_repeats && spent < options.repeat_budget);
  run.events = simulator.events();
  std::sort(costs.begin(), costs.end());
  run.cost = {costs.front(), costs[costs.size() / 2], costs.back(), static_cast<int>(costs.size())};
  if (!run.finished) {
    run.reason = "diverged after " + numberText(broke_at) + " s";
    return run;
  }
  if (options.errors) look(loaded, simulator, run.errors);
  return run;
}

}  // namespace ellipsoid_vehicle_sim
