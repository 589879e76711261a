// Forward dynamics against Kane's equations written out body by body (support/slow_tree_dynamics.h), and against what
// free flight must conserve.
#include "ellipsoid_vehicle_sim/dynamics/articulated_body.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "ellipsoid_vehicle_sim/dynamics/integrator.h"
#include "support/slow_tree_dynamics.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Vector3d;

// Relative to the largest acceleration of the case; the reference's own differences are good to about 1e-11.
constexpr double kTolerance = 1e-9;

/// Joint memory of the right sizes even where there is none, so that data() is never asked of an empty vector.
std::vector<PrescribedMotion> padded(const TreeState& x) {
  std::vector<PrescribedMotion> result = x.prescribed;
  result.resize(x.prescribed.size() + 1);
  return result;
}

struct Answer {
  Eigen::VectorXd acceleration;  // a_WB, alpha_WB, one per joint in the order of the bodies
  std::vector<double> effort;
};

Answer fast(const std::vector<Body>& bodies, const TreeState& x, const std::vector<double>& tau,
            const std::vector<TreeForce>& forces, const Vector3d& gravity_W) {
  ArticulatedBody tree(bodies);
  const std::vector<PrescribedMotion> prescribed = padded(x);
  std::vector<double> qdd(bodies.size(), 0.0);
  // The tree's frame has the base's axes.
  const auto inBase = [&](const Vector3d& v_W) { return Vec3::from(x.q_WB.conjugate() * v_W); };
  tree.positions(x.q.data(), prescribed.data());
  tree.velocities(inBase(x.w_WB), x.qd.data(), prescribed.data());
  tree.clearForces();
  for (const TreeForce& force : forces) tree.addForce(force.body, inBase(force.p_W - x.p_WB), inBase(force.f_W));
  const Spatial base = tree.accelerations(tau.data(), prescribed.data(), inBase(gravity_W), qdd.data());
  Answer answer;
  answer.acceleration.resize(5 + static_cast<int>(bodies.size()));
  answer.acceleration.head<3>() = x.q_WB * base.linear.toEigen();
  answer.acceleration.segment<3>(3) = x.q_WB * base.angular.toEigen();
  answer.effort.assign(bodies.size(), 0.0);
  for (std::size_t i = 1; i < bodies.size(); ++i) {
    const bool dynamic = bodies[i].motion == BodyMotion::kDynamic;
    answer.acceleration[5 + static_cast<int>(i)] =
        dynamic ? qdd[bodies[i].coordinate] : prescribed[bodies[i].coordinate].acceleration;
    if (!dynamic) answer.effort[i] = tree.prescribedEffort(static_cast<int>(i));
  }
  return answer;
}

void expectAgreement(unsigned seed, int most_bodies, bool prescribed, bool wheels) {
  RandomTrees random(seed);
  for (int trial = 0; trial < 60; ++trial) {
    const std::vector<Body> bodies = random.tree(1 + random.index(most_bodies), prescribed, wheels);
    const TreeState x = random.state(bodies);
    const SlowTreeDynamics slow(bodies);
    std::vector<double> tau(bodies.size(), 0.0), efforts;
    for (double& t : tau) t = random.uniform(-5.0, 5.0);
    std::vector<TreeForce> forces;
    for (int i = 0; i < 4; ++i)
      forces.push_back(
          {random.index(static_cast<int>(bodies.size())), x.p_WB + random.vector(1.0), random.vector(20.0)});
    const Vector3d gravity_W = random.vector(10.0);

    const Eigen::VectorXd expected = slow.accelerations(x, tau, forces, gravity_W, efforts);
    const Answer answer = fast(bodies, x, tau, forces, gravity_W);
    const double scale = 1.0 + expected.cwiseAbs().maxCoeff();
    ASSERT_LT((answer.acceleration - expected).cwiseAbs().maxCoeff(), kTolerance * scale)
        << "trial " << trial << ", " << bodies.size() << " bodies";
    for (std::size_t i = 1; i < bodies.size(); ++i)
      ASSERT_NEAR(answer.effort[i], efforts[i], kTolerance * scale * 10.0) << "trial " << trial << ", body " << i;
  }
}

TEST(ArticulatedBody, AgreesWithKanesEquationsForOneRigidBody) { expectAgreement(1, 1, false, false); }
TEST(ArticulatedBody, AgreesWithKanesEquationsOnTreesOfFreeJoints) { expectAgreement(2, 9, false, false); }
TEST(ArticulatedBody, AgreesWithKanesEquationsWithPrescribedJoints) { expectAgreement(3, 9, true, false); }
TEST(ArticulatedBody, AgreesWithKanesEquationsForWheelsWhoseAngleIsNotWorkedOut) { expectAgreement(4, 9, true, true); }

TEST(ArticulatedBody, KineticEnergyAndMassMomentAreThoseOfTheBodies) {
  RandomTrees random(5);
  for (int trial = 0; trial < 50; ++trial) {
    const std::vector<Body> bodies = random.tree(7, true, true);
    const TreeState x = random.state(bodies);
    const SlowTreeDynamics slow(bodies);
    ArticulatedBody tree(bodies);
    const auto inBase = [&](const Vector3d& v_W) { return Vec3::from(x.q_WB.conjugate() * v_W); };
    tree.positions(x.q.data(), padded(x).data());
    tree.velocities(inBase(x.w_WB), x.qd.data(), padded(x).data());
    const double energy = slow.kineticEnergy(x);
    EXPECT_NEAR(tree.kineticEnergy(inBase(x.v_WB)), energy, 1e-12 * energy);
    Vector3d moment = Vector3d::Zero();
    const auto jacobians = slow.jacobians(x);
    for (std::size_t i = 0; i < bodies.size(); ++i) moment += bodies[i].inertia.mass * (jacobians[i].cm - x.p_WB);
    EXPECT_LT((x.q_WB * tree.massMoment().toEigen() - moment).norm(), 1e-12 * (1.0 + moment.norm()));
  }
}

TEST(ArticulatedBody, ArticulatedInertiaIsTheRatioOfEffortToAcceleration) {
  // With the rest of the tree held by its own inertia only: D is what the last joint feels when its parent cannot move,
  // which a very heavy base provides.
  RandomTrees random(6);
  std::vector<Body> bodies = random.tree(2, false, false);
  bodies[0].inertia.mass = 1e12;
  bodies[0].inertia.I_cm_A = 1e12 * Eigen::Matrix3d::Identity();
  TreeState x = random.state(bodies);
  x.w_WB.setZero();
  x.qd[0] = 0.0;
  ArticulatedBody tree(bodies);
  const std::vector<PrescribedMotion> prescribed = padded(x);
  double qdd = 0.0;
  const double tau = 2.0;
  const Vec3 zero{0.0, 0.0, 0.0};
  tree.positions(x.q.data(), prescribed.data());
  tree.velocities(zero, x.qd.data(), prescribed.data());
  tree.clearForces();
  tree.accelerations(&tau, prescribed.data(), zero, &qdd);
  EXPECT_NEAR(tree.articulatedInertia(1), tau / qdd, 1e-9 * tau / qdd);
}

// With qdd = A tau + b of the free tree, A the inverse of the mass that the coordinates feel, coupled coordinates q = G p obey
// G^T A^-1 (G p'' - b) = G^T tau: no effort of the coupling in it.
TEST(ArticulatedBody, CoupledCoordinatesMoveAsTheReducedEquationsSay) {
  RandomTrees random(11);
  for (int trial = 0; trial < 20; ++trial) {
    const std::vector<Body> bodies = random.tree(4, false, false);
    const TreeState x = random.state(bodies);
    const std::vector<PrescribedMotion> prescribed = padded(x);
    const Eigen::Index n = static_cast<Eigen::Index>(x.q.size());
    if (n < 3) continue;
    ArticulatedBody free(bodies), coupled(bodies, {{2, 0, -0.7, 0.1}});
    const Vec3 w = Vec3::from(x.q_WB.conjugate() * x.w_WB), g{0.0, 0.0, -9.8};
    const auto accelerations = [&](ArticulatedBody& tree, const Eigen::VectorXd& tau) {
      Eigen::VectorXd qdd = Eigen::VectorXd::Zero(n);
      tree.positions(x.q.data(), prescribed.data());
      tree.velocities(w, x.qd.data(), prescribed.data());
      tree.clearForces();
      tree.accelerations(tau.data(), prescribed.data(), g, qdd.data());
      return qdd;
    };
    const Eigen::VectorXd b = accelerations(free, Eigen::VectorXd::Zero(n));
    Eigen::MatrixXd A(n, n), G = Eigen::MatrixXd::Zero(n, n - 1);
    for (Eigen::Index i = 0; i < n; ++i) A.col(i) = accelerations(free, Eigen::VectorXd::Unit(n, i)) - b;
    for (Eigen::Index i = 0, p = 0; i < n; ++i)
      if (i != 2) G(i, p++) = 1.0;
    G(2, 0) = -0.7;
    const Eigen::VectorXd tau = Eigen::VectorXd::LinSpaced(n, -1.0, 2.0);
    const Eigen::MatrixXd M = A.inverse();
    const Eigen::VectorXd p = (G.transpose() * M * G).ldlt().solve(G.transpose() * (tau + M * b));
    const Eigen::VectorXd found = accelerations(coupled, tau);
    EXPECT_LT((found - G * p).norm(), 1e-7 * (1.0 + (G * p).norm())) << trial;
    EXPECT_NEAR(found[2], -0.7 * found[0], 1e-10 * (1.0 + found.norm()));
  }
}

/// Free flight of a tree as a System of the integrators.
class FreeFlight {
 public:
  using State = TreeState;
  struct Rate {
    Vector3d v, w, a, alpha;
    std::vector<double> q, qd;
  };

  explicit FreeFlight(const std::vector<Body>& bodies) : tree_(bodies), tau_(bodies.size(), 0.0) {}

  void rate(const State& x, double, Rate& k) {
    tree_.positions(x.q.data(), nullptr);
    tree_.velocities(Vec3::from(x.q_WB.conjugate() * x.w_WB), x.qd.data(), nullptr);
    tree_.clearForces();
    k.q = x.qd;
    k.qd.resize(x.qd.size());
    const Spatial base = tree_.accelerations(tau_.data(), nullptr, Vec3{0.0, 0.0, 0.0}, k.qd.data());
    k.v = x.v_WB;
    k.w = x.w_WB;
    k.a = x.q_WB * base.linear.toEigen();
    k.alpha = x.q_WB * base.angular.toEigen();
  }
  void advance(const State& x, double h, const Rate& k, State& result) const {
    result.p_WB = x.p_WB + h * k.v;
    result.q_WB = (quaternionFromRotationVector(h * k.w) * x.q_WB).normalized();
    result.v_WB = x.v_WB + h * k.a;
    result.w_WB = x.w_WB + h * k.alpha;
    result.q.resize(x.q.size());
    result.qd.resize(x.q.size());
    for (std::size_t i = 0; i < x.q.size(); ++i) {
      result.q[i] = x.q[i] + h * k.q[i];
      result.qd[i] = x.qd[i] + h * k.qd[i];
    }
  }
  void toTangent(double h, const Rate& previous, Rate& k) const { k.w = rotationVectorRate(h * previous.w, k.w); }
  void combine(Rate (&k)[4]) const {
    const auto mix = [](auto& a, const auto& b, const auto& c, const auto& d) {
      a = (a + 2.0 * b + 2.0 * c + d) / 6.0;
    };
    mix(k[0].v, k[1].v, k[2].v, k[3].v);
    mix(k[0].w, k[1].w, k[2].w, k[3].w);
    mix(k[0].a, k[1].a, k[2].a, k[3].a);
    mix(k[0].alpha, k[1].alpha, k[2].alpha, k[3].alpha);
    for (std::size_t i = 0; i < k[0].q.size(); ++i) {
      mix(k[0].q[i], k[1].q[i], k[2].q[i], k[3].q[i]);
      mix(k[0].qd[i], k[1].qd[i], k[2].qd[i], k[3].qd[i]);
    }
  }

 private:
  ArticulatedBody tree_;
  std::vector<double> tau_;
};

struct Drift {
  double momentum, angular_momentum, energy;
};

Drift driftInFreeFlight(const std::vector<Body>& bodies, TreeState x, double dt, int steps) {
  const SlowTreeDynamics slow(bodies);
  const Vector3d P = slow.momentum(x), L = slow.angularMomentum(x);
  const double E = slow.kineticEnergy(x);
  FreeFlight system(bodies);
  FreeFlight::Rate k[4];
  TreeState scratch = x;
  for (int i = 0; i < steps; ++i) rk4Step(system, x, dt, k, scratch);
  return {(slow.momentum(x) - P).norm() / P.norm(), (slow.angularMomentum(x) - L).norm() / L.norm(),
          std::abs(slow.kineticEnergy(x) - E) / E};
}

TEST(ArticulatedBody, MomentaAndEnergyOfFreeFlightAreKeptToFourthOrder) {
  // 1 s of a tumbling tree of six bodies. Nothing conserves these by construction, so their drift shows the order of
  // the whole chain, rotation included. Prismatic joints run away in free flight; revolute ones only here.
  RandomTrees random(7);
  std::vector<Body> bodies = random.tree(6, false, false);
  for (Body& body : bodies) body.prismatic = false;
  const TreeState x = random.state(bodies);
  const Drift coarse = driftInFreeFlight(bodies, x, 4e-3, 250);
  const Drift fine = driftInFreeFlight(bodies, x, 2e-3, 500);
  for (const auto& [a, b] :
       {std::pair(coarse.momentum, fine.momentum), std::pair(coarse.angular_momentum, fine.angular_momentum),
        std::pair(coarse.energy, fine.energy)}) {
    EXPECT_LT(b, 1e-7);
    const double order = std::log2(a / b);
    EXPECT_GT(order, 3.5) << a << " -> " << b;
  }
  const Drift tiny = driftInFreeFlight(bodies, x, 2.5e-4, 4000);
  EXPECT_LT(tiny.momentum, 1e-11);
  EXPECT_LT(tiny.angular_momentum, 1e-11);
  EXPECT_LT(tiny.energy, 1e-11);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
