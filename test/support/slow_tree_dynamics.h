#pragma once

#include <Eigen/Dense>
#include <random>
#include <vector>

#include "ellipsoid_vehicle_sim/dynamics/articulated_body.h"

/// An independent, slow answer for the dynamics of a floating tree: Kane's equations with every body's Jacobian written
/// out in plain vectors, and the velocity terms from numerical differentiation. Shares no formula with the
/// articulated-body algorithm but rigid kinematics.
namespace ellipsoid_vehicle_sim::test {

/// State of a tree; coordinates by their index among the dynamic, or among the prescribed, ones.
struct TreeState {
  Eigen::Quaterniond q_WB = Eigen::Quaterniond::Identity();
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();
  Eigen::Vector3d v_WB = Eigen::Vector3d::Zero(), w_WB = Eigen::Vector3d::Zero();
  std::vector<double> q, qd;
  std::vector<PrescribedMotion> prescribed;
};

/// Force on a body at a point, both in W.
struct TreeForce {
  int body = 0;
  Eigen::Vector3d p_W, f_W;
};

/// Pose of a body and its Jacobians for the speeds u = (v_WB, w_WB, one per joint in the order of the bodies).
struct BodyJacobian {
  Eigen::Matrix3d R;
  Eigen::Vector3d p, cm;
  Eigen::MatrixXd point_of_frame, turning, of_cm;
};

class SlowTreeDynamics {
 public:
  explicit SlowTreeDynamics(std::vector<Body> bodies) : bodies_(std::move(bodies)) {}

  int speeds() const { return 5 + static_cast<int>(bodies_.size()); }

  double position(const TreeState& x, std::size_t i) const {
    const Body& b = bodies_[i];
    return b.motion == BodyMotion::kDynamic ? x.q[b.coordinate] : x.prescribed[b.coordinate].position;
  }

  Eigen::VectorXd speedsOf(const TreeState& x) const {
    Eigen::VectorXd u(speeds());
    u << x.v_WB, x.w_WB, Eigen::VectorXd::Zero(speeds() - 6);
    for (std::size_t i = 1; i < bodies_.size(); ++i) {
      const Body& b = bodies_[i];
      u[5 + static_cast<int>(i)] =
          b.motion == BodyMotion::kDynamic ? x.qd[b.coordinate] : x.prescribed[b.coordinate].velocity;
    }
    return u;
  }

  std::vector<BodyJacobian> jacobians(const TreeState& x) const {
    const int n = speeds();
    std::vector<BodyJacobian> all(bodies_.size());
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const Body& b = bodies_[i];
      BodyJacobian& j = all[i];
      if (i == 0) {
        j.R = x.q_WB.toRotationMatrix();
        j.p = x.p_WB;
        j.point_of_frame = Eigen::MatrixXd::Zero(3, n);
        j.turning = j.point_of_frame;
        j.point_of_frame.leftCols(3).setIdentity();
        j.turning.middleCols(3, 3).setIdentity();
      } else {
        const BodyJacobian& parent = all[static_cast<std::size_t>(b.parent)];
        const double s = position(x, i);
        const int column = 5 + static_cast<int>(i);
        const Eigen::Matrix3d R_joint = parent.R * b.X_PB.q.toRotationMatrix();
        const Eigen::Vector3d axis = R_joint * b.axis_B;
        j.p = parent.p + parent.R * b.X_PB.p + (b.prismatic ? Eigen::Vector3d(s * axis) : Eigen::Vector3d::Zero());
        j.R = b.prismatic ? R_joint : Eigen::Matrix3d(R_joint * Eigen::AngleAxisd(s, b.axis_B).toRotationMatrix());
        j.turning = parent.turning;
        j.point_of_frame = parent.point_of_frame + turned(parent.turning, j.p - parent.p);
        if (b.prismatic) {
          j.point_of_frame.col(column) += axis;
        } else {
          j.turning.col(column) += axis;
        }
      }
      j.cm = j.p + j.R * b.inertia.p_Acm;
      j.of_cm = j.point_of_frame + turned(j.turning, j.cm - j.p);
    }
    return all;
  }

  /// Accelerations of all speeds: free ones from the equations, prescribed ones as given. `efforts` receives what the
  /// prescribed joints need (zero elsewhere), by body.
  Eigen::VectorXd accelerations(const TreeState& x, const std::vector<double>& tau,
                                const std::vector<TreeForce>& forces, const Eigen::Vector3d& gravity_W,
                                std::vector<double>& efforts) const {
    const int n = speeds();
    const std::vector<BodyJacobian> all = jacobians(x);
    const Eigen::VectorXd u = speedsOf(x);
    Eigen::MatrixXd M = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd rest = Eigen::VectorXd::Zero(n);  // generalised force less the velocity terms
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const BodyJacobian& j = all[i];
      const double m = bodies_[i].inertia.mass;
      const Eigen::Matrix3d I = j.R * bodies_[i].inertia.I_cm_A * j.R.transpose();
      const Eigen::Vector3d w = j.turning * u;
      Eigen::Vector3d a_cm, alpha;
      accelerationOfMotion(x, u, i, a_cm, alpha);
      M += m * j.of_cm.transpose() * j.of_cm + j.turning.transpose() * I * j.turning;
      rest += j.of_cm.transpose() * (m * (gravity_W - a_cm)) - j.turning.transpose() * (I * alpha + w.cross(I * w));
    }
    for (const TreeForce& force : forces) {
      const BodyJacobian& j = all[static_cast<std::size_t>(force.body)];
      rest += (j.point_of_frame + turned(j.turning, force.p_W - j.p)).transpose() * force.f_W;
    }
    std::vector<int> is_free;
    Eigen::VectorXd known = Eigen::VectorXd::Zero(n);
    for (int i = 0; i < 6; ++i) is_free.push_back(i);
    for (std::size_t i = 1; i < bodies_.size(); ++i) {
      const int column = 5 + static_cast<int>(i);
      if (bodies_[i].motion == BodyMotion::kDynamic) {
        rest[column] += tau[bodies_[i].coordinate];
        is_free.push_back(column);
      } else {
        known[column] = x.prescribed[bodies_[i].coordinate].acceleration;
      }
    }
    const Eigen::VectorXd right = rest - M * known;
    Eigen::MatrixXd A(is_free.size(), is_free.size());
    Eigen::VectorXd b(is_free.size());
    for (std::size_t r = 0; r < is_free.size(); ++r) {
      b[r] = right[is_free[r]];
      for (std::size_t c = 0; c < is_free.size(); ++c) A(r, c) = M(is_free[r], is_free[c]);
    }
    const Eigen::VectorXd solved = A.ldlt().solve(b);
    for (std::size_t r = 0; r < is_free.size(); ++r) known[is_free[r]] = solved[r];
    const Eigen::VectorXd missing = M * known - rest;
    efforts.assign(bodies_.size(), 0.0);
    for (std::size_t i = 1; i < bodies_.size(); ++i)
      if (bodies_[i].motion == BodyMotion::kPrescribed) efforts[i] = missing[5 + static_cast<int>(i)];
    return known;
  }

  Eigen::Vector3d momentum(const TreeState& x) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    const Eigen::VectorXd u = speedsOf(x);
    const std::vector<BodyJacobian> all = jacobians(x);
    for (std::size_t i = 0; i < bodies_.size(); ++i) sum += bodies_[i].inertia.mass * (all[i].of_cm * u);
    return sum;
  }

  /// About W's origin.
  Eigen::Vector3d angularMomentum(const TreeState& x) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    const Eigen::VectorXd u = speedsOf(x);
    const std::vector<BodyJacobian> all = jacobians(x);
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const RigidInertia& inertia = bodies_[i].inertia;
      sum += inertia.mass * all[i].cm.cross(Eigen::Vector3d(all[i].of_cm * u)) +
             all[i].R * (inertia.I_cm_A * (all[i].R.transpose() * (all[i].turning * u)));
    }
    return sum;
  }

  double kineticEnergy(const TreeState& x) const {
    double twice = 0.0;
    const Eigen::VectorXd u = speedsOf(x);
    const std::vector<BodyJacobian> all = jacobians(x);
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const RigidInertia& inertia = bodies_[i].inertia;
      const Eigen::Vector3d w = all[i].R.transpose() * (all[i].turning * u);
      twice += inertia.mass * (all[i].of_cm * u).squaredNorm() + w.dot(inertia.I_cm_A * w);
    }
    return 0.5 * twice;
  }

  static Eigen::MatrixXd turned(const Eigen::MatrixXd& turning, const Eigen::Vector3d& arm) {
    Eigen::MatrixXd result(3, turning.cols());
    for (int c = 0; c < turning.cols(); ++c) result.col(c) = Eigen::Vector3d(turning.col(c)).cross(arm);
    return result;
  }

 private:
  TreeState moved(const TreeState& x, const Eigen::VectorXd& u, double t) const {
    TreeState y = x;
    y.p_WB += t * x.v_WB;
    y.q_WB = quaternionFromRotationVector(t * x.w_WB) * x.q_WB;
    for (std::size_t i = 1; i < bodies_.size(); ++i) {
      const Body& b = bodies_[i];
      double& s = b.motion == BodyMotion::kDynamic ? y.q[b.coordinate] : y.prescribed[b.coordinate].position;
      s += t * u[5 + static_cast<int>(i)];
    }
    return y;
  }

  // Acceleration at constant speeds: fourth-order central difference of J u; with a step of 1e-3 s and speeds of order
  // one its error (1e-12 from the formula, 1e-12 from rounding) is far below the 1e-9 it is used for.
  void accelerationOfMotion(const TreeState& x, const Eigen::VectorXd& u, std::size_t body, Eigen::Vector3d& a_cm,
                            Eigen::Vector3d& alpha) const {
    constexpr double kStep = 1e-3;
    a_cm.setZero();
    alpha.setZero();
    const double weight[] = {1.0 / 12.0, -8.0 / 12.0, 8.0 / 12.0, -1.0 / 12.0};
    const double at[] = {-2.0, -1.0, 1.0, 2.0};
    for (int k = 0; k < 4; ++k) {
      const BodyJacobian j = jacobians(moved(x, u, at[k] * kStep))[body];
      a_cm += weight[k] / kStep * (j.of_cm * u);
      alpha += weight[k] / kStep * (j.turning * u);
    }
  }

  std::vector<Body> bodies_;
};

/// Random trees: every mixture of revolute, prismatic, dynamic and prescribed joints; some leaves are wheels.
class RandomTrees {
 public:
  explicit RandomTrees(unsigned seed) : random_(seed) {}

  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  int index(int count) { return std::uniform_int_distribution<int>(0, count - 1)(random_); }
  Eigen::Vector3d vector(double size) { return {uniform(-size, size), uniform(-size, size), uniform(-size, size)}; }
  Eigen::Quaterniond rotation() { return quaternionFromRotationVector(vector(3.0)); }

  /// Inertia of a box of even density in a random attitude: always one a body can have.
  RigidInertia inertia() {
    RigidInertia result;
    result.mass = std::exp(uniform(-2.0, 2.0));
    const Eigen::Vector3d half(uniform(0.1, 0.5), uniform(0.1, 0.5), uniform(0.1, 0.5));
    const Eigen::Matrix3d R = rotation().toRotationMatrix();
    result.I_cm_A = R * solidEllipsoidInertia(result.mass, half) * R.transpose();
    result.p_Acm = vector(0.3);
    return result;
  }

  std::vector<Body> tree(int count, bool prescribed, bool wheels) {
    std::vector<Body> bodies(static_cast<std::size_t>(count));
    bodies[0].inertia = inertia();
    bodies[0].inertia.p_Acm.setZero();
    int dynamic = 0, given = 0;
    for (int i = 1; i < count; ++i) {
      Body& body = bodies[static_cast<std::size_t>(i)];
      body.parent = index(i);
      body.X_PB = {vector(0.8), index(3) == 0 ? Eigen::Quaterniond::Identity() : rotation()};
      body.axis_B = vector(1.0).normalized();
      body.prismatic = index(3) == 0;
      body.inertia = inertia();
      const bool is_given = prescribed && index(3) == 0;
      body.motion = is_given ? BodyMotion::kPrescribed : BodyMotion::kDynamic;
      body.coordinate = is_given ? given++ : dynamic++;
    }
    if (!wheels) return bodies;
    for (int i = 1; i < count; ++i) {
      Body& body = bodies[static_cast<std::size_t>(i)];
      bool leaf = !body.prismatic && body.motion == BodyMotion::kDynamic;
      for (const Body& other : bodies) leaf = leaf && other.parent != i;
      if (!leaf) continue;
      // A wheel about its axle, its angle not worked out; balanced exactly, or a coaxial one beside its bearing.
      const Eigen::Vector3d& k = body.axis_B;
      body.inertia.I_cm_A = 0.3 * Eigen::Matrix3d::Identity() + 0.2 * k * k.transpose();
      body.inertia.p_Acm = index(2) == 0 ? Eigen::Vector3d::Zero().eval() : Eigen::Vector3d(0.2 * k);
      body.spin_symmetric = true;
    }
    return bodies;
  }

  TreeState state(const std::vector<Body>& bodies) {
    TreeState x;
    x.q_WB = rotation();
    x.p_WB = vector(5.0);
    x.v_WB = vector(3.0);
    x.w_WB = vector(2.0);
    for (std::size_t i = 1; i < bodies.size(); ++i) {
      if (bodies[i].motion == BodyMotion::kDynamic) {
        x.q.push_back(uniform(-1.0, 1.0));
        x.qd.push_back(uniform(-2.0, 2.0));
      } else {
        x.prescribed.push_back({uniform(-1.0, 1.0), uniform(-2.0, 2.0), uniform(-3.0, 3.0)});
      }
    }
    return x;
  }

 private:
  std::mt19937_64 random_;
};

}  // namespace ellipsoid_vehicle_sim::test
