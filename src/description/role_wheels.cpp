// Which way is forward, and what stands on the ground and rolls.

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>

#include "ellipsoid_vehicle_sim/description/number_text.h"
#include "role_finder.h"
#include "role_text.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr double kDegree = M_PI / 180.0;
constexpr double kLowest = 0.3;             // radii above the lowest wheel's bottom: still on the ground
constexpr double kSquare = 15.0 * kDegree;  // axles this near to x or y are meant to be there
constexpr double kOneSided = 0.5;           // of the axles' directions that have to agree, as |sum of exp(2 i angle)|

bool endsWord(const std::string& text, std::size_t at) {
  return at >= text.size() || !std::isalpha(static_cast<unsigned char>(text[at]));
}

/// Whether a name says so: a long word anywhere, a short one only as a word of its own ("fl_wheel", "wheel_FL").
bool says(const std::string& name, std::initializer_list<const char*> words) {
  std::string lower;
  for (const char c : name) lower += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (const std::string word : words) {
    for (std::size_t at = lower.find(word); at != std::string::npos; at = lower.find(word, at + 1)) {
      const bool whole = endsWord(lower, at == 0 ? lower.size() : at - 1) && endsWord(lower, at + word.size());
      if (whole || word.size() > 2) return true;
    }
  }
  return false;
}

/// 1 front, -1 rear, 0 nothing or both.
int endOf(const std::string& name) {
  const bool front = says(name, {"front", "fl", "fr", "lf", "rf"}), rear = says(name, {"rear", "back", "rl", "bl", "br"});
  return front == rear ? 0 : front ? 1 : -1;
}

/// 1 left, -1 right, 0 nothing or both.
int sideOf(const std::string& name) {
  const bool left = says(name, {"left", "fl", "bl"}), right = says(name, {"right", "fr", "br"});
  return left == right ? 0 : left ? 1 : -1;
}

}  // namespace

/// A wheel whose joint has no <axis> turns about the axis that its shape has, not about x.
void RoleFinder::guessAxes() {
  for (std::size_t j = 0; j < vehicle_.joints.size(); ++j) {
    JointDescription& d = vehicle_.joints[j];
    if (hints_.without_axis.count(d.name) == 0 || !isRotary(d.type)) continue;
    const auto shapes = shapesOf(static_cast<int>(j));
    if (shapes.empty() || measureWheel(shapes, d.axis).round) continue;
    std::vector<Vector3d> axes = {Vector3d::UnitY(), Vector3d::UnitZ()};
    for (const PlacedShape& s : shapes)
      if (s.shape->kind == CollisionShape::Kind::kCylinder) axes.insert(axes.begin(), s.X_GS.q * Vector3d::UnitZ());
    for (const Vector3d& axis : axes) {
      if (!measureWheel(shapes, axis).round || std::abs((X_RL_[j + 1].q * axis).z()) > kLevel) continue;
      d.axis = axis.cwiseAbs().maxCoeff() > 1.0 - 1e-9 ? Vector3d(axis.array().round()) : axis;
      // Positive turns forward, where nothing says otherwise.
      if ((X_RL_[j + 1].q * d.axis).y() < 0.0) d.axis = -d.axis;
      notes_.push_back(placeText(vehicle_.file, d.line, "joint", d.name) + ": no <axis>, and its shape is round about " +
                       axisText(d.axis) + " of '" + d.child + "', not about x: that is taken");
      break;
    }
  }
}

/// The level direction across the axles [rad, within a half turn]; nullopt where they do not agree.
std::optional<double> RoleFinder::directionOfAxles() const {
  double c = 0.0, s = 0.0, count = 0.0;
  for (std::size_t j = 0; j < vehicle_.joints.size(); ++j) {
    const JointDescription& d = vehicle_.joints[j];
    const Vector3d axis = X_RL_[j + 1].q * d.axis;
    if (!isRotary(d.type) || std::abs(axis.z()) > kLevel || (!turnsFully(static_cast<int>(j)) && d.lower != d.upper))
      continue;
    bool swivels = false;
    for (int a = above(static_cast<int>(j)); a >= 0; a = above(a))
      swivels |= isRotary(vehicle_.joints[a].type) && turnsFully(a) &&
                 std::abs((X_RL_[a + 1].q * vehicle_.joints[a].axis).z()) >= kUpright;
    if (swivels) continue;
    const auto shapes = shapesOf(static_cast<int>(j));
    if (shapes.empty() || !measureWheel(shapes, d.axis).round) continue;
    // An axis and its opposite are one axle: angles are doubled.
    const double angle = std::atan2(axis.y(), axis.x());
    c += std::cos(2.0 * angle);
    s += std::sin(2.0 * angle);
    count += 1.0;
  }
  if (count == 0.0 || std::hypot(c, s) < kOneSided * count) return std::nullopt;
  return 0.5 * std::atan2(s, c) - 0.5 * M_PI;
}

/// 1 if what the joints are called, or where they steer, agrees with forward along `yaw`, -1 if it says the opposite, 0 if
/// it says nothing or contradicts itself.
int RoleFinder::forwardSign(double yaw, std::string& why) const {
  const Vector3d ahead(std::cos(yaw), std::sin(yaw), 0.0), left(-ahead.y(), ahead.x(), 0.0);
  Vector3d middle = Vector3d::Zero();
  std::vector<std::pair<std::string, Vector3d>> wheels;
  for (std::size_t j = 0; j < vehicle_.joints.size(); ++j) {
    const JointDescription& d = vehicle_.joints[j];
    const auto shapes = isRotary(d.type) ? shapesOf(static_cast<int>(j)) : std::vector<PlacedShape>{};
    if (shapes.empty()) continue;
    const WheelMeasure m = measureWheel(shapes, d.axis);
    if (!m.round || std::abs((X_RL_[j + 1].q * d.axis).z()) > kLevel) continue;
    wheels.emplace_back(d.name + " " + d.child, X_RL_[j + 1] * (m.axial_centre * d.axis));
    middle += wheels.back().second;
  }
  if (wheels.empty()) return 0;
  middle /= static_cast<double>(wheels.size());
  int for_it = 0, against = 0;
  for (const auto& [name, p] : wheels) {
    const double x = (p - middle).dot(ahead), y = (p - middle).dot(left);
    for (const double vote : {endOf(name) * x, sideOf(name) * y}) {
      if (vote > 1e-6) ++for_it;
      if (vote < -1e-6) ++against;
    }
  }
  why = "so the names of its wheels say";
  if (for_it > 0 && against == 0) return 1;
  return against > 0 && for_it == 0 ? -1 : 0;
}

void RoleFinder::turnTo(double forward_yaw) {
  vehicle_.forward_yaw = forward_yaw;
  const Pose X_FR{Vector3d::Zero(), Eigen::Quaterniond(Eigen::AngleAxisd(-forward_yaw, Vector3d::UnitZ()))};
  X_FL_.clear();
  axes_F_.clear();
  for (const Pose& X_RL : X_RL_) X_FL_.push_back(forward_yaw == 0.0 ? X_RL : X_FR * X_RL);
  for (std::size_t j = 0; j < vehicle_.joints.size(); ++j) axes_F_.push_back(X_FL_[j + 1].q * vehicle_.joints[j].axis);
}

void RoleFinder::findForward() {
  if (hints_.forward_yaw) {
    if (*hints_.forward_yaw != 0.0)
      notes_.push_back(vehicle_.file + ": forward is turned by " + numberText(*hints_.forward_yaw / kDegree) +
                       " degrees from x of the root link, as asked for by parameter");
    return turnTo(*hints_.forward_yaw);
  }
  std::string why = "its axles lie along x";
  double yaw = directionOfAxles().value_or(0.0);
  const double quarter = std::round(yaw / (0.5 * M_PI)) * 0.5 * M_PI;
  if (std::abs(yaw - quarter) < kSquare) yaw = quarter;
  // Of the two ends, the one towards x, or towards y where forward is neither.
  if (std::cos(yaw) < -1e-9 || (std::abs(std::cos(yaw)) <= 1e-9 && std::sin(yaw) < 0.0)) yaw += M_PI;
  std::string names;
  const int sign = forwardSign(yaw, names);
  if (sign < 0) yaw += M_PI;
  if (sign < 0 || (sign > 0 && std::abs(yaw) > 1e-9)) why = std::abs(std::sin(yaw)) > 1e-9 ? why + ", " + names : names;
  yaw = std::remainder(yaw, 2.0 * M_PI);
  if (std::abs(yaw) < 1e-9) yaw = 0.0;
  if (std::abs(yaw + M_PI) < 1e-9) yaw = M_PI;
  turnTo(yaw);
  if (yaw == 0.0) return;
  const std::string direction = axisText({std::cos(yaw), std::sin(yaw), 0.0});
  notes_.push_back(vehicle_.file + ": forward is taken to be " + direction + " of the root link, not x: " + why +
                   (sign == 0 ? "; which of its two ends is the front nothing says" : "") +
                   "; parameter 'forward' says otherwise");
}

/// The wheel joint j would be; nullopt if its axis or its shapes rule it out.
std::optional<GroundWheel> RoleFinder::candidate(int j) {
  const bool forced = forcedWheel(j);
  if (!isRotary(joint(j).type) || (overruled(j) && !forced)) return std::nullopt;
  bool below_upright = false;
  for (int a = above(j); a >= 0; a = above(a)) below_upright |= isRotary(joint(a).type) && upright(a);
  const Vector3d& axis = axes_F_[j];
  // Limits of 0 and 0 are what tools write who have none to write: nobody builds a wheel that cannot turn.
  const bool turns = turnsFully(j) || joint(j).lower == joint(j).upper;
  const bool fits = std::abs(axis.z()) <= kLevel && (below_upright || std::abs(axis.y()) >= kLateral) && turns;
  if (!fits && !forced) return std::nullopt;
  const auto shapes = shapesOf(j);
  if (shapes.empty()) {
    if (forced) {
      problems_.push_back({placeText(vehicle_.file, joint(j).line, "joint", joint(j).name),
                           "it is named as a wheel, and nothing that collides turns with it; allowed is a joint with a"
                           " <collision> below it"});
    }
    return std::nullopt;
  }
  GroundWheel wheel;
  wheel.joint = j;
  wheel.measure = measureWheel(shapes, joint(j).axis);
  if (!wheel.measure.round && !forced) return std::nullopt;
  wheel.p_FC = X_FL_[j + 1] * (wheel.measure.axial_centre * joint(j).axis);
  // A spheroid's reach along z: its radius across the axis, its half width along it.
  const double along = std::abs(axis.z());
  wheel.bottom = wheel.p_FC.z() - std::hypot(wheel.measure.radius * std::sqrt(1.0 - std::min(1.0, along * along)),
                                             wheel.measure.half_width * along);
  return wheel;
}

void RoleFinder::findWheels() {
  std::vector<GroundWheel> candidates;
  double lowest = std::numeric_limits<double>::infinity();
  for (std::size_t j = 0; j < vehicle_.joints.size(); ++j) {
    if (auto wheel = candidate(static_cast<int>(j))) {
      lowest = std::min(lowest, wheel->bottom);
      candidates.push_back(*wheel);
    }
  }
  for (const GroundWheel& wheel : candidates) {
    const double height = wheel.bottom - lowest;
    if (height > kLowest * wheel.measure.radius && !forcedWheel(wheel.joint)) {
      joint(wheel.joint).role_reason = ", round but " + numberText(height) + " m above the lowest wheel";
      continue;
    }
    JointDescription& d = joint(wheel.joint);
    if (d.lower == d.upper && std::isfinite(d.lower)) {
      notes_.push_back(placeText(vehicle_.file, d.line, "joint", d.name) + ": lower and upper are both " +
                       numberText(d.lower) + ", and it carries a round wheel on the ground: taken as unlimited");
      d.lower = -std::numeric_limits<double>::infinity();
      d.upper = std::numeric_limits<double>::infinity();
    }
    wheel_of_joint_[wheel.joint] = static_cast<int>(wheels_.size());
    wheels_.push_back(wheel);
  }
}

}  // namespace ellipsoid_vehicle_sim
