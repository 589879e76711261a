#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "ellipsoid_vehicle_sim/geometry/ellipsoid.h"

/// The least of h1(u) + h2(u) - u.c over the sphere the slow way, in long double: a dense set of directions, the best of
/// them refined by a compass search that uses values only. Shares nothing with the fast path but the definition.
namespace ellipsoid_vehicle_sim::test {

using Real = long double;
using RealVector = Eigen::Matrix<Real, 3, 1>;

struct PairCase {
  std::string category;
  PosedEllipsoid first, second;
};

struct PairAnswer {
  double depth = 0.0;        ///< the least of the definition, negative where they are apart [m].
  Eigen::Vector3d u;         ///< where it is.
  double runner_up = 1e300;  ///< the least depth of directions more than 0.2 rad away from u and its kin [m].
};

class SlowPair {
 public:
  explicit SlowPair(const PairCase& pair) {
    first_ = scaledAxes(pair.first);
    second_ = scaledAxes(pair.second);
    c_ = pair.first.p_WE.cast<Real>() - pair.second.p_WE.cast<Real>();
    axes_ << pair.first.R_WE, pair.second.R_WE;
  }

  Real depth(const RealVector& u) const { return (first_ * u).norm() + (second_ * u).norm() - u.dot(c_); }

  PairAnswer solve() const {
    std::vector<RealVector> directions = spiral(20000);
    addClusters(directions);
    std::vector<std::pair<Real, std::size_t>> order;
    for (std::size_t i = 0; i < directions.size(); ++i) order.emplace_back(depth(directions[i]), i);
    std::sort(order.begin(), order.end());
    PairAnswer answer;
    Real best = 1e300L;
    RealVector u = RealVector::UnitZ();
    std::vector<RealVector> tried;
    for (const auto& [value, index] : order) {
      const RealVector& start = directions[index];
      const bool new_place = std::none_of(tried.begin(), tried.end(), [&](const RealVector& t) { return t.dot(start) > 0.995L; });
      if (!new_place && tried.size() > 4) continue;
      if (tried.size() == 24) break;
      tried.push_back(start);
      RealVector refined = start;
      const Real found = refine(refined);
      if (found < best) {
        if (refined.dot(u) < 0.98L) answer.runner_up = std::min(answer.runner_up, static_cast<double>(best));
        best = found;
        u = refined;
      } else if (refined.dot(u) < 0.98L) {
        answer.runner_up = std::min(answer.runner_up, static_cast<double>(found));
      }
    }
    answer.depth = static_cast<double>(best);
    answer.u = u.cast<double>();
    return answer;
  }

 private:
  using RealMatrix = Eigen::Matrix<Real, 3, 3>;

  static RealMatrix scaledAxes(const PosedEllipsoid& e) {
    return e.radii.cast<Real>().asDiagonal() * e.R_WE.cast<Real>().transpose();
  }

  static std::vector<RealVector> spiral(int n) {
    std::vector<RealVector> result;
    for (int i = 0; i < n; ++i) {
      const Real z = 1.0L - 2.0L * (i + 0.5L) / n, s = std::sqrt(1.0L - z * z), phi = 2.39996322972865332L * i;
      result.emplace_back(s * std::cos(phi), s * std::sin(phi), z);
    }
    return result;
  }

  // Thin bodies have their minima close to their axes: rings around each, from 1e-7 to 1 rad.
  void addClusters(std::vector<RealVector>& directions) const {
    for (int axis = 0; axis < 6; ++axis)
      for (const Real sign : {1.0L, -1.0L}) {
        const RealVector a = sign * axes_.col(axis).cast<Real>();
        const RealVector t1 = a.unitOrthogonal(), t2 = a.cross(t1);
        directions.push_back(a);
        for (Real angle = 1e-7L; angle < 1.0L; angle *= 1.5L)
          for (int k = 0; k < 24; ++k) {
            const Real phi = 0.2617993877991494L * k;
            directions.push_back((a + angle * (std::cos(phi) * t1 + std::sin(phi) * t2)).normalized());
          }
      }
  }

  // Compass search: eight directions, half the step where none is better.
  Real refine(RealVector& u) const {
    Real best = depth(u);
    for (Real step = 0.02L; step > 1e-17L;) {
      const RealVector t1 = u.unitOrthogonal(), t2 = u.cross(t1);
      bool better = false;
      for (int k = 0; k < 8; ++k) {
        const Real phi = 0.7853981633974483096L * k;
        const RealVector v = (u + step * (std::cos(phi) * t1 + std::sin(phi) * t2)).normalized();
        const Real value = depth(v);
        if (value < best) {
          best = value;
          u = v;
          better = true;
          break;
        }
      }
      step *= better ? 1.3L : 0.5L;
    }
    return best;
  }

  RealMatrix first_, second_;
  RealVector c_;
  Eigen::Matrix<double, 3, 6> axes_;
};

/// 200 pairs, shallow to nested, spheres to discs and needles of 1 : 1e4.
inline std::vector<PairCase> pairCases() {
  std::mt19937_64 random(7);
  const auto uniform = [&random] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  const auto direction = [&] {
    const double z = 2.0 * uniform() - 1.0, phi = 6.283185307179586 * uniform(), s = std::sqrt(1.0 - z * z);
    return Eigen::Vector3d(s * std::cos(phi), s * std::sin(phi), z);
  };
  const auto rotation = [&] {
    return Eigen::AngleAxisd(3.141592653589793 * uniform(), direction()).toRotationMatrix();
  };
  const auto radiiOf = [&](const std::string& shape) -> Eigen::Vector3d {
    if (shape == "sphere") return Eigen::Vector3d::Constant(0.1 + uniform());
    if (shape == "wheel") return {0.35, 0.12, 0.35};
    if (shape == "disc") return {1.0, 1.0, std::pow(10.0, -1.0 - 3.0 * uniform())};
    if (shape == "needle") return {1.0, std::pow(10.0, -1.0 - 3.0 * uniform()), std::pow(10.0, -1.0 - 3.0 * uniform())};
    return {0.1 + uniform(), 0.1 + uniform(), 0.1 + uniform()};
  };
  const std::vector<std::pair<std::string, std::string>> shapes = {
      {"body", "body"},     {"wheel", "wheel"}, {"wheel", "body"},  {"sphere", "body"},   {"sphere", "sphere"},
      {"disc", "body"},     {"disc", "disc"},   {"needle", "body"}, {"needle", "needle"}, {"disc", "needle"}};
  std::vector<PairCase> cases;
  for (int k = 0; k < 200; ++k) {
    const auto& [one, other] = shapes[static_cast<std::size_t>(k) % shapes.size()];
    PairCase pair;
    pair.category = one + "-" + other;
    const Eigen::Matrix3d R1 = rotation(), R2 = rotation();
    const Eigen::Vector3d r1 = radiiOf(one), r2 = radiiOf(other);
    pair.first = PosedEllipsoid(Eigen::Vector3d::Zero(), R1, r1);
    pair.second = PosedEllipsoid(Eigen::Vector3d(uniform(), uniform(), uniform()), R2, r2);
    // Along a direction from the second, by a share of the way to where they let go of each other.
    const Eigen::Vector3d along = direction();
    double low = 0.0, high = r1.maxCoeff() + r2.maxCoeff();
    const double share = k % 5 == 0 ? uniform() : k % 5 == 1 ? 1.0 + 0.05 * uniform() : 1.0 - 0.2 * uniform() * uniform();
    for (int i = 0; i < 40; ++i) {
      const double middle = 0.5 * (low + high);
      pair.first.p_WE = pair.second.p_WE + middle * along;
      const SlowPair slow(pair);
      bool apart = false;
      const RealVector d = along.cast<Real>();
      // Apart as soon as any of a fan of directions about `along` separates them.
      std::mt19937_64 fan(11);
      RealVector u = d;
      Real value = slow.depth(u), step = 0.3L;
      for (int j = 0; j < 400 && !apart; ++j) {
        const auto number = [&fan] { return 2.0L * static_cast<Real>(fan() >> 11) * 0x1p-53L - 1.0L; };
        const RealVector v = (u + step * RealVector(number(), number(), number())).normalized();
        if (const Real here = slow.depth(v); here < value) {
          value = here;
          u = v;
          step *= 1.4L;
        } else {
          step *= 0.93L;
        }
        apart = value < 0.0L;
      }
      (apart ? high : low) = middle;
    }
    pair.first.p_WE = pair.second.p_WE + share * low * along;
    cases.push_back(pair);
  }
  return cases;
}

inline void writePairVectors(const std::string& path) {
  std::ofstream out(path);
  out << "# Ellipsoid against ellipsoid: least h1(u) + h2(u) - u.(c1 - c2), by the brute force of support/brute_force_pair.h.\n"
         "# Written anew by: ELLIPSOID_VEHICLE_SIM_WRITE_PAIRS=FILE ellipsoid_ellipsoid_vectors_test\n"
         "# category, then of each: centre (3), rotation by columns (9), radii (3); depth (negative: apart), u (3), next best\n";
  out.precision(17);
  for (const PairCase& pair : pairCases()) {
    out << pair.category;
    for (const PosedEllipsoid* e : {&pair.first, &pair.second}) {
      for (int i = 0; i < 3; ++i) out << ',' << e->p_WE[i];
      for (int i = 0; i < 9; ++i) out << ',' << e->R_WE.data()[i];
      for (int i = 0; i < 3; ++i) out << ',' << e->radii[i];
    }
    const PairAnswer answer = SlowPair(pair).solve();
    out << ',' << answer.depth << ',' << answer.u[0] << ',' << answer.u[1] << ',' << answer.u[2] << ',' << answer.runner_up << '\n';
  }
}

inline std::vector<std::pair<PairCase, PairAnswer>> readPairVectors(const std::string& path) {
  std::ifstream in(path);
  if (!in) throw std::runtime_error("cannot read " + path);
  std::vector<std::pair<PairCase, PairAnswer>> rows;
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream fields(line);
    std::string field;
    std::getline(fields, field, ',');
    PairCase pair;
    pair.category = field;
    std::vector<double> numbers;
    while (std::getline(fields, field, ',')) numbers.push_back(std::stod(field));
    if (numbers.size() != 35) throw std::runtime_error(path + ": a row of " + std::to_string(numbers.size()) + " numbers");
    const auto ellipsoidAt = [&numbers](std::size_t at) {
      return PosedEllipsoid(Eigen::Vector3d(numbers.data() + at), Eigen::Matrix3d(numbers.data() + at + 3),
                            Eigen::Vector3d(numbers.data() + at + 12));
    };
    pair.first = ellipsoidAt(0);
    pair.second = ellipsoidAt(15);
    rows.push_back({pair, {numbers[30], Eigen::Vector3d(numbers.data() + 31), numbers[34]}});
  }
  return rows;
}

}  // namespace ellipsoid_vehicle_sim::test
