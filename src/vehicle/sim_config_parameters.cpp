#include <cctype>

#include "ellipsoid_vehicle_sim/vehicle/accuracy.h"
#include "ellipsoid_vehicle_sim/vehicle/parameter_table.h"

namespace ellipsoid_vehicle_sim {

namespace {

/// A word or a number, kept as text.
Parameter<SimConfig> accuracyParameter() {
  ParameterSpec spec;
  spec.key = "accuracy";
  spec.kind = ParameterKind::kChoice;
  spec.choices = {"fast", "balanced", "exact"};
  spec.number_too = true;
  spec.minimum = 1e-9;
  spec.maximum = 1.0;
  spec.unit = "m/m";
  spec.description =
      "Chooses integrator, dt and contact_substeps: position error per metre travelled (parked or ballistic: per length of the vehicle), "
      "over at most 10 s of what can be predicted. fast is 0.01, balanced 0.001, exact 1.0e-05. Not together with dt, "
      "integrator or contact_substeps. See docs/accuracy.md.";
  return {spec,
          [](SimConfig& config, const ParameterValue& value) { config.accuracy = valueText(value); },
          [](const SimConfig& config) -> std::optional<ParameterValue> {
            if (config.accuracy.empty()) return std::nullopt;
            if (const std::optional<double> number = accuracyTarget(config.accuracy);
                number && std::isdigit(static_cast<unsigned char>(config.accuracy.front())) != 0)
              return *number;
            return config.accuracy;
          }};
}

}  // namespace

ParameterTable<SimConfig> simConfigParameters() {
  using C = SimConfig;
  const std::vector<std::pair<std::string, FrictionMode>> friction_modes = {
      {"viscous", FrictionMode::kViscous}, {"anchored", FrictionMode::kAnchored}, {"brush", FrictionMode::kBrush}};
  const auto given = [](Parameter<C> row, bool C::*flag) {
    row.set = [set = std::move(row.set), flag](C& config, const ParameterValue& value) {
      set(config, value);
      config.*flag = true;
    };
    return row;
  };
  return {
      // Time.
      given(numberParameter(
          "dt", "s", 1e-6, 0.1, &C::dt,
          "Tick: the fixed step of the simulation. A step the vehicle's stiffest mode cannot hold is refused, "
          "with the largest that can."), &C::dt_given),
      given(choiceParameter<C, IntegratorKind>(
          "integrator",
          {{"rk4", IntegratorKind::kRk4},
           {"semi_implicit_euler", IntegratorKind::kSemiImplicitEuler},
           {"explicit_euler", IntegratorKind::kExplicitEuler},
           {"rk4_events", IntegratorKind::kRk4Events},
           {"dormand_prince", IntegratorKind::kDormandPrince},
           {"linearly_implicit", IntegratorKind::kLinearlyImplicit}},
          &C::integrator,
          "rk4 evaluates four times a tick; semi_implicit_euler is the cheapest that keeps a vehicle standing; "
          "explicit_euler is a baseline; rk4_events finds the moment of touch-down and lift-off and takes smaller steps "
          "in contact; dormand_prince chooses its steps within the tick by their error; linearly_implicit holds stiff "
          "vehicles at large ticks. See docs/integrators.md."), &C::integrator_given),
      given(wholeParameter("contact_substeps", "-", 1, 64, &C::contact_substeps,
                           "Steps to a tick while anything presses; rk4_events only."), &C::substeps_given),
      numberParameter("error_tolerance", "m", 1e-12, 1e-2, &C::error_tolerance,
                      "Local error that a step within the tick may make; dormand_prince only."),
      wholeParameter("error_estimate_every", "ticks", 0, 1e6, &C::error_estimate_every,
                     "Every so many ticks the local error is estimated by taking the tick in two halves beside it, for "
                     "diagnostics and the covariance of ground_truth; 0: never. Costs two to three ticks each time, and "
                     "does not change the run."),
      flagParameter("rest_detection", &C::rest_detection,
                    "Leave a braked vehicle where it is once it stands still to 5e-10 m/s; within 6e-9 m of what it would "
                    "do."),
      flagParameter("energy_balance", &C::energy_balance,
                    "Keep account of the work that motors supply and that friction, dampers and brakes take, so that energy can be "
                    "checked in every motion (diagnostics, records). Does not change the run."),
      accuracyParameter(),
      flagParameter("allow_unstable", &C::allow_unstable,
                    "Run although the step cannot hold; only to show what happens then."),
      // World.
      numberParameter("gravity", "m/s^2", 0.0, 100.0, &C::gravity, "Gravity along -z."),
      // Contact.
      choiceParameter<C, ContactRule>(
          "contact_rule",
          {{"minimum_translation", ContactRule::kMinimumTranslation}, {"clamped_point", ContactRule::kClampedPoint}},
          &C::contact_rule, "Which point of a triangle counts. clamped_point is a baseline for comparison."),
      choiceParameter<C, ContactsPerEllipsoid>(
          "contacts_per_ellipsoid", {{"one", ContactsPerEllipsoid::kOne}, {"valley", ContactsPerEllipsoid::kValley}},
          &C::contacts_per_ellipsoid,
          "one: the deepest triangle alone pushes. valley: also a second one that faces elsewhere, so that ground and "
          "wall "
          "carry at once."),
      flagParameter(
          "contact_memory", &C::contact_memory,
          "Admission and slack: what starts below the ground is not thrown out. Off only to show what it is for."),
      choiceParameter<C, ExactSavings>(
          "exact_savings", {{"used", ExactSavings::kOn}, {"unused", ExactSavings::kOff}, {"checked", ExactSavings::kCheck}},
          &C::exact_savings,
          "used: leave out what provably changes no bit (docs/savings.md). unused: work out everything. checked: do both in every tick, "
          "at more than twice the cost, and count ticks that end differently (diagnostics)."),
      flagParameter("candidate_cache", &C::candidate_cache,
                    "Keep the triangles near an ellipsoid, and the proof that one of them alone touches it, over several steps. "
                    "Changes no result, only the time."),
      numberParameter(
          "stiffness", "N/m", 1.0, 1e12, &C::stiffness,
          "Stiffness of every contact. Not given: from contact_time, or derived from vehicle and step, and logged."),
      numberParameter("damping", "N s/m", 0.0, 1e9, &C::damping,
                      "Damping of every contact, together with stiffness. Not given: from restitution."),
      numberParameter("contact_time", "s", 1e-6, 10.0, &C::contact_time,
                      "Duration of a light touch, instead of stiffness."),
      numberParameter("restitution", "-", 1e-6, 1.0, &C::restitution,
                      "Rebound speed over impact speed of a light touch, unless damping is given."),
      // Friction.
      choiceParameter("body_friction", friction_modes, &C::body_friction,
                      "Friction of ellipsoids that are no ground wheels. viscous creeps on slopes."),
      choiceParameter("wheel_friction", friction_modes, &C::wheel_friction,
                      "Friction of ground wheels. brush has slip and cornering stiffness, and holds at standstill."),
      numberParameter("mu_static", "-", 0.0, 10.0, &C::mu_static,
                      "Coulomb coefficient before sliding, where the surface has none of its own."),
      numberParameter("mu_kinetic", "-", 0.0, 10.0, &C::mu_kinetic,
                      "Coulomb coefficient while sliding; not above mu_static."),
      numberParameter("stribeck_speed", "m/s", 1e-6, 100.0, &C::stribeck_speed,
                      "Slip at which the coefficient has fallen from static to kinetic."),
      numberParameter("viscous_friction", "N s/m", 0.0, 1e9, &C::viscous_friction,
                      "Coefficient of viscous friction; only in that mode."),
      numberParameter("tangential_stiffness", "N/m", 1e-3, 1e12, &C::tangential_stiffness,
                      "Stiffness of the friction spring. Not given: derived for each ellipsoid, and logged."),
      numberParameter("tangential_damping", "N s/m", 0.0, 1e9, &C::tangential_damping,
                      "Damping of the friction spring. Not given: derived for each ellipsoid, and logged."),
      numberParameter(
          "brush_length", "m", 1e-6, 10.0, &C::brush_length,
          "Relaxation length of a tyre's patch: slip stiffness is tangential_stiffness times this. Not given: "
          "derived for each wheel, and logged."),
      numberParameter("relaxation_time", "s", 1e-6, 10.0, &C::relaxation_time,
                      "Shortest time in which a rolling patch forgets. Not given: two ticks."),
      // Resistance.
      numberParameter("rolling_resistance", "-", 0.0, 1.0, &C::rolling_resistance,
                      "Of ground wheels: moment against rolling over load times radius; 0.015 is a car on asphalt."),
      numberParameter("drag_area", "m^2", 0.0, 1e4, &C::drag_area,
                      "Drag coefficient times frontal area, in air that stands still; 0.6 is a car."),
      numberParameter("air_density", "kg/m^3", 0.0, 100.0, &C::air_density, "Of the air, for drag_area."),
      // Vehicle.
      flagParameter("allow_no_wheels", &C::allow_no_wheels,
                    "A vehicle without ground wheels is meant to have none (a ball); otherwise it is refused."),
      flagParameter("solid_compound", &C::solid_compound,
                    "Lock every joint: one rigid body, whose wheels are treads that turn without mass."),
      choiceParameter<C, Differential>(
          "differential",
          {{"open", Differential::kOpen}, {"locked", Differential::kLocked}, {"per_wheel", Differential::kPerWheel}},
          &C::differential, "How the torque of a driven axle reaches its two wheels."),
      numberParameter("max_speed", "m/s", 1e-3, 1000.0, &C::max_speed, "Commanded speeds are cut to it."),
      numberParameter("max_acceleration", "m/s^2", 1e-3, 1000.0, &C::max_acceleration, "Of the speed command."),
      numberParameter("max_deceleration", "m/s^2", 1e-3, 1000.0, &C::max_deceleration,
                      "Of the speed command, and of the brakes."),
      numberParameter("max_drive_torque", "N m", 0.0, 1e9, &C::max_drive_torque,
                      "Of each driven wheel. Not given: the joint's effort limit."),
      numberParameter("max_power", "W", 0.0, 1e9, &C::max_power, "Of all driven wheels together. Not given: no limit."),
      numberParameter("brake_balance", "-", 0.0, 1.0, &C::brake_balance, "Share of the braking on the front half."),
      numberParameter("steer_rate", "rad/s", 1e-3, 100.0, &C::steer_rate,
                      "Of steering joints, unless their own velocity limit is lower."),
      numberParameter("steer_acceleration", "rad/s^2", 1e-3, 1e5, &C::steer_acceleration, "Of steering joints."),
      numberParameter("command_timeout", "s", 1e-6, 1e6, &C::command_timeout,
                      "A command older than this, in simulated time, means brake."),
      numberParameter("ride_frequency", "Hz", 0.01, 100.0, &C::ride_frequency,
                      "Of a suspension joint without a spring in the URDF."),
      numberParameter("ride_damping_ratio", "-", 0.0, 10.0, &C::ride_damping_ratio, "Likewise, of its damper."),
  };
}

}  // namespace ellipsoid_vehicle_sim
