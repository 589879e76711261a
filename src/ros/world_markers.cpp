#include "ellipsoid_vehicle_sim/ros/world_markers.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <numeric>
#include <utility>

#include "ellipsoid_vehicle_sim/ros/conversions.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr std::size_t kTrianglesPerMarker = 100000;
// Far enough behind the front that the depth buffer tells them apart at 100 m (near plane 0.1 m, 24 bits), near enough
// not to come out of a thin plate.
constexpr double kBackOffset = 0.005;  // [m]
// The cube follows the vehicle once it has come this share of the way to its border.
constexpr double kFollowShare = 0.5;

using Rgb = std::array<double, 3>;

/// Colours of surfaces that are named like one of these, in any case.
constexpr std::array<std::pair<const char*, Rgb>, 10> kNamedColors = {{{"asphalt", {0.46, 0.47, 0.50}},
                                                                       {"concrete", {0.76, 0.68, 0.56}},
                                                                       {"dirt", {0.52, 0.38, 0.26}},
                                                                       {"grass", {0.42, 0.54, 0.28}},
                                                                       {"gravel", {0.62, 0.58, 0.52}},
                                                                       {"ice", {0.70, 0.86, 0.94}},
                                                                       {"kerb", {0.42, 0.58, 0.80}},
                                                                       {"sand", {0.86, 0.78, 0.54}},
                                                                       {"snow", {0.94, 0.95, 0.97}},
                                                                       {"wood", {0.66, 0.48, 0.30}}}};
/// Colours of the others in order; more surfaces start again.
constexpr std::array<Rgb, 6> kSurfaceColors = {{{0.62, 0.66, 0.60},
                                                {0.72, 0.58, 0.40},
                                                {0.46, 0.60, 0.76},
                                                {0.76, 0.74, 0.44},
                                                {0.74, 0.50, 0.50},
                                                {0.48, 0.70, 0.52}}};
constexpr Rgb kBackColor = {0.27, 0.12, 0.34};

/// Light from above and the side: 0.35 in the shade, 1 facing it. RViz does not shade triangles that have colours.
double brightness(const Eigen::Vector3d& nhat_W) {
  static const Eigen::Vector3d kToLight = Eigen::Vector3d(0.4, -0.5, 0.77).normalized();
  return 0.35 + 0.65 * std::max(0.0, nhat_W.dot(kToLight));
}

std_msgs::ColorRGBA shaded(const Rgb& color, double light) {
  return toColor(light * color[0], light * color[1], light * color[2], 1.0);
}

Rgb colorOf(const std::string& surface, std::size_t index) {
  std::string name = surface;
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
  for (const auto& [known, color] : kNamedColors) {
    if (name.find(known) != std::string::npos) return color;
  }
  return kSurfaceColors[index % kSurfaceColors.size()];
}

void addTriangle(const Triangle& triangle, const Rgb& color, visualization_msgs::Marker& marker) {
  for (const Eigen::Vector3d& corner : triangle.v) marker.points.push_back(toPoint(corner));
  marker.colors.push_back(shaded(color, brightness(triangle.nhat_W)));
  // Seen from behind, this copy covers the front's; seen from the front, the front covers it.
  for (const int corner : {0, 2, 1}) {
    marker.points.push_back(toPoint(triangle.v[static_cast<std::size_t>(corner)] - kBackOffset * triangle.nhat_W));
  }
  marker.colors.push_back(shaded(kBackColor, brightness(-triangle.nhat_W)));
}

}  // namespace

WorldMarkers::WorldMarkers(std::shared_ptr<const Terrain> terrain, std::string frame, int limit)
    : terrain_(std::move(terrain)),
      frame_(std::move(frame)),
      limit_(static_cast<std::size_t>(limit)),
      partial_(terrain_->triangleCount() > limit) {}

std::vector<int> WorldMarkers::trianglesAround(const Eigen::Vector3d& centre) {
  std::vector<int> triangles;
  if (!partial_) {
    triangles.resize(static_cast<std::size_t>(terrain_->triangleCount()));
    std::iota(triangles.begin(), triangles.end(), 0);
    return triangles;
  }
  // Halving: exact enough for a picture, and cheap: each query costs about what it returns.
  double low = 0.0, high = terrain_->bounds().diagonal().norm();
  for (int i = 0; i < 12; ++i) {
    const double half = 0.5 * (low + high);
    const Eigen::Vector3d reach = Eigen::Vector3d::Constant(half);
    triangles.clear();
    terrain_->query(Eigen::AlignedBox3d(Eigen::Vector3d(centre - reach), Eigen::Vector3d(centre + reach)), triangles);
    (triangles.size() > limit_ ? high : low) = half;
  }
  half_edge_ = low;
  const Eigen::Vector3d reach = Eigen::Vector3d::Constant(low);
  triangles.clear();
  terrain_->query(Eigen::AlignedBox3d(Eigen::Vector3d(centre - reach), Eigen::Vector3d(centre + reach)), triangles);
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

std::optional<visualization_msgs::MarkerArray> WorldMarkers::update(const Eigen::Vector3d& centre) {
  if (sent_ && (!partial_ || (centre - centre_).cwiseAbs().maxCoeff() < kFollowShare * half_edge_)) return std::nullopt;
  sent_ = true;
  centre_ = centre;
  const std::vector<int> triangles = trianglesAround(centre);

  // Each triangle is drawn twice, so a marker takes half as many.
  constexpr std::size_t kPerMarker = kTrianglesPerMarker / 2;
  std::vector<Rgb> colors;
  for (const Surface& surface : terrain_->surfaces()) colors.push_back(colorOf(surface.name, colors.size()));
  visualization_msgs::MarkerArray markers;
  const std::size_t count = std::max<std::size_t>(1, (triangles.size() + kPerMarker - 1) / kPerMarker);
  for (std::size_t chunk = 0; chunk < count; ++chunk) {
    visualization_msgs::Marker marker;
    marker.header.frame_id = frame_;  // stamp 0: the world does not move
    marker.ns = "world";
    marker.id = static_cast<int>(chunk);
    marker.type = visualization_msgs::Marker::TRIANGLE_LIST;
    marker.action = visualization_msgs::Marker::ADD;
    marker.pose.orientation.w = 1.0;
    marker.scale.x = marker.scale.y = marker.scale.z = 1.0;
    marker.color = toColor(1.0, 1.0, 1.0, 1.0);
    const std::size_t end = std::min(triangles.size(), (chunk + 1) * kPerMarker);
    for (std::size_t i = chunk * kPerMarker; i < end; ++i) {
      const auto surface = static_cast<std::size_t>(terrain_->surfaceIndex(triangles[i]));
      addTriangle(terrain_->triangle(triangles[i]), colors[surface], marker);
    }
    // A list without triangles is an error to RViz: off the edge of the world there is nothing to show.
    if (marker.points.empty()) marker.action = visualization_msgs::Marker::DELETE;
    markers.markers.push_back(std::move(marker));
  }
  for (int id = static_cast<int>(count); id < chunks_; ++id) {
    visualization_msgs::Marker gone;
    gone.header.frame_id = frame_;
    gone.ns = "world";
    gone.id = id;
    gone.action = visualization_msgs::Marker::DELETE;
    markers.markers.push_back(gone);
  }
  chunks_ = static_cast<int>(count);
  return markers;
}

}  // namespace ellipsoid_vehicle_sim
