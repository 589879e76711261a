#include "peers.h"

#ifdef WITH_MUJOCO

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>

#include "mujoco_model.h"
#include "wheel_torques.h"

// A DriveScene in MuJoCo: the vehicle's own tree, body by body.

namespace ellipsoid_vehicle_sim {
namespace {

// Joints on a path turn a rotor so heavy that nothing else moves it; the effort that moves the rotor along the path is
// known. What is left of other forces in a step is put right at its end, less than 1e-12 rad [kg m^2, kg].
constexpr double kRotor = 1e6;

// Friction is so much harder than the contact's spring, or what stands on a slope would creep by millimetres [-].
constexpr const char* kHardFriction = "impratio='1000'";

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Writes the tree as nested elements.
class TreeWriter {
 public:
  explicit TreeWriter(const DriveScene& scene) : scene_(scene), model_(scene.model) {
    is_wheel_.assign(model_.dynamic_joints.size(), false);
    for (const WheelUnit& wheel : model_.drive.wheels) is_wheel_[static_cast<std::size_t>(wheel.joint)] = true;
  }

  std::string bodyXml(std::size_t index) const {
    const Body& body = model_.bodies[index];
    const Pose X = index == 0 ? scene_.start.X_WB : body.X_PB;
    const Eigen::Matrix3d& I = body.inertia.I_cm_A;
    std::string xml = "<body pos='" + mujocoVector(X.p) + "' quat='" + mujocoQuaternion(X.q) + "'>";
    xml += index == 0 ? "<freejoint/>" : jointXml(body);
    xml += "<inertial pos='" + mujocoVector(body.inertia.p_Acm) + "' mass='" + mujocoNumber(body.inertia.mass) +
           "' fullinertia='" + mujocoVector(I.diagonal()) + " " + mujocoVector({I(0, 1), I(0, 2), I(1, 2)}) + "'/>";
    for (std::size_t e = 0; e < model_.ellipsoids.size(); ++e)
      if (model_.ellipsoids[e].body == static_cast<int>(index)) xml += geomXml(e);
    for (std::size_t child = 1; child < model_.bodies.size(); ++child)
      if (model_.bodies[child].parent == static_cast<int>(index)) xml += bodyXml(child);
    return xml + "</body>";
  }

 private:
  // Joints are named by their coordinates: d3 is dynamic, p1 on a path.
  std::string jointXml(const Body& body) const {
    const std::string begin = std::string("<joint type='") + (body.prismatic ? "slide" : "hinge") + "' axis='" +
                              mujocoVector(body.axis_B) + "' name='";
    if (body.motion == BodyMotion::kPrescribed)
      return begin + "p" + std::to_string(body.coordinate) + "' armature='" + mujocoNumber(kRotor) + "'/>";
    const std::string named = begin + "d" + std::to_string(body.coordinate) + "'";
    const auto coordinate = static_cast<std::size_t>(body.coordinate);
    if (is_wheel_[coordinate]) return named + "/>";  // WheelTorques has its damping and friction
    const DynamicJoint& joint = model_.dynamic_joints[coordinate];
    std::string xml = named + " stiffness='" + mujocoNumber(joint.stiffness) + "' springref='" +
                      mujocoNumber(joint.reference) + "' damping='" + mujocoNumber(joint.damping) + "' frictionloss='" +
                      mujocoNumber(joint.friction) + "'";
    if (std::isfinite(joint.lower) && std::isfinite(joint.upper))
      xml += " limited='true' range='" + mujocoNumber(joint.lower) + " " + mujocoNumber(joint.upper) + "'";
    return xml + "/>";
  }

  // Against the plane only, and with the ellipsoid's own constants.
  std::string geomXml(std::size_t index) const {
    const ModelEllipsoid& e = model_.ellipsoids[index];
    return "<geom name='e" + std::to_string(index) + "' type='ellipsoid' contype='0' conaffinity='1' priority='1' pos='" +
           mujocoVector(e.X_BE.p) + "' quat='" + mujocoQuaternion(e.X_BE.q) + "' size='" + mujocoVector(e.radii) + "' " +
           mujocoContact(e.law.stiffness, e.law.damping, e.normal_mass, scene_.mu[index]) + "/>";
  }

  const DriveScene& scene_;
  const VehicleModel& model_;
  std::vector<bool> is_wheel_;
};

std::string xmlOf(const DriveScene& scene, const std::string& integrator, double dt) {
  // The rotors are no measure of the inertia that the solver's tolerance goes by.
  return "<mujoco><compiler inertiafromgeom='false' angle='radian'/>" + mujocoOption(dt, scene.gravity, integrator, kHardFriction) +
         "<statistic meaninertia='" + mujocoNumber(scene.model.mass) + "'/><worldbody>" +
         mujocoPlane(scene.nhat_W, scene.p_WP, "contype='1' conaffinity='0'") + TreeWriter(scene).bodyXml(0) +
         "</worldbody></mujoco>";
}

/// Contacts whose sag under a load is that of our spring; one that takes the load away has none, and the wheel hops at every
/// step's rounding of its touch. An impedance at which the regularisation R equals the contact's own inverse mass: R f =
/// aref = k R depth at rest, and half of k in motion. All in MuJoCo's own estimate of that inverse mass, which scales R.
void setSprings(const DriveScene& scene, mjModel& model) {
  for (std::size_t i = 0; i < scene.model.ellipsoids.size(); ++i) {
    const ModelEllipsoid& e = scene.model.ellipsoids[i];
    const int geom = mj_name2id(&model, mjOBJ_GEOM, ("e" + std::to_string(i)).c_str());
    const double estimate = model.body_invweight0[2 * model.geom_bodyid[geom]], own = 1.0 / e.normal_mass;
    const double d = std::clamp(estimate / (estimate + own), 1e-3, 0.999), R = (1.0 - d) / d * estimate;
    mjtNum* solref = model.geom_solref + mjNREF * geom;
    solref[0] = -e.law.stiffness * R * d;
    solref[1] = -std::max(e.law.damping, 1e-9) * R * d;
    mjtNum* solimp = model.geom_solimp + mjNIMP * geom;
    solimp[0] = solimp[1] = d;
  }
}

/// What is applied to the joints; MuJoCo asks for it at every evaluation, those within an RK4 step too.
class Driver {
 public:
  Driver(const DriveScene& scene, const mjModel& model, double dt)
      : scene_(scene), model_(model), dt_(dt), torques_(scene, dt) {
    for (const WheelUnit& wheel : scene.model.drive.wheels) wheels_.push_back(jointOf('d', wheel.joint));
    for (std::size_t p = 0; p < scene.model.prescribed_joints.size(); ++p)
      paths_.push_back(jointOf('p', static_cast<int>(p)));
    angle_.resize(wheels_.size());
    speed_.resize(wheels_.size());
  }

  void start(mjData& data) const {
    const Motion& x = scene_.start;
    const Eigen::Vector3d w_B = x.X_WB.q.conjugate() * x.w_WB;
    for (int i = 0; i < 3; ++i) {
      data.qvel[i] = x.v_WB[i];
      data.qvel[3 + i] = w_B[i];
    }
    for (std::size_t j = 0; j < x.q.size(); ++j) {
      const int joint = jointOf('d', static_cast<int>(j));
      data.qpos[model_.jnt_qposadr[joint]] = x.q[j];
      data.qvel[model_.jnt_dofadr[joint]] = x.qd[j];
    }
  }

  void apply(mjData& data) {
    read(data);
    const std::vector<double>& torque = torques_.at(data.time, angle_, speed_);
    for (std::size_t i = 0; i < wheels_.size(); ++i) data.qfrc_applied[model_.jnt_dofadr[wheels_[i]]] = torque[i];
  }

  void beginStep(mjData& data) const {
    for (std::size_t p = 0; p < paths_.size(); ++p) {
      const DriveSeries::Path from = scene_.series.path(static_cast<int>(p), data.time),
                              to = scene_.series.path(static_cast<int>(p), data.time + dt_);
      const int dof = model_.jnt_dofadr[paths_[p]];
      data.qpos[model_.jnt_qposadr[paths_[p]]] = from.position;
      data.qvel[dof] = from.velocity;
      data.qfrc_applied[dof] = kRotor * (to.velocity - from.velocity) / dt_;
    }
  }

  void endStep(const mjData& data) {
    read(data);
    torques_.endStep(data.time, angle_, speed_);
  }

 private:
  int jointOf(char kind, int coordinate) const {
    return mj_name2id(&model_, mjOBJ_JOINT, (kind + std::to_string(coordinate)).c_str());
  }
  void read(const mjData& data) {
    for (std::size_t i = 0; i < wheels_.size(); ++i) {
      angle_[i] = data.qpos[model_.jnt_qposadr[wheels_[i]]];
      speed_[i] = data.qvel[model_.jnt_dofadr[wheels_[i]]];
    }
  }

  const DriveScene& scene_;
  const mjModel& model_;
  double dt_;
  WheelTorques torques_;
  std::vector<int> wheels_, paths_;  // MuJoCo's joints
  std::vector<double> angle_, speed_;
};

// MuJoCo has one callback for all models and threads: each thread keeps whom it serves.
thread_local Driver* driving = nullptr;

void control(const mjModel*, mjData* data) {
  if (driving) driving->apply(*data);
}

}  // namespace

PeerRun driveMujoco(const DriveScene& scene, const std::string& integrator, double dt) {
  static std::once_flag installed;
  std::call_once(installed, [] { mjcb_control = control; });
  std::string error;
  const MujocoModel model = loadMujoco(xmlOf(scene, integrator, dt), error);
  if (!model) return {{}, 0.0, error};
  setSprings(scene, *model);
  const MujocoData data(mj_makeData(model.get()), mj_deleteData);
  Driver driver(scene, *model, dt);
  driver.start(*data);
  driving = &driver;
  PeerRun run = runPeer(
      scene.duration, dt,
      [&] {
        driver.beginStep(*data);
        mj_step(model.get(), data.get());
        driver.endStep(*data);
      },
      [&] {
        const mjtNum* q = data->qpos;
        return scene.rootPose({{mujocoGaveUp(*data) ? kNaN : q[0], q[1], q[2]}, Eigen::Quaterniond(q[3], q[4], q[5], q[6])});
      });
  driving = nullptr;
  return run;
}

}  // namespace ellipsoid_vehicle_sim

#endif
