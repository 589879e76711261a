#pragma once

#include <vector>

#include "ellipsoid_vehicle_sim/contact/find_contacts.h"
#include "ellipsoid_vehicle_sim/dynamics/articulated_body.h"
#include "ellipsoid_vehicle_sim/vehicle/vehicle_model.h"
#include "ellipsoid_vehicle_sim/vehicle/vehicle_state.h"
#include "ellipsoid_vehicle_sim/world/terrain.h"

namespace ellipsoid_vehicle_sim {

/// A contact with the force it makes, for whoever wants to look.
struct ActiveContact {
  int ellipsoid = 0;
  int slot = -1;   ///< of the memory that its anchor belongs to, -1 for a contact first met in this step.
  Contact contact;
  ContactForce force;
  Eigen::Vector3d p_OC = Eigen::Vector3d::Zero();   ///< where the force acts, from the base's origin [m].
  Eigen::Vector3d roll_axis = Eigen::Vector3d::Zero();  ///< of a free tread: the direction it gives way to, else 0.
};

/// The rate function: one vehicle in one world, (state, command) -> rate. Everything that a force depends on is in its
/// arguments; the members are the constants and the buffers of one evaluation. Not for several threads at once.
class VehicleDynamics {
 public:
  using State = Motion;
  using Rate = MotionRate;

  VehicleDynamics(const VehicleModel& model, const SimConfig& config, const Terrain& terrain);

  /// Friction law of every ellipsoid replaced by `mode`; for set-down, which needs one that holds.
  void overrideFriction(std::optional<FrictionMode> mode) { friction_override_ = mode; }

  /// Every coefficient of friction times `scale`, from the next evaluation on.
  void scaleFriction(double scale);

  /// The frozen part for the evaluations of the coming step. Must outlive them.
  void beginStep(const VehicleState& frozen, double dt);

  // What the integrators ask for; see integrator.h.
  void rate(const Motion& x, double fraction, MotionRate& k);
  void positionRates(const Motion& x, MotionRate& k);
  void advance(const Motion& x, double h, const MotionRate& k, Motion& result) const { retract(x, h, k, result); }
  void advanceVelocities(Motion& x, double h, const MotionRate& k) const;
  void advancePositions(Motion& x, double h, const MotionRate& k) const;
  void toTangent(double h, const MotionRate& previous, MotionRate& k) const;
  void combine(MotionRate (&k)[4]) const;

  /// Ends a step: contacts at the new pose with the old memory, then the new memory, anchors and holds. `state.motion` is the
  /// new one; its memory is still that of the last step. Returns how many ellipsoid centres went through a triangle.
  int accept(VehicleState& state, double dt);

  /// Evaluates at the state itself; afterwards the queries below answer for it.
  void evaluate(const VehicleState& state, MotionRate& k);
  const std::vector<ActiveContact>& activeContacts() const { return active_; }
  const std::vector<double>& jointEfforts() const { return joint_effort_; }
  const std::vector<double>& motorTorques() const { return motor_torque_; }
  double prescribedEffort(int prescribed) const;
  double kineticEnergy(const Motion& x) const { return tree_.kineticEnergy(toFrame(R_WB_, Vec3::from(x.v_WB))); }
  double potentialEnergy(const Motion& x) const;   ///< gravity and springs, holds and anchors included [J].
  const ArticulatedBody& tree() const { return tree_; }
  /// Where the ellipsoids were at the last evaluation.
  const std::vector<PosedEllipsoid>& posedEllipsoids() const { return posed_; }

  /// Rates and motions of the right sizes, so that no step allocates.
  Motion makeMotion() const;
  MotionRate makeRate() const;

 private:
  void prescribe(double fraction);
  void pose(const Motion& x);
  void move(const Motion& x);
  Vec3 pointVelocity(const Motion& x, int body, const Vec3& p_OX) const;
  void findAll(bool at_remembered_pose);
  void applyContacts(const Motion& x);
  Eigen::Vector3d surfaceVelocity(const Motion& x, ActiveContact& active, Eigen::Vector3d& v_roll) const;
  void jointForces(const Motion& x, MotionRate& k, bool rates_only);
  void anchorRates(MotionRate& k) const;
  void anchorOf(const Motion& x, ActiveContact& active, Eigen::Vector3d& anchor) const;
  FrictionCoefficients frictionOf(int triangle) const { return friction_[terrain_.surfaceIndex(triangle)]; }
  ContactLaw lawOf(int ellipsoid) const;
  double treadSpeed(int tread) const;

  const VehicleModel& model_;
  const SimConfig& config_;
  const Terrain& terrain_;
  ContactOptions options_;
  ArticulatedBody tree_;
  std::vector<FrictionCoefficients> friction_;   ///< per surface.
  std::optional<FrictionMode> friction_override_;
  Vec3 gravity_W_;

  const VehicleState* frozen_ = nullptr;
  double dt_ = 0.0;
  double fraction_ = 0.0;
  std::vector<PrescribedMotion> prescribed_;
  // An ellipsoid on its body; the last two along the base's axes, for bodies that keep their orientation there.
  struct Mount {
    Vec3 p_BE, p_BE_O;
    Frame3 R_OE;
  };
  std::vector<Mount> mounts_;
  std::vector<double> posed_at_, moving_at_;  ///< what the poses, and the velocities, were worked out from.
  Frame3 R_WB_;
  std::vector<PosedEllipsoid> posed_;
  std::vector<EllipsoidContacts> contacts_;
  std::vector<ContactFinder> finder_;
  std::vector<ActiveContact> active_;
  std::vector<double> joint_effort_;   ///< per dynamic joint.
  std::vector<double> motor_torque_;   ///< per wheel unit.
  std::vector<double> hold_limit_;     ///< per dynamic joint: brake plus dry friction.
};

}  // namespace ellipsoid_vehicle_sim
