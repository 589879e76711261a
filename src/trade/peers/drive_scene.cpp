#include "drive_scene.h"

#include <algorithm>
#include <cmath>

#include "ellipsoid_vehicle_sim/trade/study.h"

namespace ellipsoid_vehicle_sim {

bool DriveSeries::record(const Scene& scene, double duration, Simulator& simulator) {
  add(simulator.state());
  const auto ticks = static_cast<std::int64_t>(std::llround(duration / kInterval));
  for (std::int64_t tick = 0; tick < ticks; ++tick) {
    commandScene(scene, static_cast<double>(tick) * kInterval, kInterval, simulator);
    if (simulator.step() != StepStatus::kOk) return false;
    modes_.push_back(simulator.state().drive.mode);
    add(simulator.state());
  }
  return !modes_.empty();
}

void DriveSeries::add(const VehicleState& state) {
  Moment moment;
  moment.wheel_speed = state.drive.wheel_speed;
  moment.wheel_angle.assign(moment.wheel_speed.size(), 0.0);
  if (!moments_.empty())
    for (std::size_t i = 0; i < moment.wheel_speed.size(); ++i)
      moment.wheel_angle[i] = moments_.back().wheel_angle[i] +
                              0.5 * kInterval * (moments_.back().wheel_speed[i] + moment.wheel_speed[i]);
  for (const ProfileState& profile : state.profiles) moment.paths.push_back({profile.position, profile.velocity});
  moments_.push_back(std::move(moment));
}

std::size_t DriveSeries::tickOf(double time, double& fraction) const {
  // A moment's rounding must not make it the end of the tick before.
  const double ticks = std::max(0.0, time / kInterval);
  const std::size_t tick = std::min(modes_.size() - 1, static_cast<std::size_t>(ticks + 1e-6));
  fraction = std::clamp(ticks - static_cast<double>(tick), 0.0, 1.0);
  return tick;
}

DriveState::Mode DriveSeries::mode(double time) const {
  double fraction = 0.0;
  return modes_[tickOf(time, fraction)];
}

double DriveSeries::wheelSpeed(int wheel, double time) const {
  double fraction = 0.0;
  const std::size_t tick = tickOf(time, fraction), i = static_cast<std::size_t>(wheel);
  return (1.0 - fraction) * moments_[tick].wheel_speed[i] + fraction * moments_[tick + 1].wheel_speed[i];
}

double DriveSeries::wheelAngle(int wheel, double time) const {
  double fraction = 0.0;
  const std::size_t tick = tickOf(time, fraction), i = static_cast<std::size_t>(wheel);
  const double from = moments_[tick].wheel_speed[i], to = moments_[tick + 1].wheel_speed[i];
  return moments_[tick].wheel_angle[i] + kInterval * fraction * (from + 0.5 * fraction * (to - from));
}

DriveSeries::Path DriveSeries::path(int prescribed, double time) const {
  double fraction = 0.0;
  const std::size_t tick = tickOf(time, fraction), i = static_cast<std::size_t>(prescribed);
  const Path &from = moments_[tick].paths[i], &to = moments_[tick + 1].paths[i];
  return {(1.0 - fraction) * from.position + fraction * to.position,
          (1.0 - fraction) * from.velocity + fraction * to.velocity};
}

std::vector<Pose> DriveScene::bodyPoses() const {
  std::vector<Pose> X_WB(model.bodies.size());
  X_WB[0] = start.X_WB;
  for (std::size_t i = 1; i < model.bodies.size(); ++i) {
    const Body& body = model.bodies[i];
    const double q = body.motion == BodyMotion::kDynamic ? start.q[static_cast<std::size_t>(body.coordinate)]
                                                         : series.path(body.coordinate, 0.0).position;
    Pose X;
    if (body.prismatic) {
      X.p = q * body.axis_B;
    } else {
      X.q = Eigen::AngleAxisd(q, body.axis_B);
    }
    X_WB[i] = X_WB[static_cast<std::size_t>(body.parent)] * body.X_PB * X;
  }
  return X_WB;
}

std::optional<GroundPlane> planeOf(const Terrain& terrain) {
  const Triangle first = terrain.triangle(0);
  for (int i = 1; i < terrain.triangleCount(); ++i) {
    const Triangle t = terrain.triangle(i);
    if ((t.nhat_W - first.nhat_W).norm() > 1e-6 || std::abs(first.nhat_W.dot(t.v[0] - first.v[0])) > 1e-5)
      return std::nullopt;
  }
  return GroundPlane{first.nhat_W, first.v[0]};
}

Loaded<DriveScene> makeDriveScene(const LoadedScene& loaded) {
  Loaded<DriveScene> result;
  const std::string where = "other engines";
  const auto cannot = [&result, &where](const std::string& why) { result.problems.push_back({where, why}); };
  Setting setting;
  setting.dt = DriveSeries::kInterval;
  SimConfig config = configAt(loaded.scene, setting);
  config.allow_unstable = true;
  Loaded<Simulator> started = startScene(loaded, config);
  if (!started) {
    result.problems = started.problems;
    return result;
  }
  Simulator& simulator = *started.value;
  const Terrain& terrain = simulator.terrain();
  const std::optional<GroundPlane> plane = planeOf(terrain);
  if (!plane) cannot("the ground is not one plane");
  DriveScene scene;
  scene.model = simulator.model();
  if (!scene.model.treads.empty()) cannot("they have no treads that run about wheels that do not turn");
  if (!scene.model.couplings.empty()) cannot("joints that mimic others are not told to them");
  if (config.rolling_resistance > 0.0 || config.drag_area > 0.0) cannot("rolling resistance and drag are not told to them");
  for (const Surface& surface : terrain.surfaces())
    if (surface.mu_static != terrain.surfaces().front().mu_static ||
        surface.mu_kinetic != terrain.surfaces().front().mu_kinetic) {
      cannot("the ground is more than one surface");
      break;
    }
  if (!result.problems.empty()) return result;

  scene.start = simulator.state().motion;
  scene.nhat_W = plane->nhat_W;
  scene.p_WP = plane->p_WP;
  scene.gravity = config.gravity;
  scene.max_power = config.max_power;
  scene.duration = std::min(loaded.scene.duration, loaded.scene.horizon);
  const Surface& surface = terrain.surfaces().front();
  for (const ModelEllipsoid& e : scene.model.ellipsoids)
    scene.mu.push_back(std::min(e.mu, surface.mu_kinetic.value_or(surface.mu_static.value_or(config.mu_kinetic))));
  if (!scene.series.record(loaded.scene, scene.duration, simulator)) {
    cannot("our own run breaks down, from which wheel speeds and steering are taken");
    return result;
  }
  result.value = std::move(scene);
  return result;
}

}  // namespace ellipsoid_vehicle_sim
