#pragma once

#include <Eigen/Core>
#include <complex>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/vehicle/vehicle_dynamics.h"

namespace ellipsoid_vehicle_sim {

/// A spring, damper or servo that forces come from, as a linearisation sees it.
struct ForceElement {
  std::string name;          ///< "contact of 'front_left'", "friction of ...", "suspension joint ...", "brake of ...".
  Eigen::MatrixXd force;     ///< change of its force by each coordinate, a row for each component.
  Eigen::MatrixXd speed;     ///< of the speed that it works against.
};

/// The rate function about a state at rest, in tangent coordinates: base (x, y, z, roll, pitch, yaw), joints, the holds'
/// stretches, the friction's stretches of each carried contact; then the speeds of base and joints.
class Linearisation {
 public:
  /// The arguments must outlive it.
  Linearisation(const VehicleModel& model, VehicleDynamics& dynamics, const VehicleState& rest);

  int size() const { return size_; }
  int positions() const { return positions_; }  ///< how many are position-like; they come first.

  /// In words: "base z", "joint 'axle'", "friction of 'wheel'".
  std::string coordinateName(int i) const;

  /// Derivative of the rates, by central differences; fills elements(), too.
  const Eigen::MatrixXd& jacobian();
  const std::vector<ForceElement>& elements() const { return elements_; }

  /// What does most of the work in a mode: its name, and the coordinate that moves most behind it.
  std::string modeName(const Eigen::VectorXcd& mode) const;

  /// `x` moved by h along a coordinate.
  Motion moved(const Motion& x, int coordinate, double h) const;
  /// Where `x` lies from the rest, in tangent coordinates.
  Eigen::VectorXd tangent(const Motion& x) const;

 private:
  struct Forces {
    std::vector<double> force, speed;
  };
  Eigen::VectorXd rateAt(const Motion& x);
  Forces forcesAt(const Motion& x) const;
  double& component(MotionRate& k, int i) const;
  void nameElements();

  const VehicleModel& model_;
  VehicleDynamics& dynamics_;
  const VehicleState& rest_;
  MotionRate rate_;
  std::size_t joints_ = 0;
  std::vector<std::pair<int, int>> slots_;
  int positions_ = 0, size_ = 0;
  Eigen::MatrixXd J_;
  std::vector<ForceElement> elements_;
};

/// One step of an integrator, linearised: what it makes of a small distance from rest. J as jacobian() has it; `substeps`
/// those of rk4_events. dormand_prince as if it took the step in one.
Eigen::MatrixXd stepMap(IntegratorKind kind, const Eigen::MatrixXd& J, int positions, double dt, double substeps);

}  // namespace ellipsoid_vehicle_sim
