#include "ellipsoid_vehicle_sim/sensors/lidar.h"

#include <cstdio>
#include <utility>

namespace ellipsoid_vehicle_sim {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kMostRays = 2e6;  // of a scan: more does not fit into a message that anybody could want

std::string numbers(const char* format, double a, double b) {
  char text[200];
  std::snprintf(text, sizeof text, format, a, b);
  return text;
}

}  // namespace

ParameterTable<LidarSpec> lidarParameters() {
  using L = LidarSpec;
  const auto whole = [](Parameter<L> row) {
    row.spec.whole = true;
    return row;
  };
  return {
      choiceParameter<L, LidarKind>(
          "kind", {{"planar", LidarKind::kPlanar}, {"spatial", LidarKind::kSpatial}}, &L::kind,
          "planar: one fan of rays, as sensor_msgs/LaserScan. spatial: several fans one above "
          "the other, as sensor_msgs/PointCloud2."),
      textParameter("link", &L::link, "Link of the vehicle that carries it. Not given: the root link."),
      listParameter("pose", "m, m, m, rad, rad, rad", 6, &L::pose,
                    "x, y, z, roll, pitch, yaw of the sensor in that link, which goes out to tf_static. Not given: the "
                    "link is the sensor's own frame (x ahead, y left, z up)."),
      textParameter("frame_id", &L::frame_id, "Frame of its messages, with a pose. Not given: the lidar's name."),
      textParameter("topic", &L::topic,
                    "Topic of its messages. Not given: NAME/scan (planar) or NAME/points (spatial)."),
      numberParameter("angle_min", "rad", -2.0 * kPi, 2.0 * kPi, &L::angle_min,
                      "Azimuth of the first ray, from x towards y."),
      numberParameter("angle_max", "rad", -2.0 * kPi, 2.0 * kPi, &L::angle_max,
                      "Azimuth of the last ray. At most a full turn above angle_min."),
      wholeParameter("samples", "-", 1.0, 100000.0, &L::samples, "Rays of a fan, the first and the last included."),
      numberParameter("vertical_angle_min", "rad", -0.5 * kPi, 0.5 * kPi, &L::vertical_angle_min,
                      "Elevation of the lowest fan; spatial only. Not given: -0.262 (15 degrees down)."),
      numberParameter("vertical_angle_max", "rad", -0.5 * kPi, 0.5 * kPi, &L::vertical_angle_max,
                      "Elevation of the highest fan; spatial only. Not given: 0.262 (15 degrees up)."),
      whole(numberParameter("rings", "-", 1.0, 1024.0, &L::rings, "Number of fans; spatial only. Not given: 16.")),
      numberParameter("range_min", "m", 0.0, 1e6, &L::range_min,
                      "What is measured nearer is too close to tell: -inf in a scan, no point in a cloud."),
      numberParameter("range_max", "m", 1e-3, 1e6, &L::range_max,
                      "What is measured farther is not seen: +inf in a scan, no point in a cloud."),
      numberParameter("rate", "Hz", 0.01, 1e6, &L::rate, "Scans per simulated second; at most one a tick."),
      numberParameter(
          "noise", "m", 0.0, 100.0, &L::noise,
          "Standard deviation of each range, normally distributed; a function of seed, scan and ray alone."),
      whole(numberParameter(
          "seed", "-", 0.0, 9007199254740992.0, &L::seed,
          "Whole number that its noise is made from. Not given: from noise_seed and the lidar's name.")),
      flagParameter("sees_own_vehicle", &L::sees_own_vehicle,
                    "The ellipsoids of the vehicle that carries it stop its rays, as other vehicles always do."),
  };
}

Problems checkLidar(const LidarSpec& spec, const std::string& where) {
  Problems problems;
  const double turn = 2.0 * kPi * (1.0 + 1e-9);
  if (!(spec.angle_min <= spec.angle_max) || spec.angle_max - spec.angle_min > turn) {
    problems.push_back({where + "angle_max", numbers("'%.6g' with angle_min '%.6g'", spec.angle_max, spec.angle_min) +
                                                 ", allowed is from angle_min to a full turn above it"});
  } else if ((spec.samples > 1.0) != (spec.angle_max > spec.angle_min)) {
    problems.push_back(
        {where + "samples", numbers("'%.0f' rays over %.6g rad", spec.samples, spec.angle_max - spec.angle_min) +
                                ": one ray has angle_min = angle_max, several have not"});
  }
  if (!(spec.range_min < spec.range_max))
    problems.push_back(
        {where + "range_min", numbers("'%.6g' is not below range_max '%.6g'", spec.range_min, spec.range_max)});
  if (spec.kind == LidarKind::kPlanar) {
    for (const auto& [key, given] : {std::make_pair("rings", spec.rings.has_value()),
                                     std::make_pair("vertical_angle_min", spec.vertical_angle_min.has_value()),
                                     std::make_pair("vertical_angle_max", spec.vertical_angle_max.has_value())})
      if (given) problems.push_back({where + key, "has no meaning with kind: planar; allowed with kind: spatial"});
  } else {
    const double low = spec.elevation(0), high = spec.vertical_angle_max.value_or(LidarSpec::kVerticalAngle);
    if (spec.fanCount() == 1 ? low != high : !(low < high))
      problems.push_back({where + "vertical_angle_max", numbers("'%.6g' with vertical_angle_min '%.6g'", high, low) +
                                                            ", allowed is more than that, or the same with one ring"});
    if (spec.samples * spec.fanCount() > kMostRays)
      problems.push_back({where + "rings", numbers("makes %.0f rays a scan, allowed are %.0f",
                                                   spec.samples * spec.fanCount(), kMostRays)});
  }
  if (spec.pose.empty() && !spec.frame_id.empty())
    problems.push_back(
        {where + "frame_id", "'" + spec.frame_id + "' without a pose: the frame is then the link itself"});
  return problems;
}

std::uint64_t lidarSeed(std::uint64_t noise_seed, const std::string& name) {
  // FNV-1a [FowlerNollVo].
  std::uint64_t hash = 14695981039346656037ull ^ noise_seed;
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ull;
  return hash;
}

}  // namespace ellipsoid_vehicle_sim
