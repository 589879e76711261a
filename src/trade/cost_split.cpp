#include "ellipsoid_vehicle_sim/trade/cost_split.h"

#include <algorithm>
#include <cstdio>

#include "ellipsoid_vehicle_sim/contact/contact_force.h"
#include "ellipsoid_vehicle_sim/contact/find_contacts.h"
#include "ellipsoid_vehicle_sim/trade/measured_run.h"
#include "ellipsoid_vehicle_sim/trade/study.h"
#include "ellipsoid_vehicle_sim/vehicle/vehicle_dynamics.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr double kStep = 1e-3;
// States along the scene at which the parts are repeated.
constexpr int kStates = 40;
// Steps in a row whose searches are timed: a search depends on those before it, as lists and proofs are kept.
constexpr std::size_t kStepsInARow = 20;

/// How often a step asks for each part; see VehicleDynamics: contacts of the step's start are remembered, not searched.
struct Evaluations {
  const char* integrator;
  double searches, forces, dynamics;
};
constexpr Evaluations kEvaluations[] = {{"semi_implicit_euler", 1.0, 2.0, 1.0}, {"rk4", 4.0, 4.0, 4.0}};

/// CPU times of one search, one set of forces, one forward dynamics of a vehicle at a state [s].
class Parts {
 public:
  Parts(const Simulator& simulator)
      : simulator_(simulator),
        dynamics_(simulator.model(), simulator.config(), simulator.terrain()),
        rate_(dynamics_.makeRate()),
        finders_(simulator.model().ellipsoids.size()),
        prescribed_(std::max(simulator.model().prescribed_joints.size(), simulator.model().bodies.size())) {}

  /// A step ended: the searches of some steps in a row, `searches` of all ellipsoids in each, are done once more and
  /// timed. Midway in a step stands for every stage but the last two.
  void follow(int searches) {
    dynamics_.evaluate(simulator_.state(), rate_);
    row_.push_back({dynamics_.posedEllipsoids(), simulator_.state().memory});
    if (row_.size() <= kStepsInARow) return;
    const SimConfig& config = simulator_.config();
    const ContactOptions options{config.contact_rule, config.contacts_per_ellipsoid, config.contact_memory,
                                 config.candidate_cache};
    std::vector<std::vector<PosedEllipsoid>> midway(row_.size());
    for (std::size_t k = 1; k < row_.size(); ++k) {
      const std::vector<PosedEllipsoid>&from = row_[k - 1].posed, &to = row_[k].posed;
      for (std::size_t e = 0; e < to.size(); ++e)
        midway[k].emplace_back(0.5 * (from[e].p_WE + to[e].p_WE), to[e].R_WE, to[e].radii);
    }
    int found = 0;
    const double begun = threadTime();
    for (std::size_t k = 1; k < row_.size(); ++k) {
      for (int i = 0; i < searches; ++i) {
        const std::vector<PosedEllipsoid>& posed = i + 2 < searches ? midway[k] : row_[k].posed;
        for (std::size_t e = 0; e < posed.size(); ++e)
          found += findContacts(posed[e], row_[k - 1].memory[e], simulator_.terrain(), options, finders_[e]).count;
      }
    }
    search += (threadTime() - begun) / static_cast<double>(searches) / static_cast<double>(kStepsInARow);
    used += found;
    ++rows;
    row_.clear();
  }

  /// Adds the times at the present state, each repeated `times` times.
  void add(int times) {
    const VehicleState& state = simulator_.state();
    const VehicleModel& model = simulator_.model();
    const SimConfig& config = simulator_.config();
    dynamics_.evaluate(state, rate_);
    double depth = 0.0;
    FrictionCoefficients mu;
    mu.mu_static = config.mu_static;
    mu.mu_kinetic = config.mu_kinetic;
    mu.stribeck_speed = config.stribeck_speed;
    double begun = threadTime();
    for (int i = 0; i < times; ++i)
      for (const ActiveContact& active : dynamics_.activeContacts())
        depth += contactForce(model.ellipsoids[static_cast<std::size_t>(active.ellipsoid)].law, mu,
                              active.contact.nhat_W, active.contact.pressed, active.contact.share, state.motion.v_WB,
                              state.motion.v_WB, active.anchor_W)
                     .normal;
    force += (threadTime() - begun) / times;

    ArticulatedBody tree = dynamics_.tree();
    for (std::size_t p = 0; p < state.profiles.size(); ++p)
      prescribed_[p] = {state.profiles[p].position, state.profiles[p].velocity, state.profiles[p].then};
    const Frame3 R_WB = columns(state.motion.X_WB.q.toRotationMatrix());
    const Vec3 w_B = toFrame(R_WB, Vec3::from(state.motion.w_WB));
    std::vector<double> qdd(std::max<std::size_t>(1, state.motion.q.size()));
    begun = threadTime();
    for (int i = 0; i < times; ++i) {
      tree.positions(state.motion.q.data(), prescribed_.data());
      tree.velocities(w_B, state.motion.qd.data(), prescribed_.data());
      depth += tree.accelerations(dynamics_.jointEfforts().data(), prescribed_.data(), Vec3{0.0, 0.0, -9.8}, qdd.data())
                   .linear.x;
    }
    forward += (threadTime() - begun) / times;
    ++states;
    // What is worked out is used: no compiler may leave it out.
    used += depth;
  }

  double search = 0.0, force = 0.0, forward = 0.0, used = 0.0;
  int states = 0, rows = 0;

 private:
  /// The end of a step.
  struct Step {
    std::vector<PosedEllipsoid> posed;
    std::vector<ContactMemory> memory;
  };

  const Simulator& simulator_;
  VehicleDynamics dynamics_;
  MotionRate rate_;
  std::vector<ContactFinder> finders_;
  std::vector<Step> row_;
  std::vector<PrescribedMotion> prescribed_;
};

}  // namespace

std::vector<CostSplit> splitCost(const LoadedScene& loaded, double budget) {
  std::vector<CostSplit> splits;
  for (const Evaluations& evaluations : kEvaluations) {
    Setting setting;
    setting.integrator = evaluations.integrator;
    setting.dt = kStep;
    SimConfig config = configAt(loaded.scene, setting);
    config.allow_unstable = true;
    config.rest_detection = false;  // a tick at rest has no parts
    Loaded<Simulator> started = startScene(loaded, config);
    if (!started) continue;
    Simulator& simulator = *started.value;
    Parts parts(simulator);
    const std::int64_t ticks = std::min<std::int64_t>(sceneTicks(loaded.scene, kStep), 5000);
    const std::int64_t per_state = std::max<std::int64_t>(1, ticks / kStates);
    constexpr int kRepeats = 20;
    double spent = 0.0;
    std::int64_t done = 0;
    for (; done < ticks && spent < budget; ++done) {
      commandScene(loaded.scene, static_cast<double>(done) * kStep, kStep, simulator);
      const double begun = threadTime();
      if (simulator.step() != StepStatus::kOk) break;
      spent += threadTime() - begun;
      if (done % per_state == per_state / 2) parts.add(kRepeats);
      parts.follow(static_cast<int>(evaluations.searches));
    }
    if (done == 0 || parts.states == 0 || parts.rows == 0) continue;
    // Apart from the clock's own cost: the same ticks without looking at each.
    simulator.reset();
    const double begun = threadTime();
    for (std::int64_t tick = 0; tick < done; ++tick) {
      commandScene(loaded.scene, static_cast<double>(tick) * kStep, kStep, simulator);
      simulator.step();
    }
    CostSplit split;
    split.scene = loaded.scene.name;
    split.integrator = evaluations.integrator;
    split.dt = kStep;
    split.step = (threadTime() - begun) / static_cast<double>(done);
    const double whole = split.step * parts.states;
    split.collision = evaluations.searches * parts.search / (split.step * parts.rows);
    split.force = evaluations.forces * parts.force / whole;
    split.dynamics = evaluations.dynamics * parts.forward / whole;
    split.integration = std::max(0.0, 1.0 - split.collision - split.force - split.dynamics);
    splits.push_back(split);
  }
  return splits;
}

std::string costSplitCsv(const std::vector<CostSplit>& splits) {
  std::string table = "scene,integrator,dt,cpu_us_per_step,collision,force,dynamics,integration\n";
  for (const CostSplit& s : splits) {
    char line[256];
    std::snprintf(line, sizeof line, "%s,%s,%g,%.4g,%.3f,%.3f,%.3f,%.3f\n", s.scene.c_str(), s.integrator.c_str(), s.dt,
                  1e6 * s.step, s.collision, s.force, s.dynamics, s.integration);
    table += line;
  }
  return table;
}

}  // namespace ellipsoid_vehicle_sim
