// The tests of contact/candidate_filter.h for the lanes that one register holds. Included once for each kind of
// machine, inside a namespace of its own, with EVS_LANES set to the lanes of a register and bitsOf() to be found there;
// no include guard.

using Lanes = double __attribute__((vector_size(sizeof(double) * EVS_LANES)));
using Mask = std::int64_t __attribute__((vector_size(sizeof(double) * EVS_LANES)));

inline void load(const double* from, Lanes& to) { std::memcpy(&to, from, sizeof to); }
inline void store(const Lanes& from, double* to) { std::memcpy(to, &from, sizeof from); }

// A bit for each lane that is true. By the lanes, not by the compiler's macros of what there is: those are set before a
// file is read, so that none of them knows of a target that the file itself turns to. Eight and four are x86 alone.
inline std::uint32_t bitsOf(const Mask& mask) {
#if EVS_LANES == 8
  return static_cast<std::uint32_t>(_mm512_movepi64_mask(reinterpret_cast<const __m512i&>(mask)));
#elif EVS_LANES == 4
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

inline void cross(const LaneVec3& a, const LaneVec3& b, LaneVec3& result) {
  result.x = a.y * b.z - a.z * b.y;
  result.y = a.z * b.x - a.x * b.z;
  result.z = a.x * b.y - a.y * b.x;
}
inline void subtract(const LaneVec3& a, const LaneVec3& b, LaneVec3& result) {
  result.x = a.x - b.x, result.y = a.y - b.y, result.z = a.z - b.z;
}
inline void select(const Mask& mask, const LaneVec3& a, LaneVec3& result) {
  result.x = mask ? a.x : result.x, result.y = mask ? a.y : result.y, result.z = mask ? a.z : result.z;
}
inline void store(const LaneVec3& from, CandidateBlock::Lane (&to)[3], int first) {
  store(from.x, to[0] + first);
  store(from.y, to[1] + first);
  store(from.z, to[2] + first);
}
inline void root(const Lanes& x, Lanes& result) {
  for (int i = 0; i < EVS_LANES; ++i) result[i] = std::sqrt(x[i]);
}

// Box, normal and edge normals of the triangles; the normal by the operations of `makeTriangle`, in their order.
inline void fillOf(CandidateBlock& block, int first, int used) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Mask unused;
  for (int i = 0; i < EVS_LANES; ++i) unused[i] = first + i < used ? 0 : -1;
  LaneVec3 v[3], e[3], n;
  Lanes l[3];
  for (int k = 0; k < 3; ++k) {
    load(block.v[k], first, v[k]);
    const Lanes zero{};
    select(unused, {zero + block.v[k][0][0], zero + block.v[k][1][0], zero + block.v[k][2][0]}, v[k]);
    store(v[k], block.v[k], first);
  }
  for (int k = 0; k < 3; ++k) {
    subtract(v[(k + 1) % 3], v[k], e[k]);
    dot(e[k], e[k], l[k]);
  }
  const Mask by_0 = (l[0] >= l[1]) & (l[0] >= l[2]), by_1 = l[1] >= l[2];
  LaneVec3 other;
  cross(e[0], e[1], n);
  cross(e[2], e[0], other);
  select(by_1, other, n);
  cross(e[1], e[2], other);
  select(by_0, other, n);
  Lanes double_area, longest;
  dot(n, n, double_area);
  root(double_area, double_area);
  n.x /= double_area, n.y /= double_area, n.z /= double_area;
  store(n, block.nhat, first);

  Lanes length[3];
  for (int k = 0; k < 3; ++k) {
    root(l[k], length[k]);
    LaneVec3 m;
    cross(e[k], n, m);
    const Lanes inverse = 1.0 / length[k];  // who uses m forgives a last digit
    store({inverse * m.x, inverse * m.y, inverse * m.z}, block.edge[k], first);
  }
  larger(length[0], length[1], longest);
  larger(longest, length[2], longest);
  store(longest, block.size + first);
  LaneVec3 low = v[0], high = v[0];
  for (int k = 1; k < 3; ++k) {
    low.x = v[k].x < low.x ? v[k].x : low.x, high.x = v[k].x > high.x ? v[k].x : high.x;
    low.y = v[k].y < low.y ? v[k].y : low.y, high.y = v[k].y > high.y ? v[k].y : high.y;
    low.z = v[k].z < low.z ? v[k].z : low.z, high.z = v[k].z > high.z ? v[k].z : high.z;
  }
  const Lanes nowhere = Lanes{} + kInfinity;
  select(unused, {nowhere, nowhere, nowhere}, low);
  select(unused, {-nowhere, -nowhere, -nowhere}, high);
  store(low, block.low, first);
  store(high, block.high, first);
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
  store(n_E, result.n_E, first);
  store(s, result.height + first);
  store(h_squared, result.half_width_squared + first);
}

/// What (b) of pushesOf is made of.
struct TiltLanes {
  Lanes u_t[3], m_t[3];  ///< the corners from c along u and along m [m].
  LaneVec3 rm;           ///< m along the ellipsoid's axes, times its radii [m].
  Lanes m_u;             ///< u.m
  Lanes limit;           ///< what q.t + h(q) must not exceed [m].
};

/// For q = u + epsilon (m - (m.u) u): what the corners leave for h(q), h(q)^2, and q.n over u.n.
inline void tilt(const TiltLanes& lanes, const FilterEllipsoid& e, const KnownPush& push, const Lanes& epsilon,
                 Lanes& room, Lanes& h_q_squared, Lanes& along) {
  along = 1.0 - epsilon * lanes.m_u;
  Lanes most = along * lanes.u_t[0] + epsilon * lanes.m_t[0];
  for (int k = 1; k < 3; ++k) larger(most, along * lanes.u_t[k] + epsilon * lanes.m_t[k], most);
  const Vec3 ru{e.radii.x * dot(e.axes.x, push.u), e.radii.y * dot(e.axes.y, push.u),
                e.radii.z * dot(e.axes.z, push.u)};
  const LaneVec3 rq{along * ru.x + epsilon * lanes.rm.x, along * ru.y + epsilon * lanes.rm.y,
                    along * ru.z + epsilon * lanes.rm.z};
  dot(rq, rq, h_q_squared);
  room = lanes.limit - most;
}

/// What else the proofs of pushesOf compare.
struct ProofLanes {
  Lanes s, s_after;                      ///< heights over the plane, before the push and after it [m].
  Lanes u_n, h_squared, b;               ///< u.n; n'A n [m^2]; n'A^-1 n [1/m^2].
  Lanes epsilon;                         ///< the best tilt.
  Lanes minus_m_An, right, right_after;  ///< (a): minus_m_An / h > right, before and after [m^2, m].
  LaneVec3 n, m;
};

/// How fast something that has to stay positive falls, in metres for each metre of travel: `along` its gradient is that
/// in the direction of travel, `steepness` its length.
inline void speedOf(const Lanes& along, const Lanes& steepness, Lanes& result) {
  const Lanes zero = along - along;
  result = (along < zero ? -along : zero) + 2.0 * kTravelWidth * steepness + kLeastSpeed;
}

// See LaneTravel. What a change of A costs each of them, with E' = |A' - A| / r_min^2, so that no w'A w changes by more
// than E' of itself: no h changes by more than 0.51 E' h, no T0 (the gradient of h) by more than 1.6 E' r_max, thus
// h(q) - h(u) by no more than 1.6 E' r_max |q - u|, and s_floor^2 by no more than 2 E' h^2. All of that is less than
// kTravelPerChange r_max E' times the speed, of which 2 kTravelWidth times the gradient's length are the least.
inline void travelOf(const CandidateBlock& block, int first, const FilterEllipsoid& e, const KnownPush& push,
                     double slack, const ProofLanes& proof, const TiltLanes& tilts, LaneTravel& result) {
  const Vec3& d = result.direction;
  const double u_d = dot(push.u, d);
  const Lanes zero = proof.s - proof.s;
  Lanes h, n_d, m_d, speed, other;
  root(proof.h_squared, h);
  dot(d, proof.n, n_d);
  dot(d, proof.m, m_d);

  // The boxes stay apart.
  const Vec3 low = e.c - e.half_box, high = e.c + e.half_box;
  LaneVec3 block_low, block_high;
  load(block.low, first, block_low);
  load(block.high, first, block_high);
  Lanes travel = block_low.x - high.x;
  larger(travel, low.x - block_high.x, travel);
  larger(travel, block_low.y - high.y, travel);
  larger(travel, low.y - block_high.y, travel);
  larger(travel, block_low.z - high.z, travel);
  larger(travel, low.z - block_high.z, travel);
  travel = travel * (1.0 / (1.0 + 2.0 * kTravelWidth));  // whatever the direction

  // Or the plane stays in front, and not deep, neither before the push nor after it: u.n <= 1.
  const Lanes sine_squared = 1.0 - proof.u_n * proof.u_n;
  Lanes sine;
  root(sine_squared > zero ? sine_squared : zero, sine);
  speedOf(n_d - proof.u_n * u_d, sine, speed);
  Lanes flat = (push.depth * proof.u_n - (h - proof.s) - slack) / speed;
  const Lanes front = proof.s * (1.0 / (1.0 + 2.0 * kTravelWidth));
  flat = flat < front ? flat : front;
  larger(travel, proof.u_n > zero ? flat : zero - 1.0, travel);

  // Or all that proves the triangle shallower, and cleared, keeps doing so. The best tilt leaves the most room; a
  // slight one holds almost until the edge is reached, where the ground falls off behind it.
  Lanes least = zero - 1.0;
  for (const double part : {1.0, kSlightTilt}) {
    const Lanes epsilon = part * proof.epsilon;
    Lanes room, h_q, along;
    tilt(tilts, e, push, epsilon, room, h_q, along);
    root(h_q, h_q);
    speedOf(epsilon * (m_d - tilts.m_u * u_d), epsilon, speed);
    larger(least, along * proof.u_n > kForwardMargin ? (room - h_q) / speed : zero - 1.0, least);
  }
  // After the push the way along u is no way.
  Lanes rightmost;
  larger(proof.right, proof.right_after, rightmost);
  other = m_d - tilts.m_u * u_d;
  speedOf(m_d < other ? m_d : other, zero + 1.0, speed);
  const Lanes outside = (proof.minus_m_An / h - rightmost) / speed;
  least = outside < least ? outside : least;
  const Lanes s = proof.s_after < proof.s ? proof.s_after : proof.s;
  const Lanes floor_squared = proof.h_squared * (1.0 + kHorizonMargin) - 1.0 / proof.b;
  other = n_d - proof.u_n * u_d;
  speedOf(n_d < other ? n_d : other, zero + 1.0, speed);
  const Lanes clear = (s * s - (floor_squared > zero ? floor_squared : zero)) / (2.0 * s * speed);
  least = clear < least ? clear : least;
  larger(travel, s > kLeastHeight * h ? least : zero - 1.0, travel);
  store(travel - kTravelMargin, result.travel + first);
}

inline void pushesOf(const CandidateBlock& block, const PlaneTest& plane, int first, const FilterEllipsoid& e,
                     const KnownPush& push, double slack, PushTest& result, LaneTravel* travel) {
  const double r_max = e.radii.x > e.radii.y ? (e.radii.x > e.radii.z ? e.radii.x : e.radii.z)
                                             : (e.radii.y > e.radii.z ? e.radii.y : e.radii.z);
  const Vec3 p = push.p - e.c;
  LaneVec3 t[3], n, n_E;
  Lanes u_t[3], u_n, s, h_squared, b;
  for (int k = 0; k < 3; ++k) {
    loadFrom(block.v[k], first, e.c, t[k]);
    dot(push.u, t[k], u_t[k]);
  }
  Lanes highest;
  larger(u_t[0], u_t[1], highest);
  larger(highest, u_t[2], highest);
  result.rises |= bitsOf(highest - dot(push.u, p) > kAbove) << first;

  // The plane, before the push and after it: h - s > depth - slack without the root.
  load(block.nhat, first, n);
  dot(push.u, n, u_n);
  load(plane.height + first, s);
  load(plane.half_width_squared + first, h_squared);
  load(plane.n_E, first, n_E);
  const Lanes s_after = s + push.depth * u_n;
  const Lanes reach = s + (push.depth - slack), reach_after = s_after - slack;
  result.deep |= bitsOf((reach < 0.0) | (h_squared > reach * reach)) << first;
  result.deep_after |= bitsOf((reach_after < 0.0) | (h_squared > reach_after * reach_after)) << first;

  // (c) of cannotExceed: the horizon is clear.
  scaledNorm(e.inverse_radii, n_E, b);
  const Lanes horizon = h_squared * b * (1.0 + kHorizonMargin) - 1.0;
  const Mask clear = (s > 0.0) & (s * s * b > horizon);
  const Mask clear_after = (s_after > 0.0) & (s_after * s_after * b > horizon);

  // The tilt: the edge that p is furthest beyond, with the outward normal m.
  const Lanes zero = s - s;
  Lanes beyond = zero - 1e300;
  LaneVec3 m{zero, zero, zero};
  for (int k = 0; k < 3; ++k) {
    LaneVec3 m_k;
    Lanes beyond_k;
    load(block.edge[k], first, m_k);
    dot(LaneVec3{p.x - t[k].x, p.y - t[k].y, p.z - t[k].z}, m_k, beyond_k);
    const Mask better = beyond_k > beyond;
    beyond = better ? beyond_k : beyond;
    select(better, m_k, m);
  }
  Lanes m_t[3], edge_t;  // from c along m: of the corners, and of the edge, which stands furthest out
  for (int k = 0; k < 3; ++k) dot(m, t[k], m_t[k]);
  larger(m_t[0], m_t[1], edge_t);
  larger(edge_t, m_t[2], edge_t);
  LaneVec3 m_E;
  toFrame(e.axes, m, m_E);
  const LaneVec3 rm{e.radii.x * m_E.x, e.radii.y * m_E.y, e.radii.z * m_E.z};
  Lanes m_A_m, m_u, size;
  dot(rm, rm, m_A_m);
  dot(push.u, m, m_u);

  // (a) T0 is outside that edge: m.(T0 - v) = -m.A n / h - m.t > margin, squared with its sign.
  load(block.size + first, size);
  const Lanes minus_m_An = -(rm.x * (e.radii.x * n_E.x) + rm.y * (e.radii.y * n_E.y) + rm.z * (e.radii.z * n_E.z));
  const Lanes left = minus_m_An * (minus_m_An > zero ? minus_m_An : -minus_m_An);
  const Lanes right = edge_t + kOutsideMargin * (size + r_max), right_after = right - push.depth * m_u;
  const Mask outside = left > right * (right > zero ? right : -right) * h_squared;
  const Mask outside_after = left > right_after * (right_after > zero ? right_after : -right_after) * h_squared;

  // (b) q = u + epsilon (m - (m.u) u), not of unit length: |q| >= 1, so q.t + h(q) <= depth for all corners is more
  // than needed. Tilting lowers the corners by epsilon times their distance beyond the edge and lifts the supporting
  // plane by epsilon^2 m'A m / 2 h at most: the best epsilon balances the two. q.u = 1, so that after the push the same
  // q clears the triangle.
  Lanes epsilon = beyond * push.half_width / (m_A_m + 1e-300);
  epsilon = epsilon > zero ? epsilon : zero;
  epsilon = epsilon < zero + 1.0 ? epsilon : zero + 1.0;
  // The boxes meet, so that no corner is further from c than the one's half size and the other's side.
  const Lanes farthest = (e.half_box.x + e.half_box.y + e.half_box.z) + 3.0 * size;
  const Lanes limit = push.depth * (1.0 - kDepthMargin) - kLengthMargin * (farthest + r_max);
  const TiltLanes tilts{{u_t[0], u_t[1], u_t[2]}, {m_t[0], m_t[1], m_t[2]}, rm, m_u, limit};
  Lanes room, h_q_squared, along;
  tilt(tilts, e, push, epsilon, room, h_q_squared, along);
  // m is square to n.
  const Mask below = (room > zero) & (h_q_squared <= room * room) & (along * u_n > kForwardMargin);
  result.shallower |= bitsOf(below & outside & clear) << first;
  result.cleared |= bitsOf(below & outside_after & clear_after) << first;
  if (travel == nullptr) return;
  const ProofLanes proof{s, s_after, u_n, h_squared, b, epsilon, minus_m_An, right, right_after, n, m};
  travelOf(block, first, e, push, slack, proof, tilts, *travel);
}

// Whose prism over the triangle holds the centre.
inline std::uint32_t oversOf(const CandidateBlock& block, int first, const Vec3& c) {
  Mask over;
  for (int k = 0; k < 3; ++k) {
    LaneVec3 m, t;
    Lanes m_t;
    load(block.edge[k], first, m);
    loadFrom(block.v[k], first, c, t);
    dot(m, t, m_t);
    over = k == 0 ? m_t >= 0.0 : over & (m_t >= 0.0);
  }
  return bitsOf(over) << first;
}

void fill(CandidateBlock& block, int used) {
  for (int first = 0; first < CandidateBlock::kWidth; first += EVS_LANES) fillOf(block, first, used);
}

void planes(const CandidateBlock& block, const FilterEllipsoid& ellipsoid, double slack, PlaneTest& result) {
  result.near = result.behind = 0;
  for (int first = 0; first < CandidateBlock::kWidth; first += EVS_LANES)
    planesOf(block, first, ellipsoid, slack, result);
}

void pushes(const CandidateBlock& block, const PlaneTest& plane, std::uint32_t wanted, const FilterEllipsoid& ellipsoid,
            const KnownPush& push, double slack, PushTest& result, LaneTravel* travel) {
  result = {};
  for (int first = 0; first < CandidateBlock::kWidth; first += EVS_LANES)
    if (travel != nullptr || (wanted >> first & ((1u << EVS_LANES) - 1u)) != 0)
      pushesOf(block, plane, first, ellipsoid, push, slack, result, travel);
}

std::uint32_t overs(const CandidateBlock& block, const Vec3& c) {
  std::uint32_t found = 0;
  for (int first = 0; first < CandidateBlock::kWidth; first += EVS_LANES) found |= oversOf(block, first, c);
  return found;
}
