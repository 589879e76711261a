#pragma once

#include <functional>
#include <string>
#include <vector>

#include "drive_scene.h"
#include "ellipsoid_vehicle_sim/trade/study.h"

// Other engines on the same scenes, where they were found when this was built.

namespace ellipsoid_vehicle_sim {

/// "MuJoCo 2.2.2", or "MuJoCo: not found when this was built".
std::vector<std::string> peerVersions();

/// Runs the engines that are there on a scene over one plane: a body of one ellipsoid that is placed, not set down, as a
/// BodyScene, every other vehicle as a DriveScene. Contact stiffness and damping are set to ours as far as an engine has
/// them. error: distance from the same engine's finest run; model_error: from ours. What an engine cannot be told, and what
/// its budget does not pay for, is a row that says why.
std::vector<StudyRow> studyPeers(const LoadedScene& scene, const StudyBudget& budget, const RowListener& told);

/// One ellipsoid over one plane: what every engine can be told.
struct BodyScene {
  Eigen::Vector3d radii, inertia;  ///< semi-axes [m], principal moments [kg m^2], about the same axes.
  double mass = 1.0;               ///< [kg].
  Pose X_WB;
  Eigen::Vector3d v_WB, w_WB;    ///< in W.
  Eigen::Vector3d nhat_W, p_WP;  ///< the plane's normal and a point of it.
  double gravity = 0.0, mu = 0.0;
  double stiffness = 0.0, damping = 0.0;  ///< of the contact [N/m], [N s/m].
  double duration = 0.0;                  ///< [s].
};

/// A run of an engine: the path every kPathInterval; empty where it broke down.
struct PeerRun {
  MeasuredPath path;
  double cpu = 0.0;    ///< of the steps [s].
  std::string cannot;  ///< why the engine cannot be told the scene at all; empty: it can.
};

/// An engine with one of its methods.
struct Peer {
  std::string program, method;
  std::function<PeerRun(const BodyScene& scene, double dt)> run;
  std::function<PeerRun(const DriveScene& scene, double dt)> drive;
};

// Each in a file of its own; no peers where it was not found when this was built.
std::vector<Peer> mujocoPeers();
std::vector<Peer> bulletPeers();
std::vector<Peer> odePeers();
std::string mujocoVersion();
std::string bulletVersion();
std::string odeVersion();

// Of engines that were found.
PeerRun driveMujoco(const DriveScene& scene, const std::string& integrator, double dt);
PeerRun driveBullet(const DriveScene& scene, double dt);
PeerRun driveOde(const DriveScene& scene, double dt);

/// Steps an engine to the end, timing only its steps. `step` advances by dt; `pose` tells where the body is.
template <typename Step, typename GetPose>
PeerRun runPeer(double duration, double dt, Step&& step, GetPose&& pose) {
  PeerRun run;
  const auto ticks = static_cast<std::int64_t>(std::llround(duration / dt));
  const auto per_sample = std::max<std::int64_t>(1, std::llround(kPathInterval / dt));
  const auto sample = [&run, &pose] {
    const Pose X_WB = pose();
    run.path.p_WR.push_back(X_WB.p);
    run.path.q_WR.push_back(X_WB.q);
    return X_WB.allFinite() && X_WB.p.norm() < 1e6;
  };
  sample();
  for (std::int64_t tick = 0; tick < ticks;) {
    const double begun = threadTime();
    const std::int64_t until = std::min(ticks, tick + per_sample);
    for (; tick < until; ++tick) step();
    run.cpu += threadTime() - begun;
    if (tick % per_sample == 0 && !sample()) return {};
  }
  return run;
}

}  // namespace ellipsoid_vehicle_sim
