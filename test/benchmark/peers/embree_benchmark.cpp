// Embree on the world's workloads. Its point query takes a sphere, here one around the wheel's box.
#include <benchmark/benchmark.h>
#include <embree3/rtcore.h>

#include <cmath>
#include <cstring>

#include "workloads.h"

namespace ellipsoid_vehicle_sim::test {
namespace {

struct Scene {
  std::int64_t bytes = 0;  ///< what the device holds now; before `device`, which reports to it until its end.
  RTCDevice device = rtcNewDevice("threads=1");
  RTCScene scene = rtcNewScene(device);

  /// Vertices and indices are copied here; the tree is built by commit().
  explicit Scene(const TriangleSoup& soup) {
    rtcSetDeviceMemoryMonitorFunction(device, &Scene::count, this);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_LOW);  // Morton codes, the fastest
    RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                                 3 * sizeof(float), soup.vertices.size()));
    for (const Eigen::Vector3d& v : soup.vertices)
      for (int k = 0; k < 3; ++k) *vertices++ = static_cast<float>(v[k]);
    void* indices = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t),
                                            soup.triangles.size());
    std::memcpy(indices, soup.triangles.data(), soup.triangles.size() * sizeof(soup.triangles[0]));
    rtcSetGeometryPointQueryFunction(mesh, &Scene::found);
    rtcCommitGeometry(mesh);
    rtcAttachGeometry(scene, mesh);
    rtcReleaseGeometry(mesh);
  }
  ~Scene() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;
  void commit() { rtcCommitScene(scene); }

  static bool count(void* self, ssize_t bytes, bool) {
    static_cast<Scene*>(self)->bytes += bytes;
    return true;
  }
  static bool found(RTCPointQueryFunctionArguments* arguments) {
    ++*static_cast<std::size_t*>(arguments->userPtr);
    return false;  // the radius stays as it is
  }
};

void candidates(benchmark::State& state, bool cold) {
  Scene scene(hills(kHillCells));
  scene.commit();
  std::vector<PosedEllipsoid> places = coldPlaces(kHillCells);
  DrivingPath path(kHillCells);
  if (!cold)
    for (PosedEllipsoid& place : places) place = path.next();
  const float radius = static_cast<float>(benchmarkWheel().maxCoeff());
  std::size_t k = 0, found = 0;
  for (auto _ : state) {
    const Eigen::Vector3f p = places[k++ & 65535].p_WE.cast<float>();
    RTCPointQuery query{p.x(), p.y(), p.z(), 0.0f, radius};
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene.scene, &query, &context, nullptr, &found);
  }
  state.counters["triangles"] = static_cast<double>(found) / static_cast<double>(state.iterations());
}

void build(benchmark::State& state) {
  const TriangleSoup soup = hills(kManyHillCells);
  for (auto _ : state) {
    state.PauseTiming();
    Scene scene(soup);
    state.ResumeTiming();
    scene.commit();
    state.PauseTiming();
    state.counters["bytes_per_triangle"] =
        static_cast<double>(scene.bytes) / static_cast<double>(soup.triangles.size());
    state.ResumeTiming();
  }
  state.counters["triangles_per_second"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * static_cast<double>(soup.triangles.size()),
                         benchmark::Counter::kIsRate);
}

/// The rays of lidar_benchmark on triangles of its own, in floats; no vehicles, no noise.
void lidarScan(benchmark::State& state) {
  Scene scene(hills(kHillCells));
  scene.commit();
  const double limit = 0.5 * kHillCells - 40.0, first = -0.75 * M_PI, increment = 1.5 * M_PI / 1080.0;
  std::int64_t k = 0;
  double seen = 0.0;
  for (auto _ : state) {
    const double x = std::fmod(37.0 * static_cast<double>(k), 2.0 * limit) - limit;
    const double y = std::fmod(91.0 * static_cast<double>(k), 2.0 * limit) - limit;
    const double yaw = 0.1 * static_cast<double>(k++);
    for (int i = 0; i < 1081; ++i) {
      const double azimuth = yaw + first + i * increment;
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      RTCRayHit ray{};
      ray.ray.org_x = static_cast<float>(x), ray.ray.org_y = static_cast<float>(y);
      ray.ray.org_z = static_cast<float>(hillHeight(x, y) + 0.5);
      ray.ray.dir_x = static_cast<float>(std::cos(azimuth)), ray.ray.dir_y = static_cast<float>(std::sin(azimuth));
      ray.ray.tfar = 30.0f;
      ray.ray.mask = 0xffffffffu;
      ray.hit.geomID = ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
      rtcIntersect1(scene.scene, &context, &ray);
      seen += ray.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    }
  }
  const double scans = static_cast<double>(state.iterations());
  state.counters["us_per_scan"] =
      benchmark::Counter(1e-6 * scans, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  state.counters["rays_that_hit"] = seen / scans;
}

}  // namespace
}  // namespace ellipsoid_vehicle_sim::test

int main(int argc, char** argv) {
  using namespace ellipsoid_vehicle_sim::test;
  benchmark::RegisterBenchmark("candidates_driving/Embree", candidates, false);
  benchmark::RegisterBenchmark("candidates_cold/Embree", candidates, true);
  benchmark::RegisterBenchmark("build/Embree", build)
      ->Unit(benchmark::kMillisecond)
      ->MinTime(1.0)
      ->MeasureProcessCPUTime();
  benchmark::RegisterBenchmark("lidar_scan/Embree floats", lidarScan)->Unit(benchmark::kMicrosecond);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
