#include "ellipsoid_vehicle_sim/description/inertia_lint.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "ellipsoid_vehicle_sim/description/inertia_check.h"
#include "ellipsoid_vehicle_sim/description/number_text.h"
#include "ellipsoid_vehicle_sim/description/vehicle_tree.h"
#include "ellipsoid_vehicle_sim/dynamics/rigid_inertia.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Kind = InertiaFinding::Kind;

constexpr double kDensity = 500.0;        // of a mass that is suggested [kg/m^3]
constexpr double kSmallestGyration = 0.02;  // of the farthest point's distance
constexpr double kOffAxis = 0.05;         // of a wheel's radius
constexpr double kOffMiddle = 0.05;       // of the track
constexpr double kDisc = 1.2;             // radius over half width from which a wheel is a disc
constexpr double kClearly = 1.1;          // by which another moment has to be larger

std::string rounded(double value) {
  if (value == 0.0 || !std::isfinite(value)) return numberText(value);
  const double unit = std::pow(10.0, std::floor(std::log10(std::abs(value))) - 5.0);
  return numberText(std::round(value / unit) * unit);
}

std::string inertiaText(const Matrix3d& I) {
  const char* const names[3][3] = {{"ixx", "ixy", "ixz"}, {"", "iyy", "iyz"}, {"", "", "izz"}};
  std::string text = "<inertia";
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j) text += std::string(" ") + names[i][j] + "=\"" + rounded(I(i, j)) + "\"";
  return text + "/>";
}

Matrix3d boxInertia(double mass, const Vector3d& half) {
  const Vector3d s = half.cwiseAbs2();
  return Vector3d(s.y() + s.z(), s.x() + s.z(), s.x() + s.y()).asDiagonal() * (mass / 3.0);
}

/// Of a file that is refused no roles are known: then nothing counts as locked.
bool lockedByRole(const JointDescription& joint) {
  return joint.role == JointRole::kLocked && !joint.role_reason.empty();
}

/// A solid cylinder about the unit axis.
Matrix3d cylinderInertia(double mass, double radius, double half_width, const Vector3d& axis) {
  const double along = 0.5 * mass * radius * radius;
  const double across = mass * (radius * radius / 4.0 + half_width * half_width / 3.0);
  return across * Matrix3d::Identity() + (along - across) * axis * axis.transpose();
}

/// The nearest inertia a body can have: moments lifted above 0, the largest cut to the sum of the others.
Matrix3d nearestInertia(const Matrix3d& I, double mass) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(I);
  Vector3d m = solver.eigenvalues();
  const double least = std::max(1e-3 * m.cwiseAbs().maxCoeff(), 1e-9 * std::max(mass, 1e-6));
  m = m.cwiseMax(least);
  std::sort(m.data(), m.data() + 3);
  m[2] = std::min(m[2], 0.999999 * (m[0] + m[1]));
  const Matrix3d R = solver.eigenvectors();
  const Matrix3d fixed = R * m.asDiagonal() * R.transpose();
  return 0.5 * (fixed + fixed.transpose());
}

class Lint {
 public:
  Lint(const VehicleDescription& vehicle, const std::vector<std::vector<CollisionShape>>& shapes,
       const std::vector<GroundWheel>& wheels)
      : vehicle_(vehicle), shapes_(shapes), wheels_(wheels), parents_(parentLinks(vehicle)) {}

  std::vector<InertiaFinding> run() {
    for (std::size_t l = 0; l < vehicle_.links.size(); ++l) {
      checkMass(static_cast<int>(l));
      if (vehicle_.links[l].mass > 0.0) checkInertia(static_cast<int>(l));
    }
    for (const GroundWheel& wheel : wheels_) checkWheel(wheel);
    checkSymmetry();
    return findings_;
  }

 private:
  const LinkDescription& link(int l) const { return vehicle_.links[l]; }

  const GroundWheel* wheelOf(int l) const {
    for (const GroundWheel& wheel : wheels_)
      if (wheel.joint + 1 == l) return &wheel;
    return nullptr;
  }

  /// The box around a link's shapes, in its axes; empty without shapes.
  Eigen::AlignedBox3d boxOf(int l) const {
    Eigen::AlignedBox3d box;
    for (const CollisionShape& shape : shapes_[l])
      for (int i = 0; i < 3; ++i)
        for (const double sign : {1.0, -1.0}) {
          const Vector3d d = sign * Vector3d::Unit(i);
          const double reach = shape.X_LS.p.dot(d) + support(shape, shape.X_LS.q.conjugate() * d);
          Vector3d p = shape.X_LS.p;
          p[i] = sign * reach;
          box.extend(p);
        }
    return box;
  }

  /// The solid that stands for a link: inertia about its own centre, and that centre.
  std::optional<std::pair<Matrix3d, Vector3d>> solidOf(int l, double mass) const {
    if (const GroundWheel* wheel = wheelOf(l)) {
      const Vector3d axis = vehicle_.joints[wheel->joint].axis;
      return std::pair{cylinderInertia(mass, wheel->measure.radius, wheel->measure.half_width, axis),
                       Vector3d(wheel->measure.axial_centre * axis)};
    }
    const Eigen::AlignedBox3d box = boxOf(l);
    if (box.isEmpty() || !(box.sizes().minCoeff() >= 0.0) || box.sizes().maxCoeff() <= 0.0) return std::nullopt;
    return std::pair{boxInertia(mass, 0.5 * box.sizes()), Vector3d(box.center())};
  }

  double solidMass(int l) const {
    if (const GroundWheel* wheel = wheelOf(l))
      return kDensity * M_PI * wheel->measure.radius * wheel->measure.radius * 2.0 * wheel->measure.half_width;
    const Eigen::AlignedBox3d box = boxOf(l);
    return box.isEmpty() ? 0.0 : kDensity * box.volume();
  }

  InertiaFinding finding(Kind kind, int l, const std::string& message) const {
    InertiaFinding f;
    f.kind = kind;
    f.link = link(l).name;
    f.line = link(l).inertial_line > 0 ? link(l).inertial_line : link(l).line;
    f.message = message;
    f.fault = kind == Kind::kMass || kind == Kind::kInertia;
    return f;
  }

  void suggestInertia(InertiaFinding& f, int l, double mass) const {
    const auto solid = solidOf(l, mass);
    f.I_cm_L = solid ? solid->first : nearestInertia(link(l).I_cm_L, mass);
    if (!inertiaFault(*f.I_cm_L).empty()) f.I_cm_L = nearestInertia(*f.I_cm_L, mass);
    f.suggestion += (f.suggestion.empty() ? "" : " ") + inertiaText(*f.I_cm_L);
  }

  void checkMass(int l) {
    const LinkDescription& here = link(l);
    const JointDescription* joint = l == 0 ? nullptr : &vehicle_.joints[l - 1];
    const bool stays = joint && (joint->type == JointType::kFixed || lockedByRole(*joint));
    if (here.mass > 0.0 || (here.mass == 0.0 && stays)) return;
    double mass = 0.0;
    bool collides = false;
    for (const GroupedLink& g : rigidGroup(vehicle_, parents_, l)) {
      mass += link(g.link).mass;
      collides = collides || !shapes_[g.link].empty();
    }
    if (here.mass == 0.0 && (mass > 0.0 || (!collides && joint))) return;
    InertiaFinding f = finding(Kind::kMass, l, here.mass < 0.0 ? "mass reads " + numberText(here.mass) + " kg"
                                                               : "it moves, collides, and weighs 0 kg");
    const double suggested = here.mass < 0.0 ? -here.mass : solidMass(l);
    if (suggested > 0.0) {
      f.mass = suggested;
      f.suggestion = "<mass value=\"" + rounded(suggested) + "\"/>";
      const auto solid = solidOf(l, suggested);
      if (solid && here.mass == 0.0) f.p_Lcm = solid->second;
      suggestInertia(f, l, suggested);
    }
    findings_.push_back(f);
  }

  void checkInertia(int l) {
    const LinkDescription& here = link(l);
    const std::string fault = inertiaFault(here.I_cm_L);
    if (!fault.empty()) {
      InertiaFinding f = finding(Kind::kInertia, l, here.inertia_fault.empty() ? fault : here.inertia_fault);
      suggestInertia(f, l, here.mass);
      f.tolerated = madeUpFor(l);
      findings_.push_back(f);
      return;
    }
    const Eigen::AlignedBox3d box = boxOf(l);
    if (box.isEmpty()) return;
    double farthest = 0.0;
    for (int i = 0; i < 8; ++i)
      farthest = std::max(farthest, (box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i)) - here.p_Lcm).norm());
    const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(here.I_cm_L, Eigen::EigenvaluesOnly);
    const Vector3d gyration = (solver.eigenvalues() / here.mass).cwiseMax(0.0).cwiseSqrt();
    const bool large = gyration.maxCoeff() > farthest, small = gyration.maxCoeff() < kSmallestGyration * farthest;
    if (!large && !small) return;
    InertiaFinding f = finding(
        Kind::kSize, l, "its radius of gyration is " + rounded(gyration.maxCoeff()) + " m, " +
                            (large ? "more than the " + rounded(farthest) + " m from the centre of mass to the farthest point"
                                   : "less than a fiftieth of the " + rounded(farthest) + " m that its shapes reach") +
                            ": an inertia of another body, or in other units");
    suggestInertia(f, l, here.mass);
    findings_.push_back(f);
  }

  /// Whether the body that the link is part of can be, with the link as it stands in the file.
  bool madeUpFor(int l) const {
    int top = l;
    const auto stands = [&](int at) {
      const JointDescription& joint = vehicle_.joints[at - 1];
      return joint.type == JointType::kFixed || lockedByRole(joint) ||
             joint.role == JointRole::kPrescribed;
    };
    while (top > 0 && stands(top)) top = parents_[top];
    std::vector<Pose> X_TL(vehicle_.links.size());
    std::vector<bool> in(vehicle_.links.size(), false);
    in[top] = true;
    RigidInertia sum{link(top).mass, link(top).p_Lcm, link(top).I_cm_L};
    for (std::size_t k = top + 1; k < vehicle_.links.size(); ++k) {
      if (!in[parents_[k]] || !stands(static_cast<int>(k))) continue;
      in[k] = true;
      X_TL[k] = X_TL[parents_[k]] * vehicle_.joints[k - 1].X_PJ;
      const LinkDescription& part = link(static_cast<int>(k));
      if (part.mass > 0.0) sum = sum + RigidInertia{part.mass, part.p_Lcm, part.I_cm_L}.seenFrom(X_TL[k]);
    }
    // Alone it makes up for nothing.
    const bool alone = std::count(in.begin(), in.end(), true) == 1;
    return !alone && sum.mass > 0.0 && inertiaFault(sum.I_cm_A).empty();
  }

  void checkWheel(const GroundWheel& wheel) {
    const int l = wheel.joint + 1;
    const LinkDescription& here = link(l);
    if (!(here.mass > 0.0) || !inertiaFault(here.I_cm_L).empty()) return;
    const Vector3d axis = vehicle_.joints[wheel.joint].axis;
    const Vector3d off = here.p_Lcm - axis.dot(here.p_Lcm) * axis;
    if (off.norm() > kOffAxis * wheel.measure.radius) {
      InertiaFinding f = finding(Kind::kBalance, l, "the wheel's centre of mass is " + rounded(off.norm()) +
                                                        " m off its axis: it would hammer once a turn");
      f.p_Lcm = axis.dot(here.p_Lcm) * axis;
      f.suggestion = "<origin xyz=\"" + rounded(f.p_Lcm->x()) + " " + rounded(f.p_Lcm->y()) + " " + rounded(f.p_Lcm->z()) +
                     "\"/> of the <inertial>";
      findings_.push_back(f);
    }
    if (wheel.measure.radius < kDisc * wheel.measure.half_width) return;
    const Vector3d t1 = axis.unitOrthogonal(), t2 = axis.cross(t1);
    Eigen::Matrix2d across;
    across << t1.dot(here.I_cm_L * t1), t1.dot(here.I_cm_L * t2), t1.dot(here.I_cm_L * t2), t2.dot(here.I_cm_L * t2);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(across, Eigen::EigenvaluesOnly);
    const double along = axis.dot(here.I_cm_L * axis), most = solver.eigenvalues()[1], least = solver.eigenvalues()[0];
    if (most < kClearly * along || most < kClearly * least) return;
    InertiaFinding f = finding(Kind::kSpin, l, "a disc by its shape, but the moment about its own axis is " + rounded(along) +
                                                   " and about one across it " + rounded(most) +
                                                   " kg m^2: on the wrong entry, as if it lay on its side");
    suggestInertia(f, l, here.mass);
    findings_.push_back(f);
  }

  void checkSymmetry() {
    if (wheels_.size() < 2) return;
    double left = -1e300, right = 1e300;
    for (const GroundWheel& wheel : wheels_) {
      left = std::max(left, wheel.p_FC.y());
      right = std::min(right, wheel.p_FC.y());
    }
    const Pose X_FR{Vector3d::Zero(), Eigen::Quaterniond(Eigen::AngleAxisd(-vehicle_.forward_yaw, Vector3d::UnitZ()))};
    const std::vector<Pose> X_RL = linkPosesAtZero(vehicle_);
    const double middle = 0.5 * (left + right), track = left - right;
    double mass = 0.0, moment = 0.0, most = 0.0;
    int culprit = 0;
    for (std::size_t l = 0; l < vehicle_.links.size(); ++l) {
      const LinkDescription& here = link(static_cast<int>(l));
      if (!(here.mass > 0.0)) continue;
      const double share = here.mass * ((X_FR * (X_RL[l] * here.p_Lcm)).y() - middle);
      mass += here.mass;
      moment += share;
    }
    if (!(mass > 0.0) || !(track > 0.0) || std::abs(moment / mass) <= kOffMiddle * track) return;
    for (std::size_t l = 0; l < vehicle_.links.size(); ++l) {
      const LinkDescription& here = link(static_cast<int>(l));
      const double share = here.mass * ((X_FR * (X_RL[l] * here.p_Lcm)).y() - middle);
      if (share * moment > 0.0 && std::abs(share) > most) most = std::abs(share), culprit = static_cast<int>(l);
    }
    InertiaFinding f = finding(Kind::kSymmetry, culprit,
                               "the whole vehicle's centre of mass is " + rounded(std::abs(moment / mass)) + " m to the " +
                                   (moment > 0.0 ? "left" : "right") + " of the middle between its wheels; this link adds most");
    const Vector3d p_FL = X_FR * (X_RL[culprit] * link(culprit).p_Lcm);
    const Vector3d moved = (X_FR * X_RL[culprit]).inverse() * Vector3d(p_FL.x(), p_FL.y() - moment / link(culprit).mass, p_FL.z());
    f.suggestion = "<origin xyz=\"" + rounded(moved.x()) + " " + rounded(moved.y()) + " " + rounded(moved.z()) +
                   "\"/> of the <inertial>, if it is meant to be symmetric";
    findings_.push_back(f);
  }

  const VehicleDescription& vehicle_;
  const std::vector<std::vector<CollisionShape>>& shapes_;
  const std::vector<GroundWheel>& wheels_;
  std::vector<int> parents_;
  std::vector<InertiaFinding> findings_;
};

}  // namespace

const char* toString(InertiaFinding::Kind kind) {
  switch (kind) {
    case Kind::kMass: return "mass";
    case Kind::kInertia: return "inertia";
    case Kind::kSize: return "size";
    case Kind::kSpin: return "spin";
    case Kind::kBalance: return "balance";
    case Kind::kSymmetry: return "symmetry";
  }
  return "unknown";
}

std::vector<InertiaFinding> lintInertias(const VehicleDescription& vehicle,
                                         const std::vector<std::vector<CollisionShape>>& shapes,
                                         const std::vector<GroundWheel>& wheels) {
  return Lint(vehicle, shapes, wheels).run();
}

void repairInertias(const std::vector<InertiaFinding>& findings, VehicleDescription& vehicle,
                    std::vector<std::string>& notes) {
  for (const InertiaFinding& f : findings) {
    if (f.kind == Kind::kSymmetry || (!f.mass && !f.p_Lcm && !f.I_cm_L)) continue;
    for (LinkDescription& link : vehicle.links) {
      if (link.name != f.link) continue;
      if (f.mass) link.mass = *f.mass;
      if (f.p_Lcm) link.p_Lcm = *f.p_Lcm;
      if (f.I_cm_L) link.I_cm_L = *f.I_cm_L;
      notes.push_back(placeText(vehicle.file, f.line, "link", f.link) + ": REPAIRED as repair_inertia asks: " + f.message +
                      "; used is " + f.suggestion);
    }
  }
}

}  // namespace ellipsoid_vehicle_sim
