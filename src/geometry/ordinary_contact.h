// Rule 4 where it is plain: an edge or a corner met no deeper than the ellipsoid is curved there, and nothing else
// near. Nearly all edges and corners of a vehicle on a road are of this kind. One secular equation is solved; that no
// other feature has a shallower answer is shown by the bounds of FeatureSearch (feature_search.cpp), which is left all
// that is not as plain as that. Included once for each kind of machine, after corner_lanes.h; no include guard.

/// The near minimum of a point t inside: (S - lambda) w = -t with w'S w = 1, and u ~ w. lambda = 0 is the root of a
/// point on the surface, and that of a point inside is the only one between 0 and the least pole. With M = (S -
/// lambda)^-1 and S_k = w'S M^(k-2) w,
///   dw/dlambda = M w,  Q = S_2 = w'S w,  dQ/dlambda = 2 S_3,  dS_k/dlambda = k S_(k+1).
/// Both steps are Taylor polynomials of third degree of an inverse function, and leave an error of the fourth order.
struct SecularSums {
  double q, s3, s4, s5;
};

/// From lambda = 0, by Q^(-1/2), which is nearly straight (straight for a sphere).
inline double firstStep(const SecularSums& sums) {
  const auto& [q, s3, s4, s5] = sums;
  const double inverse_q = 1.0 / q, inverse_s3 = 1.0 / s3;
  const double newton = (q - q * std::sqrt(q)) * inverse_s3;
  const double a = s3 * inverse_q, b = s4 * inverse_s3;
  const double bend = 1.5 * (a - b);
  const double twist = (2.0 * a * a - 4.5 * s4 * inverse_q) + (4.5 * b * b - 2.0 * s5 * inverse_s3);
  return newton + newton * newton * (bend + twist * newton);
}

/// Near the root, by Q itself, which takes no root of a number.
struct LateStep {
  double step;   ///< of lambda.
  double ratio;  ///< of the terms of the series, about.

  explicit LateStep(const SecularSums& sums) {
    const double inverse_s3 = 1.0 / sums.s3;
    const double newton = (0.5 - 0.5 * sums.q) * inverse_s3;
    const double b = sums.s4 * inverse_s3;
    step = newton + newton * newton * (newton * (4.5 * b * b - 2.0 * sums.s5 * inverse_s3) - 1.5 * b);
    ratio = std::abs(b * newton);
  }
  /// w may be carried on by its own series, w + step M w + step^2 M^2 w + step^3 M^3 w, to the last digits.
  bool isLast() const { return ratio < 1e-4; }
};

class OrdinaryContact {
 public:
  OrdinaryContact(const PosedEllipsoid& ellipsoid, const CornerVec3& v, const PlaneFacts& facts)
      : ellipsoid_(ellipsoid), f_(facts), c_(Vec3::from(ellipsoid.p_WE)), axes_(columns(ellipsoid.R_WE)) {
    const Vec3 r = r_ = Vec3::from(ellipsoid.radii);
    r2_ = times(r, r);
    CornerVec3 e;
    edges(v, e);
    toFrame(axes_, {v.x - c_.x, v.y - c_.y, v.z - c_.z}, t_);
    toFrame(axes_, e, e_);
    border_ = kBorderTolerance * std::sqrt(f_.size_squared);
  }

  /// False: not as plain as that. Otherwise `contact` is the answer.
  bool find() {
    const int corner = cornerBelow();
    if (corner >= 0 && findCorner(corner)) return true;
    const bool corner_left = corner >= 0 && corner_cleared_;
    for (int k = 0; k < 3; ++k) {
      if ((f_.outside >> k & 1u) == 0) continue;
      if (!findEdge(k)) continue;
      return feature_ == Feature::kNone || feature_ >= Feature::kVertex0 || isAlone(k, corner_left ? corner : -1);
    }
    return false;
  }

  TriangleContact contact(double floor_depth) const {
    if (feature_ == Feature::kNone || !(depth_ > floor_depth)) return contactAt(Feature::kNone, 0.0, {}, {});
    Lanes w, Aw;
    fromFrame(ellipsoid_.R_WE, w_, w);
    fromFrame(ellipsoid_.R_WE, times(r2_, w_), Aw);
    w *= inverse_w_;
    return contactAt(feature_, depth_, {w[0], w[1], w[2]}, {c_.x - Aw[0], c_.y - Aw[1], c_.z - Aw[2]});
  }

 private:
  Vec3 inverseRadii() const {
    const double inverse = 1.0 / (r_.x * r_.y * r_.z);
    return {inverse * (r_.y * r_.z), inverse * (r_.z * r_.x), inverse * (r_.x * r_.y)};
  }

  static constexpr double kMargin = 1e-9;    ///< what a proof has to spare; far above rounding.
  static constexpr double kNearPole = 1e-3;  ///< lambda stays this far from the least semi-axis squared, in parts.
  static constexpr int kMostSteps = 6;

  /// A step towards the one root between 0 and the least pole; it cannot be passed unseen.
  static double bounded(double lambda, double step, double pole) {
    const double next = lambda + step;
    if (next < 0.0) return 0.5 * lambda;
    return next < (1.0 - kNearPole) * pole ? next : 0.5 * (lambda + pole);
  }

  /// The corner that the lowest point has left the triangle at, or -1.
  int cornerBelow() const {
    const unsigned both = f_.outside & (f_.outside << 1 | f_.outside >> 2) & 7u;
    if (both != 0) return 31 - __builtin_clz(both);
    // Across one edge, but past its end? (T0 - v_k)·e, times h, where n·e = 0.
    const int k = __builtin_ctz(f_.outside);
    const Vec3 e = e_[k];
    const double along = -(dot(times(r2_, f_.n_E), e) + f_.h * dot(t_[k], e));
    if (along < 0.0) return k;
    return along > f_.h * squaredNorm(e) ? (k + 1) % 3 : -1;
  }

  /// (c) of cannotExceed.
  bool isHorizonClear() const {
    const double b = squaredNorm(times(f_.n_E, inverseRadii()));
    return f_.s * f_.s * b > f_.h * f_.h * b * (1.0 + kMargin) - 1.0;
  }

  bool findCorner(int k) {
    const Vec3 t = t_[k], next = e_[k], before = e_[(k + 2) % 3];
    const Vec3 inverse_r2{1.0 / r2_.x, 1.0 / r2_.y, 1.0 / r2_.z};
    const double thin_squared = std::min(std::min(r2_.x, r2_.y), r2_.z);
    Vec3 w = -times(inverse_r2, t);
    const double gauge = -dot(w, t);
    if (gauge >= 1.0) {
      // Outside the ellipsoid: w, which leads straight off the surface, clears the corner, and with it the others if
      // they lie lower (see cannotExceed).
      const bool clear = dot(w, f_.n_E) > 0.0 && dot(w, next) <= 0.0 && dot(w, before) >= 0.0;
      return clear && gauge > 1.0 + kMargin && isHorizonClear();
    }
    Vec3 inverse = inverse_r2, y = times(r_, w);
    const auto sums = [&] {
      const Vec3 y2 = times(y, y), y3 = times(y2, inverse), y4 = times(y3, inverse), y5 = times(y4, inverse);
      return SecularSums{y2.x + y2.y + y2.z, y3.x + y3.y + y3.z, y4.x + y4.y + y4.z, y5.x + y5.y + y5.z};
    };
    double lambda = bounded(0.0, firstStep(sums()), thin_squared);
    for (int i = 0;; ++i) {
      inverse = {1.0 / (r2_.x - lambda), 1.0 / (r2_.y - lambda), 1.0 / (r2_.z - lambda)};
      w = -times(inverse, t);
      y = times(r_, w);
      const LateStep late(sums());
      if (late.isLast()) {
        const Vec3 z = times(inverse, w), v = times(inverse, z);
        w = w + late.step * (z + late.step * (v + late.step * times(inverse, v)));
        break;
      }
      if (i == kMostSteps) return false;
      lambda = bounded(lambda, late.step, thin_squared);
    }

    // h(w) = 1.
    const double inverse_w = 1.0 / norm(w);
    const double delta = (dot(t, w) + 1.0) * inverse_w;
    corner_cleared_ = true;
    if (!(dot(w, f_.n_E) > 0.0) || !(delta <= f_.d_n + border_)) return false;
    // u has to hold both other corners no higher than this one.
    if (dot(w, next) * inverse_w > border_ || dot(w, before) * inverse_w < -border_) return false;
    // The least over all directions: no other feature's push is shorter.
    take(static_cast<Feature>(static_cast<int>(Feature::kVertex0) + k), delta, w, inverse_w);
    return true;
  }

  /// An edge seen along its own direction, as EdgeShadow of FeatureSearch. Here n and m are not of unit length, but of
  /// the lengths that their cross products leave them: S w = lambda G w in place of S w = lambda w, with G = diag(n·n,
  /// m·m), and no root before the end.
  bool findEdge(int k) {
    const int l = (k + 1) % 3;
    const Vec3 &r = r_, e = e_[k], m = cross(e, f_.n_E), n = cross(m, e);
    const bool first = squaredNorm(t_[k]) <= squaredNorm(t_[l]);
    const Vec3 t_k = t_[k], t_l = t_[l], t{first ? t_k.x : t_l.x, first ? t_k.y : t_l.y, first ? t_k.z : t_l.z};
    const Vec3 rn = times(r, n), rm = times(r, m);
    const double t_n = dot(n, t), t_m = dot(m, t);
    const double nn = squaredNorm(rn), nm = dot(rn, rm), mm = squaredNorm(rm);
    const double length_squared = squaredNorm(e), g_m = squaredNorm(m), g_n = g_m * length_squared;
    // The determinant of S, without the cancellation of nn mm - nm nm.
    const double area = g_m * g_m * squaredNorm(Vec3{r.y * r.z * e.x, r.z * r.x * e.y, r.x * r.y * e.z});
    const double trace = nn * g_m + mm * g_n, g = g_n * g_m;
    // A slender shadow's entries no longer hold its short axis.
    if (!(area * g > kSlender * trace * trace)) return false;

    // adj(S) t. It leads straight off the shadow's outline where t lies on it.
    const double p_n = mm * t_n - nm * t_m, p_m = nn * t_m - nm * t_n;
    const double gauge_area = t_n * p_n + t_m * p_m;
    if (gauge_area >= area) {
      // Outside the shadow: p clears the line, and the third corner (see cannotExceed).
      return p_n < 0.0 && p_m <= 0.0 && gauge_area > area * (1.0 + kMargin) && isHorizonClear();
    }
    // M = (S - lambda G)^-1 G. Two by two, so M^2 = tr(M) M - det(M), and what follows from w and M w needs no
    // products.
    double inverse = 1.0 / area, w_n = -inverse * p_n, w_m = -inverse * p_m, z_n, z_m, tr, det;
    const auto sums = [&](double nn_l, double mm_l, double trace_l) {
      tr = inverse * trace_l, det = inverse * g;
      const double y_n = g_n * w_n, y_m = g_m * w_m;
      z_n = inverse * (mm_l * y_n - nm * y_m), z_m = inverse * (nn_l * y_m - nm * y_n);
      const double Sw_n = nn * w_n + nm * w_m, Sw_m = nm * w_n + mm * w_m;
      const double q = Sw_n * w_n + Sw_m * w_m, s3 = Sw_n * z_n + Sw_m * z_m, s4 = tr * s3 - det * q;
      return SecularSums{q, s3, s4, tr * s4 - det * s3};
    };
    double lambda = firstStep(sums(nn, mm, trace));
    for (int i = 0;; ++i) {
      const double lambda_g = lambda * g, determinant = area - lambda * (trace - lambda_g);
      if (!(lambda >= 0.0 && 2.0 * lambda_g < trace && determinant > kNearPole * area)) return false;
      inverse = 1.0 / determinant;
      w_n = inverse * (lambda * (g_m * t_n) - p_n), w_m = inverse * (lambda * (g_n * t_m) - p_m);
      const LateStep late(sums(nn - lambda * g_n, mm - lambda * g_m, trace - 2.0 * lambda_g));
      if (late.isLast()) {
        const double v_n = tr * z_n - det * w_n, v_m = tr * z_m - det * w_m;
        w_n += late.step * (z_n + late.step * (v_n + late.step * (tr * v_n - det * z_n)));
        w_m += late.step * (z_m + late.step * (v_m + late.step * (tr * v_m - det * z_m)));
        break;
      }
      if (i == kMostSteps) return false;
      lambda += late.step;
    }

    // h(w) = 1.
    const double inverse_w = 1.0 / std::sqrt(g_n * w_n * w_n + g_m * w_m * w_m);
    const double delta = (t_n * w_n + t_m * w_m + 1.0) * inverse_w;
    const double u_m = w_m * inverse_w;  // times |m|
    if (!(w_n > 0.0) || (w_m < 0.0 && u_m * u_m * g_m > kBorderTolerance * kBorderTolerance)) return false;
    if (!(delta <= f_.d_n + border_)) return false;
    const Vec3 w = w_n * n + w_m * m;
    // T has to lie on the segment; all times |e|.
    const double along = (first ? 0.0 : length_squared) - dot(e, times(r2_, w)) - dot(e, t);
    const double slack = border_ * std::sqrt(length_squared);
    if (along < -slack || along > length_squared + slack) {
      // Past an end: that corner's, if anybody's.
      return !corner_cleared_ && findCorner(along < 0.0 ? k : l);
    }
    take(static_cast<Feature>(static_cast<int>(Feature::kEdge0) + k), delta, w, inverse_w);
    return true;
  }

  void take(Feature feature, double delta, const Vec3& w, double inverse_w) {
    feature_ = feature;
    depth_ = std::min(delta, f_.d_n);
    w_ = w;
    inverse_w_ = inverse_w;
  }

  /// Has no other feature a contact as shallow as that of edge k? Where the solids meet, a feature outside the
  /// ellipsoid has none across the thick axes, and none shallower than the rim's radius across the thin one.
  bool isAlone(int k, int cleared_corner) const {
    const double thin = std::min(std::min(r_.x, r_.y), r_.z), wide = std::max(std::max(r_.x, r_.y), r_.z);
    const double rim = thin * thin / wide;
    const Vec3 inverse_r = inverseRadii();
    if (!(depth_ + border_ < rim)) return false;
    if (!(squaredNorm(times((depth_ * inverse_w_) * w_ - times(r2_, w_), inverse_r)) < 1.0 - kMargin)) return false;
    CornerVec3 t, e;
    times(t_, inverse_r, t);
    Lanes gauge, ee, te;
    dot(t, t, gauge);
    unsigned corners_out = bitsOf(gauge > 1.0 + kMargin) & 7u;
    if (cleared_corner >= 0) corners_out |= 1u << cleared_corner;
    if (corners_out != 7u) return false;
    unsigned others = ~(1u << k) & 7u;
    // Edges that T0 lies within need a plane deeper than the rim's radius (FeatureSearch::search).
    if (f_.d_n + border_ < rim) others &= f_.outside;
    if (others == 0) return true;
    // Edges whose whole lines pass the ellipsoid by: with lengths divided by the semi-axes, further than 1 from the
    // centre.
    times(e_, inverse_r, e);
    dot(e, e, ee);
    dot(t, e, te);
    return (bitsOf(gauge * ee * (1.0 - 1e-13) - te * te > ee * (1.0 + kMargin)) & others) == others;
  }

  static constexpr double kSlender = 1e-3;  ///< least product of a shadow's semi-axes squared, over their sum's square.

  const PosedEllipsoid& ellipsoid_;
  const PlaneFacts& f_;
  Vec3 c_;
  Frame3 axes_;
  Vec3 r_, r2_;
  CornerVec3 t_, e_;  ///< the corners and edges along the ellipsoid's axes [m].
  double border_;
  bool corner_cleared_ = false;  ///< findCorner has worked its near minimum out, and it is no contact.
  Feature feature_ = Feature::kNone;
  double depth_ = 0.0;
  Vec3 w_;  ///< the direction of the push, of such length that h(w) = 1: E - c = -A w.
  double inverse_w_ = 0.0;
};

/// An edge or a corner. In a function of its own, and all that is known in registers: a face needs neither.
__attribute__((noinline)) TriangleContact featureContact(const PosedEllipsoid& ellipsoid, const Triangle& triangle,
                                                         Lanes v_x, Lanes v_y, Lanes v_z, double n_x, double n_y,
                                                         double n_z, double s, double h, unsigned outside,
                                                         double size_squared, double floor_depth) {
  const PlaneFacts facts{{n_x, n_y, n_z}, s, h, h - s, size_squared, outside};
  OrdinaryContact ordinary(ellipsoid, {v_x, v_y, v_z}, facts);
  return ordinary.find() ? ordinary.contact(floor_depth) : searchFeatures(ellipsoid, triangle, floor_depth);
}

TriangleContact minimumTranslation(const PosedEllipsoid& ellipsoid, const Triangle& triangle, double floor_depth) {
  const Vec3 c = Vec3::from(ellipsoid.p_WE), n = Vec3::from(triangle.nhat_W), r = Vec3::from(ellipsoid.radii);
  CornerVec3 v;
  load(triangle, v);
  const CornerVec3 t{v.x - c.x, v.y - c.y, v.z - c.z};
  PlaneFacts facts;
  if (!reachesPlane(ellipsoid, n, t, floor_depth, facts)) return contactAt(Feature::kNone, 0.0, {}, {});
  const Vec3 An = fromFrame(columns(ellipsoid.R_WE), times(r, times(r, facts.n_E)));
  findSides(v, t, n, r, An, facts);
  if (facts.outside == 0) return contactAt(Feature::kFace, facts.d_n, n, c + (-1.0 / facts.h) * An);
  return featureContact(ellipsoid, triangle, v.x, v.y, v.z, facts.n_E.x, facts.n_E.y, facts.n_E.z, facts.s, facts.h,
                        facts.outside, facts.size_squared, floor_depth);
}
