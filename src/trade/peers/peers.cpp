#include "peers.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ellipsoid_vehicle_sim {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// The scene as every engine can be told it; nullopt for what only we can do.
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
  const Triangle first = simulator.terrain().triangle(0);
  for (int i = 1; i < simulator.terrain().triangleCount(); ++i) {
    const Triangle t = simulator.terrain().triangle(i);
    if ((t.nhat_W - first.nhat_W).norm() > 1e-6 || std::abs(first.nhat_W.dot(t.v[0] - first.v[0])) > 1e-5)
      return std::nullopt;
  }
  BodyScene scene;
  scene.radii = e.radii;
  scene.inertia = I.diagonal();
  scene.mass = model.mass;
  scene.X_WB = simulator.state().motion.X_WB;
  scene.v_WB = simulator.state().motion.v_WB;
  scene.w_WB = simulator.state().motion.w_WB;
  scene.nhat_W = first.nhat_W;
  scene.p_WP = first.v[0];
  scene.gravity = simulator.config().gravity;
  const Surface& surface = simulator.terrain().surface(0);
  scene.mu = surface.mu_kinetic.value_or(surface.mu_static.value_or(simulator.config().mu_kinetic));
  scene.stiffness = e.law.stiffness;
  scene.damping = e.law.damping;
  scene.duration = loaded.scene.duration;
  return scene;
}

}  // namespace

std::vector<std::string> peerVersions() { return {mujocoVersion(), bulletVersion(), odeVersion()}; }

std::vector<StudyRow> studyPeers(const LoadedScene& loaded, const StudyBudget& budget, const RowListener& told) {
  std::vector<StudyRow> rows;
  std::vector<Peer> peers;
  for (const auto& some : {mujocoPeers(), bulletPeers(), odePeers()})
    peers.insert(peers.end(), some.begin(), some.end());
  const Loaded<Simulator> simulator = startScene(loaded, configAt(loaded.scene, Setting{}));
  if (!simulator || peers.empty()) return rows;
  const std::optional<BodyScene> scene = bodyScene(loaded, *simulator.value);
  if (!scene) return rows;
  // Our own finest, for the distance between the models.
  Setting finest;
  finest.dt = 1e-5;
  MeasureOptions options;
  options.errors = false;
  options.repeat_budget = 0.0;
  const MeasuredRun ours = measureRun(loaded, configAt(loaded.scene, finest), options);
  const double horizon = loaded.scene.horizon;

  for (const Peer& peer : peers) {
    // At ten times the resolution of the finest step that is compared with it.
    const double reference_step = std::min(1e-5, 0.1 * budget.steps.front());
    const PeerRun reference = peer.run(*scene, reference_step);
    const PeerRun coarser = peer.run(*scene, 2.0 * reference_step);
    for (const double dt : budget.steps) {
      if (dt <= reference_step) continue;
      StudyRow row;
      row.scene = loaded.scene.name;
      row.program = peer.program;
      row.factor = "peer";
      row.setting.integrator = peer.method;
      row.setting.dt = dt;
      row.setting.contact_rule = row.setting.contacts_per_ellipsoid = row.setting.friction = "its own";
      std::vector<double> costs;
      double spent = 0.0;
      PeerRun run;
      do {
        PeerRun repeat = peer.run(*scene, dt);
        costs.push_back(repeat.cpu / scene->duration);
        spent += repeat.cpu;
        if (costs.size() == 1) run = std::move(repeat);
      } while (costs.size() < 5 && spent < budget.repeats);
      std::sort(costs.begin(), costs.end());
      row.run.started = true;
      row.run.finished = !run.path.p_WR.empty();
      row.run.cost = {costs.front(), costs[costs.size() / 2], costs.back(), static_cast<int>(costs.size())};
      row.status = row.run.finished ? RowStatus::kOk : RowStatus::kFailed;
      row.reason = row.run.finished ? "" : "diverged";
      row.error.largest = row.error.at_end = row.error.angle = row.reference_error = row.relative_error =
          row.model_error = kNaN;
      if (row.run.finished && !reference.path.p_WR.empty()) {
        row.error = pathError(run.path, reference.path, horizon);
        row.reference_error = pathError(coarser.path, reference.path, horizon).largest;
        row.distance = reference.path.distance(horizon);
        row.relative_error = row.error.largest / std::max(row.distance, ours.length);
      }
      if (row.run.finished && ours.finished) row.model_error = pathError(run.path, ours.path, horizon).largest;
      rows.push_back(row);
      if (!told(row, 1.0)) return rows;
    }
  }
  return rows;
}

}  // namespace ellipsoid_vehicle_sim
