#pragma once

#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/scene/scene.h"

// A vehicle put through its paces in a world, with numbers. What is tried depends on the ground about the start:
//
//   flat   level within 12 m: stands, 10 m straight on, turns to the left and to the right, stops when commands stay out
//   ramp   rises ahead at 9 to 11 degrees: stands, climbs
//   other  stands where there is room, drives the longest free straight
//
//   stands    the root link moves less than 1 mm between 10 s and 70 s after the set-down
//   straight  off its line by less than 2 % of the way, after 10 m
//   turns     at low speed, the yaw rate within 5 % of the layout's law: what is commanded; with wheels that have to skid,
//             what skid_steer.h says
//   stop      when commands stay out: for good slower than 10 mm/s within command_timeout, the braking time and 3 s (a car rocks on its tyres), and
//             less than 1 mm moved between 5 s and 10 s
//   climb     up to 2.5 m of the ramp itself, unless the driven wheels' torque or grip is less than that asks for
//   drive     the longest free straight of up to 10 m, without falling through, within the time that it takes

namespace ellipsoid_vehicle_sim {

/// What came of one of the trials.
struct TrialCheck {
  enum class Verdict { kPassed, kFailed, kNotTried };
  std::string name;    ///< "stands", "straight", "left", "right", "stop", "climb", "drive".
  Verdict verdict = Verdict::kNotTried;
  double value = 0.0;  ///< the number that decides, in `unit`.
  std::string unit;
  std::string text;    ///< what happened, in a few words; why it was not tried.
};

/// A vehicle in a world: refused with problems, or tried.
struct TrialResult {
  std::string vehicle, world;  ///< names of the files without folder and ending.
  Problems problems;           ///< why it could not start; no checks then.
  double mass = 0.0;           ///< [kg]
  std::string layout;
  std::string ground;          ///< "flat", "ramp", "other".
  std::vector<TrialCheck> checks;
  std::int64_t passed_through = 0;  ///< ellipsoid centres that went through the ground; a failure of the last check.

  bool passed() const;  ///< nothing refused, nothing failed.
};

/// Runs all trials that the ground calls for. `scene` is made by sceneOf, perhaps with parameters overridden.
TrialResult tryVehicle(const Scene& scene, const std::string& share);

/// One line of JSON: numbers, texts, problems.
std::string trialJson(const TrialResult& result);

}  // namespace ellipsoid_vehicle_sim
