#include "ellipsoid_vehicle_sim/sensors/lidar_mount.h"

#include <algorithm>
#include <cctype>
#include <cstdio>

namespace ellipsoid_vehicle_sim {
namespace {

constexpr double kDegrees = 57.29577951308232;

bool isName(const std::string& text) {
  return !text.empty() && std::isalpha(static_cast<unsigned char>(text.front())) != 0 &&
         std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; });
}

}  // namespace

std::string NamedLidar::frame(const VehicleDescription& vehicle) const {
  if (spec.pose.empty()) return link(vehicle);
  return spec.frame_id.empty() ? name : spec.frame_id;
}

std::string NamedLidar::topic() const {
  if (!spec.topic.empty()) return spec.topic;
  return name + (spec.kind == LidarKind::kPlanar ? "/scan" : "/points");
}

std::uint64_t NamedLidar::seed(std::uint64_t noise_seed) const {
  return spec.seed ? static_cast<std::uint64_t>(*spec.seed) : lidarSeed(noise_seed, name);
}

Problems takeLidars(const std::vector<std::string>& names, const std::string& where, ParameterValues& values,
                    std::vector<NamedLidar>& lidars) {
  Problems problems;
  const auto table = lidarParameters();
  for (const std::string& name : names) {
    auto lidar = std::find_if(lidars.begin(), lidars.end(), [&](const NamedLidar& l) { return l.name == name; });
    if (lidar == lidars.end()) lidar = lidars.insert(lidars.end(), NamedLidar{name, LidarSpec{}});
    const std::string prefix = name + "/";
    ParameterValues own;
    for (auto it = values.lower_bound(prefix);
         it != values.end() && it->first.compare(0, prefix.size(), prefix) == 0;) {
      own.emplace(it->first.substr(prefix.size()), it->second);
      it = values.erase(it);
    }
    for (const Problem& p : takeParameters(table, where + prefix, own, lidar->spec)) problems.push_back(p);
    for (const Problem& p : unknownParameters(own, parameterKeys(table), where + prefix)) problems.push_back(p);
  }
  return problems;
}

Problems checkLidars(const std::vector<std::string>& names, const std::vector<NamedLidar>& lidars) {
  Problems problems;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (!isName(names[i]))
      problems.push_back(
          {"~lidars", "'" + names[i] + "' is no name, allowed are letters, digits and _, a letter first"});
    if (std::find(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(i), names[i]) !=
        names.begin() + static_cast<std::ptrdiff_t>(i))
      problems.push_back({"~lidars", "'" + names[i] + "' stands there twice"});
  }
  for (std::size_t i = 0; i < lidars.size(); ++i) {
    const NamedLidar& lidar = lidars[i];
    for (const Problem& p : checkLidar(lidar.spec, "~" + lidar.name + "/")) problems.push_back(p);
    for (std::size_t k = 0; k < i; ++k)
      if (lidars[k].topic() == lidar.topic())
        problems.push_back({"~" + lidar.name + "/topic", "'" + lidar.topic() + "' is lidar '" + lidars[k].name + "'s"});
  }
  return problems;
}

Problems checkMounts(const std::vector<NamedLidar>& lidars, const VehicleDescription& vehicle) {
  Problems problems;
  const auto hasLink = [&vehicle](const std::string& name) {
    return std::any_of(vehicle.links.begin(), vehicle.links.end(),
                       [&name](const LinkDescription& link) { return link.name == name; });
  };
  std::string links;
  for (const LinkDescription& link : vehicle.links) links += (links.empty() ? "" : ", ") + link.name;
  for (std::size_t i = 0; i < lidars.size(); ++i) {
    const NamedLidar& lidar = lidars[i];
    if (!hasLink(lidar.link(vehicle)))
      problems.push_back(
          {"~" + lidar.name + "/link", "the vehicle has no link '" + lidar.spec.link + "'; there are: " + links});
    if (lidar.spec.pose.empty()) continue;
    const std::string frame = lidar.frame(vehicle);
    if (hasLink(frame))
      problems.push_back(
          {"~" + lidar.name + "/frame_id", "'" + frame +
                                               "' is a link of the vehicle already: leave out the "
                                               "pose and name it as link, or give the frame another name"});
    for (std::size_t k = 0; k < i; ++k)
      if (!lidars[k].spec.pose.empty() && lidars[k].frame(vehicle) == frame)
        problems.push_back({"~" + lidar.name + "/frame_id", "'" + frame + "' is lidar '" + lidars[k].name + "'s"});
  }
  return problems;
}

std::string lidarReport(const NamedLidar& lidar, const VehicleDescription& vehicle) {
  const LidarSpec& spec = lidar.spec;
  char text[400];
  std::snprintf(
      text, sizeof text,
      "lidar '%s': %d x %d rays, azimuth %.4g ... %.4g deg, elevation %.4g ... %.4g deg, %.4g ... %.4g m, noise "
      "%.3g m, %.4g Hz, on link '%s', frame '%s', topic %s%s",
      lidar.name.c_str(), spec.fanCount(), spec.fanSize(), kDegrees * spec.angle_min, kDegrees * spec.angle_max,
      kDegrees * spec.elevation(0), kDegrees * spec.elevation(spec.fanCount() - 1), spec.range_min, spec.range_max,
      spec.noise, spec.rate, lidar.link(vehicle).c_str(), lidar.frame(vehicle).c_str(), lidar.topic().c_str(),
      spec.sees_own_vehicle ? ", sees its own vehicle" : "");
  return text;
}

}  // namespace ellipsoid_vehicle_sim
