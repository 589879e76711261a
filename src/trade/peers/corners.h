#pragma once

#include <string>
#include <vector>

#include "drive_scene.h"

namespace ellipsoid_vehicle_sim {

/// A wheel with what connects it to the chassis, for engines that have a joint of suspension, steering and axle at once
/// (hinge-2). Carrier and knuckle are put into the wheel's centre: their mass, and their inertia across the axle. Vectors
/// are those of the start.
struct Corner {
  int wheel = -1;                            ///< unit of the drive.
  int body = -1;                             ///< of the tree.
  int steer = -1;                            ///< joint on a path, -1 without.
  double steer_sign = 1.0;                   ///< its axis against `up_W`.
  double mass = 0.0, spin = 0.0, across = 0.0;  ///< [kg], [kg m^2] about the axle and across it.
  Pose X_WC;                                 ///< its centre of mass; y runs along the axle.
  Eigen::Vector3d anchor_W;                  ///< where axle and steering axis meet.
  Eigen::Vector3d up_W;                      ///< axis of suspension and steering, square to the axle.
  double stiffness = 0.0, damping = 0.0;     ///< of the suspension [N/m], [N s/m]; stiffness 0: it has none.
  double pressed = 0.0;                      ///< how far the wheel is above where its spring is slack, along up_W [m].
  Eigen::Vector3d v_WC, w_WC;                ///< at the start, in W.
};

/// An ellipsoid on the chassis or on a wheel, in the frame that the engine turns.
struct CornerEllipsoid {
  int index = -1;   ///< of the model's.
  int corner = -1;  ///< -1: the chassis.
  Pose X;
};

struct CornerVehicle {
  double mass = 0.0;
  Eigen::Vector3d inertia;  ///< of the chassis, principal [kg m^2].
  Pose X_BP;                ///< their axes in the base.
  std::vector<Corner> corners;
  std::vector<CornerEllipsoid> ellipsoids;
};

/// Problems say what of the vehicle hinge-2 joints do not have.
Loaded<CornerVehicle> makeCornerVehicle(const DriveScene& scene);

/// Angle by which the corner's axle, as it is in the chassis now, is steered about `up`; both and the axle of straight on
/// in one frame.
double steeredAngle(const Eigen::Vector3d& up, const Eigen::Vector3d& straight, const Eigen::Vector3d& axle);

}  // namespace ellipsoid_vehicle_sim
