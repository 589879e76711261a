#include "drive_model.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "contact_laws.h"
#include "wheel_loads.h"

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

// A speed servo answers within this time [s], unless its wheel is too light for that at the default tick.
// With linearly_implicit a wheel counts as light below this part of what it carries, and its servo is made for the load
// instead of the wheel; heavier ones are the same with every integrator [-].
constexpr double kLightWheel = 0.01;
constexpr double kServoTime = 0.1;
constexpr double kServoStep = 0.4;
// Integral part: forgets a constant load (a slope) within this time [s].
constexpr double kServoIntegralTime = 0.5;
// Of the grip that an unlimited motor has in torque [-].
constexpr double kSkidding = 1.5;
// A locked differential's coupling, as the fraction of a wheel's inertia per default tick.
constexpr double kLockStep = 0.3;

bool isWheel(JointRole role) { return role == JointRole::kDrive || role == JointRole::kFreeWheel; }

// The nearest joint above `link` with the given role; -1 if there is none.
int ancestorWithRole(const VehicleDescription& description, std::string link, JointRole role) {
  for (bool found = true; found;) {
    found = false;
    for (std::size_t i = 0; i < description.joints.size(); ++i) {
      if (description.joints[i].child != link) continue;
      if (description.joints[i].role == role) return static_cast<int>(i);
      link = description.joints[i].parent;
      found = true;
      break;
    }
  }
  return -1;
}

// Poses of all links in the root's frame turned to look forward, with all joints at zero.
std::vector<Pose> linkPoses(const VehicleDescription& description) {
  std::vector<Pose> X_FL(description.links.size());
  if (description.forward_yaw != 0.0 && !X_FL.empty())
    X_FL[0].q = Eigen::AngleAxisd(-description.forward_yaw, Vector3d::UnitZ());
  for (std::size_t i = 0; i < description.joints.size(); ++i)
    for (std::size_t parent = 0; parent < description.links.size(); ++parent)
      if (description.links[parent].name == description.joints[i].parent)
        X_FL[i + 1] = X_FL[parent] * description.joints[i].X_PJ;
  return X_FL;
}

// Steering joints that are one by <mimic> turn by one angle: the one that is right in the middle between them.
void shareLeaders(const VehicleModel& model, DriveModel& drive) {
  const auto leaderOf = [&](const SteerUnit& steer) {
    const int leader = model.prescribed_joints[steer.prescribed].leader;
    return leader >= 0 ? leader : steer.prescribed;
  };
  std::vector<SteerUnit> shared = drive.steers;
  for (SteerUnit& steer : shared) {
    Vector3d sum = Vector3d::Zero();
    int count = 0;
    for (const SteerUnit& other : drive.steers)
      if (leaderOf(other) == leaderOf(steer) && std::abs(other.p_FS.x() - steer.p_FS.x()) < 1e-3) {
        sum += other.p_FS;
        ++count;
      }
    steer.p_FS = sum / count;
  }
  drive.steers = std::move(shared);
}

}  // namespace

double ackermannAngle(double curvature, const Vector3d& p_FS, double reference_x) {
  const double ahead = curvature * (p_FS.x() - reference_x);
  const double aside = 1.0 - curvature * p_FS.y();
  // The wheel rolls both ways: an angle beyond a quarter turn is the same axle.
  return aside >= 0.0 ? std::atan2(ahead, aside) : std::atan2(-ahead, -aside);
}

DriveModel buildDriveModel(VehicleModel& model, const std::vector<int>& owner_joint, const SimConfig& config,
                           Problems& problems) {
  const VehicleDescription& description = model.description;
  const std::vector<Pose> X_FL = linkPoses(description);
  const Eigen::Quaterniond q_RF(Eigen::AngleAxisd(description.forward_yaw, Vector3d::UnitZ()));
  DriveModel drive;
  drive.layout = description.layout;
  drive.differential = config.differential;

  std::vector<int> steer_of_joint(description.joints.size(), -1);
  for (std::size_t p = 0; p < model.prescribed_joints.size(); ++p) {
    const int index = model.prescribed_joints[p].description;
    const JointDescription& joint = description.joints[index];
    if (joint.role != JointRole::kSteer) continue;
    SteerUnit steer;
    steer.prescribed = static_cast<int>(p);
    const Pose& X_FJ = X_FL[index + 1];
    steer.p_FS = X_FJ.p;
    steer.sign = (X_FJ.q * joint.axis).z() >= 0.0 ? 1.0 : -1.0;
    steer.lower = steer.sign > 0.0 ? joint.lower : -joint.upper;
    steer.upper = steer.sign > 0.0 ? joint.upper : -joint.lower;
    steer_of_joint[index] = static_cast<int>(drive.steers.size());
    drive.steers.push_back(steer);
  }

  shareLeaders(model, drive);

  for (std::size_t i = 0; i < description.joints.size(); ++i) {
    const JointDescription& joint = description.joints[i];
    if (!isWheel(joint.role)) continue;
    const Pose& X_FJ = X_FL[i + 1];
    const Vector3d axle_F = X_FJ.q * joint.axis.normalized();
    for (std::size_t e = 0; e < model.ellipsoids.size(); ++e) {
      ModelEllipsoid& ellipsoid = model.ellipsoids[e];
      int link = -1;
      for (std::size_t l = 0; l < description.links.size(); ++l)
        if (description.links[l].name == ellipsoid.link) link = static_cast<int>(l);
      if (link < 0 || owner_joint[link] != static_cast<int>(i)) continue;

      WheelUnit wheel;
      wheel.name = joint.name;
      wheel.unit = static_cast<int>(drive.wheels.size());
      wheel.ellipsoid = static_cast<int>(e);
      wheel.p_FW = X_FL[link] * description.links[link].ellipsoids.front().X_LE.p;
      for (const EllipsoidDescription& shape : description.links[link].ellipsoids)
        if (shape.name == ellipsoid.name) wheel.p_FW = X_FL[link] * shape.X_LE.p;
      wheel.radius = ellipsoid.radii.maxCoeff();
      wheel.forward_sign = axle_F.y() >= 0.0 ? 1.0 : -1.0;
      wheel.driven = joint.role == JointRole::kDrive;
      const bool on_swivel = ancestorWithRole(description, joint.child, JointRole::kPassive) >= 0 && !wheel.driven &&
                             std::abs((X_FL[ancestorWithRole(description, joint.child, JointRole::kPassive) + 1].q *
                                       description.joints[ancestorWithRole(description, joint.child, JointRole::kPassive)].axis).z()) > 0.7;
      wheel.braked = !on_swivel;
      const int steer = ancestorWithRole(description, joint.parent, JointRole::kSteer);
      wheel.steer = steer < 0 ? -1 : steer_of_joint[steer];
      wheel.max_torque = config.max_drive_torque.value_or(joint.effort_limit);
      for (std::size_t j = 0; j < model.dynamic_joints.size(); ++j)
        if (model.dynamic_joints[j].description == static_cast<int>(i)) wheel.joint = static_cast<int>(j);
      if (wheel.joint < 0) {
        Tread tread;
        tread.description = static_cast<int>(i);
        tread.axle_B = q_RF * axle_F;
        if (wheel.steer >= 0) {
          tread.steer = drive.steers[wheel.steer].prescribed;
          tread.steer_axis_B = (q_RF * X_FL[steer + 1].q * description.joints[steer].axis).normalized();
        }
        wheel.tread = ellipsoid.tread = static_cast<int>(model.treads.size());
        model.treads.push_back(tread);
      }
      drive.wheels.push_back(wheel);
    }
  }

  if (drive.wheels.empty() && !config.allow_no_wheels)
    problems.push_back({"vehicle '" + description.name + "'",
                        "no ground wheel found among its joints (see the table of roles); a body that nothing drives needs "
                        "allow_no_wheels: true"});

  // The commanded speed is meant where the axle does not steer.
  double fixed_x = 0.0, all_x = 0.0, steered_x = 0.0;
  int fixed = 0, steered = 0;
  for (const WheelUnit& wheel : drive.wheels) {
    all_x += wheel.p_FW.x();
    // Neither casters nor a trailer's wheels roll along the vehicle's own path.
    const bool own = wheel.braked || wheel.driven;
    const bool counts = drive.layout == DriveLayout::kAckermann ? wheel.steer < 0 && own : wheel.driven;
    if (counts) {
      fixed_x += wheel.p_FW.x();
      ++fixed;
    }
    if (wheel.steer >= 0) {
      steered_x += wheel.p_FW.x();
      ++steered;
    }
  }
  const double count = std::max<double>(1.0, static_cast<double>(drive.wheels.size()));
  drive.reference_x = fixed > 0 ? fixed_x / fixed : all_x / count;
  if (steered > 0) drive.wheelbase = std::abs(steered_x / steered - drive.reference_x);

  // The sharpest curve both ways that every steering joint can follow.
  const auto sharpest = [&](double sign) {
    double low = 0.0, high = 1e3;
    for (int i = 0; i < 80; ++i) {
      const double middle = 0.5 * (low + high);
      bool possible = true;
      for (const SteerUnit& steer : drive.steers) {
        if (1.0 - sign * middle * steer.p_FS.y() <= 0.0) possible = false;
        const double angle = ackermannAngle(sign * middle, steer.p_FS, drive.reference_x);
        possible = possible && angle >= steer.lower && angle <= steer.upper;
      }
      (possible ? low : high) = middle;
    }
    return low;
  };
  if (!drive.steers.empty()) {
    drive.max_curvature_left = sharpest(1.0);
    drive.max_curvature_right = sharpest(-1.0);
  }
  return drive;
}

void deriveDriveGains(VehicleModel& model, const SimConfig& config) {
  DriveModel& drive = model.drive;
  const bool implicit = config.integrator == IntegratorKind::kLinearlyImplicit;
  int driven = 0;
  double inertia = 1e300, radius = 0.0, mean_x = 0.0;
  for (const WheelUnit& wheel : drive.wheels) {
    mean_x += wheel.p_FW.x() / static_cast<double>(drive.wheels.size());
    if (!wheel.driven) continue;
    ++driven;
    radius = std::max(radius, wheel.radius);
    if (wheel.joint >= 0) inertia = std::min(inertia, model.dynamic_joints[wheel.joint].reflected_inertia);
  }
  if (driven > 0) {
    const double wanted = model.mass * radius * radius / (driven * kServoTime);
    // Explicit steps bear a gain only in proportion to what it turns; an implicit one bears any.
    const bool light = implicit && inertia < kLightWheel * model.mass * radius * radius / driven;
    drive.speed_gain = light ? wanted : std::min(wanted, kServoStep * inertia / kDefaultTick);
    drive.integral_gain = drive.speed_gain / kServoIntegralTime;
    drive.lock_gain = kLockStep * std::min(inertia, model.mass * radius * radius) / kDefaultTick;
  }

  // Brakes: the wanted deceleration, shared front and rear; one end takes all if the other has none.
  int front = 0, rear = 0;
  for (const WheelUnit& wheel : drive.wheels)
    if (wheel.braked) ++(wheel.p_FW.x() > mean_x + 1e-9 ? front : rear);
  for (WheelUnit& wheel : drive.wheels) {
    if (std::isinf(wheel.max_torque) && wheel.driven) {
      // Enough to accelerate, and to make wheels skid that have to: else no skid-steer would turn.
      const double pull = std::max(2.0 * config.max_acceleration, kSkidding * config.mu_static * config.gravity);
      wheel.max_torque = pull * model.mass * wheel.radius / driven;
      char line[200];
      std::snprintf(line, sizeof line, "wheel '%s': no effort limit in the file, motor torque limited to %.4g N m", wheel.name.c_str(), wheel.max_torque);
      model.report.emplace_back(line);
    }
    if (!wheel.braked) continue;
    const bool is_front = wheel.p_FW.x() > mean_x + 1e-9;
    const double balance = front == 0 ? 0.0 : rear == 0 ? 1.0 : config.brake_balance;
    const double share = is_front ? balance / front : (1.0 - balance) / rear;
    wheel.brake_torque = share * model.mass * config.max_deceleration * wheel.radius;
  }
}

}  // namespace ellipsoid_vehicle_sim
