#include "ellipsoid_vehicle_sim/world/terrain.h"

#include <algorithm>
#include <cmath>
#include <future>
#include <limits>

#include "ellipsoid_vehicle_sim/world/mesh_report.h"
#include "ellipsoid_vehicle_sim/world/mesh_tree.h"

namespace ellipsoid_vehicle_sim {
namespace {

// A thread costs some tens of microseconds; the report of so many triangles takes milliseconds.
constexpr std::size_t kTrianglesWorthAThread = 50000;

using Corners = std::array<std::uint32_t, 3>;
using Eigen::Vector3d;

/// Unit roundoff with some room for the few operations of a determinant.
constexpr double kRounding = 16.0 * std::numeric_limits<double>::epsilon();

/// Two hits on edges of their triangles nearer than this [m] are hits on one seam.
constexpr double kSeamHeight = 1e-9;

void checkSoup(const TriangleSoup& soup, Problems& problems) {
  if (soup.triangles.empty()) problems.push_back({"terrain", "no triangles; a world needs at least one"});
  if (soup.triangles.size() > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max())) {
    problems.push_back({"terrain", std::to_string(soup.triangles.size()) + " triangles; allowed are up to 2147483647"});
  }
  if (!soup.surface.empty() && soup.surface.size() != soup.triangles.size()) {
    problems.push_back({"terrain", std::to_string(soup.surface.size()) + " surface numbers for " +
                                       std::to_string(soup.triangles.size()) + " triangles"});
  }
  const std::size_t surface_count = std::max<std::size_t>(soup.surfaces.size(), 1);
  for (std::size_t i = 0; i < soup.surface.size(); ++i) {
    if (soup.surface[i] < surface_count) continue;
    problems.push_back({"terrain triangle " + std::to_string(i),
                        "surface number " + std::to_string(soup.surface[i]) + " of " + std::to_string(surface_count)});
    break;
  }
  for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
    for (const std::uint32_t v : soup.triangles[i]) {
      const auto where = [i]() { return "terrain triangle " + std::to_string(i); };
      if (v >= soup.vertices.size()) {
        problems.push_back(
            {where(), "vertex number " + std::to_string(v) + " of " + std::to_string(soup.vertices.size())});
        return;
      }
      const Vector3d& p = soup.vertices[v];
      // The comparison is false for NaN.
      if (!(p.array().abs() <= kLargestCoordinate).all()) {
        problems.push_back({where(), "corner (" + std::to_string(p.x()) + ", " + std::to_string(p.y()) + ", " +
                                         std::to_string(p.z()) + ") m; allowed are finite coordinates up to 1e9 m"});
        return;
      }
    }
  }
}

/// Twice the signed area of (a, b, p) seen from +z, with a bound of its rounding error. Exactly antisymmetric in a and
/// b, so that two triangles see the same number, with opposite signs, along the edge they share.
struct SignedValue {
  double value, error;
};

SignedValue area2d(const Vector3d& a, const Vector3d& b, double x, double y) {
  const double ax = a.x() - x, ay = a.y() - y, bx = b.x() - x, by = b.y() - y;
  const double left = ax * by, right = ay * bx;
  return {left - right, kRounding * (std::abs(left) + std::abs(right))};
}

/// Six times the signed volume of (p, q, e0, e1), likewise, for d = q - p.
SignedValue volume(const Vector3d& p, const Vector3d& d, const Vector3d& e0, const Vector3d& e1) {
  const Vector3d r0 = e0 - p, r1 = e1 - p;
  const double value = d.dot(r0.cross(r1));
  return {value, kRounding * d.norm() * r0.norm() * r1.norm()};
}

}  // namespace

struct Terrain::Impl {
  std::vector<Vector3d> vertices;
  std::vector<Corners> triangles;
  std::vector<std::uint16_t> surface;  ///< empty when there is one surface only.
  std::vector<Surface> surfaces;
  MeshTree tree;
  MeshReport report;

  const Vector3d& corner(int i, std::size_t k) const { return vertices[triangles[static_cast<std::size_t>(i)][k]]; }

  bool boxMeets(int i, const Eigen::AlignedBox3d& box) const {
    const Vector3d &a = corner(i, 0), &b = corner(i, 1), &c = corner(i, 2);
    return (a.cwiseMin(b).cwiseMin(c).array() <= box.max().array()).all() &&
           (a.cwiseMax(b).cwiseMax(c).array() >= box.min().array()).all();
  }
};

namespace {

/// Renumbers to one vertex per position, in order of first use, and drops what no triangle uses.
void compactVertices(TriangleSoup& soup) {
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  const std::vector<std::uint32_t> weld = weldVertices(soup.vertices, 0.0);
  std::vector<std::uint32_t> number(soup.vertices.size(), kNone);
  std::size_t used = 0;
  for (const Corners& t : soup.triangles) {
    for (const std::uint32_t v : t) {
      if (number[weld[v]] == kNone) number[weld[v]] = static_cast<std::uint32_t>(used++);
    }
  }
  std::vector<Vector3d> vertices(used);
  for (std::size_t v = 0; v < number.size(); ++v) {
    if (number[v] != kNone) vertices[number[v]] = soup.vertices[v];
  }
  for (Corners& t : soup.triangles) {
    for (std::uint32_t& v : t) v = number[weld[v]];
  }
  soup.vertices = std::move(vertices);
}

/// Keeps the triangles with area, in order; returns how many there were without.
std::int64_t dropZeroArea(TriangleSoup& soup) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
    const Corners t = soup.triangles[i];
    const std::array<Vector3d, 3> v = {soup.vertices[t[0]], soup.vertices[t[1]], soup.vertices[t[2]]};
    const bool has_area = doubleAreaVector(v).norm() > kNoAreaRatio * longestEdgeSquared(v);
    if (!has_area) continue;
    soup.triangles[kept] = t;
    if (!soup.surface.empty()) soup.surface[kept] = soup.surface[i];
    ++kept;
  }
  const std::size_t dropped = soup.triangles.size() - kept;
  soup.triangles.resize(kept);
  if (!soup.surface.empty()) soup.surface.resize(kept);
  return static_cast<std::int64_t>(dropped);
}

}  // namespace

Loaded<Terrain> Terrain::build(TriangleSoup soup) {
  Loaded<Terrain> result;
  checkSoup(soup, result.problems);
  if (!result.problems.empty()) return result;

  if (soup.surfaces.empty()) soup.surfaces.push_back({"terrain", std::nullopt, std::nullopt});
  if (soup.surfaces.size() == 1) soup.surface.clear();
  const std::int64_t read = static_cast<std::int64_t>(soup.triangles.size());
  const std::int64_t zero_area = dropZeroArea(soup);
  if (soup.triangles.empty()) {
    result.problems.push_back({"terrain", "all " + std::to_string(read) + " triangles have no area"});
    return result;
  }
  compactVertices(soup);

  auto impl = std::make_unique<Impl>();
  impl->vertices = std::move(soup.vertices);
  impl->triangles = std::move(soup.triangles);
  impl->surface = std::move(soup.surface);
  impl->surfaces = std::move(soup.surfaces);
  impl->triangles.shrink_to_fit();
  impl->surface.shrink_to_fit();
  // Both only read the corners: in a large world the report is made beside the tree, on a second core.
  const auto inspect = [&impl] { return inspectMesh(impl->vertices, impl->triangles); };
  const bool large = impl->triangles.size() > kTrianglesWorthAThread;
  std::future<MeshReport> report = std::async(large ? std::launch::async : std::launch::deferred, inspect);
  impl->tree = MeshTree(impl->vertices, impl->triangles);
  impl->report = report.get();
  impl->report.read = read;
  impl->report.zero_area = zero_area;
  result.value = Terrain(std::move(impl));
  return result;
}

Terrain::Terrain(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Terrain::Terrain(Terrain&&) noexcept = default;
Terrain& Terrain::operator=(Terrain&&) noexcept = default;
Terrain::~Terrain() = default;

int Terrain::triangleCount() const { return static_cast<int>(impl_->triangles.size()); }

Triangle Terrain::triangle(int i) const {
  return makeTriangle(impl_->corner(i, 0), impl_->corner(i, 1), impl_->corner(i, 2));
}

void Terrain::corners(int i, std::array<Vector3d, 3>& v) const {
  const Corners& corners = impl_->triangles[static_cast<std::size_t>(i)];
  for (std::size_t k = 0; k < 3; ++k) v[k] = impl_->vertices[corners[k]];
}

void Terrain::prefetchCorners(const std::vector<int>& triangles) const {
  for (const int i : triangles)
    for (const std::uint32_t v : impl_->triangles[static_cast<std::size_t>(i)]) __builtin_prefetch(&impl_->vertices[v]);
}

int Terrain::surfaceIndex(int i) const {
  return impl_->surface.empty() ? 0 : impl_->surface[static_cast<std::size_t>(i)];
}

const Surface& Terrain::surface(int i) const { return impl_->surfaces[static_cast<std::size_t>(surfaceIndex(i))]; }

const std::vector<Surface>& Terrain::surfaces() const { return impl_->surfaces; }

Eigen::AlignedBox3d Terrain::bounds() const { return impl_->tree.bounds(); }

const MeshReport& Terrain::report() const { return impl_->report; }

std::size_t Terrain::memoryBytes() const {
  const auto bytes = [](const auto& v) { return v.capacity() * sizeof(v[0]); };
  return sizeof(Impl) + bytes(impl_->vertices) + bytes(impl_->triangles) + bytes(impl_->surface) +
         bytes(impl_->surfaces) + impl_->tree.memoryBytes();
}

void Terrain::query(const Eigen::AlignedBox3d& box, std::vector<int>& out) const {
  impl_->tree.visit(box, [&](int i, bool certain) {
    if (certain || impl_->boxMeets(i, box)) out.push_back(i);
  });
}

void Terrain::candidates(const Eigen::AlignedBox3d& box, std::vector<int>& out) const {
  impl_->tree.visit(box, [&](int i, bool) {
    __builtin_prefetch(&impl_->triangles[static_cast<std::size_t>(i)]);
    out.push_back(i);
  });
}

bool Terrain::mayMeet(const Eigen::AlignedBox3d& box) const { return impl_->tree.mayMeet(box); }

std::vector<HeightHit> Terrain::heights(double x, double y) const {
  struct Hit {
    HeightHit hit;
    bool on_edge;
  };
  std::vector<Hit> hits;
  Eigen::AlignedBox3d line = bounds();
  line.min().head<2>() = line.max().head<2>() = Eigen::Vector2d(x, y);
  impl_->tree.visit(line, [&](int i, bool) {
    const Vector3d &a = impl_->corner(i, 0), &b = impl_->corner(i, 1), &c = impl_->corner(i, 2);
    const SignedValue wa = area2d(b, c, x, y), wb = area2d(c, a, x, y), wc = area2d(a, b, x, y);
    const double area = wa.value + wb.value + wc.value, error = wa.error + wb.error + wc.error;
    // A vertical triangle is met along a line or not at all; its neighbours say where that line begins and ends.
    if (std::abs(area) <= error) return;
    const double sign = area > 0.0 ? 1.0 : -1.0;
    if (sign * wa.value < -wa.error || sign * wb.value < -wb.error || sign * wc.value < -wc.error) return;
    const bool on_edge =
        std::abs(wa.value) <= wa.error || std::abs(wb.value) <= wb.error || std::abs(wc.value) <= wc.error;
    const double z = (wa.value * a.z() + wb.value * b.z() + wc.value * c.z()) / area;
    hits.push_back({{z, area > 0.0, i}, on_edge});
  });
  std::sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) {
    return a.hit.z != b.hit.z ? a.hit.z > b.hit.z : a.hit.triangle < b.hit.triangle;
  });

  std::vector<HeightHit> result;
  std::vector<Hit> seams;  // kept hits that lie on an edge
  for (const Hit& h : hits) {
    const auto sameSeam = [&](const Hit& kept) {
      return h.on_edge && kept.hit.faces_up == h.hit.faces_up &&
             kept.hit.z - h.hit.z <= kSeamHeight + kRounding * std::abs(h.hit.z);
    };
    if (std::any_of(seams.begin(), seams.end(), sameSeam)) continue;
    result.push_back(h.hit);
    if (h.on_edge) seams.push_back(h);
  }
  return result;
}

std::optional<int> Terrain::firstFrontCrossing(const Vector3d& a, const Vector3d& b) const {
  std::optional<int> first;
  double first_time = 0.0;
  const Vector3d d = b - a;
  if (!a.allFinite() || !b.allFinite()) return first;
  impl_->tree.visitAlong(a, b, [&](int i) {
    const Triangle t = triangle(i);
    // Heights over the plane. A start within rounding of it counts as in front and an end only when it is clearly
    // behind; the two margins overlap, so that of two touching triangles one takes a segment that starts or ends on
    // them.
    const double above_a = t.nhat_W.dot(a - t.v[0]), above_b = t.nhat_W.dot(b - t.v[0]);
    const double error_a = kRounding * ((a - t.v[0]).norm() + t.v[0].norm());
    const double error_b = kRounding * ((b - t.v[0]).norm() + t.v[0].norm());
    if (above_a < -2.0 * error_a || above_b >= -error_b || above_b >= above_a) return;
    for (std::size_t k = 0; k < 3; ++k) {
      const SignedValue side = volume(a, d, t.v[k], t.v[(k + 1) % 3]);
      // Front to back means against the normal: the line passes the edges clockwise.
      if (side.value > side.error) return;
    }
    const double time = std::max(0.0, above_a / (above_a - above_b));
    if (!first || time < first_time || (time == first_time && i < *first)) first = i, first_time = time;
  });
  return first;
}

}  // namespace ellipsoid_vehicle_sim
