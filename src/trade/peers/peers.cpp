#include "peers.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "../reference.h"
#include "ellipsoid_vehicle_sim/description/number_text.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// Steps that an engine's finest run may have [s]; each divides kPathInterval, and so does its double. The last one is
// taken whatever it costs: a run at a millisecond has nothing to be compared with otherwise.
constexpr double kFinestSteps[] = {1e-6, 2e-6, 5e-6, 1e-5, 2e-5, 5e-5, 1e-4, 2e-4};
// Of an engine's budget, for that run with the one at twice its step, and for the rows [-].
constexpr double kReferenceShare = 0.75, kRowShare = 0.6;

/// The scene as a body of one ellipsoid, which every engine can be told; nullopt where it is more.
std::optional<BodyScene> bodyScene(const LoadedScene& loaded, const Simulator& simulator) {
  const VehicleModel& model = simulator.model();
  if (loaded.scene.start.set_down || !loaded.scene.commands.empty()) return std::nullopt;
  if (model.description.links.size() != 1 || model.ellipsoids.size() != 1) return std::nullopt;
  const ModelEllipsoid& e = model.ellipsoids.front();
  const LinkDescription& link = model.description.links.front();
  // The engines are told principal axes that are those of the ellipsoid, about its centre.
  const Eigen::Matrix3d& I = link.I_cm_L;
  const Eigen::Matrix3d off = I - Eigen::Matrix3d(I.diagonal().asDiagonal());
  if (e.X_BE.p.norm() > 1e-12 || !e.R_BE.isIdentity(1e-12) || off.norm() > 1e-12 * I.norm()) return std::nullopt;
  const std::optional<GroundPlane> plane = planeOf(simulator.terrain());
  if (!plane) return std::nullopt;
  BodyScene scene;
  scene.radii = e.radii;
  scene.inertia = I.diagonal();
  scene.mass = model.mass;
  scene.X_WB = simulator.state().motion.X_WB;
  scene.v_WB = simulator.state().motion.v_WB;
  scene.w_WB = simulator.state().motion.w_WB;
  scene.nhat_W = plane->nhat_W;
  scene.p_WP = plane->p_WP;
  scene.gravity = simulator.config().gravity;
  const Surface& surface = simulator.terrain().surface(0);
  scene.mu = surface.mu_kinetic.value_or(surface.mu_static.value_or(simulator.config().mu_kinetic));
  scene.stiffness = e.law.stiffness;
  scene.damping = e.law.damping;
  scene.duration = loaded.scene.duration;
  return scene;
}

StudyRow rowOf(const LoadedScene& loaded, const Peer& peer, double dt) {
  StudyRow row;
  row.scene = loaded.scene.name;
  row.program = peer.program;
  row.factor = "peer";
  row.setting.integrator = peer.method;
  row.setting.dt = dt;
  row.setting.contact_rule = row.setting.contacts_per_ellipsoid = row.setting.friction = "its own";
  row.error.largest = row.error.at_end = row.error.angle = row.reference_error = row.relative_error = row.model_error =
      kNaN;
  return row;
}

StudyRow leftOut(const LoadedScene& loaded, const Peer& peer, double dt, const std::string& why) {
  StudyRow row = rowOf(loaded, peer, dt);
  row.status = RowStatus::kLeftOut;
  row.reason = why;
  return row;
}

/// What all rows of an engine on a scene have in common.
struct Work {
  std::function<PeerRun(double dt)> run;
  double duration = 0.0;        ///< simulated [s].
  double reference_step = 0.0;  ///< of its own finest run [s].
  double budget = 0.0;          ///< of CPU time for the rows [s].
  double tick = 0.0;            ///< CPU time of a step, about [s].
};

/// Steps that the budget pays for; the finest ones are left out.
Work plan(std::function<PeerRun(double)> run, double tick, double duration, double budget) {
  Work work{std::move(run), duration, 0.0, kRowShare * budget, tick};
  for (const double step : kFinestSteps) {
    work.reference_step = step;
    if (1.5 * duration / step * tick <= kReferenceShare * budget) break;
  }
  return work;
}

/// Our own run that the engines' are compared with, and the characteristic length of the scene.
struct Ours {
  MeasuredPath path;
  double length = 0.0;
};

/// The rows of one engine, coarsest step first; false: stop here.
bool addRows(const LoadedScene& loaded, const Peer& peer, const Work& work, const Ours& ours,
             const StudyBudget& budget, const RowListener& told, std::vector<StudyRow>& rows) {
  const double horizon = loaded.scene.horizon;
  const PeerRun reference = work.run(work.reference_step), coarser = work.run(2.0 * work.reference_step);
  double spent_on_rows = 0.0;
  for (auto step = budget.steps.rbegin(); step != budget.steps.rend(); ++step) {
    const double dt = *step, expected = work.duration / dt * work.tick;
    if (dt <= work.reference_step * (1.0 + 1e-9) || spent_on_rows + expected > work.budget) {
      rows.push_back(leftOut(loaded, peer, dt,
                             "takes " + numberText(expected) + " s of CPU, more than is left for this engine; its finest run has " +
                                 numberText(work.reference_step) + " s a step"));
      if (!told(rows.back(), 1.0)) return false;
      continue;
    }
    StudyRow row = rowOf(loaded, peer, dt);
    std::vector<double> costs;
    double spent = 0.0;
    PeerRun run;
    do {
      PeerRun repeat = work.run(dt);
      costs.push_back(repeat.cpu / work.duration);
      spent += repeat.cpu;
      if (costs.size() == 1) run = std::move(repeat);
    } while (costs.size() < 5 && spent < budget.repeats);
    spent_on_rows += spent;
    std::sort(costs.begin(), costs.end());
    row.run.started = true;
    row.run.finished = !run.path.p_WR.empty();
    row.run.cost = {costs.front(), costs[costs.size() / 2], costs.back(), static_cast<int>(costs.size())};
    row.status = row.run.finished ? RowStatus::kOk : RowStatus::kFailed;
    row.reason = row.run.finished ? "" : "diverged";
    if (row.run.finished && !reference.path.p_WR.empty()) {
      row.error = pathError(run.path, reference.path, horizon);
      row.reference_error = pathError(coarser.path, reference.path, horizon).largest;
      row.distance = reference.path.distance(horizon);
      row.relative_error = row.error.largest / std::max(row.distance, ours.length);
    }
    if (row.run.finished && !ours.path.p_WR.empty())
      row.model_error = pathError(run.path, ours.path, horizon).largest;
    rows.push_back(row);
    if (!told(row, 1.0)) return false;
  }
  return true;
}

std::vector<StudyRow> studyBody(const LoadedScene& loaded, const BodyScene& scene, const std::vector<Peer>& peers,
                                const StudyBudget& budget, const RowListener& told) {
  std::vector<StudyRow> rows;
  Setting finest;
  finest.dt = 1e-5;
  MeasureOptions options;
  options.errors = false;
  options.repeat_budget = 0.0;
  const MeasuredRun own = measureRun(loaded, configAt(loaded.scene, finest), options);
  const Ours ours{own.finished ? own.path : MeasuredPath{}, own.length};
  for (const Peer& peer : peers) {
    // At ten times the resolution of the finest step that is compared with it.
    const Work work{[&](double dt) { return peer.run(scene, dt); }, scene.duration,
                    std::min(1e-5, 0.1 * budget.steps.front()), std::numeric_limits<double>::infinity(), 0.0};
    if (!addRows(loaded, peer, work, ours, budget, told, rows)) break;
  }
  return rows;
}

std::vector<StudyRow> studyDrive(const LoadedScene& loaded, DriveScene& scene, const std::vector<Peer>& peers,
                                 const StudyBudget& budget, const RowListener& told) {
  std::vector<StudyRow> rows;
  const Reference reference = makeReference(loaded, Setting{}, budget.reference);
  LoadedScene begins = loaded;
  begins.scene.duration = kPathInterval;
  MeasureOptions options;
  options.errors = false;
  options.repeat_budget = 0.0;
  const Ours ours{reference.usable ? reference.path : MeasuredPath{},
                  measureRun(begins, configAt(loaded.scene, Setting{}), options).length};
  const double step = 1e-3, whole = scene.duration;
  for (const Peer& peer : peers) {
    scene.duration = std::min(whole, 100.0 * step);
    const PeerRun trial = peer.drive(scene, step);
    const double tick = trial.cpu * step / scene.duration;
    scene.duration = whole;
    if (!trial.cannot.empty() || trial.path.p_WR.empty()) {
      rows.push_back(leftOut(loaded, peer, step, trial.cannot));
      if (trial.cannot.empty()) {
        rows.back().status = RowStatus::kFailed;
        rows.back().reason = "diverged within the first 100 steps";
      }
      if (!told(rows.back(), 1.0)) break;
      continue;
    }
    const auto run = [&peer, &scene](double dt) { return peer.drive(scene, dt); };
    // Together they get as much as our own rows.
    const Work work = plan(run, tick, whole, budget.cells / static_cast<double>(peers.size()));
    if (!addRows(loaded, peer, work, ours, budget, told, rows)) break;
  }
  return rows;
}

}  // namespace

std::vector<std::string> peerVersions() { return {mujocoVersion(), bulletVersion(), odeVersion()}; }

std::vector<StudyRow> studyPeers(const LoadedScene& loaded, const StudyBudget& budget, const RowListener& told) {
  std::vector<Peer> peers;
  for (const auto& some : {mujocoPeers(), bulletPeers(), odePeers()})
    peers.insert(peers.end(), some.begin(), some.end());
  if (peers.empty()) return {};
  SimConfig config = configAt(loaded.scene, Setting{});
  config.allow_unstable = true;
  const Loaded<Simulator> simulator = startScene(loaded, config);
  if (simulator)
    if (const std::optional<BodyScene> scene = bodyScene(loaded, *simulator.value))
      return studyBody(loaded, *scene, peers, budget, told);
  Loaded<DriveScene> scene = makeDriveScene(loaded);
  if (scene) return studyDrive(loaded, *scene.value, peers, budget, told);
  std::vector<StudyRow> rows;
  for (const Peer& peer : peers) {
    rows.push_back(leftOut(loaded, peer, Setting{}.dt, problemText(scene.problems)));
    if (!told(rows.back(), 1.0)) break;
  }
  return rows;
}

}  // namespace ellipsoid_vehicle_sim
