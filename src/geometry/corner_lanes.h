// Rules 2 and 3 with the corners of a triangle side by side: the same operations in the same order as planeContact and
// faceSides (plane_contact.h), which define them, and so the same bits. Included once for each kind of machine, inside
// a namespace of its own; no include guard.

// A bit for each lane that is true. EVS_CORNERS_IN_ONE says that they fill one register of x86; the compiler's own
// macros know nothing of a target that the file itself turns to.
inline unsigned bitsOf(const LaneMask& mask) {
#if EVS_CORNERS_IN_ONE
  return static_cast<unsigned>(_mm256_movemask_pd(reinterpret_cast<const __m256d&>(mask)));
#else
  return static_cast<unsigned>((mask[0] & 1) | (mask[1] & 2) | (mask[2] & 4) | (mask[3] & 8));
#endif
}

/// A vector for each corner and each edge; the fourth lane repeats the last.
struct CornerVec3 {
  Lanes x, y, z;

  Vec3 operator[](int k) const { return {x[k], y[k], z[k]}; }
};

inline void dot(const Vec3& a, const CornerVec3& b, Lanes& result) { result = a.x * b.x + a.y * b.y + a.z * b.z; }
inline void dot(const CornerVec3& a, const CornerVec3& b, Lanes& result) { result = a.x * b.x + a.y * b.y + a.z * b.z; }
inline void toFrame(const Frame3& frame, const CornerVec3& v, CornerVec3& result) {
  dot(frame.x, v, result.x);
  dot(frame.y, v, result.y);
  dot(frame.z, v, result.z);
}
inline void times(const CornerVec3& a, const Vec3& b, CornerVec3& result) {
  result.x = a.x * b.x, result.y = a.y * b.y, result.z = a.z * b.z;
}

/// The vector that has coordinates v in the frame R; four numbers are read for each axis, of which three count.
inline void fromFrame(const Eigen::Matrix3d& R, const Vec3& v, Lanes& result) {
  Lanes x, y, z;
  const double* R_z = &R(0, 2);
  std::memcpy(&x, &R(0, 0), sizeof x);
  std::memcpy(&y, &R(0, 1), sizeof y);
  z = Lanes{R_z[0], R_z[1], R_z[2], R_z[2]};
  result = v.x * x + v.y * y + v.z * z;
}

/// The corners themselves [m].
inline void load(const Triangle& triangle, CornerVec3& v) {
  const auto& p = triangle.v;
  v.x = Lanes{p[0].x(), p[1].x(), p[2].x(), p[2].x()};
  v.y = Lanes{p[0].y(), p[1].y(), p[2].y(), p[2].y()};
  v.z = Lanes{p[0].z(), p[1].z(), p[2].z(), p[2].z()};
}

/// Lane k from lane k + 1 of the three.
inline void fromNext(const Lanes& v, Lanes& result) {
#ifdef __clang__
  result = __builtin_shufflevector(v, v, 1, 2, 0, 0);
#else
  result = __builtin_shuffle(v, LaneMask{1, 2, 0, 0});
#endif
}

/// From every corner to the next [m].
inline void edges(const CornerVec3& v, CornerVec3& e) {
  fromNext(v.x, e.x), fromNext(v.y, e.y), fromNext(v.z, e.z);
  e.x -= v.x, e.y -= v.y, e.z -= v.z;
}

/// Where an ellipsoid stands towards a plane and T0 towards the edges, as PlaneContact and FaceSides.
struct PlaneFacts {
  Vec3 n_E;             ///< n along the ellipsoid's axes.
  double s, h, d_n;     ///< heights [m].
  double size_squared;  ///< [m^2].
  unsigned outside;     ///< a bit for each edge that T0 has left.
};

/// Rule 2, as planeContact.
inline bool reachesPlane(const PosedEllipsoid& ellipsoid, const Vec3& n, const CornerVec3& t, double floor_depth,
                         PlaneFacts& facts) {
  Lanes l, heights;
  dot(t, t, l);
  dot(n, t, heights);
  facts.s = -(l[0] <= l[1] ? (l[0] <= l[2] ? heights[0] : heights[2]) : (l[1] <= l[2] ? heights[1] : heights[2]));
  if (!(facts.s > 0.0)) return false;

  facts.n_E = toFrame(columns(ellipsoid.R_WE), n);
  const double h_squared = squaredNorm(times(Vec3::from(ellipsoid.radii), facts.n_E));
  const double reach = facts.s + floor_depth;
  if (!(h_squared > reach * reach) || !std::isfinite(h_squared)) return false;

  facts.h = std::sqrt(h_squared);
  facts.d_n = facts.h - facts.s;
  return facts.d_n > floor_depth;
}

/// On which sides of the edges T0 lies, as faceSides.
inline void findSides(const CornerVec3& v, const CornerVec3& t, const Vec3& n, const Vec3& r, const Vec3& An,
                      PlaneFacts& facts) {
  CornerVec3 e;
  edges(v, e);
  Lanes length_squared, m_An, m_t;
  dot(e, e, length_squared);
  const CornerVec3 m{e.y * n.z - e.z * n.y, e.z * n.x - e.x * n.z, e.x * n.y - e.y * n.x};
  dot(An, m, m_An);
  dot(m, t, m_t);
  const Lanes beyond = -(m_An + facts.h * m_t);
  const double r_max = std::max(std::max(r.x, r.y), r.z);
  const double longest = std::max(std::max(length_squared[0], length_squared[1]), length_squared[2]);
  facts.size_squared = std::max(r_max * r_max, longest);
  const double tolerance = kBorderTolerance * facts.h;
  const LaneMask clear = beyond * beyond > tolerance * tolerance * facts.size_squared * length_squared;
  facts.outside = bitsOf(clear & (beyond > 0.0)) & 7u;
}
