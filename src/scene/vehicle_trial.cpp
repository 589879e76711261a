#include "ellipsoid_vehicle_sim/scene/vehicle_trial.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "ellipsoid_vehicle_sim/description/number_text.h"
#include "ellipsoid_vehicle_sim/scene/free_straight.h"
#include "trial_expectations.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;
using Verdict = TrialCheck::Verdict;

constexpr double kStandFrom = 10.0, kStandTo = 70.0;  // [s]
constexpr double kStandDrift = 1e-3;                  // [m]
constexpr double kWay = 10.0;                         // [m]
constexpr double kOffLine = 0.02;                     // of the way
constexpr double kTurnError = 0.05;                   // of the yaw rate
constexpr double kStopped = 1e-2;                     // [m/s]
constexpr double kStopMargin = 3.0;                   // [s]
constexpr double kUphill = 2.5;                       // on the slope itself, to count as climbing [m]
constexpr double kSpins = 4.0;                        // wheel radii per second: walking pace for every size

std::string rounded(double value) {
  if (value == 0.0 || !std::isfinite(value)) return numberText(value);
  const double unit = std::pow(10.0, std::floor(std::log10(std::abs(value))) - 2.0);
  return numberText(std::round(value / unit) * unit);
}

/// The vehicle, and everything that is measured of it.
class Trial {
 public:
  Trial(Simulator& simulator, const Terrain& terrain) : sim_(simulator), terrain_(terrain), dt_(simulator.config().dt) {
    speed_ = trialSpeed(sim_.model(), sim_.config(), kSpins);
  }

  bool ok() const { return sim_.status() == StepStatus::kOk; }
  double speed() const { return speed_; }

  /// Commands for so long, or until `until` says so; false if the state broke down.
  template <typename Until>
  bool drive(double speed, double yaw_rate, double duration, Until&& until) {
    DriveCommand command;
    command.speed = speed;
    command.yaw_rate = yaw_rate;
    for (std::int64_t i = 0; i < ticks(duration) && !until(); ++i) {
      sim_.command(command);
      if (sim_.step() != StepStatus::kOk) return false;
    }
    return true;
  }
  bool drive(double speed, double yaw_rate, double duration) {
    return drive(speed, yaw_rate, duration, [] { return false; });
  }
  bool wait(double duration) {
    for (std::int64_t i = 0; i < ticks(duration); ++i)
      if (sim_.step() != StepStatus::kOk) return false;
    return true;
  }

  Vector3d forward() const {
    Vector3d ahead = sim_.rootPose().q * forwardOf(sim_.model());
    ahead.z() = 0.0;
    return ahead.normalized();
  }

  TrialCheck stands() {
    TrialCheck check{"stands", Verdict::kFailed, 0.0, "mm", ""};
    sim_.reset();
    if (!wait(kStandFrom)) return broken(check);
    const Vector3d at = sim_.rootPose().p;
    double drift = 0.0;
    for (double t = kStandFrom; t < kStandTo; t += 1.0) {
      if (!wait(1.0)) return broken(check);
      drift = std::max(drift, (sim_.rootPose().p - at).norm());
    }
    check.value = 1e3 * drift;
    check.verdict = drift < kStandDrift ? Verdict::kPassed : Verdict::kFailed;
    check.text = "moved " + rounded(1e3 * drift) + " mm from 10 s to 70 s";
    return check;
  }

  TrialCheck straight(const std::string& name, double way) {
    TrialCheck check{name, Verdict::kFailed, 0.0, "%", ""};
    if (!drives(check)) return check;
    sim_.reset();
    const Vector3d from = sim_.rootPose().p, ahead = forward(), left(-ahead.y(), ahead.x(), 0.0);
    double went = 0.0, off = 0.0;
    const double patience = 5.0 + 2.0 * way / speed_ + speed_ / sim_.config().max_acceleration;
    if (!drive(speed_, 0.0, patience, [&] {
          const Vector3d moved = sim_.rootPose().p - from;
          went = moved.dot(ahead);
          off = std::max(off, std::abs(moved.dot(left)));
          return went >= way;
        }))
      return broken(check);
    check.value = 100.0 * off / way;
    const bool arrived = went >= way;
    const bool in_line = name == "drive" || off < kOffLine * way;
    check.verdict = arrived && in_line ? Verdict::kPassed : Verdict::kFailed;
    check.text = "went " + rounded(went) + " m at " + rounded(speed_) + " m/s, " + rounded(1e3 * off) + " mm off its line";
    if (!arrived) check.text += ", gave up " + rounded(way) + " m after " + rounded(patience) + " s";
    return check;
  }

  TrialCheck turn(double side) {
    TrialCheck check{side > 0.0 ? "left" : "right", Verdict::kFailed, 0.0, "%", ""};
    if (!drives(check)) return check;
    sim_.reset();
    const TurnExpectation turn = turnFor(sim_, speed_, side);
    if (!turn.possible) {
      check.verdict = Verdict::kNotTried;
      check.text = turn.law;
      return check;
    }
    // Steering has to get there, casters to swing round, a trailer to follow.
    if (!drive(turn.speed, turn.commanded, 6.0 + 2.0 / std::abs(turn.commanded))) return broken(check);
    const double before = sim_.time();
    double turned = 0.0;
    Vector3d last = forward();
    const double enough = 0.5 * M_PI;
    if (!drive(turn.speed, turn.commanded, std::min(60.0, 2.0 * enough / std::abs(turn.commanded)), [&] {
          const Vector3d now = forward();
          turned += std::atan2(last.cross(now).z(), last.dot(now));
          last = now;
          return std::abs(turned) > enough;
        }))
      return broken(check);
    const double rate = turned / (sim_.time() - before);
    check.value = 100.0 * (rate / turn.expected - 1.0);
    check.verdict = std::abs(check.value) < 100.0 * kTurnError ? Verdict::kPassed : Verdict::kFailed;
    check.text = "yaw rate " + rounded(rate) + " rad/s at " + rounded(turn.speed) + " m/s, by " + turn.law + " " +
                 rounded(turn.expected);
    return check;
  }

  TrialCheck stop() {
    TrialCheck check{"stop", Verdict::kFailed, 0.0, "s", ""};
    if (!drives(check)) return check;
    sim_.reset();
    if (!drive(speed_, 0.0, 2.0 + speed_ / sim_.config().max_acceleration)) return broken(check);
    const double before = sim_.time();
    const double patience = sim_.config().command_timeout + speed_ / sim_.config().max_deceleration + kStopMargin;
    double last_moving = 0.0;
    Vector3d at = sim_.rootPose().p;
    while (sim_.time() - before < 10.0) {
      if (sim_.step() != StepStatus::kOk) return broken(check);
      if (sim_.time() - before < 5.0) at = sim_.rootPose().p;
      if (sim_.rootVelocity_W().norm() >= kStopped) last_moving = sim_.time() - before;
    }
    check.value = last_moving;
    const double moved = (sim_.rootPose().p - at).norm();
    check.verdict = last_moving < patience && moved < kStandDrift ? Verdict::kPassed : Verdict::kFailed;
    check.text = "for good below 10 mm/s " + rounded(last_moving) + " s after the last command, then moved " +
                 rounded(1e3 * moved) + " mm from 5 s to 10 s";
    return check;
  }

  /// `way`: to a place well on the slope [m].
  TrialCheck climb(double way) {
    TrialCheck check{"climb", Verdict::kFailed, 0.0, "m", ""};
    if (!drives(check)) return check;
    sim_.reset();
    const ClimbExpectation expected = climbFor(sim_, 10.0 * M_PI / 180.0);
    const Vector3d from = sim_.rootPose().p, ahead = forward();
    double went = 0.0;
    if (!drive(speed_, 0.0, 10.0 + 3.0 * way / speed_, [&] {
          went = (sim_.rootPose().p - from).dot(ahead);
          return went >= way;
        }))
      return broken(check);
    check.value = sim_.rootPose().p.z() - from.z();
    const bool climbed = went >= way;
    check.verdict = climbed || !expected.possible ? Verdict::kPassed : Verdict::kFailed;
    check.text = (climbed ? "rose " : "rose only ") + rounded(check.value) + " m in " + rounded(went) + " m; " + expected.text;
    return check;
  }

 private:
  std::int64_t ticks(double duration) const { return std::max<std::int64_t>(1, std::llround(duration / dt_)); }

  bool drives(TrialCheck& check) const {
    for (const WheelUnit& wheel : sim_.model().drive.wheels)
      if (wheel.driven) return true;
    check.verdict = Verdict::kNotTried;
    check.text = "nothing drives it";
    return false;
  }

  TrialCheck& broken(TrialCheck& check) const {
    check.text = "the state would not have been finite after " + rounded(sim_.time()) + " s";
    return check;
  }

  Simulator& sim_;
  const Terrain& terrain_;
  double dt_, speed_ = 0.0;
};

/// The ground about a start, as far as a trial is concerned.
/// `slope_from`: how far ahead a ramp is ten degrees steep [m].
std::string groundKind(const Terrain& terrain, const WorldStart& start, double& slope_from) {
  const auto z = groundBelow(terrain, start.x, start.y);
  if (!z) return "other";
  bool flat = true;
  for (double x = -12.0; x <= 12.0; x += 1.0)
    for (double y = -12.0; flat && y <= 12.0; y += 1.0) {
      const auto h = groundBelow(terrain, start.x + x, start.y + y);
      flat = h && std::abs(*h - *z) < 1e-3;
    }
  if (flat) return "flat";
  // Five metres on end of a slope of ten degrees, straight ahead.
  const double c = std::cos(start.yaw), s = std::sin(start.yaw);
  double steep = 0.0;
  for (double d = 0.0; d < 40.0; d += 0.25) {
    const auto a = groundBelow(terrain, start.x + c * d, start.y + s * d);
    const auto b = groundBelow(terrain, start.x + c * (d + 0.25), start.y + s * (d + 0.25));
    if (!a || !b) break;
    const double slope = std::atan2(*b - *a, 0.25) * 180.0 / M_PI;
    steep = slope > 9.0 && slope < 11.0 ? steep + 0.25 : 0.0;
    if (steep == 0.25) slope_from = d;
    if (steep >= 5.0) return "ramp";
    if (slope < -2.0 || slope > 12.0) break;
  }
  return "other";
}

Loaded<Simulator> startAt(const LoadedScene& loaded, const WorldStart& start) {
  LoadedScene there = loaded;
  there.scene.start.set_down = true;
  there.scene.start.x = start.x;
  there.scene.start.y = start.y;
  there.scene.start.yaw = start.yaw;
  return startScene(there, there.scene.config);
}

/// The first of the free places at which it can be set down; its problems are those of the first if there is none.
Loaded<Simulator> startWhereFree(const LoadedScene& loaded, const WorldStart& preferred, double& way) {
  const Loaded<Simulator> anywhere = Simulator::create(loaded.vehicle, loaded.terrain, loaded.scene.config);
  if (!anywhere) return {std::nullopt, anywhere.problems, {}};
  const Footprint footprint = footprintOf(anywhere.value->model());
  std::vector<FreeStraight> places = findFreeStraights(*loaded.terrain, footprint, preferred, kWay);
  Loaded<Simulator> first;
  int tried = 0;
  for (const FreeStraight& place : places) {
    WorldStart start = place.start;
    start.yaw -= loaded.vehicle.forward_yaw;
    Loaded<Simulator> simulator = startAt(loaded, start);
    if (simulator) {
      way = place.length;
      return simulator;
    }
    if (tried++ == 0) first = std::move(simulator);
    if (tried >= 10) break;
  }
  if (places.empty())
    first.problems = {{loaded.scene.world, "no place was found with room for the vehicle on ground that faces up"}};
  return first;
}

}  // namespace

bool TrialResult::passed() const {
  return problems.empty() && std::none_of(checks.begin(), checks.end(), [](const TrialCheck& check) {
           return check.verdict == Verdict::kFailed;
         });
}

TrialResult tryVehicle(const Scene& scene, const std::string& share) {
  TrialResult result;
  result.vehicle = std::filesystem::path(scene.vehicle).stem().string();
  result.world = std::filesystem::path(scene.world).stem().string();
  const Loaded<LoadedScene> loaded = loadSceneFiles(scene, share);
  if (!loaded) {
    result.problems = loaded.problems;
    return result;
  }
  const SceneStart& at = loaded.value->scene.start;
  const WorldStart start{at.x, at.y, at.yaw};
  const Terrain& terrain = *loaded.value->terrain;
  double slope_from = 0.0;
  result.ground = groundKind(terrain, start, slope_from);
  double way = kWay;
  Loaded<Simulator> simulator = result.ground == "other"
                                    ? startWhereFree(*loaded.value, start, way)
                                    : startAt(*loaded.value, {start.x, start.y, start.yaw - loaded.value->vehicle.forward_yaw});
  if (!simulator) {
    result.problems = simulator.problems;
    return result;
  }
  result.mass = simulator.value->model().mass;
  result.layout = toString(simulator.value->model().drive.layout);

  Trial trial(*simulator.value, terrain);
  result.checks.push_back(trial.stands());
  if (result.ground == "flat") {
    result.checks.push_back(trial.straight("straight", kWay));
    result.checks.push_back(trial.turn(1.0));
    result.checks.push_back(trial.turn(-1.0));
    result.checks.push_back(trial.stop());
  } else if (result.ground == "ramp") {
    result.checks.push_back(trial.climb(slope_from + kUphill));
  } else {
    result.checks.push_back(trial.straight("drive", way));
  }
  TrialCheck& last = result.checks.back();
  result.passed_through = simulator.value->events().passed_through;
  if (result.passed_through > 0) {
    last.verdict = Verdict::kFailed;
    last.text += "; went through the ground " + std::to_string(result.passed_through) + " times";
  }
  return result;
}

namespace {

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) < 0x20) {
      out += ' ';
    } else {
      out += c;
    }
  }
  return out + "\"";
}

const char* word(Verdict verdict) {
  switch (verdict) {
    case Verdict::kPassed: return "passed";
    case Verdict::kFailed: return "failed";
    case Verdict::kNotTried: return "not tried";
  }
  return "";
}

}  // namespace

std::string trialJson(const TrialResult& r) {
  std::string text = "{\"vehicle\": " + quoted(r.vehicle) + ", \"world\": " + quoted(r.world) +
                     ", \"mass\": " + numberText(r.mass) + ", \"layout\": " + quoted(r.layout) +
                     ", \"ground\": " + quoted(r.ground) + ", \"passed\": " + (r.passed() ? "true" : "false") +
                     ", \"problems\": [";
  for (std::size_t i = 0; i < r.problems.size(); ++i) text += (i ? ", " : "") + quoted(r.problems[i].text());
  text += "], \"checks\": [";
  for (std::size_t i = 0; i < r.checks.size(); ++i) {
    const TrialCheck& c = r.checks[i];
    text += std::string(i ? ", " : "") + "{\"name\": " + quoted(c.name) + ", \"verdict\": " + quoted(word(c.verdict)) +
            ", \"value\": " + (std::isfinite(c.value) ? numberText(c.value) : "null") + ", \"unit\": " + quoted(c.unit) +
            ", \"text\": " + quoted(c.text) + "}";
  }
  return text + "]}";
}

}  // namespace ellipsoid_vehicle_sim
