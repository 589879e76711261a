#pragma once

#include <Eigen/Core>
#include <cmath>

namespace ellipsoid_vehicle_sim {

/// Three plain doubles, for the inner loops of contact and dynamics. Eigen's packets handle a 3-vector as a pair and a
/// rest, and a pair that was stored as two doubles and is loaded as one waits for the store: the contact kernel took 1.3
/// to 1.7 times as long with it.
struct Vec3 {
  double x, y, z;

  static Vec3 from(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
  Eigen::Vector3d toEigen() const { return {x, y, z}; }
};

inline Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator-(const Vec3& a) { return {-a.x, -a.y, -a.z}; }
inline Vec3& operator+=(Vec3& a, const Vec3& b) { return a = a + b; }
inline Vec3& operator-=(Vec3& a, const Vec3& b) { return a = a - b; }
inline Vec3 operator*(double s, const Vec3& a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline double squaredNorm(const Vec3& a) { return dot(a, a); }
inline double norm(const Vec3& a) { return std::sqrt(dot(a, a)); }
inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/// Coordinate by coordinate.
inline Vec3 times(const Vec3& a, const Vec3& b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }

/// Three vectors of a frame.
struct Frame3 {
  Vec3 x, y, z;

  Eigen::Matrix3d toEigen() const {
    Eigen::Matrix3d columns;
    columns << x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z;
    return columns;
  }
};

/// The columns of a rotation matrix.
inline Frame3 columns(const Eigen::Matrix3d& R) {
  return {Vec3::from(R.col(0)), Vec3::from(R.col(1)), Vec3::from(R.col(2))};
}
/// v along the frame's vectors.
inline Vec3 toFrame(const Frame3& frame, const Vec3& v) { return {dot(frame.x, v), dot(frame.y, v), dot(frame.z, v)}; }
/// The vector that has coordinates v in the frame.
inline Vec3 fromFrame(const Frame3& frame, const Vec3& v) { return v.x * frame.x + v.y * frame.y + v.z * frame.z; }

/// The frame R given along another frame: the product of the rotation matrices.
inline Frame3 fromFrame(const Frame3& frame, const Frame3& R) {
  return {fromFrame(frame, R.x), fromFrame(frame, R.y), fromFrame(frame, R.z)};
}

struct Vec2 {
  double x, y;
};

inline double dot(const Vec2& a, const Vec2& b) { return a.x * b.x + a.y * b.y; }

}  // namespace ellipsoid_vehicle_sim
