#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace ellipsoid_vehicle_sim {

/// A small dense system of equations that is solved again and again without taking memory. Gaussian elimination with row
/// pivoting.
class DenseSystem {
 public:
  explicit DenseSystem(int size)
      : size_(size), matrix_(static_cast<std::size_t>(size) * size), right_(static_cast<std::size_t>(size)) {}

  int size() const { return size_; }
  /// What it holds is lost. Takes memory where it was never so large.
  void resize(int size) {
    size_ = size;
    matrix_.resize(static_cast<std::size_t>(size) * size);
    right_.resize(static_cast<std::size_t>(size));
  }
  double& at(int row, int column) { return matrix_[static_cast<std::size_t>(row) * size_ + column]; }
  double& right(int row) { return right_[static_cast<std::size_t>(row)]; }
  double solution(int row) const { return right_[static_cast<std::size_t>(row)]; }

  /// Replaces the right side by the solution and destroys the matrix. False: the matrix is singular, or not finite.
  bool solve() {
    for (int c = 0; c < size_; ++c) {
      int pivot = c;
      for (int r = c + 1; r < size_; ++r)
        if (std::abs(at(r, c)) > std::abs(at(pivot, c))) pivot = r;
      if (!(std::abs(at(pivot, c)) > 0.0) || !std::isfinite(at(pivot, c))) return false;
      if (pivot != c) {
        for (int j = c; j < size_; ++j) std::swap(at(pivot, j), at(c, j));
        std::swap(right(pivot), right(c));
      }
      for (int r = c + 1; r < size_; ++r) {
        const double factor = at(r, c) / at(c, c);
        if (factor == 0.0) continue;
        for (int j = c + 1; j < size_; ++j) at(r, j) -= factor * at(c, j);
        right(r) -= factor * right(c);
      }
    }
    for (int r = size_ - 1; r >= 0; --r) {
      double sum = right(r);
      for (int j = r + 1; j < size_; ++j) sum -= at(r, j) * right(j);
      right(r) = sum / at(r, r);
    }
    return true;
  }

 private:
  int size_;
  std::vector<double> matrix_, right_;
};

}  // namespace ellipsoid_vehicle_sim
