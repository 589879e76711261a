#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/geometry/ellipsoid_triangle.h"

namespace ellipsoid_vehicle_sim::test {

/// What one rule answers in one row of contact vectors, computed at 50 digits.
struct ExpectedContact {
  bool hit = false;
  Eigen::Vector3d p_W, nhat_W, e_W;  ///< triangle point, push direction, ellipsoid point.
  double depth = 0.0;
  std::string feature;
  int flag = 0;       ///< bits, see `kAnswerJumps` and on.
  double cond = 0.0;  ///< largest change of any output per unit relative change of the inputs.
};

constexpr int kAnswerJumps = 1;  ///< under a perturbation of 1e-9: not unique.
constexpr int kNameJumps = 2;    ///< only the feature's name does.
constexpr int kNearFold = 4;     ///< cond > 1e5.
constexpr int kContinuum = 8;    ///< a continuum or a mirror pair of solutions.
constexpr int kNotComparable = kAnswerJumps | kNearFold | kContinuum;

struct ContactVector {
  int id = 0;
  std::string category;
  PosedEllipsoid ellipsoid;
  Triangle triangle;
  ExpectedContact minimum_translation, clamped_point;
  bool front = false;  ///< the centre is strictly in front of the plane.
  bool touch = false;  ///< the solids really intersect.
};

inline std::string featureName(Feature feature) {
  static const char* const kNames[] = {"none", "face", "edge0", "edge1", "edge2", "vert0", "vert1", "vert2"};
  return kNames[static_cast<int>(feature)];
}

/// Reads contact vectors by column name; throws on a missing column or an unreadable number.
inline std::vector<ContactVector> readContactVectors(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot open " + path);
  const auto split = [](const std::string& line) {
    std::vector<std::string> fields;
    std::stringstream stream(line);
    for (std::string field; std::getline(stream, field, ',');) {
      if (!field.empty() && field.back() == '\r') field.pop_back();
      fields.push_back(field);
    }
    return fields;
  };
  std::string line;
  std::getline(file, line);
  std::map<std::string, std::size_t> column;
  for (const std::string& name : split(line)) column.emplace(name, column.size());

  std::vector<ContactVector> rows;
  while (std::getline(file, line)) {
    if (line.empty() || line == "\r") continue;
    const std::vector<std::string> fields = split(line);
    const auto text = [&](const std::string& name) { return fields.at(column.at(name)); };
    const auto number = [&](const std::string& name) { return std::stod(text(name)); };
    const auto point = [&](const std::string& stem) {
      return Eigen::Vector3d(number(stem + "x"), number(stem + "y"), number(stem + "z"));
    };
    const auto expected = [&](const std::string& rule) {
      ExpectedContact contact;
      contact.hit = number(rule + "hit") != 0.0;
      contact.p_W = point(rule + "p");
      contact.nhat_W = point(rule + "n");
      contact.e_W = point(rule + "e");
      contact.depth = number(rule + "depth");
      contact.feature = text(rule + "feature");
      contact.flag = std::stoi(text(rule + "flag"));
      contact.cond = number(rule + "cond");
      return contact;
    };
    ContactVector row;
    row.id = std::stoi(text("id"));
    row.category = text("category");
    const Eigen::Quaterniond q(number("qw"), number("qx"), number("qy"), number("qz"));
    row.ellipsoid = PosedEllipsoid(point("c"), q.normalized().toRotationMatrix(), point("r"));
    row.triangle = makeTriangle(point("v0"), point("v1"), point("v2"));
    row.minimum_translation = expected("mt_");
    row.clamped_point = expected("doc_");
    row.front = number("front") != 0.0;
    row.touch = number("touch") != 0.0;
    rows.push_back(row);
  }
  return rows;
}

/// How far a contact is from the expected one, in parts of what plain doubles may lose on that row: 1 passes,
/// infinity is another answer altogether. 1000 rounding errors, each magnified by the condition of the row or by the
/// slimness of the triangle, whichever is more; points may lose 4 units in the last place of the world's coordinates
/// besides.
inline double errorInTolerances(const ContactVector& row, const ExpectedContact& expected,
                                const TriangleContact& contact) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
  if (static_cast<bool>(contact) != expected.hit) return kInfinity;
  if (!(expected.flag & kNameJumps) && featureName(contact.feature) != expected.feature) return kInfinity;
  if (!expected.hit) return contact.depth == 0.0 ? 0.0 : kInfinity;

  const auto& v = row.triangle.v;
  const double slimness = longestEdgeSquared(v) / doubleAreaVector(v).norm();
  const double relative = 1000.0 * kEpsilon * std::max(expected.cond, slimness);
  double world = row.ellipsoid.p_WE.cwiseAbs().maxCoeff();
  for (const auto& corner : v) world = std::max(world, corner.cwiseAbs().maxCoeff());
  const double length = relative * row.ellipsoid.radii.maxCoeff();
  const double point = length + 4.0 * kEpsilon * world;
  const double error = std::max({std::abs(contact.depth - expected.depth) / length,
                                 (contact.nhat_W - expected.nhat_W).cwiseAbs().maxCoeff() / relative,
                                 (contact.p_WE_lowest - expected.e_W).cwiseAbs().maxCoeff() / point,
                                 (contact.trianglePoint() - expected.p_W).cwiseAbs().maxCoeff() / point});
  return std::isnan(error) ? kInfinity : error;
}

}  // namespace ellipsoid_vehicle_sim::test
