#include "state_check.h"

#include <cmath>
#include <type_traits>

#include "state_fields.h"

namespace ellipsoid_vehicle_sim {
namespace {

/// No state of a vehicle holds a larger number [SI].
constexpr double kLargestValue = 1e15;
constexpr std::int64_t kOldest = 1000000000000000;  // ticks: thirty thousand years of milliseconds
/// What a rotation kept for hours loses of its length, many times over.
constexpr double kRotationRounding = 1e-6;

/// Looks at the fields of a state one by one.
class FieldCheck {
 public:
  void size(std::size_t) {}
  void operator()(double value) { fits(std::isfinite(value) && std::abs(value) <= kLargestValue, "a number out of range"); }
  void operator()(bool) {}
  void operator()(int) {}  // looked at where its meaning is known
  void operator()(std::int64_t age) { fits(age >= 0 && age <= kOldest, "an age out of range"); }
  void operator()(DriveState::Mode mode) { fits(mode <= DriveState::Mode::kDrive, "an unknown mode of the drive"); }
  void operator()(DriveCommand::Kind kind) { fits(kind <= DriveCommand::Kind::kCoast, "an unknown kind of command"); }
  void operator()(JointCommand::Kind kind) { fits(kind <= JointCommand::Kind::kEffort, "an unknown kind of joint command"); }
  void operator()(TreadState::Mode mode) { fits(mode <= TreadState::Mode::kTurning, "an unknown mode of a tread"); }
  void operator()(OwnMode mode) { fits(mode <= OwnMode::kEffort, "an unknown mode of a wheel"); }

  const std::string& fault() const { return fault_; }

 private:
  void fits(bool does, const char* what) {
    if (!does && fault_.empty()) fault_ = what;
  }
  std::string fault_;
};

bool isRotation(const Eigen::Matrix3d& R) {
  return (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() <= kRotationRounding &&
         R.determinant() > 0.0;
}

std::string faultOf(const ContactMemory& memory, const Eigen::Vector3d& radii, int triangles) {
  if (memory.count < 0 || memory.count > kMaxContactsPerEllipsoid) return "an impossible number of contacts";
  for (int i = 0; i < memory.count; ++i) {
    const CarriedContact& carried = memory.carried[static_cast<std::size_t>(i)];
    if (carried.triangle < 0 || carried.triangle >= triangles) return "a contact with a triangle that is not there";
    if (std::abs(carried.nhat_W.norm() - 1.0) > kRotationRounding) return "a contact without a direction";
  }
  if (memory.fresh) return "";
  if (memory.posed.radii != radii) return "an ellipsoid of another size";
  if (!isRotation(memory.posed.R_WE)) return "an ellipsoid whose axes are no rotation";
  const Eigen::Matrix3d A = PosedEllipsoid(memory.posed.p_WE, memory.posed.R_WE, radii).A;
  if ((A - memory.posed.A).cwiseAbs().maxCoeff() > kRotationRounding * radii.maxCoeff() * radii.maxCoeff())
    return "an ellipsoid of another shape";
  return "";
}

}  // namespace

std::string faultOf(const VehicleState& state, const Simulator& simulator) {
  FieldCheck fields;
  visitFields(state, fields);
  if (!fields.fault().empty()) return fields.fault();
  if (!isSane(state.motion)) return "a motion that no vehicle has";
  if (std::abs(state.motion.X_WB.q.norm() - 1.0) > kRotationRounding) return "an orientation that is no rotation";
  for (std::size_t e = 0; e < state.memory.size(); ++e) {
    const std::string fault =
        faultOf(state.memory[e], simulator.ellipsoids()[e].radii, simulator.terrain().triangleCount());
    if (!fault.empty()) return fault;
  }
  const DriveCommand& command = state.drive.command;
  for (const double bound : {command.steering_angle_velocity, command.acceleration, command.jerk})
    if (bound < 0.0) return "a command with a negative bound";
  return "";
}

}  // namespace ellipsoid_vehicle_sim
