// MuJoCo on W1 and W2: exact ellipsoids on a height field of the same heights, with its own contact model.
#include <benchmark/benchmark.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <sstream>
#include <stdexcept>

#include "workloads.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

using Model = std::unique_ptr<mjModel, decltype(&mj_deleteModel)>;
using Data = std::unique_ptr<mjData, decltype(&mj_deleteData)>;

/// A square height field of n cells of 1 m around the origin; its heights are filled in after loading.
struct Ground {
  int n;
  std::vector<double> z;
  double low, high;
  Ground(int cells, double (*height)(double, double)) : n(cells) {
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) z.push_back(height(i - 0.5 * n, j - 0.5 * n));
    low = *std::min_element(z.begin(), z.end());
    high = std::max(*std::max_element(z.begin(), z.end()), low + 0.1);
  }
  std::string asset() const {
    std::ostringstream out;
    out << "<hfield name='ground' nrow='" << n + 1 << "' ncol='" << n + 1 << "' size='" << 0.5 * n << ' ' << 0.5 * n
        << ' ' << high - low << " 1'/>";
    return out.str();
  }
  std::string geom() const {
    return "<geom type='hfield' hfield='ground' contype='1' conaffinity='0' pos='0 0 " + std::to_string(low) + "'/>";
  }
  void fill(mjModel& model) const {
    for (std::size_t i = 0; i < z.size(); ++i) model.hfield_data[i] = static_cast<float>((z[i] - low) / (high - low));
  }
};

std::string numbers(const Eigen::Vector3d& v) {
  std::ostringstream out;
  out << v.x() << ' ' << v.y() << ' ' << v.z();
  return out.str();
}

std::string ellipsoidGeom(const Eigen::Vector3d& at, const Eigen::Vector3d& radii, double mass) {
  return "<geom type='ellipsoid' contype='0' conaffinity='1' pos='" + numbers(at) + "' size='" + numbers(radii) +
         "' mass='" + std::to_string(mass) + "'/>";
}

Model load(const Ground& ground, const std::string& bodies, const std::string& rest, bool rk4) {
  const std::string text = std::string("<mujoco><option timestep='0.001' gravity='0 0 -9.80665' integrator='") +
                           (rk4 ? "RK4" : "Euler") + "'/><default><geom friction='1 .005 .0001'/></default><asset>" +
                           ground.asset() + "</asset><worldbody>" + ground.geom() + bodies + "</worldbody>" + rest +
                           "</mujoco>";
  const auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  if (mj_makeEmptyFileVFS(files.get(), "model.xml", static_cast<int>(text.size())) != 0)
    throw std::runtime_error("mjVFS");
  std::memcpy(files->filedata[mj_findFileVFS(files.get(), "model.xml")], text.data(), text.size());
  char error[1000] = "";
  Model model(mj_loadXML("model.xml", files.get(), error, sizeof error), &mj_deleteModel);
  mj_deleteVFS(files.get());
  if (!model) throw std::runtime_error(error);
  ground.fill(*model);
  return model;
}

void reportPerStep(benchmark::State& state, std::int64_t steps) {
  state.counters["us_per_step"] = benchmark::Counter(static_cast<double>(state.iterations() * steps) * 1e-6,
                                                     benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void dropBody(benchmark::State& state, bool rk4) {
  const Ground flat(drop::kCells, [](double, double) { return 0.0; });
  std::string body = "<body pos='0.13 0.07 " + std::to_string(drop::kStartHeight) + "'><freejoint/>";
  body += ellipsoidGeom({0, 0, 0}, drop::chassis(), drop::kMass);
  for (const Eigen::Vector3d& p : drop::wheels()) body += ellipsoidGeom(p, benchmarkWheel(), 0.0);
  const Model model = load(flat, body + "</body>", "", rk4);
  const Data data(mj_makeData(model.get()), &mj_deleteData);
  const auto steps = std::llround(drop::kSeconds / drop::kTick);
  for (auto _ : state) {
    mj_resetData(model.get(), data.get());
    for (std::int64_t i = 0; i < steps; ++i) mj_step(model.get(), data.get());
  }
  if (data->qpos[2] < 0.6 || data->qpos[2] > 0.8) return state.SkipWithError("the body does not lie on its wheels");
  reportPerStep(state, steps);
}

std::string carBody(double x, double y) {
  const double body_mass = ride::kMass - 4.0 * (ride::kWheelMass + 5.0) - 2.0 * 0.5;
  std::ostringstream out;
  out << "<body pos='" << x << ' ' << y << ' ' << hillHeight(x, y) + 0.45
      << "'><freejoint/><inertial pos='0 0 .15' mass='" << body_mass << "' diaginertia='" << 0.25 * body_mass << ' '
      << 1.2 * body_mass << ' ' << 1.35 * body_mass << "'/>" << ellipsoidGeom({0, 0, 0.4}, {2.0, 0.8, 0.4}, 0.0);
  for (const bool front : {true, false})
    for (const bool left : {true, false}) {
      const std::string name = std::string(front ? "front" : "rear") + (left ? "_left" : "_right");
      out << "<body pos='" << (front ? ride::kAxle : -ride::kAxle) << ' ' << (left ? 1 : -1) * ride::kHalfTrack
          << " 0'><joint type='slide' axis='0 0 1' stiffness='" << ride::kSpring << "' damping='" << ride::kDamper
          << "' springref='" << -0.25 * body_mass * 9.80665 / ride::kSpring
          << "'/><inertial pos='0 0 0' mass='5' diaginertia='.05 .05 .05'/>";
      if (front)
        out << "<body><joint name='" << name << "_steer' type='hinge' axis='0 0 1'/>"
            << "<inertial pos='0 0 0' mass='.5' diaginertia='.01 .01 .01'/>";
      out << "<body><joint name='" << name << "_axle' type='hinge' axis='0 1 0'/>"
          << ellipsoidGeom({0, 0, 0}, benchmarkWheel(), ride::kWheelMass) << "</body>" << (front ? "</body>" : "")
          << "</body>";
    }
  out << "</body>";
  return out.str();
}

void driveOverHills(benchmark::State& state, int cells, bool rk4, double radius, double speed, double seconds) {
  const Ground ground(cells, hillHeight);
  const Model model =
      load(ground, carBody(0.0, -radius),
           "<actuator><position joint='front_left_steer' kp='5000'/><position joint='front_right_steer' kp='5000'/>"
           "<velocity joint='rear_left_axle' kv='200' forcelimited='true' forcerange='-1500 1500'/>"
           "<velocity joint='rear_right_axle' kv='200' forcelimited='true' forcerange='-1500 1500'/></actuator>",
           rk4);
  const Data data(mj_makeData(model.get()), &mj_deleteData);
  const auto steps = std::llround(seconds / ride::kTick), run_up = std::llround(ride::kRunUp / ride::kTick);
  const double angle = std::atan(2.0 * ride::kAxle / radius);
  double sum = 0.0;
  const auto advance = [&](std::int64_t count) {
    for (std::int64_t i = 0; i < count; ++i) {
      mj_step(model.get(), data.get());
      sum += std::hypot(data->qvel[0], data->qvel[1]);
    }
  };
  for (auto _ : state) {
    state.PauseTiming();
    mj_resetData(model.get(), data.get());
    data->ctrl[0] = data->ctrl[1] = angle;
    data->ctrl[2] = data->ctrl[3] = speed / ride::kWheelRadius;
    advance(run_up);
    sum = 0.0;
    state.ResumeTiming();
    advance(steps);
  }
  const double mean = sum / static_cast<double>(steps);
  state.counters["mean_speed"] = mean;
  if (std::abs(mean - speed) > 0.3 * speed) return state.SkipWithError("does not keep its speed");
  reportPerStep(state, steps);
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test

int main(int argc, char** argv) {
  using namespace ellipsoid_vehicle_sim::test;
  const auto add = [](const std::string& name, auto&& function) {
    benchmark::RegisterBenchmark(name.c_str(), function)->Unit(benchmark::kMillisecond);
  };
  for (const bool rk4 : {false, true}) {
    const std::string figure = rk4 ? "_rk4" : "_semi_implicit", who = rk4 ? "/MuJoCo RK4" : "/MuJoCo Euler";
    add("W1" + figure + who, [=](benchmark::State& s) { dropBody(s, rk4); });
    add("W2" + figure + who,
        [=](benchmark::State& s) { driveOverHills(s, kHillCells, rk4, ride::kCircle, ride::kSpeed, ride::kSeconds); });
  }
  const std::pair<const char*, int> worlds[] = {{"2k", 32}, {"20k", 100}, {"200k", kHillCells}, {"2M", kManyHillCells}};
  for (const auto& [size, cell_count] : worlds) {
    const int cells = cell_count;
    add(std::string("W2_world_") + size + "/MuJoCo Euler",
        [=](benchmark::State& s) { driveOverHills(s, cells, false, 12.0, 6.0, 10.0); });
  }
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
