#pragma once

#include <optional>
#include <vector>

#include "ellipsoid_vehicle_sim/contact/find_contacts.h"
#include "ellipsoid_vehicle_sim/dynamics/articulated_body.h"
#include "ellipsoid_vehicle_sim/vehicle/free_flight.h"
#include "ellipsoid_vehicle_sim/vehicle/vehicle_model.h"
#include "ellipsoid_vehicle_sim/vehicle/vehicle_state.h"
#include "ellipsoid_vehicle_sim/world/terrain.h"

namespace ellipsoid_vehicle_sim {

/// A contact with the force it makes, for whoever wants to look.
struct ActiveContact {
  ActiveContact(int ellipsoid_in, const Contact& contact_in) : ellipsoid(ellipsoid_in), contact(contact_in) {}

  int ellipsoid;
  int slot = -1;  ///< of the memory whose anchor it carries on, -1 for a contact first met in this step.
  int from = -1;  ///< of the memory that its stretch comes from: `slot`, or one of about the same normal that it stands beside.
  Contact contact;
  ContactForce force;
  Eigen::Vector3d p_OC;       ///< where the force acts, from the base's origin [m].
  Eigen::Vector3d roll_axis;  ///< of a free tread: the direction it gives way to, else 0.
  Eigen::Vector3d anchor_W;   ///< stretch of the friction, turned to the contact's normal [m].
};

/// A force on an ellipsoid from elsewhere than the terrain.
struct ExternalForce {
  int ellipsoid = 0;
  Eigen::Vector3d p_W, f_W;  ///< point [m], force [N].
};

/// How the surface of an ellipsoid moves where it touches.
struct SurfaceMotion {
  Vec3 v;       ///< against W [m/s].
  Vec3 v_roll;  ///< the part that the ellipsoid's own turning makes [m/s].
};

/// The rate function: one vehicle in one world, (state, command) -> rate. Everything that a force depends on is in its
/// arguments; the members are the constants and the buffers of one evaluation. Not for several threads at once.
class VehicleDynamics {
 public:
  using State = Motion;
  using Rate = MotionRate;

  VehicleDynamics(const VehicleModel& model, const SimConfig& config, const Terrain& terrain);

  /// Friction law of every ellipsoid replaced by `mode`; for set-down, which needs one that holds.
  void overrideFriction(std::optional<FrictionMode> mode);

  /// Every coefficient of friction times `scale`, from the next evaluation on.
  void scaleFriction(double scale);

  /// The frozen part for the evaluations of the coming step. Must outlive them.
  void beginStep(const VehicleState& frozen, double dt);

  // What the integrators ask for; see integrator.h.
  void rate(const Motion& x, double fraction, MotionRate& k) {
    beginRate(x, fraction, k);
    endRate(x, k);
  }
  /// rate() in two halves, between which forces from outside may be added: those of other vehicles.
  void beginRate(const Motion& x, double fraction, MotionRate& k);
  void addForce(const Motion& x, const ExternalForce& force);
  void endRate(const Motion& x, MotionRate& k);
  void positionRates(const Motion& x, MotionRate& k);
  void advance(const Motion& x, double h, const MotionRate& k, Motion& result) const {
    retract(x, h, k, result);
    couple(result);
  }
  void advanceVelocities(Motion& x, double h, const MotionRate& k) const;
  void advancePositions(Motion& x, double h, const MotionRate& k) const;
  void toTangent(double h, const MotionRate& previous, MotionRate& k) const;
  void combine(MotionRate (&k)[4]) const;
  void weightedSum(const double* weights, const MotionRate* k, int n, MotionRate& sum) const {
    ellipsoid_vehicle_sim::weightedSum(weights, k, n, sum);
  }

  /// Joints that mimic others put exactly where these say, and their speeds.
  void couple(Motion& x) const {
    for (const CoordinateCoupling& c : model_.couplings) {
      x.q[c.coordinate] = c.multiplier * x.q[c.leader] + c.offset;
      x.qd[c.coordinate] = c.multiplier * x.qd[c.leader];
    }
  }

  /// Ends a step: contacts at the new pose with the old memory, then the new memory, anchors and holds. `state.motion` is the
  /// new one; its memory is still that of the last step, which `before` gets (what stood there is room for the new one).
  /// Accelerations of prescribed motion hold until the end of the tick: a step that does not end it keeps them.
  /// Returns how many ellipsoid centres went through a triangle.
  int accept(VehicleState& state, double dt, std::vector<ContactMemory>& before, bool ends_tick = true);
  int accept(VehicleState& state, double dt, bool ends_tick = true) { return accept(state, dt, retired_, ends_tick); }
  /// The same where nothing can have touched: no search.
  void acceptFlight(VehicleState& state, double dt, std::vector<ContactMemory>& before, bool ends_tick);

  /// Evaluates at the state itself; afterwards the queries below answer for it. `outside`: forces that do not come from
  /// the terrain.
  void evaluate(const VehicleState& state, MotionRate& k, const std::vector<ExternalForce>& outside = {});
  /// Poses and velocities alone, at the state itself: posedEllipsoids() and centreVelocity() answer for it.
  void poseAt(const VehicleState& state);
  /// Velocity of an ellipsoid's centre, x being the state last posed at, in W [m/s].
  Eigen::Vector3d centreVelocity(const Motion& x, int ellipsoid) const {
    const Vec3 p_OE = Vec3::from(posed_[ellipsoid].p_WE) - Vec3::from(x.X_WB.p);
    return pointVelocity(x, model_.ellipsoids[ellipsoid].body, p_OE).toEigen();
  }
  /// And the angular velocity of the body that carries it [rad/s].
  Eigen::Vector3d turning(int ellipsoid) const { return moving_W_[model_.ellipsoids[ellipsoid].body].angular.toEigen(); }
  const std::vector<ActiveContact>& activeContacts() const { return active_; }
  /// Speed at which the vehicle's surface sinks into an active contact, x being the state last evaluated [m/s].
  double sinkingSpeed(const Motion& x, const ActiveContact& active) const {
    const Vec3 v = pointVelocity(x, model_.ellipsoids[active.ellipsoid].body, Vec3::from(active.p_OC));
    return -dot(Vec3::from(active.contact.nhat_W), v);
  }
  /// The same of the vehicle's surface at the point of a contact; a tread that runs free sets `roll_axis`, along which it
  /// gives way. Asks for ellipsoid, nhat_W, p_WE_lowest and p_OC.
  SurfaceMotion surfaceMotion(const Motion& x, ActiveContact& active) const;
  /// Coefficients of an ellipsoid where the other side has none of its own, friction scale included.
  FrictionCoefficients ownFriction(int ellipsoid) const;
  /// Linear momentum in W [N s], and angular momentum about W's origin [N m s], at the state last evaluated.
  Spatial momentum(const Motion& x) const;
  const std::vector<double>& jointEfforts() const { return joint_effort_; }
  const std::vector<double>& motorTorques() const { return motor_torque_; }
  double prescribedEffort(int prescribed) const;
  double kineticEnergy(const Motion& x) const { return tree_.kineticEnergy(toFrame(R_WB_, Vec3::from(x.v_WB))); }
  double potentialEnergy(const Motion& x) const;   ///< gravity and springs, holds and anchors included [J].
  const ArticulatedBody& tree() const { return tree_; }
  const Terrain& terrain() const { return terrain_; }
  const VehicleModel& model() const { return model_; }
  /// Where the ellipsoids were at the last evaluation.
  const std::vector<PosedEllipsoid>& posedEllipsoids() const { return posed_; }

  /// Rates and motions of the right sizes, so that no step allocates.
  Motion makeMotion() const;
  MotionRate makeRate() const;

 private:
  void prescribe(double fraction);
  void pose(const Motion& x);
  void move(const Motion& x);
  void carryEnds(VehicleState& state, double dt, bool ends_tick) const;
  void standAtEnd(VehicleState& state, double dt, std::vector<ContactMemory>& before, bool ends_tick);
  // Velocity of a point of a body that carries ellipsoids, in W; p_OX from the base's origin, in W.
  Vec3 pointVelocity(const Motion& x, int body, const Vec3& p_OX) const {
    const Spatial& v = moving_W_[body];
    return Vec3::from(x.v_WB) + (v.linear + cross(v.angular, p_OX));
  }
  void findAll(bool at_remembered_pose);
  void applyContacts(const Motion& x);
  void findStretch(ActiveContact& active, const ContactMemory& memory, unsigned& taken) const;
  Anchors acceptContacts(const Motion& x, int ellipsoid, const ContactMemory& old, ContactMemory& memory, double dt);
  double freeTreadSpeed(const Motion& x, int ellipsoid) const;
  void jointForces(const Motion& x, MotionRate& k, bool rates_only);
  void anchorRates(MotionRate& k) const;
  // energy_account.cpp
  Work drainedPower(const Motion& x);
  double stretchPower(const Motion& x, const MotionRate& k) const;
  double anchorsLetGo(const Motion& x) const;
  Vec3 anchorOf(const Motion& x, const ActiveContact& active) const;
  ContactForce forceOf(const ActiveContact& active, const SurfaceMotion& surface) const;
  const FrictionCoefficients& frictionOf(int ellipsoid, int triangle) const {
    return friction_[friction_.size() == 1 ? 0 : friction_row_[ellipsoid] + terrain_.surfaceIndex(triangle)];
  }
  const ContactLaw& lawOf(int ellipsoid) const { return laws_[ellipsoid]; }
  double treadSpeed(int tread) const;
  Vec3 axleOf(int tread, int body) const;  // along W, steered
  bool hasDrag() const { return config_.drag_area > 0.0; }
  void applyRollingResistance(const Motion& x);  // resistance.cpp
  void applyDrag(const Motion& x);               // resistance.cpp

  const VehicleModel& model_;
  const SimConfig& config_;
  const Terrain& terrain_;
  ContactOptions options_;
  ArticulatedBody tree_;
  std::optional<FreeTurning> turning_;  ///< one rigid body that nothing need push.
  bool saves_;  ///< exact_savings.
  bool counts_; ///< energy_balance.
  Work resisted_;  ///< by rolling resistance, drag and forces from outside, in the present evaluation [W].
  Work drained_;   ///< drainedPower() of the last rate().
  std::vector<FrictionCoefficients> friction_;   ///< per surface; a row for each coefficient that ellipsoids have of their own.
  std::vector<std::size_t> friction_row_;        ///< per ellipsoid: where its row begins.
  std::vector<ContactLaw> laws_;                 ///< per ellipsoid.
  Vec3 gravity_W_;
  double friction_scale_ = 1.0;
  bool pushed_ = false;  ///< from outside, in the present evaluation.

  const VehicleState* frozen_ = nullptr;
  const std::vector<ContactMemory>* memory_ = nullptr;  ///< of the last accepted pose.
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
  std::vector<int> touching_bodies_;  ///< those that carry ellipsoids.
  std::vector<Spatial> moving_W_;     ///< their motion along W's axes, as tree_ has it along the base's.
  std::vector<PosedEllipsoid> posed_;
  std::vector<ContactMemory> retired_;  ///< room for accept().
  std::vector<EllipsoidContacts> contacts_;
  std::vector<ContactFinder> finder_;
  std::vector<ActiveContact> active_;
  std::vector<double> joint_effort_;   ///< per dynamic joint.
  std::vector<double> motor_torque_;   ///< per wheel unit.
  std::vector<double> hold_limit_;     ///< per dynamic joint: brake plus dry friction.
};

}  // namespace ellipsoid_vehicle_sim
