#include "ellipsoid_vehicle_sim/scene/free_straight.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace ellipsoid_vehicle_sim {
namespace {

using Eigen::Vector3d;

constexpr double kSample = 0.05;    // along the way, and at most across it [m]
constexpr double kSlope = 0.1;      // that counts as a way [-]
constexpr double kSpare = 0.6;      // of the clearance, before and behind a bump the body pitches
constexpr int kHeadings = 16;
constexpr int kGrid = 12;           // starts along each side of the world
constexpr double kMargin = 0.05;    // beside the vehicle [m]

// The lines along which the way is felt, from right to left [m].
std::vector<double> lanes(const Footprint& f) {
  const double half = f.half_width + kMargin;
  const int count = std::clamp(static_cast<int>(std::ceil(2.0 * half / 0.1)), 4, 24);
  std::vector<double> offsets;
  for (int i = 0; i <= count; ++i) offsets.push_back(half * (2.0 * i / count - 1.0));
  return offsets;
}

using Row = std::vector<Vector3d>;

/// Whether the newest row lets a vehicle of so many rows stand over those before it.
bool follows(const std::vector<Row>& rows, std::size_t length, const Footprint& f) {
  if (rows.size() <= length) return true;
  const Row &ahead = rows.back(), &behind = rows[rows.size() - 1 - length], &between = rows[rows.size() - 1 - length / 2];
  for (std::size_t i = 0; i < ahead.size(); ++i) {
    const double bump = between[i].z() - 0.5 * (ahead[i].z() + behind[i].z());
    if (bump > kSpare * f.clearance || -bump > f.hollow) return false;
  }
  const auto roll = [](const Row& row) { return row.back().z() - row.front().z(); };
  return std::abs(roll(ahead) - roll(behind)) <= f.warp;
}

}  // namespace

std::optional<double> groundBelow(const Terrain& terrain, double x, double y) {
  for (const HeightHit& hit : terrain.heights(x, y))
    if (hit.faces_up) return hit.z;
  return std::nullopt;
}

double freeStraight(const Terrain& terrain, const Footprint& f, const WorldStart& start, double longest) {
  const Vector3d ahead(std::cos(start.yaw), std::sin(start.yaw), 0.0), left(-ahead.y(), ahead.x(), 0.0);
  const Vector3d from(start.x, start.y, 0.0);
  const std::vector<double> across = lanes(f);
  const double levels[] = {1.5 * f.step, 0.35 * f.height, 0.7 * f.height, f.height};
  Row last;
  std::vector<Row> rows;
  const auto length = static_cast<std::size_t>(std::max(2.0, (f.front + f.rear) / kSample));
  double reached = -f.rear - kSample;
  for (double s = -f.rear; s <= f.front + longest + 1e-9; s += kSample) {
    Row row;
    for (const double offset : across) {
      Vector3d p = from + s * ahead + offset * left;
      const auto z = groundBelow(terrain, p.x(), p.y());
      if (!z) break;
      p.z() = *z;
      row.push_back(p);
    }
    bool open = row.size() == across.size();
    for (std::size_t i = 0; open && i < row.size(); ++i) {
      const auto rises = [&](const Vector3d& q) {
        return std::abs(row[i].z() - q.z()) > f.step + kSlope * (row[i] - q).head<2>().norm();
      };
      if (i > 0 && rises(row[i - 1])) open = false;
      if (last.empty()) continue;
      if (rises(last[i])) open = false;
      for (const double level : levels) {
        const Vector3d up(0.0, 0.0, level);
        if (terrain.firstFrontCrossing(last[i] + up, row[i] + up)) open = false;
      }
      // A wall between two lanes, seen from either side.
      if (i > 0) {
        const Vector3d up(0.0, 0.0, levels[1]);
        if (terrain.firstFrontCrossing(row[i - 1] + up, row[i] + up) ||
            terrain.firstFrontCrossing(row[i] + up, row[i - 1] + up))
          open = false;
      }
    }
    if (open) rows.push_back(row);
    if (!open || !follows(rows, length, f)) break;
    last = std::move(row);
    reached = s;
  }
  return std::min(longest, reached - f.front);
}

std::vector<FreeStraight> findFreeStraights(const Terrain& terrain, const Footprint& footprint,
                                            const WorldStart& preferred, double longest) {
  std::vector<FreeStraight> found;
  const auto look = [&](double x, double y, double yaw) {
    const WorldStart start{x, y, yaw};
    const double length = freeStraight(terrain, footprint, start, longest);
    if (length > 0.0) found.push_back({start, length});
    return length;
  };
  const auto lookAround = [&](double x, double y, double first_yaw) {
    if (!groundBelow(terrain, x, y)) return;
    for (int h = 0; h < kHeadings; ++h)
      if (look(x, y, first_yaw + 2.0 * M_PI * h / kHeadings) >= longest) return;
  };
  lookAround(preferred.x, preferred.y, preferred.yaw);
  if (found.empty() || found.back().length < longest) {
    const Eigen::AlignedBox3d box = terrain.bounds();
    int whole = 0;
    for (int i = 0; i < kGrid && whole < 8; ++i)
      for (int j = 0; j < kGrid && whole < 8; ++j) {
        // Every cell in an order that soon has been everywhere; off the lines that meshes like to have their corners on.
        const int a = (5 * i + 3) % kGrid, b = (7 * j + 5 * i) % kGrid;
        const Vector3d at = box.min() + Vector3d((a + 0.513) / kGrid, (b + 0.487) / kGrid, 0.0).cwiseProduct(box.sizes());
        lookAround(at.x(), at.y(), 0.0);
        if (!found.empty() && found.back().length >= longest) ++whole;
      }
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const FreeStraight& a, const FreeStraight& b) { return a.length > b.length; });
  return found;
}

}  // namespace ellipsoid_vehicle_sim
