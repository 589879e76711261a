#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/scene/scene.h"

namespace ellipsoid_vehicle_sim {

/// Every step of the study divides this [s], so that all runs of a scene are known at the same instants.
constexpr double kPathInterval = 0.02;

/// Where the root link was, every kPathInterval from the start on.
struct MeasuredPath {
  std::vector<Eigen::Vector3d> p_WR;
  std::vector<Eigen::Quaterniond> q_WR;

  /// Length of the way up to `time` [m].
  double distance(double time) const;
};

/// How far two paths lie apart up to a time.
struct PathError {
  double largest = 0.0;  ///< distance of the positions, largest over the samples [m].
  double at_end = 0.0;   ///< at the last sample [m].
  double angle = 0.0;    ///< of the rotations, largest [rad].
};

/// Infinite where a path ends before `time`.
PathError pathError(const MeasuredPath& path, const MeasuredPath& reference, double time);

/// CPU time of the calling thread per simulated second.
struct Cost {
  double least = 0.0, median = 0.0, most = 0.0;  ///< over the repeats [s / s].
  int repeats = 0;
};

/// What a run got wrong that needs no other run to be seen. Empty: not asked for by the scene, or not defined.
struct OwnErrors {
  std::optional<double> closed_form;  ///< distance from the closed form, in its own measure; see closed_forms.h.
  std::optional<double> energy;       ///< largest |E - E0| over the largest kinetic energy [-].
  std::optional<double> momentum;     ///< largest change of the horizontal momentum over the largest momentum [-].
  std::optional<double> penetration;  ///< deepest [m].
  std::optional<double> ripple;       ///< standard deviation over mean of the ground's force, second half [-].
  std::optional<double> creep;        ///< way in the second half over its duration [m/s].
  std::optional<double> cone;         ///< largest |f_t| / (mu f_n) - 1, not below 0 [-].
};

struct MeasuredRun {
  bool started = false, finished = false;
  std::string reason;         ///< why it did not start or not finish.
  bool beyond_limit = false;  ///< the step is larger than the certificate allows; run all the same.
  double step_limit = 0.0;    ///< the largest step the certificate allows this integrator [s].
  double fastest = 0.0;       ///< of the certificate's modes [rad/s].
  double length = 0.0;        ///< largest distance across the vehicle's ellipsoids [m].
  Cost cost;
  MeasuredPath path;
  OwnErrors errors;
  StepEvents events;
};

struct MeasureOptions {
  bool errors = true;  ///< look at OwnErrors, in a run of its own.
  double repeat_budget =
      0.1;  ///< CPU time that repeats may take together [s]; at least one run, at most `most_repeats`.
  int most_repeats = 5;
};

/// Runs the scene at this configuration; steps that cannot hold are run all the same, and marked.
MeasuredRun measureRun(const LoadedScene& scene, SimConfig config, const MeasureOptions& options);

/// CPU time of this thread [s].
double threadTime();

}  // namespace ellipsoid_vehicle_sim
