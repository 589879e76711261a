#pragma once

#include "ellipsoid_vehicle_sim/geometry/small_vector.h"

namespace ellipsoid_vehicle_sim {

/// A vector of motion or force, taken at the base's origin O.
struct Spatial {
  Vec3 angular{0.0, 0.0, 0.0};  ///< turning, or moment about O.
  Vec3 linear{0.0, 0.0, 0.0};   ///< of the point at O, or force.
};

inline Spatial operator+(const Spatial& a, const Spatial& b) { return {a.angular + b.angular, a.linear + b.linear}; }
inline Spatial& operator+=(Spatial& a, const Spatial& b) { return a = a + b; }
inline Spatial operator*(double s, const Spatial& a) { return {s * a.angular, s * a.linear}; }

inline double dot(const Spatial& motion, const Spatial& force) {
  return dot(motion.angular, force.angular) + dot(motion.linear, force.linear);
}

/// Symmetric matrix, packed.
struct Symmetric3 {
  double xx, yy, zz, xy, xz, yz;

  static Symmetric3 from(const Eigen::Matrix3d& m) { return {m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(0, 2), m(1, 2)}; }
  Vec3 operator*(const Vec3& v) const {
    return {xx * v.x + xy * v.y + xz * v.z, xy * v.x + yy * v.y + yz * v.z, xz * v.x + yz * v.y + zz * v.z};
  }
  /// S x = b for a positive definite S, by its L D L' factors: good to rounding for the flattest body too.
  Vec3 solve(const Vec3& b) const {
    const double inverse_x = 1.0 / xx, lyx = xy * inverse_x, lzx = xz * inverse_x;
    const double dy = yy - lyx * xy, inverse_y = 1.0 / dy;
    const double lzy = (yz - lzx * xy) * inverse_y;
    const double dz = zz - lzx * xz - lzy * lzy * dy;
    const double by = b.y - lyx * b.x, bz = b.z - lzx * b.x - lzy * by;
    const double z = bz / dz, y = by * inverse_y - lzy * z;
    return {b.x * inverse_x - lyx * y - lzx * z, y, z};
  }
  /// Of a well-conditioned one, by its adjugate.
  Symmetric3 inverse() const {
    const double cxx = yy * zz - yz * yz, cxy = xz * yz - xy * zz, cxz = xy * yz - xz * yy;
    const double d = 1.0 / (xx * cxx + xy * cxy + xz * cxz);
    return {d * cxx, d * (xx * zz - xz * xz), d * (xx * yy - xy * xy), d * cxy, d * cxz, d * (xy * xz - xx * yz)};
  }
};

/// R S R' for a rotation whose columns are the frame's vectors.
inline Symmetric3 turned(const Frame3& R, const Symmetric3& S) {
  // Rows of R S, then of (R S) R'.
  const Vec3 x = S * Vec3{R.x.x, R.y.x, R.z.x}, y = S * Vec3{R.x.y, R.y.y, R.z.y}, z = S * Vec3{R.x.z, R.y.z, R.z.z};
  const auto row = [&R](const Vec3& v, double Vec3::*k) { return v.x * R.x.*k + v.y * R.y.*k + v.z * R.z.*k; };
  return {row(x, &Vec3::x), row(y, &Vec3::y), row(z, &Vec3::z), row(x, &Vec3::y), row(x, &Vec3::z), row(y, &Vec3::z)};
}

/// Rigid or articulated inertia at O: moment = J a + H l, force = H' a + M l for an acceleration (a, l). J and M are
/// symmetric: 21 numbers, packed, because adding these up is most of what the dynamics does.
class SpatialInertia {
 public:
  /// A rigid body of mass m with its centre of mass at c and inertia I about it.
  void setRigid(double m, const Vec3& c, const Symmetric3& I) {
    const Vec3 p = m * c;  // H = [m c]x, row by row.
    j_ = {I.xx + p.y * c.y + p.z * c.z,
          I.yy + p.x * c.x + p.z * c.z,
          I.zz + p.x * c.x + p.y * c.y,
          I.xy - p.x * c.y,
          I.xz - p.x * c.z,
          I.yz - p.y * c.z};
    h_[0] = {0.0, -p.z, p.y};
    h_[1] = {p.z, 0.0, -p.x};
    h_[2] = {-p.y, p.x, 0.0};
    m_ = {m, m, m, 0.0, 0.0, 0.0};
  }

  void add(const SpatialInertia& other) {
    addTo(j_, other.j_);
    for (int i = 0; i < 3; ++i) h_[i] += other.h_[i];
    addTo(m_, other.m_);
  }

  /// this += other - U U' / D: what remains of an inertia when the motion whose force is U and own inertia D is free.
  void addWithout(const SpatialInertia& other, const Spatial& U, double inverse_D) {
    const Vec3 &a = U.angular, &l = U.linear;
    const Vec3 b = inverse_D * a, k = inverse_D * l;
    addTo(j_, minusOuter(other.j_, b, a));
    h_[0] += other.h_[0] - b.x * l;
    h_[1] += other.h_[1] - b.y * l;
    h_[2] += other.h_[2] - b.z * l;
    addTo(m_, minusOuter(other.m_, k, l));
  }

  /// Force for an acceleration that is only linear.
  Spatial timesLinear(const Vec3& l) const { return {{dot(h_[0], l), dot(h_[1], l), dot(h_[2], l)}, m_ * l}; }

  Spatial operator*(const Spatial& acceleration) const {
    const Vec3& a = acceleration.angular;
    Spatial force = timesLinear(acceleration.linear);
    force.angular += j_ * a;
    force.linear += a.x * h_[0] + a.y * h_[1] + a.z * h_[2];
    return force;
  }

  /// The acceleration that this inertia, free to move, takes under a force: its inverse times the force.
  Spatial accelerationUnder(const Spatial& force) const {
    const Symmetric3 m_inverse = m_.inverse();
    // H M^-1, and Schur's complement J - H M^-1 H'.
    const Vec3 hm[3] = {m_inverse * h_[0], m_inverse * h_[1], m_inverse * h_[2]};
    const Symmetric3 schur{j_.xx - dot(hm[0], h_[0]), j_.yy - dot(hm[1], h_[1]), j_.zz - dot(hm[2], h_[2]),
                           j_.xy - dot(hm[0], h_[1]), j_.xz - dot(hm[0], h_[2]), j_.yz - dot(hm[1], h_[2])};
    const Vec3 l = m_inverse * force.linear;
    const Vec3 a = schur.solve(
        {force.angular.x - dot(h_[0], l), force.angular.y - dot(h_[1], l), force.angular.z - dot(h_[2], l)});
    return {a, l - (a.x * hm[0] + a.y * hm[1] + a.z * hm[2])};
  }

  const Symmetric3& J() const { return j_; }

 private:
  static void addTo(Symmetric3& sum, const Symmetric3& s) {
    sum.xx += s.xx, sum.yy += s.yy, sum.zz += s.zz;
    sum.xy += s.xy, sum.xz += s.xz, sum.yz += s.yz;
  }
  static Symmetric3 minusOuter(const Symmetric3& s, const Vec3& b, const Vec3& a) {
    return {s.xx - b.x * a.x, s.yy - b.y * a.y, s.zz - b.z * a.z, s.xy - b.x * a.y, s.xz - b.x * a.z, s.yz - b.y * a.z};
  }

  Symmetric3 j_, m_;
  Vec3 h_[3];  ///< rows of H.
};

}  // namespace ellipsoid_vehicle_sim
