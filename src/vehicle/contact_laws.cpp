#include "contact_laws.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "ellipsoid_vehicle_sim/contact/damped_spring.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector3d;

// Duration of a light touch when nothing is said [s]: ten steps of the default tick resolve it.
constexpr double kDefaultContactTime = 10.0 * kDefaultTick;
// Frequency of the friction's anchor times the default tick [-]: below it every integrator holds with margin.
constexpr double kTangentialStep = 0.25;
constexpr double kTangentialDampingRatio = 0.7;
// Relaxation length over rolling radius [-]; with k_t above it gives a cornering stiffness of 10 to 20 loads per radian,
// the range of tyres [Pacejka2012, sec. 1.2].
constexpr double kBrushLengthOfRadius = 0.25;
// tau over the step [-]: with less both Euler methods chatter.
constexpr double kRelaxationSteps = 2.0;

// A stiffness of the file is taken if it holds at the default tick [-] and carries the mass it feels, ten times, within
// its half width; its damping if the damping ratio is between these.
constexpr double kFileStep = 0.6;
constexpr double kFileLoad = 10.0;
constexpr double kLeastFileDamping = 0.005, kMostFileDamping = 1.0;

bool holds(double stiffness, double mass, const ModelEllipsoid& ellipsoid) {
  return std::sqrt(stiffness / mass) * kDefaultTick <= kFileStep &&
         kFileLoad * mass * 9.80665 < stiffness * 0.5 * ellipsoid.radii.minCoeff();
}

std::string text(double value) {
  char buffer[40];
  std::snprintf(buffer, sizeof buffer, "%.4g", value);
  return buffer;
}

// Acceleration of the point per unit force there, both along given directions [1/kg].
double mobility(ArticulatedBody& tree, int body, const Vector3d& p_OX, const Vector3d& force, const Vector3d& along,
                std::vector<double>& zeros, std::vector<double>& qdd, const std::vector<PrescribedMotion>& still) {
  tree.clearForces();
  const Vec3 p = Vec3::from(p_OX);
  tree.addForce(body, p, Vec3::from(force));
  tree.accelerations(zeros.data(), still.data(), Vec3{0.0, 0.0, 0.0}, qdd.data());
  const Spatial a = tree.acceleration(body);
  return dot(Vec3::from(along), a.linear + cross(a.angular, p));
}

}  // namespace

ContactMasses contactMasses(ArticulatedBody& tree, const ModelEllipsoid& ellipsoid, bool ground_wheel) {
  const std::size_t coordinates = tree.bodies().size();
  std::vector<double> zeros(coordinates, 0.0), qdd(coordinates, 0.0);
  const std::vector<PrescribedMotion> still(coordinates);
  const BodyKinematics& k = tree.kinematics(ellipsoid.body);
  const Eigen::Matrix3d R_OB = k.R_OB.toEigen();
  const PosedEllipsoid posed(k.p_OB.toEigen() + R_OB * ellipsoid.X_BE.p, R_OB * ellipsoid.R_BE, ellipsoid.radii);

  std::vector<Vector3d> normals = {Vector3d::UnitZ()};
  if (!ground_wheel) {
    normals.clear();
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z)
          if (std::abs(x) + std::abs(y) + std::abs(z) != 2 && (x || y || z))
            normals.push_back(Vector3d(x, y, z).normalized());
  }
  ContactMasses masses{1e300, 1e300};
  for (const Vector3d& n : normals) {
    const Vector3d p = posed.p_WE + posed.lowestPointFromCentre(n);
    const Vector3d t1 = n.unitOrthogonal(), t2 = n.cross(t1);
    masses.normal = std::min(masses.normal, 1.0 / mobility(tree, ellipsoid.body, p, n, n, zeros, qdd, still));
    Matrix2d m;
    m(0, 0) = mobility(tree, ellipsoid.body, p, t1, t1, zeros, qdd, still);
    m(1, 1) = mobility(tree, ellipsoid.body, p, t2, t2, zeros, qdd, still);
    m(0, 1) = m(1, 0) = mobility(tree, ellipsoid.body, p, t1, t2, zeros, qdd, still);
    const double largest = 0.5 * (m(0, 0) + m(1, 1)) + std::hypot(0.5 * (m(0, 0) - m(1, 1)), m(0, 1));
    masses.tangential = std::min(masses.tangential, 1.0 / largest);
  }
  return masses;
}

ContactLaw contactLaw(const ModelEllipsoid& ellipsoid, bool ground_wheel, const ContactMasses& masses,
                      double stiffness_cap, const SimConfig& config, std::vector<std::string>& report) {
  ContactLaw law;
  const double zeta = dampingRatioForRestitution(config.restitution);
  std::string how;
  if (config.stiffness) {
    law.stiffness = *config.stiffness;
    how = "given";
  } else if (ellipsoid.file_stiffness && !config.contact_time && holds(*ellipsoid.file_stiffness, masses.normal, ellipsoid)) {
    law.stiffness = *ellipsoid.file_stiffness;
    how = "kp of the file";
  } else {
    if (ellipsoid.file_stiffness && !config.contact_time)
      report.push_back("WARNING contact of '" + ellipsoid.name + "': kp = " + text(*ellipsoid.file_stiffness) +
                       " N/m of the file makes no physical sense here (" +
                       (*ellipsoid.file_stiffness > masses.normal ? "stiffer than the default step holds"
                                                                  : "its weight alone would sink it in") +
                       "): the derived stiffness is used instead");
    const double time = config.contact_time.value_or(kDefaultContactTime);
    const double omega = bounceOfDampedSpring(zeta).contact_time / time;
    law.stiffness = masses.normal * omega * omega;
    how = config.contact_time ? "from contact_time" : "derived";
    if (!config.contact_time && law.stiffness > stiffness_cap) {
      law.stiffness = stiffness_cap;
      how = "softened";
    }
  }
  const double critical = 2.0 * std::sqrt(law.stiffness * masses.normal);
  law.damping = config.damping.value_or(zeta * critical);
  if (ellipsoid.file_damping && !config.damping && how == "kp of the file") {
    const double ratio = *ellipsoid.file_damping / critical;
    if (ratio >= kLeastFileDamping && ratio <= kMostFileDamping) {
      law.damping = *ellipsoid.file_damping;
    } else {
      report.push_back("WARNING contact of '" + ellipsoid.name + "': kd = " + text(*ellipsoid.file_damping) +
                       " N s/m of the file makes no physical sense with its kp (damping ratio " + text(ratio) +
                       "): that of the restitution is used instead");
    }
  }

  law.mode = ground_wheel ? config.wheel_friction : config.body_friction;
  const double omega_t = kTangentialStep / kDefaultTick;
  law.tangential_stiffness = config.tangential_stiffness.value_or(masses.tangential * omega_t * omega_t);
  law.tangential_damping = config.tangential_damping.value_or(
      2.0 * kTangentialDampingRatio * std::sqrt(law.tangential_stiffness * masses.tangential));
  law.brush_length = config.brush_length.value_or(kBrushLengthOfRadius * ellipsoid.radii.maxCoeff());
  law.relaxation_time = config.relaxation_time.value_or(kRelaxationSteps * std::max(config.dt, kDefaultTick));
  law.viscous_friction = config.viscous_friction;

  char line[320];
  std::snprintf(line, sizeof line,
                "contact of '%s': mass felt %.4g kg (tangential %.4g kg), k = %.4g N/m (%s), c = %.4g N s/m, k_t = %.4g N/m, "
                "omega dt = %.3g",
                ellipsoid.name.c_str(), masses.normal, masses.tangential, law.stiffness, how.c_str(), law.damping,
                law.tangential_stiffness, std::sqrt(law.stiffness / masses.normal) * config.dt);
  report.emplace_back(line);
  return law;
}

}  // namespace ellipsoid_vehicle_sim
