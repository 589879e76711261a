#include "corners.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

// Directions that differ by less are the same [-].
constexpr double kSameDirection = 1e-6;

class Maker {
 public:
  explicit Maker(const DriveScene& scene) : scene_(scene), model_(scene.model), X_WB_(scene.bodyPoses()) {}

  Loaded<CornerVehicle> run() {
    used_.assign(model_.bodies.size(), false);
    used_[0] = true;
    for (const WheelUnit& unit : model_.drive.wheels) addCorner(unit);
    for (std::size_t i = 0; i < used_.size(); ++i)
      if (!used_[i]) cannot(jointOf(model_.bodies[i]), "is no part of a wheel's suspension, steering or axle");
    if (!result_.problems.empty()) return result_;
    addChassis();
    for (std::size_t e = 0; e < model_.ellipsoids.size(); ++e) addEllipsoid(static_cast<int>(e));
    if (!result_.problems.empty()) return result_;
    result_.value = std::move(vehicle_);
    return result_;
  }

 private:
  void cannot(const std::string& joint, const std::string& why) {
    result_.problems.push_back({"hinge-2 joints: joint '" + joint + "'", why});
  }

  std::string jointOf(const Body& body) const {
    const auto i = static_cast<std::size_t>(body.coordinate);
    const int description = body.motion == BodyMotion::kDynamic ? model_.dynamic_joints[i].description
                                                                : model_.prescribed_joints[i].description;
    return model_.description.joints[static_cast<std::size_t>(description)].name;
  }

  // The suspension's or the steering's axis; all of a corner run the same way.
  bool takeAxis(const Vector3d& axis_W, bool& known, Corner& corner, double& sign) {
    if (!known) corner.up_W = axis_W;
    known = true;
    sign = axis_W.dot(corner.up_W) > 0.0 ? 1.0 : -1.0;
    return axis_W.cross(corner.up_W).norm() < kSameDirection;
  }

  void addCorner(const WheelUnit& unit) {
    Corner corner;
    corner.wheel = unit.unit;
    corner.body = model_.dynamic_joints[static_cast<std::size_t>(unit.joint)].body;
    const auto wheel = static_cast<std::size_t>(corner.body);
    const Body& body = model_.bodies[wheel];
    if (!body.spin_symmetric) return cannot(jointOf(body), "turns a wheel that is not round about it");
    used_[wheel] = true;
    const Vector3d axle_W = X_WB_[wheel].q * body.axis_B;
    corner.mass = body.inertia.mass;
    corner.spin = body.axis_B.dot(body.inertia.I_cm_A * body.axis_B);
    corner.across = 0.5 * (body.inertia.I_cm_A.trace() - corner.spin);
    corner.X_WC.p = X_WB_[wheel] * body.inertia.p_Acm;
    corner.anchor_W = corner.X_WC.p;

    bool has_axis = false, has_suspension = false;
    Vector3d steered_at_W = Vector3d::Zero();
    for (auto i = static_cast<std::size_t>(body.parent); i != 0; i = static_cast<std::size_t>(model_.bodies[i].parent)) {
      const Body& link = model_.bodies[i];
      const std::string name = jointOf(link);
      used_[i] = true;
      double sign = 1.0;
      if (!takeAxis(X_WB_[i].q * link.axis_B, has_axis, corner, sign))
        return cannot(name, "has an axis of its own: suspension and steering share one");
      if (link.motion == BodyMotion::kPrescribed && !link.prismatic && corner.steer < 0) {
        corner.steer = link.coordinate;
        corner.steer_sign = sign;
        steered_at_W = X_WB_[i].p;
      } else if (link.motion == BodyMotion::kDynamic && link.prismatic && !has_suspension) {
        has_suspension = true;
        takeSuspension(static_cast<std::size_t>(link.coordinate), sign, name, corner);
      } else {
        return cannot(name, "is neither the one suspension nor the one steering of its wheel");
      }
      corner.mass += link.inertia.mass;
      corner.across += 0.5 * (link.inertia.I_cm_A.trace() - axialInertia(link, X_WB_[i], axle_W));
    }
    if (!has_axis) corner.up_W = axle_W.unitOrthogonal();
    if (std::abs(corner.up_W.dot(axle_W)) > kSameDirection)
      return cannot(jointOf(body), "is not square to the axis of suspension and steering");
    corner.X_WC.q.setFromTwoVectors(Vector3d::UnitY(), axle_W);
    if (corner.steer >= 0) takeKingpin(steered_at_W, axle_W, jointOf(body), corner);

    const Motion& x = scene_.start;
    const Vector3d arm = corner.X_WC.p - x.X_WB.p;
    corner.v_WC = x.v_WB + x.w_WB.cross(arm);
    corner.w_WC = x.w_WB + x.qd[static_cast<std::size_t>(unit.joint)] * axle_W;
    vehicle_.corners.push_back(corner);
  }

  static double axialInertia(const Body& link, const Pose& X_WL, const Vector3d& axle_W) {
    const Vector3d axle_L = X_WL.q.conjugate() * axle_W;
    return axle_L.dot(link.inertia.I_cm_A * axle_L);
  }

  void takeSuspension(std::size_t coordinate, double sign, const std::string& name, Corner& corner) {
    const DynamicJoint& joint = model_.dynamic_joints[coordinate];
    if (joint.friction > 0.0) cannot(name, "has dry friction");
    if (!(joint.stiffness > 0.0)) cannot(name, "has no spring");
    corner.stiffness = joint.stiffness;
    corner.damping = joint.damping;
    corner.pressed = sign * (scene_.start.q[coordinate] - joint.reference);
  }

  // The steering axis has to meet the axle: a hinge-2 has no trail.
  void takeKingpin(const Vector3d& p_WS, const Vector3d& axle_W, const std::string& name, Corner& corner) {
    const Vector3d gap = p_WS - corner.X_WC.p;
    const Vector3d square = gap - corner.up_W.dot(gap) * corner.up_W;
    corner.anchor_W = corner.X_WC.p + axle_W.dot(square) * axle_W;
    if ((square - axle_W.dot(square) * axle_W).norm() > 1e-6) cannot(name, "does not meet the steering axis: it has trail");
  }

  void addChassis() {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(model_.bodies[0].inertia.I_cm_A);
    Eigen::Matrix3d R = principal.eigenvectors();
    if (R.determinant() < 0.0) R.col(0) *= -1.0;
    vehicle_.X_BP.q = Eigen::Quaterniond(R).normalized();
    vehicle_.inertia = principal.eigenvalues();
    vehicle_.mass = model_.bodies[0].inertia.mass;
  }

  void addEllipsoid(int index) {
    const ModelEllipsoid& e = model_.ellipsoids[static_cast<std::size_t>(index)];
    CornerEllipsoid placed{index, -1, vehicle_.X_BP.inverse() * e.X_BE};
    if (e.body != 0) {
      for (std::size_t c = 0; c < vehicle_.corners.size(); ++c)
        if (vehicle_.corners[c].body == e.body) placed.corner = static_cast<int>(c);
      if (placed.corner < 0)
        return cannot(jointOf(model_.bodies[static_cast<std::size_t>(e.body)]), "moves '" + e.name + "', which touches the ground");
      const Pose X_WE = X_WB_[static_cast<std::size_t>(e.body)] * e.X_BE;
      placed.X = vehicle_.corners[static_cast<std::size_t>(placed.corner)].X_WC.inverse() * X_WE;
    }
    vehicle_.ellipsoids.push_back(placed);
  }

  const DriveScene& scene_;
  const VehicleModel& model_;
  std::vector<Pose> X_WB_;
  std::vector<bool> used_;
  CornerVehicle vehicle_;
  Loaded<CornerVehicle> result_;
};

}  // namespace

Loaded<CornerVehicle> makeCornerVehicle(const DriveScene& scene) { return Maker(scene).run(); }

double steeredAngle(const Vector3d& up, const Vector3d& straight, const Vector3d& axle) {
  return std::atan2(up.dot(straight.cross(axle)), straight.dot(axle));
}

}  // namespace ellipsoid_vehicle_sim
