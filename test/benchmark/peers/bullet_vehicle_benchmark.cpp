// Bullet on W1 and W2: exact ellipsoids on its triangle mesh, and its raycast vehicle (four rays, one body).
#include <benchmark/benchmark.h>
#include <btBulletDynamicsCommon.h>

#include <BulletDynamics/ConstraintSolver/btHinge2Constraint.h>
#include <BulletDynamics/Vehicle/btRaycastVehicle.h>

#include "bullet_shapes.h"
#include "workloads.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

constexpr btScalar kStep = btScalar(ride::kTick);

/// A world with one mesh as its ground.
class BulletWorld {
 public:
  explicit BulletWorld(const TriangleSoup& soup) : mesh_(soup), ground_(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, mesh_.shape.get())) {
    world.setGravity({0, 0, btScalar(-9.80665)});
    ground_.setFriction(1);
    world.addRigidBody(&ground_);
  }
  ~BulletWorld() {
    // The world knows its bodies by address: they leave in the reverse order of their coming.
    for (int i = world.getNumConstraints(); i-- > 0;) world.removeConstraint(world.getConstraint(i));
    for (int i = world.getNumCollisionObjects(); i-- > 0;)
      world.removeCollisionObject(world.getCollisionObjectArray()[i]);
  }
  BulletWorld(const BulletWorld&) = delete;
  BulletWorld& operator=(const BulletWorld&) = delete;

  std::unique_ptr<btRigidBody> add(btCollisionShape& shape, double mass, const Eigen::Vector3d& p,
                                   const btVector3& inertia) {
    auto body = std::make_unique<btRigidBody>(
        btRigidBody::btRigidBodyConstructionInfo(static_cast<btScalar>(mass), nullptr, &shape, inertia));
    body->setWorldTransform(btTransform(btMatrix3x3::getIdentity(), toBullet(p)));
    body->setInterpolationWorldTransform(body->getWorldTransform());
    body->setFriction(1);
    body->setActivationState(DISABLE_DEACTIVATION);
    world.addRigidBody(body.get());
    return body;
  }
  void step() { world.stepSimulation(kStep, 1, kStep); }

 private:
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;

 public:
  btDiscreteDynamicsWorld world{&dispatcher_, &broadphase_, &solver_, &configuration_};

 private:
  BulletMesh mesh_;
  btRigidBody ground_;
};

void reportPerStep(benchmark::State& state, std::int64_t steps) {
  state.counters["us_per_step"] = benchmark::Counter(static_cast<double>(state.iterations() * steps) * 1e-6,
                                                     benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

btTransform at(const Eigen::Vector3d& p) { return btTransform(btMatrix3x3::getIdentity(), toBullet(p)); }

void dropBody(benchmark::State& state) {
  BulletWorld bullet(gridSoup(drop::kCells, 1.0, [](double, double) { return 0.0; }, {-10.0, -10.0, 0.0}));
  BulletEllipsoid chassis(toBullet(drop::chassis())), wheel(toBullet(benchmarkWheel()));
  btCompoundShape shape;
  shape.addChildShape(btTransform::getIdentity(), &chassis);
  for (const Eigen::Vector3d& p : drop::wheels()) shape.addChildShape(at(p), &wheel);
  btVector3 inertia;
  chassis.calculateLocalInertia(btScalar(drop::kMass), inertia);
  const Eigen::Vector3d start(0.13, 0.07, drop::kStartHeight);
  const auto body = bullet.add(shape, drop::kMass, start, inertia);
  const auto steps = std::llround(drop::kSeconds / drop::kTick);
  for (auto _ : state) {
    body->setWorldTransform(at(start));
    body->setLinearVelocity({0, 0, 0});
    body->setAngularVelocity({0, 0, 0});
    for (std::int64_t i = 0; i < steps; ++i) bullet.step();
  }
  const btScalar z = body->getWorldTransform().getOrigin().z();
  if (z < 0.6 || z > 0.9) state.SkipWithError("the body does not lie on its wheels");
  reportPerStep(state, steps);
}

/// Measures 20 s after the run-up; `advance` does one step.
template <typename Advance>
void measureRide(benchmark::State& state, const btRigidBody& chassis, Advance advance) {
  const auto steps = std::llround(ride::kSeconds / ride::kTick), run_up = std::llround(ride::kRunUp / ride::kTick);
  for (std::int64_t i = 0; i < run_up; ++i) advance();
  double sum = 0.0;
  for (auto _ : state)
    for (std::int64_t i = 0; i < steps; ++i) {
      advance();
      sum += chassis.getLinearVelocity().length();
    }
  const double mean = sum / static_cast<double>(steps * state.iterations());
  state.counters["mean_speed"] = mean;
  const btVector3& p = chassis.getWorldTransform().getOrigin();
  if (std::abs(p.z() - hillHeight(p.x(), p.y())) > 1.5) state.SkipWithError("left the ground");
  if (std::abs(mean - ride::kSpeed) > 0.3 * ride::kSpeed) state.SkipWithError("does not keep its speed");
  reportPerStep(state, steps);
}

std::unique_ptr<btRigidBody> addChassis(BulletWorld& bullet, btCollisionShape& shape, double mass,
                                        const Eigen::Vector3d& p) {
  const auto m = static_cast<btScalar>(mass);
  return bullet.add(shape, mass, p, {m * btScalar(0.25), m * btScalar(1.2), m * btScalar(1.35)});
}

/// Four wheel bodies, each on a joint with suspension, steering axis and axle.
void driveOverHills(benchmark::State& state) {
  BulletWorld bullet(hills(kHillCells));
  const Eigen::Vector3d start(0.0, -ride::kCircle, hillHeight(0.0, -ride::kCircle) + 0.45);
  BulletEllipsoid body(toBullet(Eigen::Vector3d(2.0, 0.8, 0.4))), wheel(toBullet(benchmarkWheel()));
  btCompoundShape shape;
  shape.addChildShape(at({0.0, 0.0, 0.25}), &body);
  const auto chassis =
      addChassis(bullet, shape, ride::kMass - 4.0 * ride::kWheelMass, start + Eigen::Vector3d(0, 0, 0.15));
  std::vector<std::unique_ptr<btRigidBody>> wheels;
  std::vector<std::unique_ptr<btHinge2Constraint>> joints;
  for (const double x : {ride::kAxle, -ride::kAxle})
    for (const double y : {ride::kHalfTrack, -ride::kHalfTrack}) {
      btVector3 inertia;
      wheel.calculateLocalInertia(btScalar(ride::kWheelMass), inertia);
      const Eigen::Vector3d p = start + Eigen::Vector3d(x, y, 0.0);
      wheels.push_back(bullet.add(wheel, ride::kWheelMass, p, inertia));
      btVector3 anchor = toBullet(p), up(0, 0, 1), axle(0, 1, 0);
      joints.push_back(std::make_unique<btHinge2Constraint>(*chassis, *wheels.back(), anchor, up, axle));
      btHinge2Constraint& joint = *joints.back();
      joint.setStiffness(2, btScalar(ride::kSpring));
      joint.setDamping(2, btScalar(ride::kDamper));
      joint.setEquilibriumPoint(2, btScalar(-0.25 * ride::kMass * 9.80665 / ride::kSpring));
      const auto angle = static_cast<btScalar>(x > 0.0 ? -ride::steeringAngle() : 0.0);
      joint.setLimit(5, angle, angle);
      if (x < 0.0) {
        joint.enableMotor(3, true);
        joint.setTargetVelocity(3, btScalar(-ride::kSpeed / ride::kWheelRadius));
        joint.setMaxMotorForce(3, btScalar(1500));
      }
      bullet.world.addConstraint(&joint, true);
    }
  measureRide(state, *chassis, [&] { bullet.step(); });
}

void raycastVehicle(benchmark::State& state) {
  BulletWorld bullet(hills(kHillCells));
  const Eigen::Vector3d start(0.0, -ride::kCircle, hillHeight(0.0, -ride::kCircle) + 0.75);
  btBoxShape body({btScalar(1.6), btScalar(0.7), btScalar(0.2)});
  btCompoundShape shape;
  shape.addChildShape(at({0.0, 0.0, 0.3}), &body);
  const auto chassis = addChassis(bullet, shape, ride::kMass, start);
  btDefaultVehicleRaycaster caster(&bullet.world);
  btRaycastVehicle::btVehicleTuning tuning;
  tuning.m_suspensionStiffness = btScalar(4.0 * ride::kSpring / ride::kMass);  // Bullet's is per mass of the chassis
  tuning.m_suspensionDamping = tuning.m_suspensionCompression = btScalar(4.0 * ride::kDamper / ride::kMass);
  tuning.m_frictionSlip = 1;
  btRaycastVehicle vehicle(tuning, chassis.get(), &caster);
  vehicle.setCoordinateSystem(1, 2, 0);  // right y, up z, forward x
  for (const double x : {ride::kAxle, -ride::kAxle})
    for (const double y : {ride::kHalfTrack, -ride::kHalfTrack})
      vehicle.addWheel(toBullet(Eigen::Vector3d(x, y, 0.2)), {0, 0, -1}, {0, -1, 0}, btScalar(0.3),
                       btScalar(ride::kWheelRadius), tuning, x > 0.0);
  bullet.world.addVehicle(&vehicle);
  for (const int i : {0, 1}) vehicle.setSteeringValue(static_cast<btScalar>(ride::steeringAngle()), i);
  measureRide(state, *chassis, [&] {
    const btScalar force = 3000 * (btScalar(ride::kSpeed) - chassis->getLinearVelocity().length());
    for (const int i : {2, 3}) vehicle.applyEngineForce(force, i);
    bullet.step();
  });
  bullet.world.removeVehicle(&vehicle);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test

int main(int argc, char** argv) {
  using namespace ellipsoid_vehicle_sim::test;
  const auto add = [](const std::string& name, void (*function)(benchmark::State&)) {
    benchmark::RegisterBenchmark(name.c_str(), function)->Unit(benchmark::kMillisecond)->Iterations(1);
  };
  const std::string bullet = kBulletName;
  add("W1_semi_implicit/" + bullet, dropBody);
  add("W2_semi_implicit/" + bullet, driveOverHills);
  add("W2_semi_implicit/" + bullet + " raycast vehicle", raycastVehicle);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
