#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/vehicle/certificate.h"
#include "ellipsoid_vehicle_sim/vehicle/scene_kind.h"
#include "ellipsoid_vehicle_sim/vehicle/sim_config.h"

namespace ellipsoid_vehicle_sim {

// The dial `accuracy`: from metres of error per metre of way to an integrator, its step and its contact sub-steps.

/// One point of a measured curve: scripts/make_accuracy_curves writes them from what trade_off measured.
struct AccuracyPoint {
  SceneKind kind;           ///< measured on scenes of this kind.
  const char* integrator;   ///< as the parameter spells it.
  double omega_dt;          ///< step in units of the fastest mode of the certificate [-].
  double error;             ///< that all scenes of the kind but one in ten, and at least one, stay below [m/m].
  double tick_cost;         ///< CPU time of a tick over one of semi_implicit_euler [-].
  double substeps = 0.0;    ///< contact_substeps; of rk4_events only, else 0.
};

const std::vector<AccuracyPoint>& accuracyCurves();

/// Position error per metre travelled (parked or ballistic: per characteristic length) that a word stands for, or the number
/// itself: fast 1e-2, balanced 1e-3, exact 1e-5. nullopt: neither.
std::optional<double> accuracyTarget(const std::string& accuracy);

struct AccuracyChoice {
  IntegratorKind integrator = IntegratorKind::kRk4;
  double dt = 1e-3;
  double substeps = 0.0;        ///< contact_substeps; 0: the integrator has none, they stay as they are.
  double expected_error = 0.0;  ///< by the curve [m/m].
  bool reached = false;         ///< false: no measured setting is so exact, this is the most exact one.
  std::string reason;           ///< in words, for the log.
};

/// The cheapest setting whose curve stays below the target, at a step that the certificate holds with a tenth to spare;
/// steps divide 20 ms.
AccuracyChoice chooseAccuracy(double target, SceneKind kind, const StabilityCertificate& certificate,
                              const std::vector<AccuracyPoint>& curves);

}  // namespace ellipsoid_vehicle_sim
