#include "ellipsoid_vehicle_sim/geometry/ellipsoid_ellipsoid.h"

#include <algorithm>
#include <cmath>

#include "ellipsoid_vehicle_sim/geometry/small_vector.h"

namespace ellipsoid_vehicle_sim {
namespace {

constexpr int kMostSteps = 200;
// A turn by less than this is rounding [rad].
constexpr double kRounding = 4e-16;
// Longest turn of one step [rad]: beyond it the model of second order says nothing.
constexpr double kLongestTurn = 0.7;
// Share of the promised decrease that a step has to bring [Nocedal2006, 3.1].
constexpr double kArmijo = 1e-4;
// Within this of the answer [rad] depths no longer tell better from worse, gradients do.
constexpr double kClose = 1e-5;
// Out of a saddle by so much [rad].
constexpr double kOffSaddle = 0.05;
// Depths that differ by less than this share of the sizes are equal.
constexpr double kSameDepth = 1e-12;

// The frame scaled by the radii: its rows times u have the length h(u).
struct Body {
  Frame3 axes;  // r_i times the unit axes
  Frame3 unit;
  Vec3 radii;

  explicit Body(const PosedEllipsoid& e) : unit(columns(e.R_WE)), radii(Vec3::from(e.radii)) {
    axes = {radii.x * unit.x, radii.y * unit.y, radii.z * unit.z};
  }
};

// Depth along u, and what Newton's method asks for: slope and curvature along the tangents t1 and t2.
struct Model {
  double depth = 0.0;
  Vec2 slope{0.0, 0.0};
  double h11 = 0.0, h12 = 0.0, h22 = 0.0;
};

double depthAlong(const Body& a, const Body& b, const Vec3& c, const Vec3& u) {
  return norm(toFrame(a.axes, u)) + norm(toFrame(b.axes, u)) - dot(u, c);
}

void tangents(const Vec3& u, Vec3& t1, Vec3& t2) {
  const Vec3 other = std::abs(u.x) < 0.6 ? Vec3{1.0, 0.0, 0.0} : Vec3{0.0, 1.0, 0.0};
  t1 = cross(u, other);
  t1 = (1.0 / norm(t1)) * t1;
  t2 = cross(u, t1);
}

// With b = D R'u, a_i = D R't_i: h = |b|, dh/dt_i = a_i.b / h, and d2h/dt_i dt_j = (a_i x b).(a_j x b) / h^3, which does not
// cancel where the body is thin.
void addBody(const Body& body, const Vec3& u, const Vec3& t1, const Vec3& t2, Model& m) {
  const Vec3 b = toFrame(body.axes, u), a1 = toFrame(body.axes, t1), a2 = toFrame(body.axes, t2);
  const double h = norm(b);
  const Vec3 n1 = (1.0 / h) * cross(a1, b), n2 = (1.0 / h) * cross(a2, b);
  m.depth += h;
  m.slope.x += dot(a1, b) / h;
  m.slope.y += dot(a2, b) / h;
  m.h11 += dot(n1, n1) / h;
  m.h12 += dot(n1, n2) / h;
  m.h22 += dot(n2, n2) / h;
}

Model modelAt(const Body& a, const Body& b, const Vec3& c, const Vec3& u, const Vec3& t1, const Vec3& t2) {
  Model m;
  addBody(a, u, t1, t2, m);
  addBody(b, u, t1, t2, m);
  m.depth -= dot(u, c);
  m.slope.x -= dot(t1, c);
  m.slope.y -= dot(t2, c);
  // The sphere's own curvature: the depth is homogeneous of degree one in u.
  m.h11 -= m.depth;
  m.h22 -= m.depth;
  return m;
}

// The curvature's principal values, low <= high, and the direction of the low one.
struct Curvature {
  double low, high;
  Vec2 direction;
};

Curvature curvatureOf(const Model& m) {
  const double mean = 0.5 * (m.h11 + m.h22), half = 0.5 * (m.h11 - m.h22);
  const double radius = std::hypot(half, m.h12);
  const double angle = 0.5 * std::atan2(-m.h12, -half);
  Curvature result{mean - radius, mean + radius, {std::cos(angle), std::sin(angle)}};
  // The smaller in absolute value from the product, without cancellation.
  const double det = m.h11 * m.h22 - m.h12 * m.h12;
  if (mean > 0.0 && result.high > 0.0) result.low = det / result.high;
  if (mean < 0.0 && result.low < 0.0) result.high = det / result.low;
  return result;
}

struct Minimum {
  double depth = 0.0;
  Vec3 u{0.0, 0.0, 1.0};
  bool apart = false;  // a separating direction was met
};

Vec3 turned(const Vec3& u, const Vec3& t1, const Vec3& t2, const Vec2& step, double share) {
  const double angle = share * std::sqrt(dot(step, step));
  const Vec3 s = share * (step.x * t1 + step.y * t2);
  const Vec3 v = std::cos(angle) * u + (angle > 0.0 ? std::sin(angle) / angle : 1.0) * s;
  return (1.0 / norm(v)) * v;
}

Minimum descend(const Body& a, const Body& b, const Vec3& c, Vec3 u, double size) {
  double last_turn = 1e9;
  bool left_saddle = false;
  Minimum result;
  for (int i = 0; i < kMostSteps; ++i) {
    Vec3 t1, t2;
    tangents(u, t1, t2);
    const Model m = modelAt(a, b, c, u, t1, t2);
    result.depth = m.depth;
    result.u = u;
    if (m.depth <= 0.0) {
      result.apart = true;
      return result;
    }
    const Curvature k = curvatureOf(m);
    const Vec2 d = k.direction, e{-d.y, d.x};
    const double along = dot(m.slope, d), across = dot(m.slope, e);
    const double tiny = 1e-14 * size;
    // Downhill also where the curvature is that of a ridge.
    Vec2 step{0.0, 0.0};
    const double p = -along / std::max(std::abs(k.low), tiny), q = -across / std::max(std::abs(k.high), tiny);
    step = {p * d.x + q * e.x, p * d.y + q * e.y};
    const double turn = std::sqrt(dot(step, step));
    if (k.low < -1e-9 * size && turn < kClose) {
      // The top of a ridge: a step aside, once; both sides are as good.
      if (left_saddle) return result;
      left_saddle = true;
      u = turned(u, t1, t2, d, kOffSaddle);
      last_turn = 1e9;
      continue;
    }
    if (turn <= kRounding) return result;
    if (k.low > 0.0 && turn < kClose) {
      if (turn >= 0.5 * last_turn) return result;
      last_turn = turn;
      u = turned(u, t1, t2, step, 1.0);
      continue;
    }
    double share = std::min(1.0, kLongestTurn / turn);
    const double promised = dot(m.slope, step);
    Vec3 next = turned(u, t1, t2, step, share);
    int halvings = 0;
    while (depthAlong(a, b, c, next) > m.depth + kArmijo * share * promised && ++halvings < 60) {
      share *= 0.5;
      next = turned(u, t1, t2, step, share);
    }
    if (halvings == 60) return result;  // not even rounding goes down from here
    u = next;
  }
  return result;
}

// That one of u and -u which leads towards the first, upwards where neither does.
Vec3 towards(const Vec3& c, const Vec3& u, double size) {
  const double s = dot(u, c);
  if (std::abs(s) > 1e-14 * size) return s > 0.0 ? u : -u;
  const double up = u.z != 0.0 ? u.z : u.y != 0.0 ? u.y : u.x;
  return up >= 0.0 ? u : -u;
}

double leastCurvatureRadius(const PosedEllipsoid& e) {
  const double least = e.radii.minCoeff();
  return least * least / e.radii.maxCoeff();
}

}  // namespace

EllipsoidPairContact minimumTranslation(const PosedEllipsoid& first, const PosedEllipsoid& second) {
  EllipsoidPairContact contact;
  const Vec3 c = Vec3::from(first.p_WE) - Vec3::from(second.p_WE);
  const double distance = norm(c), size = first.radii.maxCoeff() + second.radii.maxCoeff();
  if (!(distance < size)) return contact;

  const Body a(first), b(second);
  const bool centred = distance <= 1e-14 * size;
  Minimum best = descend(a, b, c, centred ? Vec3{0.0, 0.0, 1.0} : (1.0 / distance) * c, size);
  if (best.apart) return contact;
  if (best.depth > leastCurvatureRadius(first) + leastCurvatureRadius(second)) {
    const Vec3 starts[] = {a.unit.x, a.unit.y, a.unit.z, b.unit.x, b.unit.y, b.unit.z};
    const auto search = [&](const Vec3& start) {
      const Minimum other = descend(a, b, c, start, size);
      if (other.depth < best.depth - kSameDepth * size) best = other;
      return !other.apart;
    };
    for (const Vec3& start : starts)
      if (!search(towards(c, start, size))) return contact;
    // Almost square to the line of centres, the other side of a thin body is nearly as good.
    if (!centred && !search(-best.u)) return contact;
  }
  // Its mirror image is never better, but may be where the search has ended.
  if (dot(best.u, c) < 0.0) {
    best.u = -best.u;
    best.depth = depthAlong(a, b, c, best.u);
    if (best.depth <= 0.0) return contact;
  }
  const Vec3 in_a = toFrame(a.axes, best.u), in_b = toFrame(b.axes, best.u);
  contact.depth = best.depth;
  contact.nhat_W = best.u.toEigen();
  contact.p_WE_first = (Vec3::from(first.p_WE) - (1.0 / norm(in_a)) * fromFrame(a.axes, in_a)).toEigen();
  contact.p_WE_second = (Vec3::from(second.p_WE) + (1.0 / norm(in_b)) * fromFrame(b.axes, in_b)).toEigen();
  return contact;
}

}  // namespace ellipsoid_vehicle_sim
