#include "ellipsoid_vehicle_sim/world/mesh_report.h"

#include <algorithm>
#include <cmath>

#include "vertex_welder.h"

namespace ellipsoid_vehicle_sim {
namespace {

/// Welds vertices of equal keys.
template <typename KeyOf>
std::vector<std::uint32_t> weldByKey(const std::vector<Eigen::Vector3d>& vertices, KeyOf&& keyOf) {
  std::vector<std::uint32_t> weld(vertices.size());
  VertexTable table(vertices.size());
  const auto keyOfNumber = [&](std::uint32_t i) { return keyOf(vertices[i]); };
  for (std::uint32_t i = 0; i < vertices.size(); ++i) weld[i] = table.findOrEnter(keyOf(vertices[i]), i, keyOfNumber);
  return weld;
}

/// Entries grouped by a key below `keys`, in their own order: a counting sort.
template <typename Entry>
struct Groups {
  std::vector<std::uint32_t> begin;
  std::vector<Entry> entries;

  /// visit(emit) must call emit(key, entry) for the same entries each time.
  template <typename ForEach>
  Groups(std::size_t keys, ForEach&& for_each) : begin(keys + 1, 0) {
    for_each([this](std::uint32_t key, const Entry&) { ++begin[key + 1]; });
    for (std::size_t k = 0; k < keys; ++k) begin[k + 1] += begin[k];
    entries.resize(begin[keys]);
    for_each([this](std::uint32_t key, const Entry& entry) { entries[begin[key]++] = entry; });
    for (std::size_t k = keys; k > 0; --k) begin[k] = begin[k - 1];
    begin[0] = 0;
  }
};

using Corners = std::array<std::uint32_t, 3>;

void countEdges(const std::vector<Corners>& triangles, std::size_t vertex_count, MeshReport& report) {
  struct Edge {
    std::uint32_t other;
    bool upwards;  ///< runs from the lower vertex number to the higher.
  };
  Groups<Edge> edges(vertex_count, [&](auto&& emit) {
    for (const Corners& t : triangles) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t from = t[k], to = t[(k + 1) % 3];
        emit(std::min(from, to), Edge{std::max(from, to), from < to});
      }
    }
  });
  for (std::size_t v = 0; v < vertex_count; ++v) {
    const auto begin = edges.entries.begin() + edges.begin[v], end = edges.entries.begin() + edges.begin[v + 1];
    std::sort(begin, end, [](const Edge& a, const Edge& b) { return a.other < b.other; });
    for (auto first = begin; first != end;) {
      auto past = first;
      while (past != end && past->other == first->other) ++past;
      const auto uses = past - first;
      if (uses == 1) ++report.open_edges;
      if (uses > 2) ++report.nonmanifold_edges;
      if (uses == 2 && first->upwards == (first + 1)->upwards) ++report.flipped_edges;
      first = past;
    }
  }
}

void countDuplicates(const std::vector<Corners>& triangles, std::size_t vertex_count, MeshReport& report) {
  struct Rest {
    std::uint32_t low, high;  ///< the other two corners.
    bool upwards;             ///< lowest corner, low, high is the triangle's own sense.
  };
  Groups<Rest> groups(vertex_count, [&](auto&& emit) {
    for (const Corners& t : triangles) {
      const std::size_t k = static_cast<std::size_t>(std::min_element(t.begin(), t.end()) - t.begin());
      const std::uint32_t b = t[(k + 1) % 3], c = t[(k + 2) % 3];
      emit(t[k], Rest{std::min(b, c), std::max(b, c), b < c});
    }
  });
  for (std::size_t v = 0; v < vertex_count; ++v) {
    const auto begin = groups.entries.begin() + groups.begin[v], end = groups.entries.begin() + groups.begin[v + 1];
    std::sort(begin, end,
              [](const Rest& a, const Rest& b) { return a.low != b.low ? a.low < b.low : a.high < b.high; });
    for (auto first = begin; first != end;) {
      std::int64_t with = 0, against = 0;
      auto past = first;
      for (; past != end && past->low == first->low && past->high == first->high; ++past) {
        ++(past->upwards ? with : against);
      }
      report.duplicates += std::max<std::int64_t>(with - 1, 0) + std::max<std::int64_t>(against - 1, 0);
      report.opposite_duplicates += std::min(with, against);
      first = past;
    }
  }
}

}  // namespace

std::vector<std::uint32_t> weldVertices(const std::vector<Eigen::Vector3d>& vertices, double tolerance) {
  if (!(tolerance > 0.0)) {
    return weldByKey(vertices, [](const Eigen::Vector3d& v) { return VertexKey(v.x(), v.y(), v.z()); });
  }
  const double per_step = 1.0 / tolerance;
  const auto step = [per_step](double x) { return std::nearbyint(x * per_step); };
  return weldByKey(vertices, [step](const Eigen::Vector3d& v) { return VertexKey(step(v.x()), step(v.y()), step(v.z())); });
}

MeshReport inspectMesh(const std::vector<Eigen::Vector3d>& vertices, const std::vector<Corners>& triangles) {
  MeshReport report;
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& v : vertices) box.extend(v);
  if (triangles.empty()) return report;
  const std::vector<std::uint32_t> weld = weldVertices(vertices, kReportWeldRatio * box.diagonal().norm());
  std::vector<Corners> welded;
  welded.reserve(triangles.size());
  for (const Corners& t : triangles) {
    const Corners w = {weld[t[0]], weld[t[1]], weld[t[2]]};
    if (w[0] != w[1] && w[1] != w[2] && w[2] != w[0]) welded.push_back(w);
  }
  countEdges(welded, vertices.size(), report);
  countDuplicates(welded, vertices.size(), report);
  return report;
}

}  // namespace ellipsoid_vehicle_sim
