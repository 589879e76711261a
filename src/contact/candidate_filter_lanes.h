// The tests of contact/candidate_filter.h for the lanes that one register holds. Included once for each kind of
// machine, inside a namespace of its own, with EVS_LANES set to the lanes of a register and bitsOf() to be found there;
// no include guard.

using Lanes = double __attribute__((vector_size(sizeof(double) * EVS_LANES)));
using Mask = std::int64_t __attribute__((vector_size(sizeof(double) * EVS_LANES)));

inline void load(const double* from, Lanes& to) { std::memcpy(&to, from, sizeof to); }
inline void store(const Lanes& from, double* to) { std::memcpy(to, &from, sizeof from); }

// A bit for each lane that is true.
inline std::uint32_t bitsOf(const Mask& mask) {
#if EVS_LANES == 8 && defined(__AVX512DQ__)
  return static_cast<std::uint32_t>(_mm512_movepi64_mask(reinterpret_cast<const __m512i&>(mask)));
#elif EVS_LANES == 4 && defined(__AVX2__)
  return static_cast<std::uint32_t>(_mm256_movemask_pd(reinterpret_cast<const __m256d&>(mask)));
#elif EVS_LANES == 2 && defined(__SSE2__)
  return static_cast<std::uint32_t>(_mm_movemask_pd(reinterpret_cast<const __m128d&>(mask)));
#else
  std::uint32_t bits = 0;
  for (int i = 0; i < EVS_LANES; ++i) bits |= static_cast<std::uint32_t>(mask[i] & 1) << i;
  return bits;
#endif
}

struct LaneVec3 {
  Lanes x, y, z;
};

inline void load(const CandidateBlock::Lane (&from)[3], int first, LaneVec3& to) {
  load(from[0] + first, to.x);
  load(from[1] + first, to.y);
  load(from[2] + first, to.z);
}
inline void dot(const LaneVec3& a, const LaneVec3& b, Lanes& result) { result = a.x * b.x + a.y * b.y + a.z * b.z; }
inline void dot(const Vec3& a, const LaneVec3& b, Lanes& result) { result = a.x * b.x + a.y * b.y + a.z * b.z; }
inline void toFrame(const Frame3& frame, const LaneVec3& v, LaneVec3& result) {
  dot(frame.x, v, result.x);
  dot(frame.y, v, result.y);
  dot(frame.z, v, result.z);
}
// |r v|^2, coordinate by coordinate.
inline void scaledNorm(const Vec3& r, const LaneVec3& v, Lanes& result) {
  const Lanes x = r.x * v.x, y = r.y * v.y, z = r.z * v.z;
  result = x * x + y * y + z * z;
}
inline void larger(const Lanes& a, const Lanes& b, Lanes& result) { result = a > b ? a : b; }
inline void loadFrom(const CandidateBlock::Lane (&from)[3], int first, const Vec3& origin, LaneVec3& to) {
  load(from, first, to);
  to.x -= origin.x;
  to.y -= origin.y;
  to.z -= origin.z;
}

inline void planesOf(const CandidateBlock& block, int first, const FilterEllipsoid& e, double slack,
                     PlaneTest& result) {
  const Vec3 low = e.c - e.half_box, high = e.c + e.half_box;
  LaneVec3 block_low, block_high, n, n_E, t;
  load(block.low, first, block_low);
  load(block.high, first, block_high);
  const Mask meet = (block_low.x <= high.x) & (block_high.x >= low.x) & (block_low.y <= high.y) &
                    (block_high.y >= low.y) & (block_low.z <= high.z) & (block_high.z >= low.z);
  load(block.nhat, first, n);
  loadFrom(block.v[0], first, e.c, t);
  Lanes s, h_squared;
  dot(n, t, s);
  s = -s;
  toFrame(e.axes, n, n_E);
  scaledNorm(e.radii, n_E, h_squared);
  // h - s > -slack without the root; s - slack < 0 is reached in any case.
  const Lanes beyond = s - slack;
  const Mask reached = (beyond < 0.0) | (h_squared > beyond * beyond);
  result.near |= bitsOf(meet & reached & (s >= -slack)) << first;
  result.behind |= bitsOf(meet & (s <= 0.0)) << first;
  store(s, result.height + first);
  store(h_squared, result.half_width_squared + first);
}

inline std::uint32_t risesOf(const CandidateBlock& block, int first, const FilterEllipsoid& e, const KnownPush& push) {
  const double u_p = dot(push.u, push.p - e.c);
  LaneVec3 t;
  Lanes u_t, most;
  loadFrom(block.v[0], first, e.c, t);
  dot(push.u, t, most);
  for (int k = 1; k < 3; ++k) {
    loadFrom(block.v[k], first, e.c, t);
    dot(push.u, t, u_t);
    larger(most, u_t, most);
  }
  return bitsOf(most - u_p > kAbove) << first;
}

inline std::uint32_t pushesOf(const CandidateBlock& block, int first, const FilterEllipsoid& e, const KnownPush& push) {
  const double r_max = e.radii.x > e.radii.y ? (e.radii.x > e.radii.z ? e.radii.x : e.radii.z)
                                             : (e.radii.y > e.radii.z ? e.radii.y : e.radii.z);
  LaneVec3 t[3], n, n_E, m[3];
  for (int k = 0; k < 3; ++k) loadFrom(block.v[k], first, e.c, t[k]);
  load(block.nhat, first, n);

  const Vec3 p = push.p - e.c;

  // (c) the horizon is clear.
  Lanes s, h_squared, b;
  dot(n, t[0], s);
  toFrame(e.axes, n, n_E);
  scaledNorm(e.radii, n_E, h_squared);
  scaledNorm(e.inverse_radii, n_E, b);
  const Mask horizon = s * s * b > h_squared * b * (1.0 + kHorizonMargin) - 1.0;

  // (a) T0 is outside an edge: m.(T0 - v) = -m.A n / h - m.t > margin, squared with its sign. Of the edges it has left
  // the one that p is furthest beyond gives the tilt.
  LaneVec3 r2n_E{e.radii.x * e.radii.x * n_E.x, e.radii.y * e.radii.y * n_E.y, e.radii.z * e.radii.z * n_E.z};
  LaneVec3 An;
  An.x = e.axes.x.x * r2n_E.x + e.axes.y.x * r2n_E.y + e.axes.z.x * r2n_E.z;
  An.y = e.axes.x.y * r2n_E.x + e.axes.y.y * r2n_E.y + e.axes.z.y * r2n_E.z;
  An.z = e.axes.x.z * r2n_E.x + e.axes.y.z * r2n_E.y + e.axes.z.z * r2n_E.z;
  Lanes size;
  load(block.size + first, size);
  const Lanes margin = kOutsideMargin * (size + r_max);
  const Lanes zero = size - size;
  Lanes best_beyond = zero - 1.0;
  LaneVec3 tilt{zero, zero, zero};
  Mask outside = zero > zero;
  for (int k = 0; k < 3; ++k) {
    load(block.edge[k], first, m[k]);
    Lanes m_An, m_t, m_p;
    dot(m[k], An, m_An);
    dot(m[k], t[k], m_t);
    dot(p, m[k], m_p);
    const Lanes left = zero - m_An, right = m_t + margin;
    const Lanes left_squared = left * (left > zero ? left : -left);
    const Lanes right_squared = right * (right > zero ? right : -right) * h_squared;
    const Mask has_left = left_squared > right_squared;
    const Lanes beyond = m_p - m_t;
    const Mask better = has_left & (beyond > best_beyond);
    outside = outside | has_left;
    best_beyond = better ? beyond : best_beyond;
    tilt.x = better ? m[k].x : tilt.x;
    tilt.y = better ? m[k].y : tilt.y;
    tilt.z = better ? m[k].z : tilt.z;
  }

  // (b) q = u + epsilon (m - (m.u) u), not of unit length: |q| >= 1, so q.t + h(q) <= depth for all corners is more
  // than needed. Tilting lowers the corners by epsilon times their distance beyond the edge and lifts the supporting
  // plane by epsilon^2 m'A m / 2 h at most: the best epsilon balances the two.
  LaneVec3 tilt_E;
  toFrame(e.axes, tilt, tilt_E);
  Lanes m_A_m, m_u;
  scaledNorm(e.radii, tilt_E, m_A_m);
  dot(push.u, tilt, m_u);
  Lanes epsilon = best_beyond * push.half_width / (m_A_m + 1e-300);
  epsilon = epsilon > zero ? epsilon : zero;
  epsilon = epsilon < zero + 1.0 ? epsilon : zero + 1.0;
  const Lanes along = 1.0 - epsilon * m_u;
  const LaneVec3 q{along * push.u.x + epsilon * tilt.x, along * push.u.y + epsilon * tilt.y,
                   along * push.u.z + epsilon * tilt.z};
  LaneVec3 q_E;
  Lanes q_t[3], most, h_q_squared, q_n, farthest = zero;
  for (int k = 0; k < 3; ++k) {
    dot(q, t[k], q_t[k]);
    const Lanes length =
        (t[k].x > zero ? t[k].x : -t[k].x) + (t[k].y > zero ? t[k].y : -t[k].y) + (t[k].z > zero ? t[k].z : -t[k].z);
    larger(farthest, length, farthest);
  }
  larger(q_t[0], q_t[1], most);
  larger(most, q_t[2], most);
  toFrame(e.axes, q, q_E);
  scaledNorm(e.radii, q_E, h_q_squared);
  dot(q, n, q_n);
  const Lanes room = push.depth * (1.0 - kDepthMargin) - kLengthMargin * (farthest + r_max) - most;
  const Mask below = (room > zero) & (h_q_squared <= room * room);
  return bitsOf(outside & horizon & below & (q_n > zero) & (s < zero)) << first;
}

void planes(const CandidateBlock& block, const FilterEllipsoid& ellipsoid, double slack, PlaneTest& result) {
  result.near = result.behind = 0;
  for (int first = 0; first < CandidateBlock::kWidth; first += EVS_LANES)
    planesOf(block, first, ellipsoid, slack, result);
}

std::uint32_t pushes(const CandidateBlock& block, std::uint32_t wanted, const FilterEllipsoid& ellipsoid,
                     const KnownPush& push) {
  std::uint32_t cleared = 0;
  for (int first = 0; first < CandidateBlock::kWidth; first += EVS_LANES)
    if ((wanted >> first & ((1u << EVS_LANES) - 1u)) != 0) cleared |= pushesOf(block, first, ellipsoid, push);
  return cleared & wanted;
}

std::uint32_t rises(const CandidateBlock& block, std::uint32_t wanted, const FilterEllipsoid& ellipsoid,
                    const KnownPush& push) {
  std::uint32_t found = 0;
  for (int first = 0; first < CandidateBlock::kWidth; first += EVS_LANES)
    if ((wanted >> first & ((1u << EVS_LANES) - 1u)) != 0) found |= risesOf(block, first, ellipsoid, push);
  return found & wanted;
}
