#include "ellipsoid_vehicle_sim/vehicle/vehicle_state.h"

#include <cmath>

#include "base_motion.h"
#include "fnv_hash.h"
#include "state_fields.h"

namespace ellipsoid_vehicle_sim {
namespace {

// Beyond these a state counts as exploded [m/s, rad/s, m]: ten times what any test at the extremes asks for.
constexpr double kFastest = 1e5, kFastestSpin = 1e6, kFarthest = 1e9;

// Zero times a number is zero but for NaN and infinity; four sums at once, because one waits for each term.
bool finite(const double* values, std::size_t n) {
  double sum[4] = {0.0, 0.0, 0.0, 0.0};
  std::size_t i = 0;
  for (; i + 4 <= n; i += 4)
    for (std::size_t k = 0; k < 4; ++k) sum[k] += 0.0 * values[i + k];
  for (; i < n; ++i) sum[0] += 0.0 * values[i];
  return (sum[0] + sum[1]) + (sum[2] + sum[3]) == 0.0;
}

bool finite(const std::vector<double>& values) { return finite(values.data(), values.size()); }

/// Hashes the values that visitFields hands out.
class HashOfFields {
 public:
  void size(std::size_t n) { hash_.add(static_cast<std::uint64_t>(n)); }
  void operator()(double value) { hash_.add(value); }
  template <typename Whole>
  void operator()(const Whole& value) {
    hash_.add(static_cast<std::uint64_t>(value));
  }
  std::uint64_t value() const { return hash_.value(); }

 private:
  FnvHash hash_;
};

}  // namespace

bool Motion::allFinite() const {
  if (!X_WB.allFinite() || !v_WB.allFinite() || !w_WB.allFinite() || !finite(q) || !finite(qd) || !finite(stretch))
    return false;
  static_assert(sizeof(Anchors) == 3 * kMaxContactsPerEllipsoid * sizeof(double), "anchors are numbers, one by one");
  return anchor.empty() || finite(anchor[0][0].data(), anchor.size() * 3 * kMaxContactsPerEllipsoid);
}

void retract(const Motion& x, double h, const MotionRate& rate, Motion& result) {
  retractBase(x, h, rate, result);
  result.work = x.work + h * rate.power;
  for (std::size_t i = 0; i < x.q.size(); ++i) {
    result.q[i] = x.q[i] + h * rate.q[i];
    result.qd[i] = x.qd[i] + h * rate.qd[i];
    result.stretch[i] = x.stretch[i] + h * rate.stretch[i];
  }
  for (std::size_t i = 0; i < x.anchor.size(); ++i)
    for (int j = 0; j < kMaxContactsPerEllipsoid; ++j) result.anchor[i][j] = x.anchor[i][j] + h * rate.anchor[i][j];
}

void weightedSum(const double* weights, const MotionRate* k, int n, MotionRate& sum) {
  const std::size_t joints = sum.q.size(), ellipsoids = sum.anchor.size();
  bool first = true;
  for (int s = 0; s < n; ++s) {
    const double w = weights[s];
    if (w == 0.0) continue;
    const MotionRate& r = k[s];
    const auto add = [w, first](auto& total, const auto& value) { addWeighted(w, value, first, total); };
    addBase(w, r, first, sum);
    addWeighted(w, r.power, first, sum.power);
    for (std::size_t i = 0; i < joints; ++i) {
      add(sum.q[i], r.q[i]);
      add(sum.qd[i], r.qd[i]);
      add(sum.stretch[i], r.stretch[i]);
    }
    for (std::size_t i = 0; i < ellipsoids; ++i)
      for (int j = 0; j < kMaxContactsPerEllipsoid; ++j) add(sum.anchor[i][j], r.anchor[i][j]);
    first = false;
  }
}

bool isSane(const Motion& x) {
  return x.allFinite() && x.v_WB.squaredNorm() < kFastest * kFastest &&
         x.w_WB.squaredNorm() < kFastestSpin * kFastestSpin && x.X_WB.p.squaredNorm() < kFarthest * kFarthest;
}

std::uint64_t hashOf(const VehicleState& state) {
  HashOfFields hash;
  visitFields(state, hash);
  return hash.value();
}

}  // namespace ellipsoid_vehicle_sim
