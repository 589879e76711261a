#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>
#include <string>

// Included where MuJoCo was found only.

namespace ellipsoid_vehicle_sim {

using MujocoModel = std::unique_ptr<mjModel, decltype(&mj_deleteModel)>;
using MujocoData = std::unique_ptr<mjData, decltype(&mj_deleteData)>;

/// Nullptr, and `error` says why, where MuJoCo cannot read its own language.
MujocoModel loadMujoco(const std::string& xml, std::string& error);

// Attributes with every digit.
std::string mujocoNumber(double x);
std::string mujocoVector(const Eigen::Vector3d& v);
std::string mujocoQuaternion(const Eigen::Quaterniond& q);
/// <option> of a method and step, with the friction cone round; `more`: further attributes.
std::string mujocoOption(double dt, double gravity, const std::string& integrator, const std::string& more = "");
/// The infinite ground.
std::string mujocoPlane(const Eigen::Vector3d& nhat_W, const Eigen::Vector3d& p_WP, const std::string& attributes);
/// Contact attributes of a geom whose contact feels `mass`. A negative solref is stiffness and damping per unit of that
/// mass; impedance near one makes the contact as good as a spring of its own.
std::string mujocoContact(double stiffness, double damping, double mass, double mu);

/// It met numbers that are none, or too large, and began anew from the start.
bool mujocoGaveUp(const mjData& data);

}  // namespace ellipsoid_vehicle_sim
