#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "ellipsoid_vehicle_sim/contact/contact_force.h"
#include "ellipsoid_vehicle_sim/contact/find_contacts.h"
#include "ellipsoid_vehicle_sim/geometry/problem.h"

namespace ellipsoid_vehicle_sim {

/// How a tick is integrated; docs/integrators.md says what each is for.
enum class IntegratorKind { kExplicitEuler, kSemiImplicitEuler, kRk4, kRk4Events, kDormandPrince, kLinearlyImplicit };
constexpr int kIntegratorCount = 6;

/// Whether what provably changes no bit of the state is left out, worked out all the same, or both in every tick, compared.
enum class ExactSavings { kOn, kOff, kCheck };

enum class Differential { kOpen, kLocked, kPerWheel };

/// Everything that defines a run besides the vehicle and the world. SI units. An empty optional means: derived at load
/// from the vehicle, and printed. validate() finds every value out of range.
struct SimConfig {
  // Time.
  double dt = 1e-3;                                         ///< tick [s], 1e-6 ... 0.1.
  IntegratorKind integrator = IntegratorKind::kRk4;
  double contact_substeps = 4.0;                            ///< whole number; rk4_events: steps to a tick while anything presses, 1 ... 64.
  double error_tolerance = 1e-6;                            ///< dormand_prince: local error of a step [m].
  double error_estimate_every = 0.0;                        ///< local error by step doubling every so many ticks; 0: never. Whole.
  bool rest_detection = true;                               ///< a vehicle at rest is left where it is.
  std::string accuracy;                                     ///< "fast", "balanced", "exact" or a number; empty: dt and integrator as they are.
  bool dt_given = false, integrator_given = false, substeps_given = false;  ///< somebody asked for them: not together with accuracy.
  bool energy_balance = false;                              ///< account of work lost and supplied; docs/physics.md.
  ExactSavings exact_savings = ExactSavings::kOn;           ///< whether what changes no bit is left out; docs/savings.md.
  bool allow_unstable = false;                              ///< run although the certificate says the step cannot hold.

  // World.
  double gravity = 9.80665;                                 ///< along -z [m/s^2], 0 ... 100.

  // Contact.
  ContactRule contact_rule = ContactRule::kMinimumTranslation;
  ContactsPerEllipsoid contacts_per_ellipsoid = ContactsPerEllipsoid::kValley;
  bool contact_memory = true;                               ///< admission and slack; off only to show what they are for.
  bool candidate_cache = true;                              ///< changes no answer, only the time.
  std::optional<double> stiffness;                          ///< k of every ellipsoid [N/m].
  std::optional<double> damping;                            ///< c of every ellipsoid [N s/m]; goes with stiffness.
  std::optional<double> contact_time;                       ///< duration of a light touch [s]; instead of stiffness.
  double restitution = 0.3;                                 ///< rebound of that touch [-], 0 < e <= 1; unless damping is given.

  // Friction.
  FrictionMode body_friction = FrictionMode::kAnchored;     ///< ellipsoids that are no ground wheels.
  FrictionMode wheel_friction = FrictionMode::kBrush;
  double mu_static = 0.9;                                   ///< where the surface has none of its own.
  double mu_kinetic = 0.9;                                  ///< <= mu_static.
  double stribeck_speed = 0.05;                             ///< slip at which mu has fallen from static to kinetic [m/s].
  double viscous_friction = 1e4;                            ///< f of the seed's law [N s/m], `viscous` only.
  std::optional<double> tangential_stiffness;               ///< k_t [N/m].
  std::optional<double> tangential_damping;                 ///< c_t [N s/m].
  std::optional<double> brush_length;                       ///< relaxation length l of the patch [m].
  std::optional<double> relaxation_time;                    ///< tau [s], bound on how fast the brush forgets.

  // Resistance; none unless asked for.
  double rolling_resistance = 0.0;                          ///< of ground wheels: moment over load times radius [-].
  double drag_area = 0.0;                                   ///< drag coefficient times frontal area [m^2].
  double air_density = 1.225;                               ///< [kg/m^3], 0 ... 100.

  // Vehicle.
  bool allow_no_wheels = false;                             ///< a body that nothing drives (a ball) is meant to have none.
  bool solid_compound = false;                              ///< lock every joint; wheels become treads on one rigid body.
  Differential differential = Differential::kOpen;
  double max_speed = 30.0;                                  ///< commanded speeds are cut to it [m/s].
  double max_acceleration = 3.0;                            ///< of the speed command [m/s^2].
  double max_deceleration = 6.0;                            ///< of the speed command, and of the brakes [m/s^2].
  std::optional<double> max_drive_torque;                   ///< a driven wheel [N m]; default: the joint's effort limit.
  std::optional<double> max_power;                          ///< all driven wheels together [W].
  double brake_balance = 0.6;                               ///< share of the braking on the front half [-].
  double steer_rate = 1.0;                                  ///< [rad/s], unless the joint's velocity limit is lower.
  double steer_acceleration = 20.0;                         ///< [rad/s^2].
  double command_timeout = 0.5;                             ///< older commands mean brake [s].
  double ride_frequency = 1.5;                              ///< of a suspension without a spring in the file [Hz].
  double ride_damping_ratio = 0.4;                          ///< [-].

  bool saves() const { return exact_savings != ExactSavings::kOff; }

  /// Every value out of range, each with its allowed range; the ranges are those of parameter_table.h.
  Problems validate() const;
};

}  // namespace ellipsoid_vehicle_sim
