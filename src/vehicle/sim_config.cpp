#include "ellipsoid_vehicle_sim/vehicle/sim_config.h"

#include "ellipsoid_vehicle_sim/vehicle/accuracy.h"
#include "ellipsoid_vehicle_sim/vehicle/parameter_table.h"

namespace ellipsoid_vehicle_sim {

Problems SimConfig::validate() const {
  Problems problems;
  const auto fail = [&problems](const std::string& name, const std::string& message) {
    problems.push_back({"parameter '" + name + "'", message});
  };
  for (const auto& row : simConfigParameters()) {
    const auto value = row.get(*this);
    if (!value) continue;  // not given: derived at load
    if (const auto reason = refusal(row.spec, *value)) fail(row.spec.key, *reason);
  }

  // What only several values together can get wrong.
  if (!accuracy.empty()) {
    const SimConfig defaults;
    const auto both = [&](const std::string& name) {
      fail("accuracy", "is '" + accuracy + "' together with " + name + ": it chooses that itself; give one of them");
    };
    if (!accuracyTarget(accuracy)) fail("accuracy", "'" + accuracy + "' is neither fast, balanced, exact nor a number from 1e-9 to 1");
    if (dt_given || dt != defaults.dt) both("dt");
    if (integrator_given || integrator != defaults.integrator) both("integrator");
    if (substeps_given || contact_substeps != defaults.contact_substeps) both("contact_substeps");
    if (allow_unstable) both("allow_unstable");
  }
  if (damping && !stiffness) fail("damping", "is given without stiffness; give both, or contact_time and restitution");
  if (stiffness && contact_time) fail("contact_time", "is given together with stiffness; give one of them");
  if (mu_kinetic > mu_static)
    fail("mu_kinetic", "is " + std::to_string(mu_kinetic) + ", above mu_static = " + std::to_string(mu_static) +
                           "; sliding friction cannot exceed the static one");
  return problems;
}

}  // namespace ellipsoid_vehicle_sim
