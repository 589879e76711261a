// What the file says of friction and stiffness, link by link.

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <utility>

#include "ellipsoid_vehicle_sim/description/number_text.h"
#include "text_to_description.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

constexpr double kMostFriction = 5.0;    // more is "never slip" in some simulators' words
constexpr double kLeastGrip = 0.05;      // of a driven wheel: less is a wheel that a plugin slides about
constexpr double kBallFriction = 0.005;  // of what stands for a rolling ball or a caster
constexpr double kOnGround = 0.3;        // radii of the smallest wheel: as near as this to the wheels' bottoms

double bottomOf(const EllipsoidDescription& e, const Pose& X_RL) {
  const Pose X_RE = X_RL * e.X_LE;
  return X_RE.p.z() - (X_RE.q.conjugate() * Vector3d::UnitZ()).cwiseProduct(e.radii).norm();
}

bool calledCaster(const std::string& name) {
  std::string lower;
  for (const char c : name) lower += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower.find("caster") != std::string::npos || lower.find("castor") != std::string::npos ||
         lower.find("ball") != std::string::npos || lower.find("omni") != std::string::npos;
}

/// Of a shape that is one, not of a piece of something else.
bool isSphere(const EllipsoidDescription& e) {
  return e.fit_error == 0.0 && e.radii.maxCoeff() <= 1.02 * e.radii.minCoeff();
}

/// The link whose ellipsoids stand for the shapes of this one: itself, or the wheel it is fixed to; -1 without.
int standsFor(const VehicleDescription& vehicle, const std::vector<int>& parents, int link) {
  while (link > 0 && vehicle.links[link].ellipsoids.empty() && vehicle.joints[link - 1].type == JointType::kFixed)
    link = parents[link];
  return vehicle.links[link].ellipsoids.empty() ? -1 : link;
}

void readSurface(const GazeboLinkText& surface, const std::string& place, bool driven, LinkDescription& link,
                 std::vector<std::string>& notes) {
  std::optional<double> mu = surface.mu1 ? surface.mu1 : surface.mu2;
  if (surface.mu1 && surface.mu2 && *surface.mu1 != *surface.mu2) {
    mu = std::min(*surface.mu1, *surface.mu2);
    notes.push_back(place + ": mu1 and mu2 differ; friction here is the same in all directions, taken is the smaller, " +
                    numberText(*mu));
  }
  if (mu && (*mu > kMostFriction || (driven && *mu < kLeastGrip))) {
    notes.push_back(place + ": mu " + numberText(*mu) + " makes no physical sense " + (driven ? "on a wheel that drives " : "") +
                    "(" + numberText(driven ? kLeastGrip : 0.0) + " to " + numberText(kMostFriction) +
                    " does): mu_static and mu_kinetic are used instead");
    mu.reset();
  }
  for (EllipsoidDescription& e : link.ellipsoids) {
    if (mu) e.mu = mu;
    if (surface.kp && *surface.kp > 0.0) e.stiffness = surface.kp;
    if (surface.kd) e.damping = surface.kd;
  }
}

}  // namespace

void addSurfaces(VehicleDescription& vehicle, const UrdfText& urdf, const std::vector<GroundWheel>& wheels,
                 std::vector<std::string>& notes) {
  const std::vector<int> parents = parentLinks(vehicle);
  for (const GazeboLinkText& surface : urdf.gazebo_links) {
    for (std::size_t l = 0; l < vehicle.links.size(); ++l) {
      if (vehicle.links[l].name != surface.link) continue;
      const auto text = std::find_if(urdf.links.begin(), urdf.links.end(),
                                     [&](const LinkText& link) { return link.name == surface.link; });
      if (text == urdf.links.end() || text->collision_count == 0) continue;
      const int owner = standsFor(vehicle, parents, static_cast<int>(l));
      if (owner < 0) continue;
      const bool driven = owner > 0 && vehicle.joints[owner - 1].role == JointRole::kDrive;
      readSurface(surface, placeText(vehicle.file, surface.line, "link", surface.link), driven, vehicle.links[owner], notes);
    }
  }
  if (wheels.empty()) return;

  double bottom = std::numeric_limits<double>::infinity(), radius = bottom;
  bool drives = false;
  for (const GroundWheel& wheel : wheels) {
    bottom = std::min(bottom, wheel.bottom);
    radius = std::min(radius, wheel.measure.radius);
    drives = drives || vehicle.joints[wheel.joint].role == JointRole::kDrive;
  }
  const std::vector<Pose> X_RL = linkPosesAtZero(vehicle);
  for (std::size_t l = 0; l < vehicle.links.size(); ++l) {
    LinkDescription& link = vehicle.links[l];
    const JointDescription* joint = l == 0 ? nullptr : &vehicle.joints[l - 1];
    const bool wheel = joint && (joint->role == JointRole::kDrive || joint->role == JointRole::kFreeWheel);
    // A wheel that rolls along may have any name; a ball on an axle has to slide sideways.
    const bool ball_on_axle = wheel && joint->role == JointRole::kFreeWheel && calledCaster(link.name + joint->name) &&
                              joint->role_reason.find("below a swivel") == std::string::npos;
    if (!drives || (wheel && !ball_on_axle)) continue;
    bool told = false;
    for (EllipsoidDescription& e : link.ellipsoids) {
      if (e.mu || std::abs(bottomOf(e, X_RL[l]) - bottom) > kOnGround * radius) continue;
      // A vehicle on two wheels leans on something that stands for its casters, whatever it is drawn as.
      const bool stands_for_one = isSphere(e) || calledCaster(link.name) || wheels.size() < 3;
      if (wheel ? !isSphere(e) : !stands_for_one) continue;
      e.mu = kBallFriction;
      if (std::exchange(told, true)) continue;
      notes.push_back("link '" + link.name + "': " + e.source + " stands on the ground and cannot roll along: taken for a" +
                      " ball or caster, friction " + numberText(kBallFriction) + " (<gazebo reference=\"" + link.name +
                      "\"> mu1 says otherwise)");
    }
  }
}

}  // namespace ellipsoid_vehicle_sim
