#include "ellipsoid_vehicle_sim/vehicle/vehicle_model.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>

#include "contact_laws.h"
#include "drive_model.h"
#include "wheel_loads.h"

namespace ellipsoid_vehicle_sim {

const char* toString(JointRole role) {
  switch (role) {
    case JointRole::kLocked: return "locked";
    case JointRole::kDrive: return "drive";
    case JointRole::kFreeWheel: return "free_wheel";
    case JointRole::kSteer: return "steer";
    case JointRole::kSuspension: return "suspension";
    case JointRole::kPassive: return "passive";
    case JointRole::kPrescribed: return "prescribed";
  }
  return "unknown";
}

const char* toString(DriveLayout layout) {
  switch (layout) {
    case DriveLayout::kNone: return "none";
    case DriveLayout::kAckermann: return "ackermann";
    case DriveLayout::kDifferential: return "differential";
  }
  return "unknown";
}

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Seed's stiffness: what collisions of a ton at hundreds of m/s ask for [N/m]. Derived contacts are not made stiffer.
constexpr double kSeedStiffness = 1e7;
// Joint stops and holds: frequency with the joint's own inertia [rad/s] and damping ratio; 0.2 to 0.25 of a default tick.
constexpr double kStopFrequency = 200.0, kStopDampingRatio = 0.5;
constexpr double kHoldFrequency = 250.0, kHoldDampingRatio = 0.7;
// Sag of the wheels of a stiff vehicle with casters, of their radius [-]: what rubber gives.
constexpr double kCasterSag = 0.02;
// Height above the wheels' bottoms, of their radius [-], up to which two wheels let the vehicle tip onto its body.
constexpr double kLeans = 0.3;
// Inertia below which a coordinate would accelerate without bound [kg m^2, kg].
constexpr double kNoInertia = 1e-12;
// A wheel counts as symmetric about its axle when it differs by less than this fraction.
constexpr double kSymmetryTolerance = 1e-3;

bool isWheel(JointRole role) { return role == JointRole::kDrive || role == JointRole::kFreeWheel; }

class Compiler {
 public:
  Compiler(const VehicleDescription& description, const SimConfig& config) : config_(config) {
    model_.description = description;
  }

  Loaded<VehicleModel> run() {
    problems_ = config_.validate();
    chooseJoints();
    buildBodies();
    if (!problems_.empty()) return {std::nullopt, problems_, {}};
    centreBase();
    findSpinSymmetry();
    if (model_.ellipsoids.empty())
      fail("vehicle '" + description().name + "'", "has no collision shape; at least one is needed");
    if (!problems_.empty()) return {std::nullopt, problems_, {}};

    coupleMimics();
    ArticulatedBody tree(model_.bodies, model_.couplings);
    const std::vector<double> zeros(model_.bodies.size(), 0.0);
    const std::vector<PrescribedMotion> still(model_.bodies.size());
    tree.positions(zeros.data(), still.data());
    tree.velocities(Vec3{0.0, 0.0, 0.0}, zeros.data(), still.data());
    if (!reflectInertias(tree)) return {std::nullopt, problems_, {}};

    model_.drive = buildDriveModel(model_, owner_joint_, config_, problems_);
    deriveContacts(tree);
    deriveSprings();
    deriveJointConstants();
    deriveDriveGains(model_, config_);
    if (!problems_.empty()) return {std::nullopt, problems_, {}};
    Loaded<VehicleModel> result;
    result.value = std::move(model_);
    return result;
  }

 private:
  const VehicleDescription& description() const { return model_.description; }
  void fail(const std::string& where, const std::string& message) { problems_.push_back({where, message}); }
  void note(const std::string& line) { model_.report.push_back(line); }

  int linkIndex(const std::string& name) const {
    for (std::size_t i = 0; i < description().links.size(); ++i)
      if (description().links[i].name == name) return static_cast<int>(i);
    return -1;
  }

  // Which joints become coordinates: those that can move and matter.
  void chooseJoints() {
    const auto& joints = description().joints;
    moves_.assign(joints.size(), false);
    std::map<std::string, double> subtree_inertia;
    for (const LinkDescription& link : description().links)
      subtree_inertia[link.name] = link.mass + link.I_cm_L.trace();
    for (std::size_t i = joints.size(); i-- > 0;) subtree_inertia[joints[i].parent] += subtree_inertia[joints[i].child];
    for (std::size_t i = 0; i < joints.size(); ++i) {
      const JointDescription& joint = joints[i];
      if (joint.type == JointType::kFixed || joint.role == JointRole::kLocked || config_.solid_compound) continue;
      const bool prescribed = onPath(static_cast<int>(i));
      if (subtree_inertia[joint.child] <= 0.0 && !prescribed) {
        note("joint '" + joint.name + "' moves nothing that has mass: locked");
        continue;
      }
      moves_[i] = true;
    }
    // A joint that mimics a still one is still.
    for (std::size_t i = 0; i < joints.size(); ++i)
      if (const auto leader = leaderOf(static_cast<int>(i)); leader && !moves_[leader->leader]) moves_[i] = false;
  }

  // Whom a joint follows in the end, through all that mimic each other; nullopt for nobody. Indices of the description.
  std::optional<CoordinateCoupling> leaderOf(int index) const {
    const auto& joints = description().joints;
    if (!joints[index].mimic || joints[index].role == JointRole::kLocked) return std::nullopt;
    CoordinateCoupling c{index, index, 1.0, 0.0};
    for (std::size_t guard = 0; joints[c.leader].mimic && guard <= joints.size(); ++guard) {
      const JointMimic& mimic = *joints[c.leader].mimic;
      const auto next = std::find_if(joints.begin(), joints.end(), [&](const auto& j) { return j.name == mimic.joint; });
      if (next == joints.end()) return std::nullopt;
      c.offset += c.multiplier * mimic.offset;
      c.multiplier *= mimic.multiplier;
      c.leader = static_cast<int>(next - joints.begin());
    }
    return c;
  }

  // Whether a joint runs on a given path: one that mimics does as its leader does.
  bool onPath(int index) const {
    const auto leader = leaderOf(index);
    const JointRole role = description().joints[leader ? leader->leader : index].role;
    return role == JointRole::kSteer || role == JointRole::kPrescribed;
  }

  // Joints that mimic others, told by their coordinates.
  void coupleMimics() {
    const auto find = [](const auto& joints, int index) {
      for (std::size_t i = 0; i < joints.size(); ++i)
        if (joints[i].description == index) return static_cast<int>(i);
      return -1;
    };
    for (std::size_t i = 0; i < description().joints.size(); ++i) {
      const auto c = leaderOf(static_cast<int>(i));
      if (!c) continue;
      const int follower = find(model_.prescribed_joints, c->coordinate);
      if (follower < 0 && !moves_[i]) continue;
      const std::string name = description().joints[i].name, leader = description().joints[c->leader].name;
      note("joint '" + name + "' mimics '" + leader + "': position = " + std::to_string(c->multiplier) + " x its + " +
           std::to_string(c->offset) + ", exactly");
      if (follower >= 0) {
        PrescribedJoint& joint = model_.prescribed_joints[follower];
        joint.leader = find(model_.prescribed_joints, c->leader);
        joint.multiplier = c->multiplier;
        joint.offset = c->offset;
      } else {
        model_.couplings.push_back({find(model_.dynamic_joints, c->coordinate), find(model_.dynamic_joints, c->leader),
                                    c->multiplier, c->offset});
      }
    }
  }

  void buildBodies() {
    const auto& links = description().links;
    model_.bodies.push_back(Body{});
    std::vector<int> body_of(links.size(), -1);
    std::vector<Pose> X_BL(links.size());
    owner_joint_.assign(links.size(), -1);
    if (links.empty()) {
      fail("vehicle '" + description().name + "'", "has no link");
      return;
    }
    body_of[0] = 0;
    for (std::size_t i = 0; i < description().joints.size(); ++i) {
      const JointDescription& joint = description().joints[i];
      const int parent = linkIndex(joint.parent), child = linkIndex(joint.child);
      if (parent < 0 || child < 0 || body_of[parent] < 0) {
        fail("joint '" + joint.name + "'", "parent '" + joint.parent + "' must be a link that stands before child '" + joint.child + "'");
        return;
      }
      const bool can_move = joint.type != JointType::kFixed && joint.role != JointRole::kLocked;
      owner_joint_[child] = can_move ? static_cast<int>(i) : owner_joint_[parent];
      const Pose X_PJ = X_BL[parent] * joint.X_PJ;
      if (!moves_[i]) {
        body_of[child] = body_of[parent];
        X_BL[child] = X_PJ * restPose(joint, stillAt(static_cast<int>(i)));
        continue;
      }
      Body body;
      body.parent = body_of[parent];
      body.prismatic = joint.type == JointType::kPrismatic;
      body.X_PB = X_PJ;
      body.axis_B = joint.axis.normalized();
      const int index = static_cast<int>(model_.bodies.size());
      if (onPath(static_cast<int>(i))) {
        body.motion = BodyMotion::kPrescribed;
        body.coordinate = addPrescribed(static_cast<int>(i), index);
      } else {
        body.motion = BodyMotion::kDynamic;
        body.coordinate = static_cast<int>(model_.dynamic_joints.size());
        DynamicJoint dynamic;
        dynamic.description = static_cast<int>(i);
        dynamic.body = index;
        dynamic.role = joint.role;
        dynamic.damping = joint.damping;
        dynamic.friction = joint.friction;
        if (!isWheel(joint.role)) {
          dynamic.lower = joint.lower;
          dynamic.upper = joint.upper;
        }
        model_.dynamic_joints.push_back(dynamic);
      }
      model_.bodies.push_back(body);
      body_of[child] = index;
      X_BL[child] = Pose{};
    }
    for (std::size_t i = 0; i < links.size(); ++i) {
      Body& body = model_.bodies[body_of[i]];
      const RigidInertia link{links[i].mass, links[i].p_Lcm, links[i].I_cm_L};
      body.inertia = body.inertia + link.seenFrom(X_BL[i]);
      for (const EllipsoidDescription& shape : links[i].ellipsoids) {
        ModelEllipsoid ellipsoid;
        ellipsoid.name = shape.name;
        ellipsoid.link = links[i].name;
        ellipsoid.body = body_of[i];
        ellipsoid.X_BE = X_BL[i] * shape.X_LE;
        ellipsoid.R_BE = ellipsoid.X_BE.q.toRotationMatrix();
        ellipsoid.radii = shape.radii;
        ellipsoid.mu = shape.mu.value_or(ellipsoid.mu);
        ellipsoid.file_stiffness = shape.stiffness;
        ellipsoid.file_damping = shape.damping;
        model_.ellipsoids.push_back(ellipsoid);
      }
      model_.mass += links[i].mass;
    }
    // A solid compound still steers and rolls: its axles turn, its wheels become treads.
    if (config_.solid_compound)
      for (std::size_t i = 0; i < description().joints.size(); ++i)
        if (description().joints[i].role == JointRole::kSteer) addPrescribed(static_cast<int>(i), -1);
    if (!(model_.mass > 0.0))
      fail("vehicle '" + description().name + "'", "weighs " + std::to_string(model_.mass) + " kg in all; more than 0 is needed");
  }

  // Where a joint that does not move stands.
  double stillAt(int index) const {
    if (const auto leader = leaderOf(index)) return leader->multiplier * stillAt(leader->leader) + leader->offset;
    const JointDescription& joint = description().joints[index];
    return std::clamp(0.0, std::min(joint.lower, joint.upper), std::max(joint.lower, joint.upper));
  }

  static Pose restPose(const JointDescription& joint, double position) {
    Pose X;
    if (joint.type == JointType::kPrismatic) X.p = position * joint.axis;
    if (joint.type == JointType::kRevolute || joint.type == JointType::kContinuous)
      X.q = Eigen::AngleAxisd(position, joint.axis.normalized());
    return X;
  }

  int addPrescribed(int index, int body) {
    const JointDescription& joint = description().joints[index];
    PrescribedJoint prescribed;
    prescribed.description = index;
    prescribed.body = body;
    prescribed.lower = joint.lower;
    prescribed.upper = joint.upper;
    prescribed.max_speed = std::min(config_.steer_rate, joint.velocity_limit);
    prescribed.max_acceleration = config_.steer_acceleration;
    prescribed.effort_limit = joint.effort_limit;
    model_.prescribed_joints.push_back(prescribed);
    return static_cast<int>(model_.prescribed_joints.size()) - 1;
  }

  // The base's frame moves into its centre of mass: translation and rotation then decouple in free flight.
  void centreBase() {
    Body& base = model_.bodies[0];
    const Vector3d p = base.inertia.p_Acm;
    model_.X_BR.p = -p;
    base.inertia.p_Acm.setZero();
    for (Body& body : model_.bodies)
      if (body.parent == 0) body.X_PB.p -= p;
    for (ModelEllipsoid& ellipsoid : model_.ellipsoids)
      if (ellipsoid.body == 0) ellipsoid.X_BE.p -= p;
  }

  void findSpinSymmetry() {
    for (std::size_t i = 1; i < model_.bodies.size(); ++i) {
      Body& body = model_.bodies[i];
      if (body.prismatic) continue;
      bool symmetric = true;
      for (const Body& other : model_.bodies) symmetric = symmetric && other.parent != static_cast<int>(i);
      const Vector3d& a = body.axis_B;
      const double scale = std::max(body.inertia.I_cm_A.norm(), 1e-30);
      const Vector3d off = body.inertia.p_Acm - a.dot(body.inertia.p_Acm) * a;
      const Vector3d t1 = a.unitOrthogonal(), t2 = a.cross(t1);
      const Matrix3d& I = body.inertia.I_cm_A;
      symmetric = symmetric && std::abs(t1.dot(I * t1) - t2.dot(I * t2)) < kSymmetryTolerance * scale &&
                  std::abs(t1.dot(I * t2)) < kSymmetryTolerance * scale && (I * a).cross(a).norm() < kSymmetryTolerance * scale;
      for (const ModelEllipsoid& ellipsoid : model_.ellipsoids) {
        if (ellipsoid.body != static_cast<int>(i)) continue;
        const Matrix3d A = ellipsoid.R_BE * ellipsoid.radii.cwiseAbs2().asDiagonal() * ellipsoid.R_BE.transpose();
        const double size = ellipsoid.radii.maxCoeff();
        const Vector3d from_axis = ellipsoid.X_BE.p - a.dot(ellipsoid.X_BE.p) * a;
        // Only an exactly round wheel may skip its angle: a micrometre of wobble would be a force.
        symmetric = symmetric && from_axis.norm() < 1e-9 * size && (A * a).cross(a).norm() < 1e-9 * size * size &&
                    std::abs(t1.dot(A * t1) - t2.dot(A * t2)) < 1e-9 * size * size &&
                    std::abs(t1.dot(A * t2)) < 1e-9 * size * size && off.norm() < kSymmetryTolerance * size;
      }
      body.spin_symmetric = symmetric;
    }
  }

  static bool isWheelJoint(const DynamicJoint& joint) {
    return joint.role == JointRole::kDrive || joint.role == JointRole::kFreeWheel;
  }

  // What each coordinate feels with all else free; a coordinate that moves nothing cannot be integrated.
  bool reflectInertias(ArticulatedBody& tree) {
    std::vector<double> tau(model_.bodies.size(), 0.0), qdd(model_.bodies.size(), 0.0);
    const std::vector<PrescribedMotion> still(model_.bodies.size());
    for (std::size_t j = 0; j < model_.dynamic_joints.size(); ++j) {
      DynamicJoint& joint = model_.dynamic_joints[j];
      std::fill(tau.begin(), tau.end(), 0.0);
      tau[j] = 1.0;
      tree.clearForces();
      tree.accelerations(tau.data(), still.data(), Vec3{0.0, 0.0, 0.0}, qdd.data());
      joint.reflected_inertia = 1.0 / qdd[j];
      // All wheels are held at once: what one of them moves, the others feel. Of heavy wheels under a light body that is
      // much; the sum of a row bounds the fastest mode of all holds together (Gershgorin).
      double together = std::abs(qdd[j]);
      for (std::size_t other = 0; other < model_.dynamic_joints.size(); ++other)
        if (other != j && isWheelJoint(joint) && isWheelJoint(model_.dynamic_joints[other])) together += std::abs(qdd[other]);
      hold_inertia_.push_back(1.0 / together);
      if (!(tree.articulatedInertia(joint.body) > kNoInertia) || !std::isfinite(qdd[j]) || !(qdd[j] > 0.0)) {
        const JointDescription& d = description().joints[joint.description];
        fail("joint '" + d.name + "' (line " + std::to_string(d.line) + ")",
             "the links it moves have no inertia along it (" + std::to_string(tree.articulatedInertia(joint.body)) +
                 "); link '" + d.child + "' needs an <inertial> with a positive " +
                 (d.type == JointType::kPrismatic ? "mass" : "moment about the axis"));
      }
    }
    return problems_.empty();
  }

  bool groundWheel(int ellipsoid) const {
    for (const WheelUnit& wheel : model_.drive.wheels)
      if (wheel.ellipsoid == ellipsoid) return true;
    return false;
  }

  // Something gives between the wheels: a suspension, a rocker. A caster's swivel does not.
  bool levelsOut(const DynamicJoint& j) const {
    const Body& body = model_.bodies[j.body];
    return j.role == JointRole::kSuspension ||
           (j.role == JointRole::kPassive && std::abs((restGeometry(model_).X_RB[j.body].q * body.axis_B).z()) < 0.7);
  }

  // Whether a vehicle on fewer than three wheels leans on this ellipsoid, which is none of them.
  bool leansOn(std::size_t ellipsoid) const {
    const auto& wheels = model_.drive.wheels;
    if (wheels.empty() || wheels.size() > 2 || groundWheel(static_cast<int>(ellipsoid))) return false;
    double bottom = 1e300, radius = 1e300;
    for (const WheelUnit& wheel : wheels) {
      bottom = std::min(bottom, wheel.p_FW.z() - wheel.radius);
      radius = std::min(radius, wheel.radius);
    }
    const ModelEllipsoid& e = model_.ellipsoids[ellipsoid];
    const Pose X_RE = restGeometry(model_).X_RB[e.body] * e.X_BE;
    const double low = X_RE.p.z() - (X_RE.q.toRotationMatrix() * e.radii.asDiagonal()).row(2).norm();
    return low < bottom + kLeans * radius;
  }

  int leanedOn() const {
    int count = 0;
    for (std::size_t i = 0; i < model_.ellipsoids.size(); ++i) count += leansOn(i) ? 1 : 0;
    return count;
  }

  // Without suspension a stiff vehicle would stand on three wheels: the sag must be twice the spread of the bottoms. And
  // one that trails casters would lift its driven wheels off every hollow, where a real one's tyres give.
  double stiffnessThatSags() const {
    const auto& wheels = model_.drive.wheels;
    const auto& joints = model_.dynamic_joints;
    if (wheels.empty() || std::any_of(joints.begin(), joints.end(), [this](const auto& j) { return levelsOut(j); }))
      return kSeedStiffness;
    double low = 1e300, high = -1e300, radius = 1e300;
    bool casters = false;
    for (const WheelUnit& wheel : wheels) {
      low = std::min(low, wheel.p_FW.z() - wheel.radius);
      high = std::max(high, wheel.p_FW.z() - wheel.radius);
      radius = std::min(radius, wheel.radius);
      casters = casters || (!wheel.driven && !wheel.braked);
    }
    // Two wheels and what the vehicle leans on: that is less than a caster, and must not let it rock back on slopes.
    const int leans = wheels.size() < 3 ? leanedOn() : 0;
    if (wheels.size() < 3 && leans == 0) return kSeedStiffness;
    const bool many = (casters && wheels.size() > 3) || leans > 1;
    const double spread = wheels.size() < 3 ? 0.0 : 2.0 * (high - low);
    const double sag = std::max(spread, many ? (leans > 1 ? 0.5 : 1.0) * kCasterSag * radius : 0.0);
    const double load = model_.mass * std::max(config_.gravity, 1.0) / static_cast<double>(wheels.size() + leans);
    return sag > 0.0 ? load / sag : kSeedStiffness;
  }

  void deriveContacts(ArticulatedBody& tree) {
    const double cap = kSeedStiffness;
    const double wheel_cap = std::min(cap, stiffnessThatSags());
    for (std::size_t i = 0; i < model_.ellipsoids.size(); ++i) {
      ModelEllipsoid& ellipsoid = model_.ellipsoids[i];
      const bool wheel = groundWheel(static_cast<int>(i));
      const ContactMasses masses = contactMasses(tree, ellipsoid, wheel);
      ellipsoid.normal_mass = masses.normal;
      ellipsoid.tangential_mass = masses.tangential;
      ellipsoid.law = contactLaw(ellipsoid, wheel, masses, wheel || leansOn(i) ? wheel_cap : cap, config_, model_.report);
      const double h = ellipsoid.radii.minCoeff();
      // Head-on with the whole mass behind it, and never more than its half width in one step. A step's delay lets it sink
      // deeper than v / omega: over all phases of the touch and damping ratios by up to 1.09 (measured), and to twice that
      // with explicit Euler, which moves on with the speed of before the touch.
      const double omega = std::sqrt(ellipsoid.law.stiffness / model_.mass);
      const bool explicit_euler = config_.integrator == IntegratorKind::kExplicitEuler;
      const double delay = (explicit_euler ? 1.0 : 0.125) * omega * config_.dt;
      const double speed = std::min(h * omega / (1.0 + delay), h / ((explicit_euler ? 2.0 : 1.0) * config_.dt));
      model_.stoppable_speed.push_back(speed);
      char line[200];
      std::snprintf(line, sizeof line, "contact of '%s': stops the whole vehicle up to %.3g m/s", ellipsoid.name.c_str(), speed);
      note(line);
    }
  }

  // Whether a suspension's spring can carry its load within the travel; a note says so if not, and what is used instead.
  bool springHolds(const DynamicJoint& joint, const JointDescription& d, double load) {
    if (joint.role != JointRole::kSuspension || d.type != JointType::kPrismatic || load == 0.0) return true;
    const double k = *d.spring_stiffness, reference = d.spring_reference.value_or(0.0);
    const double rest = k > 0.0 ? reference + load / k : std::copysign(std::numeric_limits<double>::infinity(), load);
    const double travel = joint.upper - joint.lower;
    const bool stands = !std::isfinite(travel) ? k > 0.0 : rest > joint.lower && rest < joint.upper;
    if (stands) return true;
    char line[320];
    std::snprintf(line, sizeof line,
                  "WARNING suspension '%s' (line %d): its spring of %.4g N/m about %.4g m would rest at %.4g m under %.4g N, outside "
                  "its travel %.4g ... %.4g m: it makes no physical sense, a spring from the carried mass is used instead",
                  d.name.c_str(), d.line, k, reference, rest, load, joint.lower, joint.upper);
    note(line);
    return false;
  }

  // Springs: from the file, or from the carried load so that the joint rests in the middle of its travel.
  void deriveSprings() {
    const double g = config_.gravity > 0.0 ? config_.gravity : 9.80665;
    const std::vector<double> loads = carriedLoads(model_, owner_joint_, g);
    for (std::size_t j = 0; j < model_.dynamic_joints.size(); ++j) {
      DynamicJoint& joint = model_.dynamic_joints[j];
      const JointDescription& d = description().joints[joint.description];
      if (d.spring_stiffness && springHolds(joint, d, loads[j])) {
        joint.stiffness = *d.spring_stiffness;
        joint.reference = d.spring_reference.value_or(0.0);
        const double rest = joint.reference + (joint.stiffness > 0.0 ? loads[j] / joint.stiffness : 0.0);
        joint.rest = std::clamp(rest, joint.lower, joint.upper);
        continue;
      }
      joint.rest = std::clamp(0.0, joint.lower, joint.upper);
      if (joint.role != JointRole::kSuspension) continue;
      const double omega = 2.0 * M_PI * config_.ride_frequency;
      const double carried = std::max(std::abs(loads[j]) / g, 0.1 * joint.reflected_inertia);
      joint.stiffness = carried * omega * omega;
      if (joint.damping == 0.0) joint.damping = 2.0 * config_.ride_damping_ratio * carried * omega;
      const double middle = std::isfinite(joint.lower) && std::isfinite(joint.upper) ? 0.5 * (joint.lower + joint.upper) : 0.0;
      joint.reference = middle - loads[j] / joint.stiffness;
      joint.rest = middle;
      char line[240];
      std::snprintf(line, sizeof line, "suspension '%s': no spring to go by in the file, carries %.4g kg: stiffness %.4g N/m, damping %.4g N s/m, rests at %.3g m",
                    d.name.c_str(), carried, joint.stiffness, joint.damping, middle);
      note(line);
    }
  }

  void deriveJointConstants() {
    for (const CoordinateCoupling& c : model_.couplings)
      model_.dynamic_joints[c.coordinate].rest = c.multiplier * model_.dynamic_joints[c.leader].rest + c.offset;
    for (std::size_t j = 0; j < model_.dynamic_joints.size(); ++j) {
      DynamicJoint& joint = model_.dynamic_joints[j];
      const double I = joint.reflected_inertia;
      joint.stop_stiffness = I * kStopFrequency * kStopFrequency;
      joint.stop_damping = 2.0 * kStopDampingRatio * I * kStopFrequency;
      joint.hold.stiffness = hold_inertia_[j] * kHoldFrequency * kHoldFrequency;
      joint.hold.damping = 2.0 * kHoldDampingRatio * hold_inertia_[j] * kHoldFrequency;
    }
  }

  const SimConfig& config_;
  VehicleModel model_;
  Problems problems_;
  std::vector<bool> moves_;        // per joint: is a coordinate
  std::vector<double> hold_inertia_;  // per coordinate: what it feels with all wheels held at once [kg m^2]
  std::vector<int> owner_joint_;   // per link: the nearest movable joint above it, -1 at the root
};

}  // namespace

Loaded<VehicleModel> compileVehicle(const VehicleDescription& description, const SimConfig& config) {
  return Compiler(description, config).run();
}

}  // namespace ellipsoid_vehicle_sim
