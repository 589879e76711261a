// What the certificate says about a step, against what a step really does.
#include "ellipsoid_vehicle_sim/vehicle/linearisation.h"

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "ellipsoid_vehicle_sim/vehicle/drive.h"
#include "ellipsoid_vehicle_sim/vehicle/tick_stepper.h"
#include "support/motions.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;

/// A vehicle at rest on the flat, the pieces of a simulator apart.
struct Standing {
  Standing(const VehicleDescription& vehicle, SimConfig c) : config(c), terrain(flatFloor()) {
    config.allow_unstable = true;
    Simulator simulator = make(vehicle, terrain, config);
    standAt(simulator, 0.3, -0.2, 0.0);
    // What set-down leaves is still.
    run(simulator, 0.0);
    config.allow_no_wheels = true;
    model = *compileVehicle(vehicle, config).value;
    dynamics = std::make_unique<VehicleDynamics>(model, config, *terrain);
    state = simulator.state();
  }
  SimConfig config;
  std::shared_ptr<const Terrain> terrain;
  VehicleModel model;
  std::unique_ptr<VehicleDynamics> dynamics;
  VehicleState state;
};

/// Largest modulus of the eigenvalues that are not those of rigid drifting.
double spectralRadius(const MatrixXd& map, double dt) {
  double radius = 0.0;
  const Eigen::VectorXcd values = map.eigenvalues();
  for (Eigen::Index i = 0; i < values.size(); ++i)
    if (std::abs(values[i] - 1.0) > 2.0 * dt) radius = std::max(radius, std::abs(values[i]));
  return radius;
}

/// The one-step map by central differences of real steps, contact memory and all.
MatrixXd differencedMap(Standing& s, const Linearisation& linearisation) {
  TickStepper stepper(s.model, s.config, *s.dynamics);
  const auto stepped = [&](int coordinate, double h) {
    VehicleState moved = s.state;
    moved.motion = linearisation.moved(s.state.motion, coordinate, h);
    // The memory belongs to the pose: taken anew there, the friction's stretches as they were.
    const std::vector<Anchors> anchors = moved.motion.anchor;
    s.dynamics->beginStep(s.state, 0.0);
    s.dynamics->accept(moved, 0.0);
    moved.motion.anchor = anchors;
    std::vector<ContactMemory> before = moved.memory;
    EXPECT_TRUE(stepper.advance(moved, before).sane);
    return linearisation.tangent(moved.motion);
  };
  MatrixXd map(linearisation.size(), linearisation.size());
  for (int i = 0; i < linearisation.size(); ++i) {
    const double h = i < linearisation.positions() ? 1e-7 : 1e-6;
    map.col(i) = (stepped(i, h) - stepped(i, -h)) / (2.0 * h);
  }
  return map;
}

TEST(Linearisation, PredictedSpectralRadiusIsThatOfRealSteps) {
  // Below, at and beyond what each integrator holds; within 2 %.
  for (const bool vehicle : {false, true})
    for (const IntegratorKind kind : allIntegrators()) {
      // The error control takes no step that grows: there is no map of it to compare with.
      if (kind == IntegratorKind::kDormandPrince) continue;
      SimConfig config;
      config.integrator = kind;
      config.relaxation_time = 2e-3;
      const VehicleDescription description = vehicle ? car() : solidBody({0.4, 0.35, 0.3}, 20.0);
      SimConfig unbounded = config;
      unbounded.allow_unstable = true;
      const double limit = make(description, flatFloor(), unbounded).certificate().largestStep(kind);
      ASSERT_GT(limit, 0.0);
      for (const double part : {0.7, 1.0, 1.3}) {
        config.dt = std::max(1e-6, part * limit);
        Standing standing(description, config);
        Linearisation linearisation(standing.model, *standing.dynamics, standing.state);
        const MatrixXd J = linearisation.jacobian();
        const double predicted = spectralRadius(
            stepMap(kind, J, linearisation.positions(), config.dt, config.contact_substeps), config.dt);
        const double real = spectralRadius(differencedMap(standing, linearisation), config.dt);
        EXPECT_NEAR(real, predicted, 0.02 * predicted)
            << toString(kind) << (vehicle ? ", car" : ", body") << ", " << part << " of the limit " << limit;
      }
    }
}

TEST(Linearisation, TangentUndoesMoved) {
  SimConfig config;
  Standing standing(car(), config);
  const Linearisation linearisation(standing.model, *standing.dynamics, standing.state);
  for (int i = 0; i < linearisation.size(); ++i) {
    const Eigen::VectorXd t = linearisation.tangent(linearisation.moved(standing.state.motion, i, 1e-3));
    for (int j = 0; j < linearisation.size(); ++j) EXPECT_NEAR(t[j], i == j ? 1e-3 : 0.0, 1e-12) << i << " " << j;
  }
}

bool hasMode(const StabilityCertificate& certificate, const std::string& words, double low, double high) {
  for (const StabilityMode& mode : certificate.modes)
    if (mode.name.find(words) == 0 && mode.frequency > low && mode.frequency < high) return true;
  return false;
}

std::string modesOf(const StabilityCertificate& certificate) {
  std::string text;
  for (const std::string& line : describeModes(certificate, 1e-3, IntegratorKind::kRk4, 100)) text += line + "\n";
  return text;
}

TEST(Linearisation, ModesOfACarAreNamedByTheForceBehindThem) {
  CarShape shape;
  SimConfig config;
  const Simulator simulator = make(car(shape), flatFloor(), config);
  const StabilityCertificate& certificate = simulator.certificate();
  // Heave on four springs, each carrying a quarter of the sprung mass; the tyres are a hundred times stiffer.
  const double sprung = shape.mass - 4.0 * (shape.wheel_mass + 5.0) - 1.0;
  const double heave = std::sqrt(4.0 * shape.spring / sprung);
  EXPECT_TRUE(hasMode(certificate, "suspension joint", 0.7 * heave, 1.5 * heave)) << modesOf(certificate);
  // A wheel with its upright hops on the contact's spring.
  const double hop = std::sqrt(simulator.model().ellipsoids[1].law.stiffness / (shape.wheel_mass + 5.0));
  EXPECT_TRUE(hasMode(certificate, "contact of", 0.5 * hop, 2.0 * hop)) << modesOf(certificate);
  EXPECT_TRUE(hasMode(certificate, "friction of", 2.0, 1e6)) << modesOf(certificate);
  EXPECT_TRUE(hasMode(certificate, "brake of", 2.0, 1e6)) << modesOf(certificate);
}

TEST(Linearisation, EveryModeSaysWhatEachIntegratorHoldsOfIt) {
  // An oscillator with the mode's frequency and damping: the closed forms.
  const Simulator simulator = make(car(), flatFloor(), SimConfig{});
  const StabilityCertificate& certificate = simulator.certificate();
  ASSERT_FALSE(certificate.modes.empty());
  for (const StabilityMode& mode : certificate.modes) {
    if (mode.damping_ratio > 0.999 || mode.damping_ratio < 0.0) continue;
    for (const IntegratorKind kind : {IntegratorKind::kSemiImplicitEuler, IntegratorKind::kRk4, IntegratorKind::kExplicitEuler}) {
      const double expected = std::min(0.1, oscillatorLimit(kind, mode.damping_ratio) / mode.frequency);
      EXPECT_NEAR(mode.largest_step[static_cast<std::size_t>(kind)], expected, 1e-6 * expected) << mode.name;
    }
  }
}

TEST(Linearisation, TheLogTellsModesWithFrequencyDampingStepsAndMargin) {
  const Simulator simulator = make(car(), flatFloor(), SimConfig{});
  int told = 0;
  for (const std::string& line : simulator.loadReport()) {
    if (line.rfind("mode: ", 0) != 0) continue;
    ++told;
    for (const char* word : {" rad/s", " Hz", "damping ratio", "margin", "rk4 ", "semi_implicit_euler ", "linearly_implicit "})
      EXPECT_NE(line.find(word), std::string::npos) << line;
  }
  EXPECT_GE(told, 3);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test
