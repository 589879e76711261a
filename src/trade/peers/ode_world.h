#pragma once

#include <ode/ode.h>

#include <Eigen/Core>
#include <mutex>

#include "ellipsoid_vehicle_sim/geometry/pose.h"

// Included where ODE was found only.

namespace ellipsoid_vehicle_sim {

/// An empty world, and ODE to itself: all worlds share one pool of jobs, which two threads at once break.
class OdeWorld {
 public:
  explicit OdeWorld(double gravity);
  ~OdeWorld();
  OdeWorld(const OdeWorld&) = delete;
  OdeWorld& operator=(const OdeWorld&) = delete;

  /// `inertia`: principal [kg m^2]; velocities in W.
  dBodyID addBody(double mass, const Eigen::Vector3d& inertia, const Pose& X_WB, const Eigen::Vector3d& v_WB,
                  const Eigen::Vector3d& w_WB);
  /// Ends a step: contacts are told anew for every one.
  void step(double dt);

 private:
  static std::mutex& mutex();
  std::lock_guard<std::mutex> alone_{mutex()};

 public:
  dWorldID world = nullptr;
  dJointGroupID contacts = nullptr;
};

Pose odePose(dBodyID body);

/// How deep an ellipsoid at X_WE is below a plane, and its lowest point.
struct OdeContact {
  double depth = 0.0;
  Eigen::Vector3d p_WC;
};
OdeContact lowestPoint(const Pose& X_WE, const Eigen::Vector3d& radii, const Eigen::Vector3d& nhat_W,
                       const Eigen::Vector3d& p_WP);

/// ODE has no ellipsoid: its contact joint is told the lowest point over the plane, with spring and damper as its manual
/// gives them in terms of ERP and CFM.
dContact odeContact(const OdeContact& contact, const Eigen::Vector3d& nhat_W, double mu, double stiffness,
                    double damping, double dt);

}  // namespace ellipsoid_vehicle_sim
