#include "feature_search.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "ellipsoid_vehicle_sim/geometry/plane_contact.h"
#include "ellipsoid_vehicle_sim/geometry/secular_equation.h"
#include "ellipsoid_vehicle_sim/geometry/small_vector.h"

namespace ellipsoid_vehicle_sim {
namespace {

/// Depths closer than this, in parts of the size, are the same depth to rounding; the larger u·n then decides.
constexpr double kTieTolerance = 1e-14;
/// A coordinate across the thin axis this small may be a rounded zero, with the two mirror images tied.
constexpr double kMirrorTolerance = 1e-12;
/// What a bound has to spare before a feature is skipped on its word; far above rounding, far below anything of
/// interest.
constexpr double kBoundMargin = 1e-9;

Feature edgeFeature(int k) { return static_cast<Feature>(static_cast<int>(Feature::kEdge0) + k); }
Feature vertexFeature(int k) { return static_cast<Feature>(static_cast<int>(Feature::kVertex0) + k); }

/// An edge seen along its own direction: the ellipsoid is an ellipse, the edge line a point. Coordinates are along n
/// (in the plane across the edge) and along m, the outward normal of the edge in the triangle's plane.
struct EdgeShadow {
  Vec3 e, n, m;         ///< along the ellipsoid's axes.
  double length;        ///< of the edge.
  double near_end;      ///< where on the edge the end nearer to the centre is, 0 or length.
  double t_e;           ///< that end along e.
  Vec2 t;               ///< the edge line as a point (n, m).
  Vec3 rn, rm;          ///< n and m times the semi-axes: h(u) = |u_n rn + u_m rm|.
  double nn, nm, mm;    ///< the shadow's matrix.
  double area_squared;  ///< its determinant, without cancellation: the product of the shadow's semi-axes, squared.
};

/// The shadow's semi-axes: lengths, directions by the angle of the major one from n towards m, and h's share of each:
/// h(u) = |u_major r_major + u_minor r_minor|.
struct ShadowAxes {
  double major, minor, cos, sin;
  Vec3 r_major, r_minor;
};

/// Rule 4 for one triangle: the features are looked at in turn, the least depth so far bounds what is still of
/// interest. Lengths are divided by the largest semi-axis, vectors are along the ellipsoid's axes, turned in a cycle
/// so that the thinnest comes last.
class FeatureSearch {
 public:
  FeatureSearch(const PlaneContact& plane, const Triangle& triangle, const FaceSides& sides, double floor_depth)
      : triangle_(triangle), sides_(sides) {
    const Vec3& r = plane.radii;
    const Frame3& axes = plane.axes;
    const Vec3& n = plane.nhat_E;
    size_ = std::max(std::max(r.x, r.y), r.z);
    const double scale = 1.0 / size_;
    if (r.x <= r.y && r.x <= r.z) {
      axes_ = {axes.y, axes.z, axes.x}, r_ = scale * Vec3{r.y, r.z, r.x}, n_ = {n.y, n.z, n.x};
    } else if (r.y <= r.z) {
      axes_ = {axes.z, axes.x, axes.y}, r_ = scale * Vec3{r.z, r.x, r.y}, n_ = {n.z, n.x, n.y};
    } else {
      axes_ = axes, r_ = scale * r, n_ = n;
    }
    inverse_r_ = {1.0 / r_.x, 1.0 / r_.y, 1.0 / r_.z};
    const double half = 0.5 * r_.z * r_.z;
    inverse_gap_ = {1.0 / (r_.x * r_.x - half), 1.0 / (r_.y * r_.y - half), 1.0 / half};
    for (int k = 0; k < 3; ++k) t_[k] = scale * toFrame(axes_, plane.t[k]);
    const double size = scale * std::sqrt(sides.size_squared);
    p_ET0_ = scale * toFrame(axes_, plane.p_ET0());
    d_n_ = scale * plane.d_n;
    floor_ = scale * floor_depth;
    border_ = kBorderTolerance * size;
    tie_ = kTieTolerance * size;
    limit_ = d_n_;
    slack_ = border_;
    horizon_clear_ = isHorizonClear(scale * plane.s, scale * plane.h, squaredNorm(times(n_, inverse_r_)));
  }

  /// Looks until the answer is found, or proved not to exceed the floor.
  bool solve() {
    search();
    return feature_ != Feature::kNone && limit_ > floor_;
  }

  TriangleContact contact(const Eigen::Vector3d& c_W) const {
    TriangleContact result;
    result.feature = feature_;
    result.nhat_W = fromFrame(axes_, u_).toEigen();
    result.depth = size_ * limit_;
    result.p_WE_lowest = c_W + (size_ * fromFrame(axes_, p_EE_)).toEigen();
    if (!std::isfinite(result.depth) || !result.nhat_W.allFinite() || !result.p_WE_lowest.allFinite()) return {};
    return result;
  }

 private:
  void search() {
    // Features that the lowest point has left the triangle across come first: they nearly always hold the answer.
    const bool* outside = sides_.outside;
    int corner = -1;
    for (int k = 0; k < 3; ++k) {
      if (outside[k] && outside[(k + 2) % 3]) corner = k;
    }
    for (int k = 0; k < 3 && corner < 0; ++k) {
      if (!outside[k]) continue;
      // Across one edge, but past its end.
      const int l = (k + 1) % 3;
      const Vec3 e = t_[l] - t_[k];
      const double along = dot(p_ET0_ - t_[k], e);
      if (along < 0.0) corner = k;
      if (along > squaredNorm(e)) corner = l;
    }
    if (corner >= 0) {
      searchVertex(corner);
      if (done_) return;
    }
    for (int k = 0; k < 3; ++k) {
      if (!outside[k]) continue;
      searchEdge(k);
      if (done_) return;
    }
    for (int k = 0; k < 3; ++k) {
      if (k == corner) continue;
      searchVertex(k);
      if (done_) return;
    }
    // With T0 inside the edge delta rises from n towards m, so a minimum there takes two minima on the circle, both
    // less deep than n itself; but the far one is at least the least radius of curvature deep.
    if (d_n_ + border_ < r_.z * r_.z) return;
    for (int k = 0; k < 3; ++k) {
      if (outside[k]) continue;
      searchEdge(k);
      if (done_) return;
    }
  }

  EdgeShadow edgeShadow(int k) const {
    const int l = (k + 1) % 3;
    EdgeShadow edge;
    // From the corners themselves: two far points seen from the centre would have lost digits.
    const Vec3 e = toFrame(axes_, Vec3::from(triangle_.v[l]) - Vec3::from(triangle_.v[k]));
    const double length = norm(e);
    edge.length = length / size_;
    edge.e = (1.0 / length) * e;
    // n is square to a sliver's long edges to a few digits only, hence a frame of the edge's own. That leaves m of
    // unit length but for the square of this error; one step of Newton's for the inverse root takes care of it.
    const Vec3 m = cross(edge.e, n_);
    edge.m = (1.5 - 0.5 * squaredNorm(m)) * m;
    edge.n = cross(edge.m, edge.e);
    const bool first = squaredNorm(t_[k]) <= squaredNorm(t_[l]);
    const Vec3& t = first ? t_[k] : t_[l];
    edge.near_end = first ? 0.0 : edge.length;
    edge.t_e = dot(edge.e, t);
    edge.t = {dot(edge.n, t), dot(edge.m, t)};
    edge.rn = times(r_, edge.n);
    edge.rm = times(r_, edge.m);
    edge.nn = squaredNorm(edge.rn);
    edge.nm = dot(edge.rn, edge.rm);
    edge.mm = squaredNorm(edge.rm);
    edge.area_squared = squaredNorm(Vec3{r_.y * r_.z * edge.e.x, r_.z * r_.x * edge.e.y, r_.x * r_.y * edge.e.z});
    return edge;
  }

  static ShadowAxes shadowAxes(const EdgeShadow& edge) {
    const double half = 0.5 * (edge.nn + edge.mm), difference = 0.5 * (edge.nn - edge.mm);
    const double spread = std::sqrt(difference * difference + edge.nm * edge.nm);
    ShadowAxes axes;
    axes.major = std::sqrt(half + spread);
    axes.minor = std::min(std::sqrt(edge.area_squared) / axes.major, axes.major);
    axes.cos = 1.0;
    axes.sin = 0.0;
    if (spread > 0.0) {
      // The angle is atan2(nm, difference) / 2; of its sine and cosine the larger comes from the root.
      const double large = std::sqrt(0.5 + 0.5 * std::abs(difference) / spread);
      const double small = 0.5 * edge.nm / (spread * large);
      axes.cos = difference >= 0.0 ? large : std::abs(small);
      axes.sin = difference >= 0.0 ? small : std::copysign(large, small);
    }
    axes.r_major = axes.cos * edge.rn + axes.sin * edge.rm;
    axes.r_minor = axes.cos * edge.rm - axes.sin * edge.rn;
    // Square to each other in exact numbers. A needle's r_minor would otherwise carry the rounding of its long axis,
    // which decides where along the needle E comes to lie.
    axes.r_minor = axes.r_minor - (dot(axes.r_minor, axes.r_major) / (axes.major * axes.major)) * axes.r_major;
    return axes;
  }

  void searchEdge(int k) {
    const EdgeShadow edge = edgeShadow(k);
    // adj = area^2 S^-1 t: the direction that pushes the line off the shadow, and its place q in it (1 on the outline).
    const Vec2 adj{edge.mm * edge.t.x - edge.nm * edge.t.y, edge.nn * edge.t.y - edge.nm * edge.t.x};
    const double q_area_squared = dot(edge.t, adj);

    // Any direction that clears the triangle to within the floor is proof enough, with nothing solved (see
    // cannotExceed).
    if (horizon_clear_ && adj.x < 0.0 && adj.y <= 0.0 && (q_area_squared >= edge.area_squared || floor_ > 0.0)) {
      const double delta = norm(adj.x * edge.rn + adj.y * edge.rm) - q_area_squared;
      if (delta <= floor_ * std::sqrt(dot(adj, adj))) {
        done_ = true;
        limit_ = 0.0;
        return;
      }
    }
    // Where the solids meet, no feature has an answer below zero; a minimum across a thin axis is this deep at least.
    const double rounding = 1e-14 * (edge.mm * edge.t.x * edge.t.x + edge.nn * edge.t.y * edge.t.y);
    const bool clears_line = q_area_squared > edge.area_squared * (1.0 + kBoundMargin) + rounding;
    const double most = limit_ + slack_;
    if (touches_ && clears_line && r_.z * r_.z > most) return;

    const ShadowAxes axes = shadowAxes(edge);
    const double major_t = axes.cos * edge.t.x + axes.sin * edge.t.y,
                 minor_t = axes.cos * edge.t.y - axes.sin * edge.t.x;
    const SupportProblem<2> problem{{withoutZero(major_t, axes.cos), withoutZero(minor_t, -axes.sin)},
                                    {axes.major, axes.minor}};
    const double far_bound = std::abs(minor_t) + axes.minor * axes.minor / axes.major;
    if (sides_.inside[k] && far_bound > d_n_ + border_) return;
    const bool near_possible = !(touches_ && clears_line) && !(leastDepthSquared(problem) > most * most);
    if (near_possible) {
      // The near minimum is the least on the whole circle: where it is taken, the far one cannot win.
      const bool taken = offerEdge(edge, axes, k, nearMinimum(problem));
      if (done_ || (taken && std::abs(minor_t) > kMirrorTolerance)) return;
    }
    if (far_bound <= limit_ + slack_) {
      if (const auto u = farMinimum(problem)) offerEdge(edge, axes, k, *u);
    }
  }

  void searchVertex(int k) {
    const Vec3& t = t_[k];
    const double most = limit_ + slack_, far_bound = std::abs(t.z) + r_.z * r_.z;
    const bool near_possible = !(touches_ && squaredNorm(times(t, inverse_r_)) > 1.0 + kBoundMargin) &&
                               !(leastVertexDepthSquared(t) > most * most);
    if (!near_possible && far_bound > most) return;
    const SupportProblem<3> problem{{withoutZero(t.x, n_.x), withoutZero(t.y, n_.y), withoutZero(t.z, n_.z)},
                                    {r_.x, r_.y, r_.z}};
    if (near_possible) {
      // The near minimum is the least over all directions. No other feature's push is shorter: it clears this corner
      // too.
      const bool taken = offerVertex(k, nearMinimum(problem));
      if (taken && std::abs(t.z) > kMirrorTolerance) done_ = true;
      if (done_) return;
    }
    if (far_bound <= limit_ + slack_) {
      if (const auto u = farMinimum(problem)) offerVertex(k, *u);
    }
  }

  /// `leastDepthSquared`, with the divisors that all corners share.
  double leastVertexDepthSquared(const Vec3& t) const {
    return 0.5 * r_.z * r_.z * (1.0 - dot(times(t, t), inverse_gap_));
  }

  bool offerEdge(const EdgeShadow& edge, const ShadowAxes& axes, int k, const std::array<double, 2>& direction) {
    const double inverse_length = 1.0 / std::sqrt(direction[0] * direction[0] + direction[1] * direction[1]);
    const double u_major = inverse_length * direction[0], u_minor = inverse_length * direction[1];
    const Vec2 u{axes.cos * u_major - axes.sin * u_minor, axes.sin * u_major + axes.cos * u_minor};
    if (!(u.x > 0.0) || u.y < -kBorderTolerance) return false;
    const Vec3 y = u_major * axes.r_major + u_minor * axes.r_minor;
    const double h = norm(y);
    const double delta = dot(edge.t, u) + h;
    if (!isLeast(delta, u.x)) return false;

    // T has to lie on the segment.
    const Vec3 p_EE = (-1.0 / h) * times(r_, y);
    const double along = edge.near_end + dot(edge.e, p_EE) - edge.t_e;
    if (along < -border_ || along > edge.length + border_) return false;
    take(delta, u.x * edge.n + u.y * edge.m, p_EE, u.x, edgeFeature(k));
    return true;
  }

  bool offerVertex(int k, const std::array<double, 3>& direction) {
    Vec3 u{direction[0], direction[1], direction[2]};
    if (!(dot(u, n_) > 0.0)) return false;
    u = (1.0 / norm(u)) * u;
    const double u_n = dot(u, n_);
    const Vec3 y = times(r_, u);
    const double h = norm(y);
    const double delta = dot(t_[k], u) + h;
    if (!isLeast(delta, u_n)) return false;

    // u has to hold both other corners no higher than this one.
    const Vec3 u_W = fromFrame(axes_, u);
    for (int j = 1; j < 3; ++j) {
      const Vec3 from_other = Vec3::from(triangle_.v[k]) - Vec3::from(triangle_.v[(k + j) % 3]);
      if (dot(u_W, from_other) < -border_ * size_) return false;
    }
    take(delta, u, (-1.0 / h) * times(r_, y), u_n, vertexFeature(k));
    return true;
  }

  /// Not deeper than n's own depth, and less deep than what was taken before; equal depths: nearer to n.
  bool isLeast(double delta, double u_n) const {
    if (feature_ == Feature::kNone) return delta <= limit_ + slack_;
    return delta < limit_ - tie_ || (delta <= limit_ + tie_ && u_n > u_n_);
  }

  void take(double delta, const Vec3& u, const Vec3& p_EE, double u_n, Feature feature) {
    limit_ = std::min(delta, d_n_);
    slack_ = tie_;
    u_ = u;
    p_EE_ = p_EE;
    u_n_ = u_n;
    feature_ = feature;
    done_ = !(limit_ > floor_);
    // T within the ellipsoid is proof that the solids meet, and that no direction clears the triangle.
    if (!touches_) touches_ = squaredNorm(times(p_EE + delta * u, inverse_r_)) < 1.0 - kBoundMargin;
  }

  const Triangle& triangle_;
  const FaceSides& sides_;
  Frame3 axes_;
  double size_;  ///< the largest semi-axis [m]; all lengths below are in parts of it.
  Vec3 r_, inverse_r_, n_;
  Vec3 inverse_gap_;  ///< 1 / (r^2 - r_z^2 / 2).
  Vec3 t_[3], p_ET0_;
  double d_n_, floor_, border_, tie_;
  bool horizon_clear_;

  bool touches_ = false;  ///< the solids are known to intersect.
  bool done_ = false;     ///< nothing better is left, or the answer is known not to exceed the floor.
  double limit_;          ///< least depth taken so far, d_n before the first.
  double slack_;          ///< how far above it a depth still counts as equal.
  double u_n_ = 0.0;
  Vec3 u_, p_EE_;
  Feature feature_ = Feature::kNone;
};

}  // namespace

TriangleContact searchFeatures(const PosedEllipsoid& ellipsoid, const Triangle& triangle, double floor_depth) {
  PlaneContact plane;
  if (!planeContact(ellipsoid, triangle, floor_depth, plane)) return {};
  const FaceSides sides = faceSides(plane, triangle);
  if (sides.isFace()) return {Feature::kFace, plane.d_n, triangle.nhat_W, ellipsoid.p_WE + plane.p_EE0().toEigen()};
  FeatureSearch search(plane, triangle, sides, floor_depth);
  if (!search.solve()) return {};
  return search.contact(ellipsoid.p_WE);
}

}  // namespace ellipsoid_vehicle_sim
