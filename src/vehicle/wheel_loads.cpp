#include "wheel_loads.h"

#include <Eigen/QR>

namespace ellipsoid_vehicle_sim {

RestGeometry restGeometry(const VehicleModel& model) {
  RestGeometry rest;
  rest.X_RB.resize(model.bodies.size());
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  double mass = 0.0;
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    const Body& body = model.bodies[i];
    rest.X_RB[i] = i == 0 ? model.X_BR.inverse() : rest.X_RB[body.parent] * body.X_PB;
    moment += body.inertia.mass * (rest.X_RB[i] * body.inertia.p_Acm);
    mass += body.inertia.mass;
  }
  rest.p_Rcm = mass > 0.0 ? Eigen::Vector3d(moment / mass) : Eigen::Vector3d::Zero();
  return rest;
}

std::vector<double> carriedLoads(const VehicleModel& model, const std::vector<int>&, double gravity) {
  std::vector<double> loads(model.dynamic_joints.size(), 0.0);
  const auto& wheels = model.drive.wheels;
  if (wheels.empty()) return loads;
  const RestGeometry rest = restGeometry(model);

  // Weight and both moments, carried with the smallest loads that do it.
  Eigen::MatrixXd balance(3, wheels.size());
  for (std::size_t i = 0; i < wheels.size(); ++i) balance.col(i) << 1.0, wheels[i].p_FW.x(), wheels[i].p_FW.y();
  const Eigen::Vector3d p_Fcm = Eigen::AngleAxisd(-model.description.forward_yaw, Eigen::Vector3d::UnitZ()) * rest.p_Rcm;
  const Eigen::Vector3d weight = model.mass * gravity * Eigen::Vector3d(1.0, p_Fcm.x(), p_Fcm.y());
  const Eigen::VectorXd wheel_load = balance.completeOrthogonalDecomposition().solve(weight);

  for (std::size_t j = 0; j < model.dynamic_joints.size(); ++j) {
    const int body = model.dynamic_joints[j].body;
    if (!model.bodies[body].prismatic) continue;
    const auto hangsBelow = [&](int other) {
      for (; other > 0; other = model.bodies[other].parent)
        if (other == body) return true;
      return false;
    };
    const double up = (rest.X_RB[body].q * model.bodies[body].axis_B).z();
    for (std::size_t i = 0; i < model.bodies.size(); ++i)
      if (hangsBelow(static_cast<int>(i))) loads[j] -= up * model.bodies[i].inertia.mass * gravity;
    for (std::size_t i = 0; i < wheels.size(); ++i)
      if (hangsBelow(model.ellipsoids[wheels[i].ellipsoid].body)) loads[j] += up * wheel_load[i];
  }
  return loads;
}

}  // namespace ellipsoid_vehicle_sim
