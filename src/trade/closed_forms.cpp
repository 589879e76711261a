#include "ellipsoid_vehicle_sim/trade/closed_forms.h"

#include <algorithm>
#include <cmath>

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

/// Undamped spring under a falling body: the state is advanced from event to event.
class Bounce : public ClosedFormCheck {
 public:
  Bounce(const Scene& scene, const Simulator& simulator) : horizon_(scene.horizon) {
    const ModelEllipsoid& e = simulator.model().ellipsoids.front();
    const Vector3d p = simulator.rootPose().p;
    const auto ground = simulator.terrain().heights(p.x(), p.y());
    usable_ = !ground.empty() && simulator.model().ellipsoids.size() == 1 && e.law.damping == 0.0;
    if (!usable_) return;
    g_ = simulator.config().gravity;
    omega_ = std::sqrt(e.law.stiffness / simulator.model().mass);
    // Height of the root over where the lowest point touches. A sphere, or an ellipsoid that falls flat and does not
    // turn.
    touching_ = ground.front().z + p.z() - lowest(simulator, e);
    height_ = p.z() - touching_;
    speed_ = simulator.rootVelocity_W().z();
  }

  void watch(const Simulator& simulator, double time) override {
    if (!usable_ || time > horizon_ * (1.0 + 1e-9)) return;
    advance(time - time_);
    time_ = time;
    error_ = std::max(error_, std::abs(simulator.rootPose().p.z() - touching_ - height_));
  }

  std::optional<double> error() const override { return usable_ ? std::optional<double>(error_) : std::nullopt; }

 private:
  static double lowest(const Simulator& simulator, const ModelEllipsoid& e) {
    const Pose X_WE = simulator.state().motion.X_WB * e.X_BE;
    const Vector3d n_E = X_WE.q.conjugate() * Vector3d::UnitZ();
    return X_WE.p.z() - e.radii.cwiseProduct(n_E).norm();
  }

  void advance(double left) {
    while (left > 0.0) {
      if (height_ > 0.0 || (height_ == 0.0 && speed_ > 0.0)) {
        const double to_ground = (speed_ + std::sqrt(speed_ * speed_ + 2.0 * g_ * height_)) / g_;
        const double t = std::min(left, to_ground);
        height_ += speed_ * t - 0.5 * g_ * t * t;
        speed_ -= g_ * t;
        if (t == to_ground) {
          height_ = 0.0;
          in_contact_ = 0.0;
          touch_speed_ = -speed_;
        }
        left -= t;
        if (t == to_ground) contact(left);
      } else {
        contact(left);
      }
    }
  }

  /// y = g / w^2 (1 - cos w t) + v / w sin w t, until y = 0 again at w t = 2 (pi - atan(v w / g)).
  void contact(double& left) {
    const double whole = 2.0 * (M_PI - std::atan(touch_speed_ * omega_ / g_)) / omega_;
    const double t = std::min(left, whole - in_contact_);
    in_contact_ += t;
    left -= t;
    const double phase = omega_ * in_contact_, sag = g_ / (omega_ * omega_);
    height_ = -(sag * (1.0 - std::cos(phase)) + touch_speed_ / omega_ * std::sin(phase));
    speed_ = -(sag * omega_ * std::sin(phase) + touch_speed_ * std::cos(phase));
    if (in_contact_ < whole) return;
    height_ = 0.0;
    speed_ = touch_speed_;
  }

  double horizon_, g_ = 0.0, omega_ = 1.0, touching_ = 0.0, height_ = 0.0, speed_ = 0.0, time_ = 0.0;
  double in_contact_ = 0.0, touch_speed_ = 0.0, error_ = 0.0;
  bool usable_ = false;
};

class TorqueFree : public ClosedFormCheck {
 public:
  TorqueFree(const Scene& scene, const Simulator& simulator) : horizon_(scene.horizon) {
    const VehicleModel& model = simulator.model();
    usable_ = model.bodies.size() == 1 && model.description.links.size() == 1 && !model.ellipsoids.empty();
    if (!usable_) return;
    const Motion& x = simulator.state().motion;
    I_ = model.description.links.front().I_cm_L;
    I_inverse_ = I_.inverse();
    p_ = x.X_WB.p;
    v_ = x.v_WB;
    q_ = x.X_WB.q;
    L_ = q_ * (I_ * (q_.conjugate() * x.w_WB));
    g_ = simulator.config().gravity;
    reach_ = model.ellipsoids.front().radii.maxCoeff();
  }

  void watch(const Simulator& simulator, double time) override {
    if (!usable_ || time > horizon_ * (1.0 + 1e-9)) return;
    turn(time - time_);
    time_ = time;
    const Motion& x = simulator.state().motion;
    const Vector3d p = p_ + time * v_ - 0.5 * g_ * time * time * Vector3d::UnitZ();
    const double angle = 2.0 * std::asin(std::min(1.0, (x.X_WB.q * q_.conjugate()).vec().norm()));
    error_ = std::max(error_, (x.X_WB.p - p).norm() + reach_ * angle);
  }

  std::optional<double> error() const override { return usable_ ? std::optional<double>(error_) : std::nullopt; }

 private:
  using Vector4d = Eigen::Vector4d;

  /// q' = w q / 2 with w from the angular momentum, which does not change; classical Runge-Kutta in steps that leave no
  /// more than rounding.
  void turn(double duration) {
    constexpr double kStep = 5e-5;
    const int steps = std::max(1, static_cast<int>(std::ceil(duration / kStep - 1e-9)));
    const double h = duration / steps;
    Vector4d q = q_.coeffs();
    for (int i = 0; i < steps; ++i) {
      const Vector4d k1 = rate(q), k2 = rate(q + 0.5 * h * k1), k3 = rate(q + 0.5 * h * k2), k4 = rate(q + h * k3);
      q = (q + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)).normalized();
    }
    q_.coeffs() = q;
  }

  Vector4d rate(const Vector4d& coefficients) const {
    const Quaterniond q(coefficients);
    const Quaterniond unit = q.normalized();
    const Vector3d w = unit * (I_inverse_ * (unit.conjugate() * L_));
    return 0.5 * (Quaterniond(0.0, w.x(), w.y(), w.z()) * q).coeffs();
  }

  double horizon_;
  Eigen::Matrix3d I_, I_inverse_;
  Vector3d p_, v_, L_;
  Quaterniond q_;
  double g_ = 0.0, reach_ = 0.0, time_ = 0.0, error_ = 0.0;
  bool usable_ = false;
};

class RollDown : public ClosedFormCheck {
 public:
  RollDown(const Scene& scene, const Simulator& simulator) : horizon_(scene.horizon) {
    const VehicleModel& model = simulator.model();
    const Vector3d p = simulator.rootPose().p;
    const auto ground = simulator.terrain().heights(p.x(), p.y());
    usable_ = !ground.empty() && model.ellipsoids.size() == 1 && model.bodies.size() == 1;
    if (!usable_) return;
    const Vector3d n = simulator.terrain().triangle(ground.front().triangle).nhat_W;
    const Vector3d down = -Vector3d::UnitZ() + n.z() * n;
    usable_ = down.norm() > 1e-9;
    if (!usable_) return;
    along_ = down.normalized();
    // Rolls about the level axis across the slope.
    const Vector3d axis_B = simulator.state().motion.X_WB.q.conjugate() * n.cross(along_);
    const double I = axis_B.dot(model.description.links.front().I_cm_L * axis_B);
    const ModelEllipsoid& e = model.ellipsoids.front();
    const double R = e.radii.cwiseProduct((simulator.state().motion.X_WB * e.X_BE).q.conjugate() * n).norm();
    a_ = simulator.config().gravity * down.norm() / (1.0 + I / (model.mass * R * R));
  }

  void watch(const Simulator& simulator, double time) override {
    if (!usable_ || time > horizon_ * (1.0 + 1e-9) || time < 0.5 * horizon_) return;
    const double s = along_.dot(simulator.rootPose().p);
    if (!begun_) {
      begun_ = true;
      time_ = time;
      s_ = s;
      v_ = along_.dot(simulator.rootVelocity_W());
    }
    const double t = time - time_;
    error_ = std::max(error_, std::abs(s - (s_ + v_ * t + 0.5 * a_ * t * t)));
  }

  std::optional<double> error() const override { return begun_ ? std::optional<double>(error_) : std::nullopt; }

 private:
  double horizon_, a_ = 0.0, time_ = 0.0, s_ = 0.0, v_ = 0.0, error_ = 0.0;
  Vector3d along_ = Vector3d::UnitX();
  bool usable_ = false, begun_ = false;
};

class Slide : public ClosedFormCheck {
 public:
  Slide(const Scene& scene, const Simulator& simulator) : horizon_(scene.horizon) {
    const Vector3d p = simulator.rootPose().p;
    const auto ground = simulator.terrain().heights(p.x(), p.y());
    start_ = p.head<2>();
    v_ = simulator.rootVelocity_W().head<2>();
    usable_ = !ground.empty();
    if (!usable_) return;
    const Surface& surface = simulator.terrain().surface(ground.front().triangle);
    const double mu = surface.mu_kinetic.value_or(surface.mu_static.value_or(simulator.config().mu_kinetic));
    a_ = mu * simulator.config().gravity;
  }

  void watch(const Simulator& simulator, double time) override {
    if (!usable_ || time > horizon_ * (1.0 + 1e-9)) return;
    const double speed = v_.norm();
    const double t = a_ > 0.0 ? std::min(time, speed / a_) : time;
    const double way = speed * t - 0.5 * a_ * t * t;
    const Eigen::Vector2d expected = start_ + (speed > 0.0 ? Eigen::Vector2d(way / speed * v_) : Eigen::Vector2d(0, 0));
    error_ = std::max(error_, (simulator.rootPose().p.head<2>() - expected).norm());
  }

  std::optional<double> error() const override { return usable_ ? std::optional<double>(error_) : std::nullopt; }

 private:
  double horizon_, a_ = 0.0, error_ = 0.0;
  Eigen::Vector2d start_, v_;
  bool usable_ = false;
};

class Circle : public ClosedFormCheck {
 public:
  Circle(const Scene& scene, const Simulator& simulator) : horizon_(scene.horizon) {
    const DriveModel& drive = simulator.model().drive;
    if (scene.commands.empty() || drive.layout != DriveLayout::kAckermann) return;
    const DriveCommand& command = scene.commands.back().command;
    if (command.kind != DriveCommand::Kind::kAckermann || command.steering_angle == 0.0) return;
    radius_ = std::hypot(drive.wheelbase / std::tan(std::abs(command.steering_angle)), drive.reference_x);
  }

  void watch(const Simulator& simulator, double time) override {
    if (time > horizon_ * (1.0 + 1e-9) || time < 0.5 * horizon_) return;
    const double turning = std::abs(simulator.rootAngularVelocity_W().z());
    if (turning < 1e-6) return;
    sum_ += simulator.rootVelocity_W().head<2>().norm() / turning;
    ++count_;
  }

  std::optional<double> error() const override {
    if (!(radius_ > 0.0) || count_ == 0) return std::nullopt;
    return std::abs(sum_ / count_ - radius_);
  }

 private:
  double horizon_, radius_ = 0.0, sum_ = 0.0;
  std::int64_t count_ = 0;
};

class Stop : public ClosedFormCheck {
 public:
  Stop(const Scene& scene, const Simulator& simulator) {
    if (scene.commands.empty()) return;
    begin_ = scene.commands.back().time;
    const Vector3d p = simulator.rootPose().p;
    const auto ground = simulator.terrain().heights(p.x(), p.y());
    if (ground.empty()) return;
    const Surface& surface = simulator.terrain().surface(ground.front().triangle);
    const SimConfig& config = simulator.config();
    const double mu = surface.mu_kinetic.value_or(surface.mu_static.value_or(config.mu_kinetic));
    a_ = std::min(config.max_deceleration, mu * config.gravity);
  }

  void watch(const Simulator& simulator, double time) override {
    if (!(a_ > 0.0) || time < begin_) return;
    if (!begun_) {
      begun_ = true;
      from_ = simulator.rootPose().p;
      speed_ = simulator.rootVelocity_W().norm();
    }
    way_ = (simulator.rootPose().p - from_).norm();
  }

  std::optional<double> error() const override {
    return begun_ ? std::optional<double>(std::abs(way_ - speed_ * speed_ / (2.0 * a_))) : std::nullopt;
  }

 private:
  double begin_ = 0.0, a_ = 0.0, speed_ = 0.0, way_ = 0.0;
  Vector3d from_ = Vector3d::Zero();
  bool begun_ = false;
};

class Rest : public ClosedFormCheck {
 public:
  explicit Rest(const Simulator& simulator) : start_(simulator.rootPose().p) {}
  void watch(const Simulator& simulator, double) override {
    error_ = std::max(error_, (simulator.rootPose().p - start_).norm());
  }
  std::optional<double> error() const override { return error_; }

 private:
  Vector3d start_;
  double error_ = 0.0;
};

}  // namespace

std::unique_ptr<ClosedFormCheck> makeClosedFormCheck(const LoadedScene& loaded, const Simulator& simulator) {
  const Scene& scene = loaded.scene;
  switch (scene.measures.closed_form) {
    case ClosedForm::kNone:
      return nullptr;
    case ClosedForm::kBounce:
      return std::make_unique<Bounce>(scene, simulator);
    case ClosedForm::kTorqueFree:
      return std::make_unique<TorqueFree>(scene, simulator);
    case ClosedForm::kRollDown:
      return std::make_unique<RollDown>(scene, simulator);
    case ClosedForm::kSlide:
      return std::make_unique<Slide>(scene, simulator);
    case ClosedForm::kCircle:
      return std::make_unique<Circle>(scene, simulator);
    case ClosedForm::kStop:
      return std::make_unique<Stop>(scene, simulator);
    case ClosedForm::kRest:
      return std::make_unique<Rest>(simulator);
  }
  return nullptr;
}

}  // namespace ellipsoid_vehicle_sim
