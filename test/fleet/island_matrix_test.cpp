// linearly_implicit's matrix for vehicles that touch each other: each column is found from those alone whom it concerns.
// Here against the whole island moved, and evaluated whole.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <deque>
#include <memory>

#include "../../src/fleet/island_stepper.h"
#include "support/motions.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::Vector3d;

constexpr double kTick = 1e-3;
constexpr double kDelta = 1e-4;  // of a speed: moves by 1e-7 m within the tick

/// A body in space, the pieces of a simulator apart.
struct Body {
  Body(const Vector3d& radii, double mass, const Vector3d& p, const Vector3d& v, const Vector3d& w) : terrain(emptySpace()) {
    config = springConfig(IntegratorKind::kLinearlyImplicit, kTick, 5e5, 200.0);
    config.body_friction = FrictionMode::kAnchored;
    config.mu_static = config.mu_kinetic = 0.8;
    const VehicleDescription description = solidBody(radii, mass);
    Simulator simulator = make(description, terrain, config);
    placeAt(simulator, p, v, w);
    config.allow_no_wheels = true;
    model = *compileVehicle(description, config).value;
    dynamics = std::make_unique<VehicleDynamics>(model, config, *terrain);
    stepper = std::make_unique<TickStepper>(model, config, *dynamics);
    state = simulator.state();
    before = state.memory;
  }

  std::shared_ptr<const Terrain> terrain;
  SimConfig config;
  VehicleModel model;
  std::unique_ptr<VehicleDynamics> dynamics;
  std::unique_ptr<TickStepper> stepper;
  VehicleState state;
  std::vector<ContactMemory> before;
};

/// Three in a row: an egg that is pressed against a ball and drags at it, and a second ball behind that.
class Row : public testing::Test {
 protected:
  Row() {
    const Vector3d zero = Vector3d::Zero();
    bodies_.emplace_back(Vector3d(0.3, 0.2, 0.25), 5.0, Vector3d(-0.598, 0.03, 0.01), Vector3d(0.2, 0.02, 0.0), Vector3d(0.0, 0.1, 0.2));
    bodies_.emplace_back(Vector3d::Constant(0.3), 8.0, zero, zero, zero);
    bodies_.emplace_back(Vector3d::Constant(0.2), 4.0, Vector3d(0.499, 0.0, 0.0), Vector3d(-0.1, 0.0, 0.03), zero);
    island_.reserve(bodies_.size());
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      Body& b = bodies_[i];
      island_.addVehicle({&b.model, &b.config, b.dynamics.get(), b.stepper.get(), &b.state, &b.before}, static_cast<int>(i));
    }
    int first = 0;
    for (PairCandidate& pair : pairs_) {
      pair.member[0] = first++;
      pair.member[1] = first;
      pair.memory.ellipsoid[0] = pair.memory.ellipsoid[1] = 0;
      island_.addPair(pair);
    }
    for (int tick = 0; tick < 2; ++tick) EXPECT_TRUE(island_.advance());
  }

  /// The step's start from where it stands now, and its first guess as the trial.
  void begin() {
    IslandStepper::Buffers& b = island_.buffers();
    island_.beginStep(kTick);
    island_.rate(island_.start(), 0.0, b.k[0]);
    island_.findDirections(kTick, kDelta);
    b.trial = island_.start();
    island_.advancePositions(b.trial, kTick, b.k[0]);
  }
  std::vector<std::vector<double>> columns() {
    std::vector<std::vector<double>> result;
    DenseSystem& matrix = island_.matrix();
    island_.beginColumns();
    for (int j = 0; j < matrix.size(); ++j) {
      island_.findColumn(j, kTick * kDelta);
      result.emplace_back();
      for (int i = 0; i < matrix.size(); ++i) result.back().push_back(matrix.at(i, j));
    }
    return result;
  }
  /// Rates of all speeds where the trial has moved along what a unit of speed j does within the step.
  std::vector<double> wholeColumn(int j) {
    IslandStepper::Buffers& b = island_.buffers();
    island_.rate(island_.start(), 0.0, b.k[2]);  // the pairs stand at the start, too
    for (MotionRate* rate : b.sum.of) {
      rate->a.setZero();
      rate->alpha.setZero();
    }
    island_.speed(b.sum, j) = 1.0;
    b.scratch = island_.start();
    island_.advanceVelocities(b.scratch, kDelta, b.sum);
    island_.positionRates(b.scratch, b.k[1]);
    const double difference[2] = {1.0 / kDelta, -1.0 / kDelta};
    island_.weightedSum(difference, b.k + 1, 2, b.error);
    for (std::size_t p = 0; p < pairs_.size(); ++p) b.error.anchor[p] = (b.k[1].anchor[p] - b.k[2].anchor[p]) / kDelta;
    for (std::size_t i = 0; i < b.error.of.size(); ++i) {
      b.error.of[i]->a = b.sum.of[i]->a / kTick;
      b.error.of[i]->alpha = b.sum.of[i]->alpha / kTick;
    }
    island_.advance(b.trial, kTick * kDelta, b.error, b.scratch);
    island_.rate(b.scratch, 1.0, b.k[1]);
    std::vector<double> result;
    for (int i = 0; i < island_.matrix().size(); ++i) result.push_back(island_.speed(b.k[1], i));
    return result;
  }
  void expectTheWhole(const std::vector<std::vector<double>>& columns) {
    for (std::size_t j = 0; j < columns.size(); ++j) {
      const std::vector<double> whole = wholeColumn(static_cast<int>(j));
      for (std::size_t i = 0; i < whole.size(); ++i)
        EXPECT_NEAR(columns[j][i], whole[i], 1e-9 * (1.0 + std::abs(whole[i]))) << i << ", " << j;
    }
  }

  std::deque<Body> bodies_;
  std::array<PairCandidate, 2> pairs_;
  IslandStepper island_;
};

TEST_F(Row, EachColumnIsWhatTheWholeIslandDoes) {
  begin();
  ASSERT_GT(pairs_[0].memory.anchor_W.norm(), 0.0);
  for (const PairCandidate& pair : pairs_) {
    ASSERT_TRUE(pair.known);
    ASSERT_GT(pair.force.normal, 100.0);
    ASSERT_FALSE(pair.force.sliding);
  }
  const std::vector<std::vector<double>> found = columns();
  expectTheWhole(found);
}

// A trial at which two just touch, or just do not: what the one does parts them, or joins them.
TEST_F(Row, AlsoWhereAContactEndsOrBegins) {
  begin();
  IslandStepper::Buffers& b = island_.buffers();
  for (const double apart : {-3e-8, 3e-8}) {
    b.trial.of[2]->X_WB.p = b.trial.of[1]->X_WB.p + (0.5 + apart) * Vector3d::UnitX();
    b.trial.of[2]->v_WB.x() = b.trial.of[1]->v_WB.x() - 0.1;  // so that the damper pushes
    const std::vector<std::vector<double>> found = columns();
    EXPECT_EQ(static_cast<bool>(pairs_[1].contact), apart < 0.0);
    expectTheWhole(found);
  }
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
