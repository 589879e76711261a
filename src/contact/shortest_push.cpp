#include "ellipsoid_vehicle_sim/contact/shortest_push.h"

#include <Eigen/LU>

namespace ellipsoid_vehicle_sim {
namespace {

// A determinant of unit normals below this means that they are parallel to rounding; the larger set adds nothing then.
constexpr double kParallel = 1e-12;

using Vectors = std::array<Eigen::Vector3d, kMaxContactsPerEllipsoid>;
using Numbers = std::array<double, kMaxContactsPerEllipsoid>;

// Multipliers that make all constraints of the set {members[0..size)} active; false if they are dependent.
bool activeSet(const Vectors& nhat, const Numbers& depth, const int* members, int size, Numbers& weight) {
  weight = {};
  if (size == 1) {
    weight[members[0]] = depth[members[0]];
    return true;
  }
  if (size == 2) {
    const int i = members[0], j = members[1];
    const double c = nhat[i].dot(nhat[j]);
    const double det = nhat[i].cross(nhat[j]).squaredNorm();
    if (det < kParallel) return false;
    weight[i] = (depth[i] - c * depth[j]) / det;
    weight[j] = (depth[j] - c * depth[i]) / det;
    return true;
  }
  Eigen::Matrix3d N;
  N << nhat[0], nhat[1], nhat[2];
  const double det = N.determinant();
  if (det * det < kParallel) return false;
  const Eigen::Matrix3d gram = N.transpose() * N;
  const Eigen::Vector3d a = gram.inverse() * Eigen::Vector3d(depth[0], depth[1], depth[2]);
  weight = {a[0], a[1], a[2]};
  return true;
}

}  // namespace

ShortestPush shortestPush(const Vectors& nhat, const Numbers& depth, int count) {
  ShortestPush best;
  if (count == 1) {
    if (depth[0] > 0.0) {
      best.weight[0] = depth[0];
      best.p = depth[0] * nhat[0];
    }
    return best;
  }

  // Small sets first: the optimum of a convex program is unique, so the first set that satisfies all conditions is it.
  static constexpr int kSets[7][4] = {{1, 0, -1, -1}, {1, 1, -1, -1}, {1, 2, -1, -1}, {2, 0, 1, -1},
                                      {2, 0, 2, -1},  {2, 1, 2, -1},  {3, 0, 1, 2}};
  double best_length = -1.0;
  for (const auto& set : kSets) {
    const int size = set[0];
    const int* members = set + 1;
    if (members[size - 1] >= count || (size == 3 && count < 3)) continue;
    Numbers weight;
    if (!activeSet(nhat, depth, members, size, weight)) continue;
    bool pushes = true;
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
    for (int i = 0; i < count; ++i) {
      pushes = pushes && weight[i] >= 0.0;
      p += weight[i] * nhat[i];
    }
    if (!pushes) continue;
    bool clears = true;
    for (int i = 0; i < count; ++i) clears = clears && p.dot(nhat[i]) >= depth[i] - 1e-12 * (1.0 + depth[i]);
    const double length = p.squaredNorm();
    if (clears) return {p, weight};
    // Kept in case nothing clears all of them (opposite normals: pinched between two faces).
    if (length > best_length) {
      best_length = length;
      best = {p, weight};
    }
  }
  return best;
}

}  // namespace ellipsoid_vehicle_sim
