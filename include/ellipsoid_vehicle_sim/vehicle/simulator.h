#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/geometry/pose.h"
#include "ellipsoid_vehicle_sim/geometry/problem.h"
#include "ellipsoid_vehicle_sim/vehicle/certificate.h"
#include "ellipsoid_vehicle_sim/vehicle/drive_command.h"
#include "ellipsoid_vehicle_sim/vehicle/sim_config.h"
#include "ellipsoid_vehicle_sim/vehicle/vehicle_description.h"
#include "ellipsoid_vehicle_sim/vehicle/vehicle_model.h"
#include "ellipsoid_vehicle_sim/vehicle/vehicle_state.h"
#include "ellipsoid_vehicle_sim/world/terrain.h"

namespace ellipsoid_vehicle_sim {

/// What a step ended with. Anything but kOk leaves the state at the last good step, and every later step says so again.
enum class StepStatus {
  kOk,
  kDiverged  ///< the next state would not have been finite; the simulation is frozen until reset.
};

/// One contact as published: where, how deep, with what force. Forces act on the vehicle.
struct ContactReport {
  int ellipsoid = 0;              ///< index into Simulator::ellipsoids().
  int triangle = 0;               ///< index into the terrain; -1: another vehicle is touched.
  int other = -1;                 ///< that vehicle, see Fleet::nameOf().
  int other_ellipsoid = -1;       ///< and which of its ellipsoids.
  Eigen::Vector3d p_WC;           ///< point of the terrain, or of the other ellipsoid [m].
  Eigen::Vector3d nhat_W;         ///< unit, from the terrain, or the other, into the vehicle.
  double depth = 0.0;             ///< geometric penetration [m].
  double normal_force = 0.0;      ///< [N], >= 0.
  Eigen::Vector3d friction_W;     ///< [N], perpendicular to nhat_W.
  double friction_limit = 0.0;    ///< largest friction that the contact can carry now: mu normal_force [N].
  bool sliding = false;           ///< the friction is at the edge of its cone.
};

/// A movable joint as a robot would report it; also the prescribed ones, and the wheels of a solid compound.
struct JointReading {
  double position = 0.0;  ///< [rad] or [m]; wheels count turns without wrapping.
  double velocity = 0.0;
  double effort = 0.0;    ///< of motor, brake, spring or servo on the joint [N m] or [N].
};

/// Where an ellipsoid is fixed, for drawing.
struct EllipsoidPlacement {
  std::string name, link;
  Pose X_LE;
  Eigen::Vector3d radii;
  bool ground_wheel = false;
  std::string source;
};

/// Why one triangle near an ellipsoid pushes it, or not.
struct CandidateReport {
  int triangle = 0;
  TriangleContact alone;      ///< the contact if this were the only triangle; none: feature is kNone.
  double plane_depth = 0.0;   ///< of the ellipsoid's lowest point below the triangle's plane [m]; negative: above.
  bool admitted = false;      ///< whether the contact memory lets it push.
  int rank = -1;              ///< 0: the contact that pushes first; 1, 2: those that still hold it then; -1: does not push.
  std::string reason;         ///< in words.
};

/// The contacts of one ellipsoid explained: every triangle whose box its own box meets, by index.
struct ContactExplanation {
  std::vector<CandidateReport> candidates;
  std::vector<ContactReport> contacts;  ///< those that push, in order.
  double margin = 0.0;  ///< by how much the first is deeper than the next other contact that may push [m].
  double slack = 0.0;   ///< depth that the spring does not feel [m].
};

/// Counts since the last reset of things a user should hear about; none of them stops the run.
struct StepEvents {
  std::int64_t passed_through = 0;    ///< an ellipsoid's centre went through a triangle from front to back.
  std::int64_t effort_exceeded = 0;   ///< ticks in which a prescribed joint needed more than its effort limit and held.
  std::int64_t command_timeouts = 0;  ///< times the command got too old and the brakes came on.
  std::int64_t rejected_commands = 0; ///< non-finite commands, dropped.
  std::int64_t floor_steps = 0;       ///< steps within a tick at the smallest size, less exact than the method promises.
  std::int64_t savings_differences = 0;  ///< ticks that the whole model ended otherwise (exact_savings: checked); never, or it is a fault.
};

/// What the last estimated tick got wrong of the root link's motion: its local error, which says nothing of what has come
/// together before, or of what the motion makes of it later.
struct ErrorEstimate {
  std::int64_t step = -1;  ///< stepCount() at its end; -1: none yet.
  Eigen::Vector3d position_W = Eigen::Vector3d::Zero();          ///< [m].
  Eigen::Vector3d rotation_W = Eigen::Vector3d::Zero();          ///< rotation vector [rad].
  Eigen::Vector3d velocity_W = Eigen::Vector3d::Zero();          ///< [m/s].
  Eigen::Vector3d angular_velocity_W = Eigen::Vector3d::Zero();  ///< [rad/s].
};

/// Where the energy has gone since the last setDown, place, reset or restore [J]; SimConfig::energy_balance keeps it.
struct EnergyBalance {
  double energy = 0.0;    ///< energy() now.
  double start = 0.0;     ///< energy() when the account began.
  double lost = 0.0;      ///< to friction, dampers, brakes and resistance.
  double supplied = 0.0;  ///< by motors, prescribed joints, and other vehicles of a fleet.

  /// What came from nowhere, or, negative, went there: the integrator's doing, and that of depth which the contact memory gives
  /// back (contact_memory).
  double error() const { return energy + lost - supplied - start; }
};

struct Snapshot;  // snapshot.h

/// Vehicle, world and clock: the only thing the ROS layer drives. No ROS in here, no wall clock, no randomness: the same
/// calls give the same bits. Not for use from several threads at once.
class Simulator {
 public:
  /// Compiles the model, checks the step against the stability certificate, or chooses integrator and step where
  /// config.accuracy asks for it (config() and loadReport() then say what); all problems at once. The vehicle is not yet
  /// in the world: call setDown. The terrain is shared, never changed.
  static Loaded<Simulator> create(const VehicleDescription& vehicle, std::shared_ptr<const Terrain> terrain,
                                  const SimConfig& config);
  Simulator(Simulator&&) noexcept;
  Simulator& operator=(Simulator&&) noexcept;
  ~Simulator();

  /// Puts the vehicle at rest on the ground below (x, y) [m] with the heading yaw [rad]: static equilibrium, springs
  /// settled, friction loaded, at least three supports (a vehicle with fewer than three ellipsoids: one). Problems say why
  /// not; the state is then unchanged. Does not touch the clock. Becomes the pose that reset() returns to.
  Problems setDown(double x, double y, double yaw);
  /// Puts the root link at X_WR moving with the given velocity, as it is: contacts it is already in are taken with slack.
  /// Joints at their reference positions, at rest. Becomes the pose that reset() returns to.
  Problems place(const Pose& X_WR, const Eigen::Vector3d& v_WR_W, const Eigen::Vector3d& w_WR_W);
  /// Back to the last setDown or place: everything except the clock, bit for bit.
  void reset();

  /// A new command, in force from the next step until it is older than command_timeout. False: not finite, beyond
  /// kLargestCommand or a negative bound: dropped, counted.
  bool command(const DriveCommand& command);
  /// Commands for single joints, in force likewise; a joint obeys its own before the vehicle's. All or none: problems say
  /// why none, and are counted. A joint on a path holds where it is when its command gets too old.
  Problems commandJoints(const std::vector<JointRequest>& requests);
  /// What commandJoints would say, without taking anything.
  Problems checkJoints(const std::vector<JointRequest>& requests) const;
  /// Every coefficient of friction times `scale` >= 0, from the next step on; reset() does not change it.
  void setFrictionScale(double scale);
  double frictionScale() const;

  /// Everything but the clock: what restore() needs to go on bit for bit. See snapshot.h for files and messages.
  Snapshot save() const;
  /// The step count goes on. Only for snapshots of this very vehicle, world and configuration: snapshot.h checks that.
  void restore(const Snapshot& snapshot);

  /// Advances one tick.
  StepStatus step();

  std::int64_t stepCount() const;   ///< ticks since creation; never goes back.
  double time() const;              ///< stepCount() * dt [s].
  StepStatus status() const;
  const StepEvents& events() const;
  bool commandInForce() const;      ///< false: none yet, or timed out.
  double commandAge() const;        ///< of the last command [s]; infinite before the first.

  Pose rootPose() const;                    ///< X_WR of the URDF's root link.
  Eigen::Vector3d rootVelocity_W() const;   ///< of the root link's origin, in W [m/s].
  Eigen::Vector3d rootAngularVelocity_W() const;  ///< [rad/s].
  Eigen::Vector3d rootAcceleration_W() const;     ///< of the root link's origin, in W, at the present state [m/s^2].
  const std::vector<std::string>& jointNames() const;  ///< every movable joint of the description, in its order.
  void jointReadings(std::vector<JointReading>& out) const;  ///< same order; no allocation once sized.
  /// At the present state, those with other vehicles of a fleet last; no allocation once sized.
  void contacts(std::vector<ContactReport>& out) const;
  /// Where the ellipsoids are, in the order of ellipsoids(); no allocation once sized.
  void posedEllipsoids(std::vector<PosedEllipsoid>& out) const;
  /// Why an ellipsoid (an index into ellipsoids()) is pushed as it is; for looking closely, not for every step.
  ContactExplanation explainContact(int ellipsoid) const;
  const std::vector<EllipsoidPlacement>& ellipsoids() const;
  double largestPenetration() const;  ///< deepest geometric contact right now [m].
  double energy() const;              ///< kinetic + gravity + springs of joints, terrain contacts and friction [J].
  /// The account of it; all zero without SimConfig::energy_balance.
  EnergyBalance energyBalance() const;
  Eigen::Vector3d momentum_W() const;         ///< [N s].
  Eigen::Vector3d angularMomentum_W() const;  ///< about W's origin [N m s].
  double encoderSpeed() const;        ///< forward speed as the wheels' encoders tell it [m/s].
  double encoderYawRate() const;      ///< [rad/s].

  const SimConfig& config() const;
  const VehicleModel& model() const;
  const VehicleState& state() const;
  const Terrain& terrain() const;
  const StabilityCertificate& certificate() const;
  /// The step is larger than the certificate allows: what this simulator says may be nonsense (allow_unstable).
  bool isBeyondCertificate() const;
  /// By step doubling, every error_estimate_every ticks; see there for what it is. Does not change the run by a bit.
  const ErrorEstimate& errorEstimate() const;
  /// The vehicle stands and is left where it is: the last tick was not worked out (rest_detection).
  bool isResting() const;
  /// What was derived and assumed at load, for the log: one line each.
  const std::vector<std::string>& loadReport() const;
  /// FNV-1a over every bit of the state, the friction scale included, except the absolute time.
  std::uint64_t stateHash() const;

 private:
  static Loaded<Simulator> createForAccuracy(const VehicleDescription& vehicle, std::shared_ptr<const Terrain> terrain,
                                             SimConfig config, double target);
  friend class Fleet;
  friend class FleetIsland;
  friend class BroadPhase;
  struct Impl;
  explicit Simulator(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ellipsoid_vehicle_sim
